//! One way to trade accuracy for time: everything that a sweep can vary.
//!
//! A setting says what is wanted; [`realise`](super::realise) says what of it a scene calls for.

use serde::{Deserialize, Serialize};

use crate::scenes::PassName;

/// A setting. Each field has the library's default, so a sweep names only what it varies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Setting {
    /// How much is given up at most.
    pub quality: Quality,
    /// What makes a difference noticeable.
    pub estimator: Estimator,
    /// t of Eq. 15: the share of the luma around it that a difference may have.
    pub threshold: f64,
    /// A factor on the estimator's own threshold; for motion alone, on the speeds, which it divides.
    pub tolerance: f64,
    /// l of Eq. 15: the luma of the surroundings, 0 to 1.
    pub ambient: f64,
    /// The norm over a window's derivatives.
    pub norm: NormName,
    /// Which derivatives are taken.
    pub derivatives: DerivativesName,
    /// Where luma comes from.
    pub luma: LumaName,
    /// The largest rate.
    pub largest: LargestName,
    /// Pixels across the area that shares one rate, the finest of its quads': 2, 4, 8 or 16.
    pub granularity: u32,
    /// Rates are made anew every so many frames.
    pub every: u32,
    /// Whether motion, where the scene has it, lowers rates, and the picture before is fetched along it.
    pub motion: bool,
    /// Whether smooth metal, where the scene tells it, is shaded finer.
    pub materials: bool,
    /// Whether sky, where the scene has it, is skipped by passes that have nothing to do there.
    pub sky: bool,
    /// The tolerance of the extra half rate, relative to `threshold`; 0 leaves it out, but for `grain`.
    pub half_rate: f64,
    /// Whether noise, where the scene tells where it is, gets the extra half rate: there alone, by half the threshold if `half_rate`
    /// says nothing else.
    pub grain: bool,
    /// Whether the picture after transparents, where the scene has it, is looked at too: what they cover may be coarser.
    pub transparents: bool,
    /// What keeps rates from going back and forth.
    pub hysteresis: HysteresisName,
    /// Which pixels may share.
    pub sharing: SharingName,
    /// What smooths blocks where they meet.
    pub deblock: DeblockName,
    /// Limits between the rates of neighbours.
    pub smoothing: SmoothingName,
    /// Whether primaries move from frame to frame.
    pub rotate: bool,
    /// How primaries find their pixels.
    pub mode: ModeName,
    /// Passes that run as their author wrote them, as those should that take less than variable rate costs them. Those that a scene
    /// does not have are passed over; if none is left, there is no analysis, no build and no deblocker either.
    pub full_rate: Vec<PassName>,
}

impl Default for Setting {
    fn default() -> Setting {
        Setting {
            quality: Quality::Adaptive,
            estimator: Estimator::Paper,
            threshold: 0.15,
            tolerance: 1.0,
            ambient: 0.05,
            norm: NormName::L2,
            derivatives: DerivativesName::All,
            luma: LumaName::Colour,
            largest: LargestName::R2x2,
            granularity: 2,
            every: 1,
            motion: true,
            materials: true,
            sky: true,
            half_rate: 0.0,
            grain: true,
            transparents: true,
            hysteresis: HysteresisName::Derived,
            sharing: SharingName::Declared,
            deblock: DeblockName::Guarded,
            smoothing: SmoothingName::Off,
            rotate: false,
            mode: ModeName::Tiled,
            full_rate: Vec::new(),
        }
    }
}

macro_rules! names {
    ($(#[$doc:meta])+ $name:ident { $($(#[$of:meta])+ $variant:ident = $text:literal,)+ }) => {
        $(#[$doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $name {
            $($(#[$of])+ #[serde(rename = $text)] $variant,)+
        }
    };
}

names! {
    /// How much is given up at most.
    Quality {
        /// Nothing: only work that provably changes nothing is left out.
        Exact = "exact",
        /// What the estimator says cannot be seen.
        Adaptive = "adaptive",
    }
}

names! {
    /// A published estimator: see [`Peer`](crate::analyse::peers::Peer).
    Estimator {
        /// Yang et al. 2019, Eq. 2, 15 and 16, with this setting's threshold, ambient, norm, derivatives and smoothing. Each of the
        /// others brings its own.
        Paper = "paper",
        /// NVIDIA at GDC 2019: pairs by Weber and Fechner.
        Gdc = "gdc",
        /// NVIDIA's sample: the largest derivative.
        NvidiaSample = "nvidia-sample",
        /// AMD's FidelityFX: the range of luma in a quad.
        FidelityFx = "fidelityfx",
        /// Intel's velocity-and-luminance form: the root of the mean absolute derivative.
        Valar = "valar",
        /// The Sobel operator, as several engines use.
        Sobel = "sobel",
        /// Wicked Engine: motion alone. Only for scenes that have motion.
        Wicked = "wicked",
    }
}

names! {
    /// A norm over derivatives.
    NormName {
        /// The mean.
        L1 = "l1",
        /// The root of the mean square.
        L2 = "l2",
        /// The largest.
        Max = "max",
    }
}

names! {
    /// Which derivatives are taken.
    DerivativesName {
        /// All pairs of neighbours.
        All = "all",
        /// Every other pair, in a checkerboard.
        Interleaved = "interleaved",
        /// Pairs of every other row and column.
        Subsampled = "subsampled",
    }
}

names! {
    /// Where luma comes from.
    LumaName {
        /// The shown colour, decoded exactly.
        Colour = "colour",
        /// The shown colour, decoded by squaring.
        Square = "square",
        /// The root of luma that the deblocker has left.
        Root = "root",
    }
}

names! {
    /// The largest rate.
    LargestName {
        /// Every pixel is shaded.
        R1x1 = "1x1",
        /// Up to 2×2.
        R2x2 = "2x2",
        /// Up to 2×4.
        R2x4 = "2x4",
        /// Up to 4×2.
        R4x2 = "4x2",
        /// Up to 4×4.
        R4x4 = "4x4",
    }
}

names! {
    /// What keeps rates from going back and forth.
    HysteresisName {
        /// Nothing.
        Off = "off",
        /// Two thresholds, as far apart as the norm asks.
        Derived = "derived",
        /// The error is divided by the gain of the rate that the frame before had.
        Compensated = "compensated",
    }
}

names! {
    /// Which pixels may share.
    SharingName {
        /// All of a block.
        Rate = "rate",
        /// Those that all that the scene has says belong together.
        Declared = "declared",
    }
}

names! {
    /// What smooths blocks where they meet.
    DeblockName {
        /// Nothing: what stands in a block is what its primary has.
        Off = "off",
        /// The filter that spills over all edges, as in the slides.
        Plain = "plain",
        /// The filter that stops where depth or surface, as far as the scene has them, differ.
        Guarded = "guarded",
    }
}

names! {
    /// Limits between the rates of neighbours.
    SmoothingName {
        /// None.
        Off = "off",
        /// 4 beside 1 becomes 2.
        Limit = "limit",
        /// No coarser than the mean of the neighbourhood.
        Conservative = "conservative",
    }
}

names! {
    /// How primaries find their pixels.
    ModeName {
        /// A workgroup a tile.
        Tiled = "tiled",
        /// One list for the picture.
        List = "list",
        /// Lists by class, in one dispatch.
        Classified = "classified",
    }
}

/// A field and its value, for a reader.
fn said(key: &str, value: &toml::Value) -> String {
    let key = key.replace('_', " ");
    match value {
        toml::Value::String(text) => format!("{key} {text}"),
        toml::Value::Array(values) => {
            let names: Vec<&str> = values.iter().filter_map(toml::Value::as_str).collect();
            format!("{} at {key}", names.join(" and "))
        }
        other => format!("{key} {other}"),
    }
}

impl Setting {
    /// The scene as its author wrote it: every pass at full rate, and no machinery.
    pub fn untouched() -> Setting {
        Setting {
            quality: Quality::Exact,
            deblock: DeblockName::Off,
            full_rate: PassName::ALL.to_vec(),
            ..Setting::default()
        }
    }

    /// What differs from the defaults, as name and value.
    fn differences(&self) -> Vec<(String, toml::Value)> {
        let (Ok(own), Ok(defaults)) = (
            toml::Table::try_from(self),
            toml::Table::try_from(Setting::default()),
        ) else {
            unreachable!("a setting is plain data");
        };
        own.into_iter()
            .filter(|(key, value)| defaults.get(key) != Some(value))
            .collect()
    }

    /// What differs from the defaults, for a reader: `norm l1, threshold 0.1`.
    pub fn summary(&self) -> String {
        let parts: Vec<String> = self
            .differences()
            .into_iter()
            .map(|(key, value)| said(&key, &value))
            .collect();
        match parts.is_empty() {
            true => "the defaults".to_owned(),
            false => parts.join(", "),
        }
    }

    /// The same with the estimator's name in front, the paper's too.
    pub fn estimator_summary(&self) -> String {
        let name = match toml::Value::try_from(self.estimator) {
            Ok(toml::Value::String(name)) => name,
            _ => unreachable!("an estimator is a name"),
        };
        let rest: Vec<String> = self
            .differences()
            .into_iter()
            .filter(|(key, _)| key != "estimator")
            .map(|(key, value)| said(&key, &value))
            .collect();
        match rest.is_empty() {
            true => name,
            false => format!("{name}, {}", rest.join(", ")),
        }
    }

    /// What differs from the defaults, and the threshold in any case, as name and value.
    pub fn said(&self) -> Vec<(String, toml::Value)> {
        let mut said = self.differences();
        if !said.iter().any(|(key, _)| key == "threshold") {
            said.push(("threshold".to_owned(), self.threshold.into()));
        }
        said
    }

    /// A whole sweep that tries this setting, beside the presets: `vrcs tradeoff --sweep` takes it as it is.
    pub fn to_sweep(&self) -> String {
        let lines: Vec<String> = self
            .said()
            .into_iter()
            .map(|(key, value)| format!("{key} = [{value}]\n"))
            .collect();
        format!("[[grid]]\n{}", lines.concat())
    }
}

/// A named setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it gives up.
    pub gives_up: &'static str,
    /// The setting.
    pub setting: Setting,
}

/// The presets, from the most accurate to the fastest.
pub fn presets() -> [Preset; 3] {
    [
        Preset {
            name: "Exact",
            gives_up: "nothing: passes that have nothing to do in the sky skip it, all else is shaded pixel by pixel",
            setting: Setting {
                quality: Quality::Exact,
                deblock: DeblockName::Off,
                mode: ModeName::Classified,
                ..Setting::default()
            },
        },
        Preset {
            name: "Balanced",
            gives_up: "detail that the paper's threshold calls invisible, at half that threshold",
            setting: Setting {
                threshold: 0.075,
                mode: ModeName::Classified,
                ..Setting::default()
            },
        },
        Preset {
            name: "Fast",
            gives_up: "detail up to the paper's threshold, with rates up to 4×2 and an extra half rate",
            setting: Setting {
                threshold: 0.15,
                largest: LargestName::R4x2,
                half_rate: 0.5,
                mode: ModeName::Classified,
                ..Setting::default()
            },
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_names_only_what_differs() {
        assert_eq!(Setting::default().summary(), "the defaults");
        let setting = Setting {
            norm: NormName::Max,
            threshold: 0.1,
            ..Setting::default()
        };
        assert_eq!(setting.summary(), "norm max, threshold 0.1");
    }

    #[test]
    fn what_is_copied_for_a_sweep_is_a_whole_sweep_of_that_setting() {
        let presets = presets().map(|preset| preset.setting);
        for setting in presets.into_iter().chain([Setting::default()]) {
            let trials = super::super::sweep::parse(&setting.to_sweep()).expect("a sweep");
            assert!(trials.iter().any(|trial| trial.setting == setting));
            assert!(trials.len() <= 4, "the presets, and no other");
        }
    }

    #[test]
    fn settings_survive_being_written() {
        for preset in presets() {
            let text = toml::to_string(&preset.setting).expect("plain data");
            assert_eq!(
                toml::from_str::<Setting>(&text).expect("the same"),
                preset.setting
            );
        }
    }
}
