//! What accuracy costs in time: scenes, a sweep of settings, errors and times, and a report.
//!
//! | room | what |
//! |---|---|
//! | [`setting`] | everything that can be varied, and the presets Exact, Balanced and Fast |
//! | [`sweep`] | which settings are tried: TOML |
//! | [`realise`] | from a setting and what a scene declares to what runs |
//! | [`rig`] | a setting at work on a scene, frame by frame |
//! | [`mod@bench`] | error and time of settings |
//! | [`turns`] | settings timed in turns, against full rate in the same round |
//! | [`effects`] | the effects that a scene declares |
//! | [`clock`] | times by the GPU's clock |
//! | [`truth`] | what coarsening really does |
//! | [`granularity`] | one rate for several quads |
//! | [`front`] | what nothing beats |
//! | [`choice`], [`chosen`] | the presets for a scene, by what was measured, and their file |
//! | [`journal`] | what is finished, on disk, to go on from |
//! | [`memory`] | whether it fits |
//! | [`run`] | a whole study |
//! | [`summary`] | all scenes together: Fig. 10 of the paper, and its t and l |
//! | [`study`], [`report`], [`pictures`], [`plot`] | what was found, as data, page, tables and pictures |
//!
//! # On a real GPU
//!
//! ```sh
//! cargo build --release                                      # metrics are computed on the CPU
//! vrcs tradeoff --quick --size 1920x1080 --out tradeoff      # presets, a few thresholds, the published estimators: minutes
//! vrcs tradeoff --size 1920x1080 --out tradeoff              # the standard sweep; interrupted, it goes on where it was
//! ```
//!
//! writes `report.html`, `points.csv`, `passes.csv`, `study.json`, `plot.svg` and `presets.toml`.

pub mod bench;
pub mod choice;
pub mod chosen;
pub mod clock;
pub mod effects;
pub mod front;
pub mod granularity;
pub mod journal;
pub mod memory;
pub mod pictures;
pub mod plot;
pub mod realise;
pub mod report;
pub mod rig;
pub mod run;
pub mod setting;
pub mod study;
pub mod summary;
pub mod sweep;
pub mod truth;
pub mod turns;

use crate::{check::gpu::GpuError, scenes::stage::StageError};

/// Why a study came to nothing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// The device has no timestamps.
    #[error(
        "{0} has no GPU timestamps, and time is what is to be measured: choose another by --adapter"
    )]
    NoClock(String),
    /// A setting calls for what cannot be had.
    #[error("{0}")]
    Setting(String),
    /// The pictures are too large for the device's memory.
    #[error(
        "pictures of {}x{} need about {gibibytes:.1} GiB at once, which {adapter} has not: choose a smaller --size",
        .size[0], .size[1]
    )]
    Memory {
        /// The device.
        adapter: String,
        /// Width and height.
        size: [u32; 2],
        /// What they need.
        gibibytes: f64,
    },
    /// A scene could not be staged.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// There is no device, or it refused something.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A file could not be written.
    #[error("{path}: {why}")]
    Write {
        /// The file.
        path: String,
        /// Why.
        why: String,
    },
    /// Something of this crate's own went wrong.
    #[error("{0}")]
    Own(String),
}
