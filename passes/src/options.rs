//! How a shader is to be rewritten.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// How primaries find their pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// One workgroup a tile, for the whole picture; a tile's primaries sit in its first invocations and the rest
    /// leave at once.
    #[default]
    Tiled,
    /// One list of the picture's primaries, packed without a gap, in one indirect dispatch: at most one wave of the whole
    /// picture is partial (the slides' "pixel commands").
    List,
    /// A list for each class of tiles, in one indirect dispatch: primaries of tiles that are one rate throughout are
    /// computed, only those of mixed tiles are loaded.
    Classified,
    /// Every invocation runs and nothing is copied; the shader asks `vrcs_copies()` how many share its pixel's work.
    Graded,
    /// The rewriter [chooses](crate::auto) tiled or list, and tells why in the manifest.
    Auto,
}

impl Mode {
    /// All modes but [`Mode::Auto`].
    pub const ALL: [Mode; 4] = [Mode::Tiled, Mode::List, Mode::Classified, Mode::Graded];
}

/// What becomes of pixels that the scene's coverage calls sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sky {
    /// They are not shaded and not written.
    #[default]
    Skip,
    /// They are shaded, by groups of their own.
    Shade,
}

/// The largest shading rate whose copies a rewritten shader makes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MaxRate {
    /// Up to 2×2 pixels a primary: copies are three conditional stores.
    #[default]
    #[serde(rename = "2x2")]
    R2x2,
    /// Up to 2 pixels across and 4 down: copies are a loop over a primary's duplicates.
    #[serde(rename = "2x4")]
    R2x4,
    /// Up to 4 pixels across and 2 down.
    #[serde(rename = "4x2")]
    R4x2,
    /// Up to 4 pixels across and 4 down.
    #[serde(rename = "4x4")]
    R4x4,
}

/// What becomes of a tile with so many primaries that packing them would retire no wave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FullTiles {
    /// All its pixels become their own primaries (the slides' rule: more than tile area − wave).
    #[default]
    Promote,
    /// Its primaries stay as they are (bonus slide 8).
    Keep,
}

/// What becomes of a target's stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Policy {
    /// Each primary's stores are repeated for its duplicates.
    #[default]
    Copy,
    /// Only the primary stores; its duplicates keep what they had.
    Leader,
    /// Every pixel stores what the original does: these stores and what they need run for every invocation, before
    /// anything else, with the pixel's own ids. Only mode `tiled` visits every pixel.
    Full,
    /// The entry point is refused if it stores here.
    Refuse,
}

/// What becomes of atomics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Atomics {
    /// An entry point that has any is refused.
    #[default]
    Refuse,
    /// Where the result is unused, a primary's atomic counts for all its pixels: a place that is a function of the ids gets
    /// one for each pixel, as a store would; elsewhere sums count as often as there are pixels, and minima, maxima and bit
    /// sets, which nothing changes by being repeated, once.
    Weight,
}

/// The width of a picture whose pixels a one-dimensional dispatch numbers row by row.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Linear {
    /// So many pixels.
    Pixels(u32),
    /// What the shader calls it: a uniform's or immediate's member (`params.width`, `frame.size.x`), or an `override`.
    Named(String),
}

impl std::str::FromStr for Linear {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Linear, Self::Err> {
        Ok(match text.parse() {
            Ok(pixels) => Linear::Pixels(pixels),
            Err(_) => Linear::Named(text.to_owned()),
        })
    }
}

impl std::fmt::Display for Linear {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Linear::Pixels(pixels) => write!(f, "{pixels}"),
            Linear::Named(name) => f.write_str(name),
        }
    }
}

/// Where the added bindings go: this number of this group and the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Place {
    /// The bind group.
    pub group: u32,
    /// The parameters' number; the coordinate buffer has the next.
    pub binding: u32,
}

impl std::str::FromStr for Place {
    type Err = String;

    /// Understands `GROUP:BINDING`.
    fn from_str(text: &str) -> Result<Place, Self::Err> {
        let parts = text.split_once(':');
        let numbers =
            parts.and_then(|(group, binding)| Some((group.parse().ok()?, binding.parse().ok()?)));
        match numbers {
            Some((group, binding)) => Ok(Place { group, binding }),
            None => Err(format!("`{text}` is not GROUP:BINDING, two numbers")),
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.group, self.binding)
    }
}

/// How the work between a shader's barriers is saved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Barriers {
    /// Each region falls into a part for the whole workgroup and a part for primaries only, and whole subgroups skip the
    /// latter.
    #[default]
    Split,
    /// Every invocation runs everything with its own ids, and only primaries store: nothing is saved but stores. For
    /// comparison.
    Mask,
}

/// The options of a rewrite.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// How do primaries find their pixels?
    pub mode: Mode,
    /// What is the largest shading rate?
    pub max_rate: MaxRate,
    /// How wide and high is a tile, in pixels? Its area is the new workgroup's size: 16×16 packs waves best on every GPU
    /// measured, and is the most that WebGPU's default limits allow.
    pub tile: [u32; 2],
    /// How many invocations retire together? 32 on NVIDIA and on AMD's newer GPUs. Only the nearly-full rule needs it.
    pub wave: u32,
    /// What becomes of nearly full tiles?
    pub full_tiles: FullTiles,
    /// What becomes of sky?
    #[serde(default)]
    pub sky: Sky,
    /// How many bind groups does the device have? WebGPU's default is 4.
    pub max_bind_groups: u32,
    /// How many bindings can a group have? Numbers are below that. wgpu's default is 1000.
    #[serde(default = "default_bindings_per_group")]
    pub max_bindings_per_group: u32,
    /// How many uniform buffers can a shader have? WebGPU's default is 12; one is added.
    #[serde(default = "default_uniform_buffers")]
    pub max_uniform_buffers: u32,
    /// How many storage buffers can a shader have? WebGPU's default is 8; one is added.
    #[serde(default = "default_storage_buffers")]
    pub max_storage_buffers: u32,
    /// Where do the added bindings go? If nothing is said: into the first free group, else into free numbers of a group that is
    /// in use.
    #[serde(default)]
    pub place: Option<Place>,
    /// How is the work between barriers saved?
    #[serde(default)]
    pub barriers: Barriers,
    /// How many bytes of workgroup memory does the device have? WebGPU's default is 16384. Only shaders with barriers
    /// take any.
    #[serde(default = "default_workgroup_memory")]
    pub max_workgroup_memory: u32,
    /// What becomes of each target's stores? Targets that are not named are copied, or have [every pixel store](crate::full::unasked) where
    /// copies cannot serve them.
    #[serde(default)]
    pub targets: BTreeMap<String, Policy>,
    /// What becomes of atomics?
    #[serde(default)]
    pub atomics: Atomics,
    /// Does the dispatch have one dimension, over the pixels' numbers `y * width + x`? Then this is the width.
    #[serde(default)]
    pub linear: Option<Linear>,
    /// Are the gradients of `textureSampleGrad` [scaled](crate::detail) by the block that a primary stands for, as hardware VRS
    /// does on its own?
    #[serde(default)]
    pub scale_gradients: bool,
    /// For which textures is the level of `textureSampleLevel` [biased](crate::detail) by log2 of the rate?
    #[serde(default)]
    pub bias_level: BTreeSet<String>,
    /// Do the entries of the view carry the linear depth of their primaries in their spare bits? A shader that declares
    /// [`vrcs_depth()`](crate::graded) is told it. No group may be larger than 2×2, and no side of a tile longer than 16.
    #[serde(default)]
    pub linear_depth: bool,
    /// Which pairs of writable bindings are, by the author's word, never the same memory?
    #[serde(default)]
    pub distinct: Vec<[String; 2]>,
    /// Which targets are, by the author's word, never read where another pixel stores, whatever its data: several pictures in one buffer,
    /// of which one is read and another is written? Needed only where the addresses do not show it.
    #[serde(default)]
    pub apart: BTreeSet<String>,
}

fn default_workgroup_memory() -> u32 {
    16384
}

fn default_bindings_per_group() -> u32 {
    1000
}

fn default_uniform_buffers() -> u32 {
    12
}

fn default_storage_buffers() -> u32 {
    8
}

impl Options {
    /// What becomes of a target's stores.
    pub fn policy(&self, target: &str) -> Policy {
        self.targets.get(target).copied().unwrap_or_default()
    }
}

impl Default for Options {
    fn default() -> Options {
        Options {
            mode: Mode::default(),
            max_rate: MaxRate::default(),
            tile: [16, 16],
            wave: 32,
            full_tiles: FullTiles::default(),
            sky: Sky::default(),
            max_bind_groups: 4,
            max_bindings_per_group: default_bindings_per_group(),
            max_uniform_buffers: default_uniform_buffers(),
            max_storage_buffers: default_storage_buffers(),
            place: None,
            barriers: Barriers::default(),
            max_workgroup_memory: default_workgroup_memory(),
            targets: BTreeMap::new(),
            atomics: Atomics::default(),
            linear: None,
            scale_gradients: false,
            bias_level: BTreeSet::new(),
            linear_depth: false,
            distinct: Vec::new(),
            apart: BTreeSet::new(),
        }
    }
}
