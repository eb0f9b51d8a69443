//! Tile classification, for passes that are not shading: post-processing, reflections, anything with cheap and dear tiles.
//!
//! After Wicked Engine ("Tile-based optimization for post processing"): a picture is cut into tiles; the range of some value (circle of
//! confusion, velocity, roughness) in and around a tile says which of several shaders is enough for it; each class of tiles
//! gets a list and indirect arguments, and is shaded by its own pipeline.
//!
//! *Does*: reduces each tile to its least and greatest value, sorts the tiles by the caller's rules, writes lists and arguments. *Needs*:
//! a texture of floats. *Guarantees*: every tile is in exactly one list; no dimension of a dispatch is above the device's limit (wgpu would
//! silently dispatch nothing); counters are reset on the GPU, each frame; a tile with a value that is no number gets the last
//! class, whatever the rules. *Refuses*: rules that are no WGSL, at once and with the text around.
//!
//! Where the 3×3 neighbourhood counts (a blurred neighbour bleeds in), that is a second small dispatch over tiles; where it does
//! not, classes come straight from the reduction.
//!
//! ```no_run
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, coc: &wgpu::TextureView,
//! #      own: &wgpu::BindGroup, pipelines: &[wgpu::ComputePipeline], sources: &[&str; 3]) -> Result<(), Box<dyn std::error::Error>> {
//! use vrcs::classify::{Classifier, Options};
//!
//! // once: "early", "cheap" and "expensive", by Wicked's thresholds
//! let blur = Classifier::new(device, Options::circle_of_confusion(0.4, 0.2))?;
//! let mut lists = blur.bind(device, coc)?;
//! blur.set_extent(queue, &mut lists, [1920, 1080])?;
//! // a class's shader: bindings of @group(1) and vrcs_pixel() in front; workgroups of 64 in one dimension
//! let cheap = blur.wgsl("cheap", 1)? + sources[1];
//!
//! // each frame
//! blur.record(encoder, &lists)?;
//! let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
//! pass.set_bind_group(0, own, &[]);
//! for (class, pipeline) in pipelines.iter().enumerate() {
//!     pass.set_pipeline(pipeline);
//!     lists.dispatch(&mut pass, class, 1)?;
//! }
//! # Ok(())
//! # }
//! ```

pub mod cpu;
pub mod gpu;

pub use gpu::{Classifier, Lists};

use crate::limits::LimitError;

/// The most classes.
pub const MOST_CLASSES: usize = 8;

/// How tiles are classified.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The side of a tile, in pixels: a multiple of `block` and of 8, at most 64. Wicked's is 32.
    pub tile: u32,
    /// The side of the block that one workgroup of the classes' shaders does, `block`² invocations: 8 is Wicked's. A tile is done by
    /// `(tile / block)²` workgroups, Wicked's `tile_replicate`.
    pub block: u32,
    /// What is looked at: a WGSL expression of `texel`, a `vec4<f32>`, such as `texel.r` or `length(texel.rg)`.
    pub measure: String,
    /// Whether a tile's range is that of the 3×3 tiles around it.
    pub neighbourhood: bool,
    /// The classes; the first whose rule holds has the tile. The last has all tiles that are left and so needs no rule.
    pub classes: Vec<Class>,
    /// Functions and constants that the measure and the rules use, in WGSL.
    pub functions: String,
}

/// A class of tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// Its name.
    pub name: String,
    /// Which tiles it has.
    pub rule: Rule,
}

impl Class {
    /// A class.
    pub fn new(name: &str, rule: Rule) -> Class {
        Class {
            name: name.to_owned(),
            rule,
        }
    }
}

/// Which tiles a class has, by the least and the greatest value in and around them.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// The greatest value is below this.
    MaxBelow(f32),
    /// The least value is above this.
    MinAbove(f32),
    /// The greatest less the least is below this.
    RangeBelow(f32),
    /// A WGSL expression of `lo` and `hi`, both `f32`, is true.
    Wgsl(String),
    /// All that are left.
    Rest,
}

impl Options {
    /// Classes of your own over tiles of 32, shaded in blocks of 8, with the 3×3 neighbourhood.
    pub fn new(measure: &str, classes: Vec<Class>) -> Options {
        Options {
            tile: 32,
            block: 8,
            measure: measure.to_owned(),
            neighbourhood: true,
            classes,
            functions: String::new(),
        }
    }

    /// Depth of field, by the circle of confusion in the red channel: *early* where all of it is below `sharp` (nothing is
    /// blurred), *cheap* where it varies by less than `even` (one radius will do), *expensive* else. Wicked: 0.4 and 0.2.
    pub fn circle_of_confusion(sharp: f32, even: f32) -> Options {
        Options::three("texel.r", Rule::MaxBelow(sharp), Rule::RangeBelow(even))
    }

    /// Motion blur, by the velocity in red and green: *early* where all of it is below `still`, *cheap* where its length varies by less
    /// than `even`, *expensive* else. Wicked: 1e-4 and 2e-3, in parts of the screen.
    pub fn velocity(still: f32, even: f32) -> Options {
        Options::three(
            "length(texel.rg)",
            Rule::MaxBelow(still),
            Rule::RangeBelow(even),
        )
    }

    /// Reflections, by the roughness in the red channel: *early* where all of it is above `rough` (none is traced), *cheap* where all of
    /// it is below `mirror` (one ray, no blur), *expensive* else. Wicked's `rough` is 0.35. Neighbours do not count.
    pub fn roughness(rough: f32, mirror: f32) -> Options {
        Options {
            neighbourhood: false,
            ..Options::three("texel.r", Rule::MinAbove(rough), Rule::MaxBelow(mirror))
        }
    }

    fn three(measure: &str, early: Rule, cheap: Rule) -> Options {
        Options::new(
            measure,
            vec![
                Class::new("early", early),
                Class::new("cheap", cheap),
                Class::new("expensive", Rule::Rest),
            ],
        )
    }

    /// Workgroups for each tile.
    pub fn replicate(&self) -> u32 {
        (self.tile / self.block.max(1)).pow(2)
    }

    /// Tiles across and down.
    pub fn tiles(&self, extent: [u32; 2]) -> [u32; 2] {
        extent.map(|side| side.div_ceil(self.tile))
    }

    /// Looks for what cannot be.
    ///
    /// # Errors
    /// If there is.
    pub fn check(&self) -> Result<(), ClassifyError> {
        let err = |why: String| Err(ClassifyError::Options(why));
        let [tile, block] = [self.tile, self.block];
        if tile == 0 || !tile.is_multiple_of(8) || tile > 64 {
            return err(format!(
                "a tile's side is a multiple of 8, at most 64, not {tile}"
            ));
        }
        if block == 0 || !tile.is_multiple_of(block) || block > 16 {
            return err(format!(
                "a block's side divides the tile's and is at most 16 (256 invocations), not {block}"
            ));
        }
        if self.classes.is_empty() || self.classes.len() > MOST_CLASSES {
            return err(format!(
                "there are 1 to {MOST_CLASSES} classes, not {}",
                self.classes.len()
            ));
        }
        for (index, class) in self.classes.iter().enumerate() {
            let is_last = index + 1 == self.classes.len();
            if is_last != (class.rule == Rule::Rest) {
                return err(format!(
                    "the last class, and no other, has the rule `Rest`: see {:?}",
                    class.name
                ));
            }
            if self.classes[..index]
                .iter()
                .any(|other| other.name == class.name)
            {
                return err(format!("two classes are called {:?}", class.name));
            }
            if let Rule::MaxBelow(v) | Rule::MinAbove(v) | Rule::RangeBelow(v) = class.rule
                && !v.is_finite()
            {
                return err(format!("the limit of {:?} is {v}", class.name));
            }
        }
        Ok(())
    }
}

/// Why tiles cannot be classified so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ClassifyError {
    /// The options contradict themselves.
    #[error("classify: {0}")]
    Options(String),
    /// The measure, a rule or the functions are no WGSL.
    #[error("classify: the measure, the rules or the functions do not compile\n{0}")]
    Wgsl(String),
    /// There is no such class.
    #[error("classify: there is no class {0:?}; the classes are {1:?}")]
    NoClass(String, Vec<String>),
    /// There is no class of this index.
    #[error(
        "classify: there is no class {index}: there are {classes}, from 0 on; `Classifier::class` gives the index of a name"
    )]
    NoClassAt {
        /// The index.
        index: usize,
        /// How many there are.
        classes: usize,
    },
    /// The device has no bind group of this number.
    #[error(
        "classify: the lists are to be bind group {group}, and the device has {most}, from 0 on"
    )]
    NoGroup {
        /// The number.
        group: u32,
        /// How many there are.
        most: u32,
    },
    /// Lists whose extent was not set: nothing would be classified.
    #[error("classify: the lists have no extent yet: call `Classifier::set_extent`")]
    NoExtent,
    /// Lists of another classifier.
    #[error("classify: the lists were bound by a classifier with other classes")]
    OtherLists,
    /// What is given belongs to another device than the classifier.
    #[error("classify: the classifier and what it is given belong to different devices")]
    Device,
    /// The device has too little.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// wgpu does not take the texture, or the rules: a texture that no shader may read or of integers, what the rules need and the
    /// device has not.
    #[error("classify: wgpu refuses it: {0}")]
    Refused(String),
    /// The extent does not fit the texture, or has too many tiles.
    #[error("classify: {0}")]
    Extent(String),
}
