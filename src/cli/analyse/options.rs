//! The settings of the stage, from the command line.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::{
    Rate,
    analyse::{Granularity, Peer, Settings, settings, written},
    cli::{Failure, files},
};

/// How the stage decides.
#[derive(Debug, clap::Args)]
pub(super) struct Options {
    /// Start from a published estimator.
    ///
    /// paper, gdc, nvidia-sample, fidelityfx, valar, sobel or wicked. The options below change it.
    #[arg(long, value_name = "NAME", default_value = "paper")]
    estimator: Peer,
    /// Start from settings in a file instead.
    ///
    /// Every parameter of every effect: see the example at the end of this help.
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["estimator", "white"])]
    settings: Option<PathBuf>,
    /// How large a difference may be, as a share of the luma around.
    ///
    /// t of the paper's Eq. 15, 0.15 there.
    #[arg(long, value_name = "T")]
    threshold: Option<f64>,
    /// The luma of the room, in the picture's units.
    ///
    /// l of the paper's Eq. 15, 0.05 there.
    #[arg(long, value_name = "L")]
    ambient: Option<f64>,
    /// How much more a quarter rate loses than a half: k of the paper's Eq. 14, 2.13 there.
    #[arg(long, value_name = "K", hide_short_help = true)]
    k: Option<f64>,
    /// Refit k to what is analysed: its spectrum is taken for 1/f^s, s is had from how its differences grow from one pixel to two,
    /// and the paper's Eq. 13 is solved for k. s is 1 in nature, and k then 2.13; 1 to 15 is what is taken.
    #[arg(long, conflicts_with = "k", hide_short_help = true)]
    pub(super) refit_k: bool,
    /// How differences become one error.
    #[arg(long, value_name = "NORM", hide_short_help = true)]
    norm: Option<Norm>,
    /// Which differences.
    #[arg(long, value_name = "SET", hide_short_help = true)]
    derivatives: Option<Derivatives>,
    /// Of what.
    #[arg(long, value_name = "OF", hide_short_help = true)]
    difference: Option<Difference>,
    /// What luma is made from: the colour, or its root in eight bits, as the deblocker keeps it.
    #[arg(
        long,
        value_name = "SOURCE",
        default_value = "colour",
        hide_short_help = true
    )]
    pub(super) luma_source: LumaSource,
    /// White of linear pictures (EXR, HDR), a power of two from 1/65536 to 65536: what is brighter is in doubt, and at full rate.
    #[arg(
        long,
        value_name = "WHITE",
        default_value = "1",
        hide_short_help = true
    )]
    white: f64,
    /// Limits between neighbours: none, limit or conservative.
    #[arg(long, value_name = "KIND", hide_possible_values = true)]
    smoothing: Option<Smoothing>,
    /// The coarsest rate, on each axis.
    ///
    /// 2x2 unless the settings say otherwise.
    #[arg(long, value_name = "WxH")]
    largest: Option<Rate>,
    /// The scale of the dynamic resolution, above 0 to 1: what foveation and overshoot hang on.
    #[arg(long, default_value = "1", value_name = "SCALE", value_parser = parse_scale, hide_short_help = true)]
    pub(super) resolution_scale: f64,
    /// The side of what has one estimate and one rate: 2, or 4, 8, 16 or 32 for tiles.
    ///
    /// A quad of 2 pixels is judged by the 4x4 pixels around it, a tile by its own pixels. 2 unless the settings say otherwise.
    #[arg(long, value_name = "N", value_parser = parse_granularity, hide_short_help = true)]
    granularity: Option<Granularity>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Norm {
    /// The mean.
    L1,
    /// The root mean square (the paper's Eq. 2).
    L2,
    /// The maximum.
    Linf,
    /// The root of the mean (VALAR).
    Root,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Derivatives {
    /// All pairs of neighbours.
    All,
    /// Every other (GDC).
    Interleaved,
    /// One in four.
    SubSampled,
    /// The quad's own (FidelityFX).
    Quad,
    /// Sobel's filter.
    Sobel,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Difference {
    /// Of luma.
    Luma,
    /// Of the channel that differs most.
    LargestChannel,
    /// Of the channels, weighted as luma is.
    Rgb,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LumaSource {
    /// The colour.
    Colour,
    /// √luma in eight bits.
    Root,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Smoothing {
    /// None.
    None,
    /// 4 beside 1 becomes 2 (the paper).
    Limit,
    /// Fine spreads into coarse (GDC).
    Conservative,
}

fn parse_granularity(text: &str) -> Result<Granularity, String> {
    let side = text.parse().ok().and_then(Granularity::of_side);
    side.ok_or_else(|| "a rate holds for squares of 2, 4, 8, 16 or 32 pixels".to_owned())
}

fn parse_scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if scale > 0.0 && scale <= 1.0 => Ok(scale),
        _ => Err("a scale is above 0 and at most 1".to_owned()),
    }
}

fn within(name: &str, value: f64, least: f64, most: f64) -> Result<f64, Failure> {
    match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(Failure::Misused(format!(
            "the {name} has to be from {least} to {most}"
        ))),
    }
}

impl Options {
    /// The file of settings.
    pub(super) fn settings_path(&self) -> Option<&PathBuf> {
        self.settings.as_ref()
    }

    /// The settings, given whether there is motion.
    pub(super) fn settings(&self, has_motion: bool) -> Result<Settings, Failure> {
        if self.estimator == Peer::Wicked && !has_motion {
            return Err(Failure::Misused(
                "the estimator wicked looks at motion alone: it needs --motion or --matrices"
                    .to_owned(),
            ));
        }
        let mut all = match &self.settings {
            Some(path) => read(path)?,
            None => self.estimator.settings(has_motion),
        };
        let content = &mut all.content;
        let log2 = self.white.log2();
        if log2.fract() != 0.0 || !(-16.0..=16.0).contains(&log2) {
            return Err(Failure::Misused(
                "white has to be a power of two from 1/65536 to 65536".to_owned(),
            ));
        }
        let white = match &self.settings {
            Some(_) => 2f64.powi(content.white_log2),
            None => self.white,
        };
        if self.settings.is_none() {
            content.white_log2 = log2 as i32;
            content.ambient /= white;
        }
        if let Some(threshold) = self.threshold {
            content.threshold = within("threshold", threshold, 0.0, 15.0)?;
        }
        if let Some(ambient) = self.ambient {
            content.ambient = within("luma of the room", ambient, 0.0, white)? / white;
        }
        if let Some(k) = self.k {
            content.k = within("factor k", k, 1.0, 15.0)?;
        }
        if let Some(norm) = self.norm {
            content.norm = match norm {
                Norm::L1 => settings::Norm::L1,
                Norm::L2 => settings::Norm::L2,
                Norm::Linf => settings::Norm::LInf,
                Norm::Root => settings::Norm::Root,
            };
        }
        if let Some(derivatives) = self.derivatives {
            content.pairs = match derivatives {
                Derivatives::All => settings::Pairs::All,
                Derivatives::Interleaved => settings::Pairs::Interleaved,
                Derivatives::SubSampled => settings::Pairs::SubSampled,
                Derivatives::Quad => settings::Pairs::Quad,
                Derivatives::Sobel => settings::Pairs::Sobel,
            };
        }
        if let Some(difference) = self.difference {
            content.difference = match difference {
                Difference::Luma => settings::Difference::Luma,
                Difference::LargestChannel => settings::Difference::LargestChannel,
                Difference::Rgb => settings::Difference::Rgb,
            };
        }
        if let Some(smoothing) = self.smoothing {
            all.smoothing = match smoothing {
                Smoothing::None => settings::Smoothing::None,
                Smoothing::Limit => settings::Smoothing::Limit,
                Smoothing::Conservative => settings::Smoothing::Conservative,
            };
        }
        if let Some(largest) = self.largest {
            all.largest = largest;
        }
        if let Some(granularity) = self.granularity {
            all.granularity = granularity;
        }
        Ok(all)
    }
}

/// Settings from a file.
pub(in crate::cli) fn read(path: &std::path::Path) -> Result<Settings, Failure> {
    let text = files::read_text(path)?;
    written::settings(&text).map_err(|(line, why)| {
        let line = line.map(|line| format!(":{line}")).unwrap_or_default();
        Failure::Outside(format!("{}{line}: {why}", files::display_name(path)))
    })
}
