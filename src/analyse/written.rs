//! Settings as they are written in a file: TOML, in which every name is that of its field here, in kebab case.
//!
//! Does: reads [`Settings`]; what is left out has its default, and an effect that is not named is not there.
//! Guarantees: what is read is within the ranges that the fields' comments state.
//! Refuses: names that there are none of, values out of range, and what is no TOML, each with its line or its name.
//!
//! ```toml
//! largest = "4x2"
//! smoothing = "conservative"
//! [content]
//! threshold = 0.1
//! form = { pairwise = { sensitivity = 0.07 } }
//! [own.ids]
//! combiner = "min"
//! rates = { 3 = "2x2", 7 = "1x1" }
//! [own.distance]
//! steps = [[20.0, "2x1"], [60.0, "2x2"]]
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, de::Error};

use super::{
    own::IdRates,
    settings::{Blur, Form, Settings},
};
use crate::rate::Rate;

impl<'de> Deserialize<'de> for Rate {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Rate, D::Error> {
        String::deserialize(from)?.parse().map_err(D::Error::custom)
    }
}

/// Rates by their ids: a table of those that are stated.
pub(super) fn rates_by_id<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Vec<Option<Rate>>, D::Error> {
    let stated: BTreeMap<String, Rate> = BTreeMap::deserialize(from)?;
    let mut rates = Vec::new();
    for (id, rate) in stated {
        let id: u8 = id
            .parse()
            .map_err(|_| D::Error::custom(format!("an id is 0 to 255, not {id}")))?;
        let place = usize::from(id);
        rates.resize(rates.len().max(place + 1), None);
        rates[place] = Some(rate);
    }
    Ok(rates)
}

/// Up to four steps, each a distance and the rate from there on.
pub(super) fn steps<'de, D: Deserializer<'de>>(from: D) -> Result<[(f64, Rate); 4], D::Error> {
    let stated: Vec<(f64, Rate)> = Vec::deserialize(from)?;
    let is_rising = stated.windows(2).all(|pair| pair[0].0 < pair[1].0);
    if stated.len() > 4 || !is_rising || stated.iter().any(|(from, _)| from.is_nan()) {
        return Err(D::Error::custom(
            "a ladder has up to four steps, in order of distance",
        ));
    }
    let mut steps = [(f64::INFINITY, Rate::R1X1); 4];
    steps[..stated.len()].copy_from_slice(&stated);
    Ok(steps)
}

/// Reads settings; an error is a line, counted from 1, if it is known, and what is wrong.
pub(crate) fn settings(text: &str) -> Result<Settings, (Option<usize>, String)> {
    let settings: Settings = toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| {
            let before = text.get(..span.start).unwrap_or_default();
            before.matches('\n').count() + 1
        });
        (line, error.message().replace('\n', " "))
    })?;
    match out_of_range(&settings) {
        None => Ok(settings),
        Some(why) => Err((None, why)),
    }
}

/// The first value that is not within its range.
fn out_of_range(settings: &Settings) -> Option<String> {
    let content = &settings.content;
    let motion = settings.motion.unwrap_or_default();
    let materials = settings.materials.unwrap_or_default();
    let half_rate = settings.half_rate.unwrap_or_default();
    let safe = settings.safe_area.unwrap_or_default();
    let foveation = settings.foveation.clone().unwrap_or_default();
    let lens = settings.lens.unwrap_or_default();
    let reprojection = settings.reprojection.unwrap_or_default();
    let ladder = settings.own.clone().unwrap_or_default().distance;
    let ladder = ladder.unwrap_or_default();
    let sensitivity = match content.form {
        Form::Pairwise { sensitivity } => sensitivity,
        Form::Window | Form::Absolute => 0.0,
    };
    let error = match motion.blur {
        Blur::Standalone { error } => error,
        Blur::Scaled | Blur::Linear | Blur::Ladder(_) => 1.0,
    };
    let any = f64::MAX;
    let ranges = [
        ("content.threshold", content.threshold, 0.0, 15.0),
        ("content.ambient", content.ambient, 0.0, 1.0),
        ("content.k", content.k, 1.0, 15.0),
        (
            "content.white-log2",
            f64::from(content.white_log2),
            -16.0,
            16.0,
        ),
        ("content.form.pairwise.sensitivity", sensitivity, 0.0, 1.0),
        ("motion.weight", motion.weight, 0.0, 4.0),
        ("motion.scale", motion.scale[0], -any, any),
        ("motion.scale", motion.scale[1], -any, any),
        ("motion.blur.standalone.error", error, 0.0, any),
        (
            "reprojection.tolerance",
            reprojection.tolerance,
            0.0,
            f64::INFINITY,
        ),
        (
            "reprojection.near-over-far",
            reprojection.near_over_far,
            0.0,
            1.0,
        ),
        ("materials.least", materials.least, 0.0, 1.0),
        ("materials.slow", materials.slow, 0.0, any),
        ("materials.mirror", materials.mirror, 0.0, any),
        ("half-rate.tolerance", half_rate.tolerance, 0.0, 1.0),
        ("half-rate.fast", half_rate.fast, 0.0, f64::INFINITY),
        ("safe-area.tolerance", safe.tolerance, 1.0, 15.0),
        ("foveation.centre", foveation.centre[0], 0.0, 1.0),
        ("foveation.centre", foveation.centre[1], 0.0, 1.0),
        ("lens.focus", lens.focus, f64::MIN_POSITIVE, any),
        ("lens.infinity", lens.infinity, 0.0, any),
        ("lens.most", lens.most, 0.0, any),
        ("lens.near", lens.near, f64::MIN_POSITIVE, any),
        ("lens.far", lens.far, lens.near, f64::INFINITY),
        ("own.distance.near", ladder.near, f64::MIN_POSITIVE, any),
        ("own.distance.far", ladder.far, ladder.near, f64::INFINITY),
    ];
    let outside = ranges
        .into_iter()
        .find(|(_, value, least, most)| !(least..=most).contains(&value));
    if let Some((name, value, least, most)) = outside {
        return Some(format!(
            "{name} is {value}, and has to be from {least} to {most}"
        ));
    }
    let curves = [
        ("overshoot", &settings.overshoot),
        ("foveation.falloff", &foveation.falloff),
        ("foveation.strength", &foveation.strength),
    ];
    let bad = curves.into_iter().find(|(_, points)| {
        let is_rising = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let are_numbers = points.iter().flatten().all(|value| value.is_finite());
        !is_rising || !are_numbers || points.iter().any(|point| point[1] < 0.0)
    });
    bad.map(|(name, _)| format!("{name}: a curve is pairs of numbers, the first of which rise"))
}

/// Whether ids state any rate.
pub(crate) fn states_ids(ids: Option<&IdRates>) -> bool {
    ids.is_some_and(|ids| ids.rates.iter().any(Option::is_some))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyse::settings::*;

    #[test]
    fn an_empty_file_is_the_default() {
        assert_eq!(settings(""), Ok(Settings::default()));
    }

    #[test]
    fn every_effect_has_its_name() {
        let text = r#"
            later-blur = true
            stability = "hysteresis"
            transparents = true
            overshoot = [[0.85, 1.0], [1.0, 0.7]]
            smoothing = "limit"
            half-resolution = "footprint"
            largest = "4x4"
            [content]
            norm = "linf"
            pairs = "sub-sampled"
            difference = "largest-channel"
            transfer = "square"
            weights = "rec709"
            form = { pairwise = { sensitivity = 0.07 } }
            threshold = 0.1
            [motion]
            blur = { standalone = { error = 0.2 } }
            weight = 0.5
            scale = [-1920, 1080]
            [lens]
            focus = 3
            [reprojection]
            fetch = "tile"
            [materials]
            mirror = 2
            [half-rate]
            fast = inf
            [foveation]
            centre = [0.25, 0.5]
            [safe-area]
            width = 8
            [own.ids]
            combiner = "override"
            rates = { 2 = "2x2", 0 = "1x1" }
            [own.distance]
            steps = [[10, "2x1"], [20.5, "4x2"]]
            [own.particles]
            rate = "2x2"
        "#;
        let read = settings(text).expect("settings");
        let own = read.own.as_ref().expect("own rates");
        let ids = own.ids.as_ref().expect("ids");
        assert_eq!(ids.rates, [Some(Rate::R1X1), None, Some(Rate::R2X2)]);
        let ladder = own.distance.expect("a ladder");
        assert_eq!(ladder.steps[1], (20.5, Rate::R4X2));
        assert_eq!(ladder.steps[2].0, f64::INFINITY);
        let everything = Settings {
            content: Content {
                norm: Norm::LInf,
                pairs: Pairs::SubSampled,
                difference: Difference::LargestChannel,
                transfer: Transfer::Square,
                form: Form::Pairwise { sensitivity: 0.07 },
                weights: Weights::Rec709,
                threshold: 0.1,
                ..Content::default()
            },
            motion: Some(Motion {
                blur: Blur::Standalone { error: 0.2 },
                weight: 0.5,
                scale: [-1920.0, 1080.0],
            }),
            later_blur: true,
            stability: Stability::Hysteresis,
            transparents: true,
            overshoot: vec![[0.85, 1.0], [1.0, 0.7]],
            smoothing: Smoothing::Limit,
            half_resolution: Some(crate::analyse::HalfResolution::Footprint),
            largest: Rate::R4X4,
            ..read.clone()
        };
        assert_eq!(read, everything);
        assert!(read.is_by_tiles() && read.lens.is_some() && read.foveation.is_some());
    }

    #[test]
    fn what_is_wrong_is_told_by_line_or_by_name() {
        for (text, line, word) in [
            ("\nlargset = \"2x2\"", Some(2), "largset"),
            ("largest = \"4x1\"", Some(1), "4x1"),
            ("[own.ids]\nrates = { 256 = \"2x2\" }", Some(2), "0 to 255"),
            (
                "[own.distance]\nsteps = [[2, \"2x2\"], [1, \"2x1\"]]",
                Some(2),
                "order",
            ),
            (
                "[content]\nthreshold = nan",
                None,
                "content.threshold is NaN",
            ),
            ("[content]\nk = 0.5", None, "from 1 to 15"),
            ("[lens]\nnear = 0", None, "lens.near"),
            ("overshoot = [[1, 1], [0.5, 1]]", None, "overshoot"),
        ] {
            let (found, why) = settings(text).expect_err(text);
            assert_eq!(found, line, "{text}: {why}");
            assert!(why.contains(word), "{text}: {why}");
        }
    }
}
