//! Why there is no pass, or it does not go with a view.

use vrcs_passes::{Refusal, options::Mode};

use super::reflect::Unbindable;
use crate::{limits::LimitError, rate::Rate};

/// Why a [`Pass`](crate::Pass) could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PassError {
    /// The shader is not valid WGSL. The text points into it.
    #[error("{0}")]
    Invalid(String),
    /// The shader cannot be made variable-rate. The text points into it.
    #[error("{rendered}")]
    Refused {
        /// The reasons.
        refusal: Refusal,
        /// The reasons, with the lines that they are about.
        rendered: String,
    },
    /// The manifest of a shader that was rewritten before does not fit.
    #[error("the manifest does not fit: {0}")]
    Manifest(String),
    /// A constant has no such name, or its value does not fit.
    #[error("the shader's overrides: {0}")]
    Constants(String),
    /// wgpu cannot bind one of the shader's resources.
    #[error(transparent)]
    Unbindable(#[from] Unbindable),
    /// A bind group layout of the caller's has not what the shader binds. wgpu says so when the pipeline is made: it does not tell
    /// what a layout's entries are.
    #[error(
        "the given layout of bind group {group} does not serve `{name}` at binding {binding}: {why}; the shader needs {wanted}"
    )]
    Layout {
        /// The group.
        group: u32,
        /// The binding's number.
        binding: u32,
        /// The shader's name for it.
        name: String,
        /// The type of a layout entry that would do, as [`wgpu::BindingType`] prints it.
        wanted: String,
        /// What is wrong with the one that is given.
        why: String,
    },
    /// The device has too little for the shader.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// wgpu refuses the pipeline for another reason: a feature that the shader needs and the device was not asked for, a layout of
    /// another device, what a driver does not compile.
    #[error("wgpu refuses the pipeline: {0}")]
    Pipeline(String),
    /// The shader's invocations work together, so its workgroup has to be a tile, and it is larger than a tile can be.
    #[error(
        "the workgroup of {size:?} invocations is {area} pixels; tiles have at most {most}: choose smaller values for its overrides"
    )]
    GroupTooLarge {
        /// The workgroup's size.
        size: [u32; 3],
        /// Its invocations.
        area: u32,
        /// The most that there may be.
        most: u32,
    },
    /// The given layouts use the bind group that was chosen for the added bindings, which the shader itself leaves free.
    #[error(
        "bind group {group} is used for the added bindings, but the layouts define it: leave it `None`, or choose numbers in \
         one of the groups with `Options::place` and give its layout the entries of `vrcs::dispatch::bindings::layout_entries`"
    )]
    GroupTaken {
        /// The group.
        group: u32,
    },
    /// The added bindings lie in a group of the shader's own, and the given layouts leave it out.
    #[error(
        "bind group {group} holds bindings of the shader's and the two added ones, {first} and the next: give a layout for it \
         that has the entries of `vrcs::dispatch::bindings::layout_entries({first})`, too"
    )]
    GroupMissing {
        /// The group.
        group: u32,
        /// The parameters' binding number.
        first: u32,
    },
}

/// Why a pass cannot be dispatched over a view.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// The view's build does not serve the pass's mode.
    #[error(
        "the pass is {pass:?}, and the view's build options do not ask for that mode: make the view with `Pass::build_options`"
    )]
    Mode {
        /// The pass's mode.
        pass: Mode,
    },
    /// The tiles differ.
    #[error(
        "the pass was made for tiles of {pass:?} pixels, the view has tiles of {view:?}: make the view with `Pass::build_options`"
    )]
    Tile {
        /// The pass's tile.
        pass: [u32; 2],
        /// The view's tile.
        view: [u32; 2],
    },
    /// The view has larger rates than the pass copies.
    #[error(
        "the view's rates go up to {view}, the pass copies up to {pass}: make the view with `Pass::build_options`, or rewrite with a larger \
         `max_rate`"
    )]
    Rate {
        /// The pass's largest rate.
        pass: Rate,
        /// The view's largest rate.
        view: Rate,
    },
    /// The view's entries carry linear depth and the pass was not rewritten for that, or the other way round.
    #[error(
        "the view's entries carry linear depth: {view}; the pass was rewritten for entries that do: {pass}. Let `BuildOptions::linear_depth` and \
         the rewrite's `Options::linear_depth` (which a shader that asks `vrcs_depth()` turns on) agree"
    )]
    LinearDepth {
        /// Whether the pass reads it.
        pass: bool,
        /// Whether the view's entries carry it.
        view: bool,
    },
    /// The shader asks for the user's own bits of its tile, and the view's build has none.
    #[error(
        "the shader asks `vrcs_user()`, and the view's build options do not ask for the user's own bits of each tile: make the view with \
         `Pass::build_options`"
    )]
    User,
    /// They were made for different devices, of one instance or of several.
    #[error(
        "the pass and the view belong to different devices: make a view with the pass's device, or the pass once more with the view's"
    )]
    Device,
    /// More workgroups on one axis than the device dispatches.
    #[error(
        "the dispatch has {groups} workgroups on one axis, and the device dispatches at most {limit}: make the view's extent smaller, or \
         the shader's workgroup larger"
    )]
    TooManyGroups {
        /// The workgroups.
        groups: u32,
        /// The device's limit.
        limit: u32,
    },
}
