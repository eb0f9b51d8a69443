//! What a study has found, as data: written as JSON, CSV and the report.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::setting::Setting;

/// A study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The driver.
    pub adapter: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Frames of each point; the last four are compared.
    pub frames: u32,
    /// Frames of each point that are timed.
    pub rounds: u32,
    /// Where all chance comes from.
    pub seed: u64,
    /// The command that made it.
    pub command: String,
    /// What the reader should know of the times.
    pub note: String,
    /// Colours of rates and reasons: name and CSS colour.
    pub legends: BTreeMap<String, Vec<(String, String)>>,
    /// What was found for each scene.
    pub scenes: Vec<SceneStudy>,
}

/// What was found for a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneStudy {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub about: String,
    /// What runs for it and why, line by line: the plan of the preset Balanced.
    pub plan: Vec<String>,
    /// The last frame at full rate, as a data URI.
    pub full: String,
    /// The settings that were tried.
    pub points: Vec<Point>,
    /// What each declared effect adds.
    pub effects: Vec<Effect>,
    /// How far the analysis is from the truth.
    pub truth: Option<Truth>,
}

/// A setting that was tried, and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// What sets it apart, in a few words.
    pub name: String,
    /// The preset that it is.
    pub preset: Option<String>,
    /// Whether it stands for a published estimator.
    pub peer: bool,
    /// A whole sweep that tries the setting: [`Setting::to_sweep`].
    pub settings: String,
    /// The whole setting.
    pub setting: Setting,
    /// What the preset gives up.
    pub gives_up: Option<String>,
    /// The share of pixels that are shaded, 0 to 1.
    pub primary_share: f64,
    /// The share of waves that retire at once, 0 to 1.
    pub retired_share: f64,
    /// The mean of pixels shaded for each pixel shown, by rates alone, 0 to 1.
    pub average_rate: f64,
    /// Against the same frames at full rate.
    pub error: Errors,
    /// Against the same passes at full rate.
    pub time: Times,
    /// Whether the variable-rate pictures have the full-rate pictures' bytes.
    pub identical: bool,
    /// Pictures of the last frame as data URIs: `variable`, `flip`, and the layers `rates` and `reasons`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub pictures: BTreeMap<String, String>,
}

/// Distances from the full-rate pictures, means over the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// ꟻLIP, mean over the picture.
    pub flip_mean: f64,
    /// ꟻLIP, 99th percentile.
    pub flip_p99: f64,
    /// SSIM.
    pub ssim: f64,
    /// PSNR in decibels, of the mean square error over all frames; nothing if there is no difference.
    pub psnr: Option<f64>,
    /// The seam ratio.
    pub seam: f64,
    /// The share of quads whose rate changes from a frame to the next.
    pub flips: f64,
}

/// Times in milliseconds, by the GPU's clock.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// All passes at full rate, median.
    pub full_ms: f64,
    /// The same, 95th percentile.
    pub full_p95_ms: f64,
    /// All passes at variable rate with all machinery, median.
    pub variable_ms: f64,
    /// The same, 95th percentile.
    pub variable_p95_ms: f64,
    /// A pass that never changes (the G-buffer), median: how steady the machine was.
    pub control_ms: f64,
    /// The same, 95th percentile.
    pub control_p95_ms: f64,
    /// Each stage of the machinery and each pass, in order.
    pub passes: Vec<PassTime>,
}

impl Times {
    /// The time at variable rate as a share of that at full rate.
    pub fn share(&self) -> f64 {
        self.variable_ms / self.full_ms
    }

    /// What full rate does without: analysis, build, deblocking.
    pub fn machinery_ms(&self) -> f64 {
        let machinery = self.passes.iter().filter(|pass| pass.full_ms.is_none());
        machinery.map(|pass| pass.variable_ms).sum()
    }

    /// The share of the passes' own time that is saved, machinery not counted.
    pub fn saved_share(&self) -> f64 {
        1.0 - (self.variable_ms - self.machinery_ms()) / self.full_ms
    }
}

/// The time of a pass or of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassTime {
    /// Its name.
    pub name: String,
    /// At full rate; nothing for machinery, which full rate does without.
    pub full_ms: Option<f64>,
    /// At variable rate.
    pub variable_ms: f64,
}

/// What a declared effect adds: the preset Balanced less the same without it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Milliseconds of analysis, build and deblocking.
    pub machinery_ms: f64,
    /// Milliseconds of the whole frame; less than nothing where the effect saves more than it takes.
    pub frame_ms: f64,
    /// The share of pixels that are shaded for it, or not any more.
    pub primaries: f64,
    /// What mean ꟻLIP gains or loses.
    pub flip: f64,
}

/// The analysis against really coarsening each quad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// How the truth was found, for the reader.
    pub about: String,
    /// By threshold, at the paper's surroundings.
    pub curve: Vec<TruthAt>,
    /// By the luma of the surroundings, at the paper's threshold.
    pub ambients: Vec<TruthAt>,
}

/// The analysis against the truth at a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthAt {
    /// The threshold.
    pub t: f64,
    /// The luma of the surroundings.
    pub l: f64,
    /// The share of quads that the analysis makes coarser on some axis than the truth allows.
    pub too_coarse: f64,
    /// The share of the others that it leaves finer than the truth allows.
    pub too_fine: f64,
    /// The average rate of the analysis: shaded pixels for each pixel.
    pub rate: f64,
    /// The average rate of the truth.
    pub true_rate: f64,
    /// SSIM of the picture that the analysis' rates give.
    pub ssim: f64,
}
