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
    /// Frames of each point.
    pub frames: u32,
    /// Of these so many are compared, the last.
    pub compared: u32,
    /// Rounds that shall count of those that are timed.
    pub rounds: u32,
    /// Where all chance comes from.
    pub seed: u64,
    /// The command that made it.
    pub command: String,
    /// What the reader should know of the times.
    pub note: String,
    /// Colours of rates, reasons and what is skipped: name and CSS colour.
    pub legends: BTreeMap<String, Vec<(String, String)>>,
    /// What all scenes together say of the paper's analysis.
    pub summary: Option<Summary>,
    /// What is not there yet; nothing once all is.
    pub unfinished: Option<String>,
    /// What was found for each scene.
    pub scenes: Vec<SceneStudy>,
}

/// What all scenes together say of the paper's analysis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The scenes.
    pub scenes: Vec<String>,
    /// Sentences on the paper's t and l.
    pub verdict: Vec<String>,
    /// By threshold, the mean of the scenes.
    pub curve: Vec<TruthAt>,
    /// The published estimators, as published, by the paper's threshold: the mean of the scenes.
    pub peers: Vec<(String, TruthAt)>,
}

/// What was found for a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneStudy {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub about: String,
    /// What runs for it and why, line by line: the plan of the general preset Balanced.
    pub plan: Vec<String>,
    /// Its own presets, chosen of what was measured; none before all is.
    pub chosen: Vec<Chosen>,
    /// The last frame at full rate, as a data URI.
    pub full: String,
    /// A part of it, pixel by pixel, if the whole is reduced.
    pub close: Option<Close>,
    /// The settings that were tried.
    pub points: Vec<Point>,
    /// For each measure of time and each of error, as `time flip_mean`, the points that no other beats in both, in the order of time.
    pub fronts: BTreeMap<String, Vec<usize>>,
    /// What could not be tried, and why.
    pub left_out: Vec<String>,
    /// What each declared effect adds.
    pub effects: Vec<Effect>,
    /// How far the analysis is from the truth.
    pub truth: Option<Truth>,
}

/// A part of a frame at full rate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Close {
    /// Left, top, width and height, in pixels of the frame.
    pub window: [u32; 4],
    /// The part, as a data URI.
    pub full: String,
}

/// What is chosen for a scene under the name of a preset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chosen {
    /// The preset.
    pub preset: String,
    /// The number of the point.
    pub point: usize,
    /// Why it is that one, in sentences.
    pub because: Vec<String>,
    /// What runs, line by line.
    pub plan: Vec<String>,
}

/// A setting that was tried, and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// What sets it apart, in a few words.
    pub name: String,
    /// The general preset that it is, which is the same for every scene.
    pub preset: Option<String>,
    /// Whether it stands for a published estimator.
    pub peer: bool,
    /// A whole sweep that tries the setting: [`Setting::to_sweep`].
    pub settings: String,
    /// The whole setting.
    pub setting: Setting,
    /// What the preset gives up.
    pub gives_up: Option<String>,
    /// What it looks like.
    #[serde(flatten)]
    pub seen: Seen,
    /// Against the same passes at full rate.
    pub time: Times,
    /// Pictures of the last frame as data URIs: `variable`, `close`, `flip`, and the layers `rates`, `reasons` and `skipped`. Of
    /// presets and some others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub pictures: BTreeMap<String, String>,
}

/// What a setting looks like.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// The share of pixels that are shaded, sky that is skipped not among them, 0 to 1; mean over the frames.
    pub primary_share: f64,
    /// The share of waves that find nothing to do, of a tiled dispatch at these rates, 0 to 1; mean over the frames. Lists launch
    /// hardly any of those.
    pub retired_share: f64,
    /// Shaded pixels for each pixel, by rates alone, 0 to 1; mean over the frames.
    pub average_rate: f64,
    /// Against the same frames at full rate.
    pub error: Errors,
    /// Whether the compared pictures have the full-rate pictures' bytes.
    pub identical: bool,
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

/// A median, and the interval that holds the true one in 95 of 100 cases: see [`median_interval`](super::clock::median_interval).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// The median.
    pub median: f64,
    /// Where the interval begins.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
}

impl Span {
    /// Whether it may as well be nothing.
    pub fn is_within_noise(&self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }
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
    /// The time at variable rate as a share of that at full rate in the same round.
    pub share: Span,
    /// A pass that never changes (the G-buffer), median: how steady the machine was.
    pub control_ms: f64,
    /// The same, 95th percentile.
    pub control_p95_ms: f64,
    /// Rounds that count.
    pub rounds: u32,
    /// How far the control was from its median, as a share: 95th percentile of all rounds.
    pub drift: f64,
    /// Whether enough rounds had a steady control; else all rounds count.
    pub is_steady: bool,
    /// Each stage of the machinery and each pass, in order.
    pub passes: Vec<PassTime>,
}

impl Times {
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
    /// At full rate, median; nothing for machinery, which full rate does without.
    pub full_ms: Option<f64>,
    /// The same, 95th percentile.
    pub full_p95_ms: Option<f64>,
    /// At variable rate: the median of the frames in which it runs, times the share of frames in which it does.
    pub variable_ms: f64,
    /// The 95th percentile of the frames in which it runs.
    pub variable_p95_ms: f64,
}

/// What a declared effect adds: the preset Balanced less the same without it, round by round.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Milliseconds of analysis, build and deblocking.
    pub machinery_ms: Span,
    /// Milliseconds of the whole frame; less than nothing where the effect saves more than it takes.
    pub frame_ms: Span,
    /// The share of pixels that are shaded for it, or not any more.
    pub primaries: f64,
    /// What mean ꟻLIP gains or loses.
    pub flip: f64,
}

/// Analyses against really coarsening the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// How the truth was found, for the reader.
    pub about: String,
    /// By threshold, at the paper's surroundings.
    pub curve: Vec<TruthAt>,
    /// By the luma of the surroundings, at the paper's threshold.
    pub ambients: Vec<TruthAt>,
    /// The published estimators, as published, by the paper's threshold.
    pub peers: Vec<(String, TruthAt)>,
}

/// An analysis against the truth at a threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthAt {
    /// The threshold.
    pub t: f64,
    /// The luma of the surroundings.
    pub l: f64,
    /// The share of quads whose true error at the analysis' rate is not below the threshold.
    pub too_coarse: f64,
    /// The share of the others that shade more pixels than they would in the cheapest way that stays below it.
    pub too_fine: f64,
    /// The average rate of the analysis: shaded pixels for each pixel.
    pub rate: f64,
    /// The average rate of the truth.
    pub true_rate: f64,
    /// SSIM of the picture that the analysis' rates give.
    pub ssim: f64,
}

impl SceneStudy {
    /// The presets for which a point is chosen.
    pub fn presets_of(&self, point: usize) -> Vec<&str> {
        let chosen = self.chosen.iter().filter(|chosen| chosen.point == point);
        chosen.map(|chosen| chosen.preset.as_str()).collect()
    }
}

impl TruthAt {
    /// Adds a share of another, number by number.
    pub fn add(&mut self, other: &TruthAt, share: f64) {
        let TruthAt {
            t,
            l,
            too_coarse,
            too_fine,
            rate,
            true_rate,
            ssim,
        } = other;
        for (sum, value) in [
            (&mut self.t, t),
            (&mut self.l, l),
            (&mut self.too_coarse, too_coarse),
            (&mut self.too_fine, too_fine),
            (&mut self.rate, rate),
            (&mut self.true_rate, true_rate),
            (&mut self.ssim, ssim),
        ] {
            *sum += share * value;
        }
    }
}
