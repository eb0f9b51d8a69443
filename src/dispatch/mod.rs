//! The dispatch stage: a rewritten shader as a compute pipeline, recorded into the caller's compute pass.

pub mod bindings;
mod prewritten;
pub mod reflect;

use std::{collections::HashMap, sync::Arc};

use naga::{ShaderStage, back::pipeline_constants::process_overrides, valid::ModuleInfo};
use vrcs_passes::{
    Color, Finding, Options, Refusal, Source, manifest,
    options::{Mode, Place},
};

use crate::{build::BuildOptions, rate::Rate, view::View};
use reflect::Unbindable;

/// How a [`Pass`] is made.
#[derive(Clone, Debug)]
pub struct PassOptions<'p> {
    /// A name for captures and messages.
    pub label: Option<&'p str>,
    /// The entry point; the only compute entry point if there is just one.
    pub entry: Option<&'p str>,
    /// How the shader is rewritten. By default its mode is [chosen](Mode::Auto) for it: see [`Pass::mode`]. Limits are the
    /// device's, but `max_bind_groups`, which may be lower.
    pub rewrite: Options,
    /// The layouts of the shader's own bind groups. If there are none, they are read off the shader; see
    /// [`Pass::bind_group_layout`]. A layout of the group in which the added bindings lie has their
    /// [entries](bindings::layout_entries), too.
    pub layouts: &'p [Option<&'p wgpu::BindGroupLayout>],
    /// Values of the shader's `override` constants.
    pub constants: &'p [(&'p str, f64)],
    /// The bytes of immediates that the shader uses.
    pub immediate_size: u32,
}

impl Default for PassOptions<'_> {
    fn default() -> Self {
        PassOptions {
            label: None,
            entry: None,
            rewrite: Options {
                mode: Mode::Auto,
                ..Options::default()
            },
            layouts: &[],
            constants: &[],
            immediate_size: 0,
        }
    }
}

impl<'p> PassOptions<'p> {
    /// The defaults, for a shader whose bind groups have the caller's layouts: `layouts[n]` is that of group n.
    pub fn with_layouts(layouts: &'p [Option<&'p wgpu::BindGroupLayout>]) -> PassOptions<'p> {
        PassOptions {
            layouts,
            ..PassOptions::default()
        }
    }
}

/// Why a [`Pass`] could not be made.
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
    /// The device has too few bind groups.
    #[error(
        "the shader needs bind group {group}, and the device has {groups}: request a higher `max_bind_groups`"
    )]
    TooManyGroups {
        /// The group.
        group: u32,
        /// What the device has.
        groups: u32,
    },
}

/// A rewritten shader, ready to be dispatched over [views](View).
#[derive(Debug)]
pub struct Pass {
    pipeline: wgpu::ComputePipeline,
    /// Where the added bindings are.
    added: Place,
    /// Whether their group is the caller's.
    is_shared: bool,
    layouts: Vec<Option<wgpu::BindGroupLayout>>,
    manifest: manifest::Entry,
    original_group_size: [u32; 3],
    warnings: Vec<Finding>,
    module: Arc<naga::Module>,
}

/// Why a pass cannot be dispatched over a view.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Mismatch {
    /// The view's build does not serve the pass's mode.
    #[error("the pass is {pass:?}, and the view's build options do not ask for that mode")]
    Mode {
        /// The pass's mode.
        pass: Mode,
    },
    /// The tiles differ.
    #[error("the pass was made for tiles of {pass:?} pixels, the view has tiles of {view:?}")]
    Tile {
        /// The pass's tile.
        pass: [u32; 2],
        /// The view's tile.
        view: [u32; 2],
    },
    /// The view has larger rates than the pass copies.
    #[error("the view's rates go up to {view}, the pass copies up to {pass}")]
    Rate {
        /// The pass's largest rate.
        pass: Rate,
        /// The view's largest rate.
        view: Rate,
    },
}

impl Pass {
    /// Rewrites a WGSL shader and makes its pipeline.
    ///
    /// # Errors
    /// See [`PassError`].
    pub fn new(
        device: &wgpu::Device,
        source: &Source,
        options: &PassOptions,
    ) -> Result<Pass, PassError> {
        let (module, info) = vrcs_passes::input::wgsl(source)
            .map_err(|invalid| PassError::Invalid(invalid.rendered))?;
        Pass::from_module(device, &module, &info, source, options)
    }

    /// Rewrites a naga module and makes its pipeline. `source` is the text that the module's spans point into; it
    /// may be empty.
    ///
    /// # Errors
    /// See [`PassError`].
    pub fn from_module(
        device: &wgpu::Device,
        module: &naga::Module,
        info: &ModuleInfo,
        source: &Source,
        options: &PassOptions,
    ) -> Result<Pass, PassError> {
        let _span = tracing::trace_span!("vrcs pass").entered();
        let refused = |refusal: Refusal| PassError::Refused {
            rendered: refusal.render(source, Color::Never),
            refusal,
        };
        let entry = match options.entry {
            Some(name) => vrcs_passes::Entries::Named(name),
            None => vrcs_passes::Entries::PerPixel,
        };
        let limits = device.limits();
        let rewrite_options = Options {
            max_bind_groups: options.rewrite.max_bind_groups.min(limits.max_bind_groups),
            max_bindings_per_group: limits.max_bindings_per_bind_group,
            max_uniform_buffers: limits.max_uniform_buffers_per_shader_stage,
            max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
            ..options.rewrite.clone()
        };
        let rewritten =
            vrcs_passes::rewrite(module, info, entry, &rewrite_options).map_err(refused)?;
        let Some(manifest) = rewritten.manifest.entries.first().cloned() else {
            unreachable!("a rewrite without a refusal has an entry");
        };
        let index = entry_index(&rewritten.module, &manifest.name);
        let original_group_size = group_size(module, info, &manifest.name, options.constants)?;
        check_tile(&manifest, original_group_size)?;
        let added = place_of(&manifest)?;
        let is_given = |group: u32| {
            let layout = options.layouts.get(group as usize);
            layout.is_some_and(Option::is_some)
        };
        if is_given(added.group) && !manifest.shares_group && options.rewrite.place.is_none() {
            return Err(PassError::GroupTaken { group: added.group });
        }
        let layouts = match options.layouts {
            [] => {
                let resources = reflect::resources(&rewritten.module, &rewritten.info, index)?;
                reflect::group_layouts(device, &resources, &manifest.name)
            }
            given => given.iter().map(|layout| layout.cloned()).collect(),
        };
        let (pipeline_layout, is_shared) =
            pipeline_layout(device, &layouts, added, manifest.shares_group, options)?;
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: options.label,
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(rewritten.module.clone())),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: options.label,
            layout: Some(&pipeline_layout),
            module: &shader,
            entry_point: Some(&manifest.name),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: options.constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        });
        Ok(Pass {
            pipeline,
            added,
            is_shared,
            layouts,
            manifest,
            original_group_size,
            warnings: rewritten.warnings.into_iter().map(|(_, w)| w).collect(),
            module: Arc::new(rewritten.module),
        })
    }

    /// What is known of the rewritten entry point.
    pub fn manifest(&self) -> &manifest::Entry {
        &self.manifest
    }

    /// What the rewriter warns of.
    pub fn warnings(&self) -> &[Finding] {
        &self.warnings
    }

    /// The rewritten module.
    pub fn module(&self) -> &naga::Module {
        &self.module
    }

    /// The workgroup size that the shader was written for.
    pub fn original_group_size(&self) -> [u32; 3] {
        self.original_group_size
    }

    /// The layout of one of the shader's own bind groups; `None` if it uses no such group. That of a
    /// [shared](Pass::shared_group) group has the added bindings, too.
    pub fn bind_group_layout(&self, group: u32) -> Option<&wgpu::BindGroupLayout> {
        match group == self.added.group && !self.is_shared {
            true => None,
            false => self.layouts.get(group as usize)?.as_ref(),
        }
    }

    /// How primaries find their pixels, and why if it was chosen for the shader.
    pub fn mode(&self) -> (Mode, Option<&str>) {
        (self.manifest.mode, self.manifest.mode_reason.as_deref())
    }

    /// What a view's build has to be for this pass, other wishes being as given: its mode, its tile, and a largest rate that both
    /// the pass copies and the tile has room for.
    ///
    /// A view that several passes share needs what each of them does; where their tiles differ, it takes two views.
    pub fn build_options(&self, wishes: BuildOptions) -> BuildOptions {
        let copied: Rate = self.manifest.max_rate.into();
        let mode = self.manifest.mode;
        let options = BuildOptions {
            modes: wishes.modes.with(mode),
            ..wishes
        };
        if mode == Mode::Graded {
            return options;
        }
        let largest = match options.largest.is_within(copied) {
            true => options.largest,
            false => copied,
        };
        BuildOptions { largest, ..options }
            .for_tile(self.manifest.tile_for(self.original_group_size))
    }

    /// Whether the pass can be dispatched over a view.
    ///
    /// # Errors
    /// What does not fit.
    pub fn check(&self, view: &View) -> Result<(), Mismatch> {
        let built = view.options();
        let mode = self.manifest.mode;
        if !built.modes.has(mode) {
            return Err(Mismatch::Mode { pass: mode });
        }
        let tile = self.manifest.tile_for(self.original_group_size);
        if mode != Mode::Graded && built.tile != tile {
            return Err(Mismatch::Tile {
                pass: tile,
                view: built.tile,
            });
        }
        let largest: Rate = self.manifest.max_rate.into();
        if mode != Mode::Graded && !built.largest.is_within(largest) {
            return Err(Mismatch::Rate {
                pass: largest,
                view: built.largest,
            });
        }
        Ok(())
    }

    /// Records a dispatch over a view's extent. Sets the pipeline and this crate's own bind group, unless that is
    /// [shared](Pass::shared_group); the caller has set theirs, with dynamic offsets and immediates as they need.
    ///
    /// # Panics
    /// If the pass does not [fit](Pass::check) the view.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass, view: &View) {
        let _span = tracing::trace_span!("vrcs dispatch", entry = self.manifest.name).entered();
        let mode = self.manifest.mode;
        if let Err(mismatch) = self.check(view) {
            panic!("{mismatch}");
        }
        pass.set_pipeline(&self.pipeline);
        if !self.is_shared {
            let group = view.bind_group(self.original_group_size, mode, self.added.binding);
            let Some(group) = group else {
                unreachable!("the build serves the mode");
            };
            pass.set_bind_group(self.added.group, &group, &[]);
        }
        match view.arguments(mode, self.manifest.sky) {
            Some((arguments, at)) if view.is_enabled() => {
                pass.dispatch_workgroups_indirect(arguments, at);
            }
            _ => {
                let [x, y, z] = self
                    .manifest
                    .groups_for(view.extent(), self.original_group_size);
                pass.dispatch_workgroups(x, y, z);
            }
        }
    }
}

fn entry_index(module: &naga::Module, name: &str) -> usize {
    let found = module
        .entry_points
        .iter()
        .position(|entry| entry.name == name && entry.stage == ShaderStage::Compute);
    match found {
        Some(index) => index,
        None => unreachable!("the rewriter keeps the names of entry points"),
    }
}

/// Refuses a workgroup that has to be a tile, and is larger than tiles can be.
fn check_tile(manifest: &manifest::Entry, size: [u32; 3]) -> Result<(), PassError> {
    const MOST: u32 = 256;
    let area = size
        .iter()
        .fold(1, |area: u32, side| area.saturating_mul(*side));
    match manifest.group.is_some() && area > MOST {
        true => Err(PassError::GroupTooLarge {
            size,
            area,
            most: MOST,
        }),
        false => Ok(()),
    }
}

/// The workgroup size of an entry point, its overrides resolved.
pub(crate) fn group_size(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &str,
    constants: &[(&str, f64)],
) -> Result<[u32; 3], PassError> {
    let constants: HashMap<String, f64> = constants
        .iter()
        .map(|&(name, value)| (name.to_owned(), value))
        .collect();
    let constants = constants.into_iter().collect();
    let (resolved, _) = process_overrides(
        module,
        info,
        Some((ShaderStage::Compute, entry)),
        &constants,
    )
    .map_err(|error| PassError::Constants(error.to_string()))?;
    Ok(resolved.entry_points[entry_index(&resolved, entry)].workgroup_size)
}

/// Where the added bindings are.
fn place_of(manifest: &manifest::Entry) -> Result<Place, PassError> {
    let unfit = |why: &str| PassError::Manifest(why.to_owned());
    let [params, coords] = manifest.bindings.as_slice() else {
        return Err(unfit("it does not name the two added bindings"));
    };
    let is_pair = params.group == coords.group
        && params.binding.checked_add(1) == Some(coords.binding)
        && (params.name.as_str(), coords.name.as_str()) == ("params", "coords");
    match is_pair {
        true => Ok(Place {
            group: params.group,
            binding: params.binding,
        }),
        false => Err(unfit("the added bindings are not two in a row")),
    }
}

/// The layout of a pipeline, and whether the group of the added bindings is the caller's.
fn pipeline_layout(
    device: &wgpu::Device,
    layouts: &[Option<wgpu::BindGroupLayout>],
    added: Place,
    shares_group: bool,
    options: &PassOptions,
) -> Result<(wgpu::PipelineLayout, bool), PassError> {
    let Place { group, binding } = added;
    let groups = device.limits().max_bind_groups;
    if group >= groups {
        return Err(PassError::TooManyGroups { group, groups });
    }
    let mut all: Vec<Option<&wgpu::BindGroupLayout>> = layouts.iter().map(Option::as_ref).collect();
    while all.len() <= group as usize {
        all.push(None);
    }
    let is_given = !options.layouts.is_empty() && all[group as usize].is_some();
    let is_shared = shares_group || is_given;
    if is_shared && all[group as usize].is_none() {
        return Err(PassError::GroupMissing {
            group,
            first: binding,
        });
    }
    let own = (!is_shared).then(|| View::bind_group_layout(device, binding));
    if let Some(own) = &own {
        all[group as usize] = Some(own);
    }
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: options.label,
        bind_group_layouts: &all,
        immediate_size: options.immediate_size,
    });
    Ok((layout, is_shared))
}
