//! The presets for a scene: of what was measured, that which gives up no more than the general preset and takes the least time.
//!
//! *Does*: from the times of the general presets, finds settings that may do better ([`candidates`]): passes that variable rate only
//! slows stay as their author wrote them, effects that cost more than they save are left out. Once those are measured too, [`choose`]s.
//! *Guarantees*: what is chosen has no larger mean ꟻLIP than the general preset of its name, so that nothing measured beats it in both
//! but what flickers; it is surely faster than full rate (by the whole interval of its time), or it is the scene as its author wrote it.
//! Each choice has its reasons.

use super::{
    effects::without,
    realise::realise,
    report::break_even_ms,
    setting::{Quality, Setting, presets},
    study::{Chosen, PassTime, Point, SceneStudy},
};
use crate::scenes::{PassName, SceneName};

/// What the scene as its author wrote it is called.
pub const UNTOUCHED: &str = "full rate";

/// A pass that variable rate brings less than this share of its time is left alone.
const WORTH: f64 = 0.02;

/// Rates of so many quads may change in a frame, whatever the general preset's do.
const STEADY: f64 = 0.01;

/// The point of a general preset.
fn general<'s>(study: &'s SceneStudy, preset: &str) -> Option<(usize, &'s Point)> {
    let mut points = study.points.iter().enumerate();
    points.find(|(_, point)| point.preset.as_deref() == Some(preset))
}

/// Whether variable rate brings a pass nothing.
fn is_light(pass: &PassTime) -> bool {
    pass.full_ms
        .is_some_and(|full| pass.variable_ms > full * (1.0 - WORTH))
}

fn light_passes(point: &Point) -> Vec<PassName> {
    let light: Vec<&str> = point
        .time
        .passes
        .iter()
        .filter(|pass| is_light(pass))
        .map(|pass| pass.name.as_str())
        .collect();
    let all = PassName::ALL.into_iter();
    all.filter(|pass| light.contains(&pass.entry())).collect()
}

/// The effects that surely take more time than they save, the costliest first.
fn costly(study: &SceneStudy) -> Vec<&str> {
    let mut effects: Vec<_> = study
        .effects
        .iter()
        .filter(|effect| effect.frame_ms.low > 0.0)
        .collect();
    effects.sort_by(|a, b| b.frame_ms.median.total_cmp(&a.frame_ms.median));
    effects.iter().map(|effect| effect.name.as_str()).collect()
}

/// Settings that may do better than the general presets, by name; none that has a point already.
pub fn candidates(scene: SceneName, study: &SceneStudy) -> Vec<(String, Setting)> {
    let costly = costly(study);
    let mut found: Vec<(String, Setting)> = Vec::new();
    for preset in presets() {
        let Some((_, point)) = general(study, preset.name) else {
            continue;
        };
        if preset.setting.quality == Quality::Exact {
            continue;
        }
        let light = light_passes(point);
        let base = Setting {
            full_rate: light.clone(),
            ..preset.setting.clone()
        };
        let mut sets: Vec<Vec<&str>> = vec![Vec::new()];
        sets.extend(costly.iter().take(2).map(|&effect| vec![effect]));
        if costly.len() > 1 {
            sets.push(costly.clone());
        }
        for set in sets {
            let setting = set
                .iter()
                .fold(base.clone(), |s, effect| without(effect, &s));
            let is_known = study.points.iter().any(|point| point.setting == setting)
                || found.iter().any(|(_, known)| *known == setting);
            // what can be had, and is not the scene untouched by another name
            let runs = realise(scene, &setting, false).is_ok_and(|real| real.build.is_some());
            if !is_known && runs {
                found.push((name(preset.name, &set, &light), setting));
            }
        }
    }
    found
}

fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

fn name(preset: &str, effects: &[&str], light: &[PassName]) -> String {
    let mut name = preset.to_owned();
    if !effects.is_empty() {
        name += &format!(" without {}", listed(effects));
    }
    if !light.is_empty() {
        let light: Vec<&str> = light.iter().map(|pass| pass.entry()).collect();
        name += &format!(", {} at full rate", listed(&light));
    }
    name
}

/// The presets for a scene, one for each general preset that was tried.
pub fn choose(scene: SceneName, study: &SceneStudy) -> Vec<Chosen> {
    let mut all = Vec::new();
    for preset in presets() {
        let Some((at, general)) = general(study, preset.name) else {
            continue;
        };
        let gives_up_no_more = |point: &Point| match preset.setting.quality {
            Quality::Exact => point.seen.identical,
            Quality::Adaptive => point.seen.error.flip_mean <= general.seen.error.flip_mean,
        };
        let is_steady =
            |point: &Point| point.seen.error.flips <= general.seen.error.flips.max(STEADY);
        let is_faster = |point: &Point| point.time.share.high < 1.0;
        let is_untouched = |point: &Point| is_idle(scene, &point.setting);
        let fits =
            |point: &Point| gives_up_no_more(point) && (is_untouched(point) || is_faster(point));
        let share = |index: usize| match is_untouched(&study.points[index]) {
            true => 1.0,
            false => study.points[index].time.share.median,
        };
        let best = |wanted: &dyn Fn(&Point) -> bool| {
            (0..study.points.len())
                .filter(|&index| wanted(&study.points[index]))
                .min_by(|&a, &b| {
                    let error = |index: usize| study.points[index].seen.error.flip_mean;
                    let by_error = error(a).total_cmp(&error(b));
                    share(a).total_cmp(&share(b)).then(by_error)
                })
        };
        let Some(point) = best(&|point| fits(point) && is_steady(point)) else {
            continue;
        };
        let flickers = best(&fits).filter(|&other| share(other) < share(point));
        let mut because = match is_untouched(&study.points[point]) {
            true => vec![left_alone(general)],
            false => reasons(study, general, point, at),
        };
        because.extend(flickers.map(|other| flicker(&study.points[other], general)));
        let plan = realise(scene, &study.points[point].setting, false);
        all.push(Chosen {
            preset: preset.name.to_owned(),
            point,
            because,
            plan: plan.map_or_else(|why| vec![why], |plan| plan.lines(scene)),
        });
    }
    all
}

/// Whether a setting leaves a scene as its author wrote it: whatever its time seems to be is full rate's.
fn is_idle(scene: SceneName, setting: &Setting) -> bool {
    realise(scene, setting, false).is_ok_and(|runs| runs.build.is_none())
}

fn flicker(point: &Point, general: &Point) -> String {
    format!(
        "{} is faster still, but the rates of {:.1} % of the quads change from a frame to the next, where the general preset changes {:.1} %.",
        point.name,
        100.0 * point.seen.error.flips,
        100.0 * general.seen.error.flips
    )
}

/// Why a point was chosen in place of a general preset.
fn reasons(study: &SceneStudy, general: &Point, at: usize, general_at: usize) -> Vec<String> {
    let point = &study.points[at];
    let mut because = vec![match at == general_at {
        true => "It is the general preset: nothing that was measured is faster and has no larger mean ꟻLIP.".to_owned(),
        false => format!(
            "{}: {:.3} of full rate at a mean ꟻLIP of {:.4}, where the general preset has {:.3} and {:.4}.",
            point.name,
            point.time.share.median,
            point.seen.error.flip_mean,
            general.time.share.median,
            general.seen.error.flip_mean
        ),
    }];
    for pass in &point.setting.full_rate {
        because.extend(light(general, pass.entry()));
    }
    for effect in &study.effects {
        let is_left_out = point.setting == without(&effect.name, &point.setting)
            && general.setting != without(&effect.name, &general.setting);
        if is_left_out {
            because.push(format!(
                "Without {}: it adds {:+.3} ms to the frame [{:+.3}, {:+.3}] and {:+.4} to mean ꟻLIP.",
                effect.name,
                effect.frame_ms.median,
                effect.frame_ms.low,
                effect.frame_ms.high,
                effect.flip
            ));
        }
    }
    because
}

/// Why nothing is made variable-rate.
fn left_alone(general: &Point) -> String {
    let passes = format!(
        "These passes take {:.3} ms in all at full rate",
        general.time.full_ms
    );
    let share = general.time.share;
    match break_even_ms(general) {
        Some(ms) if ms > 0.0 && share.median < 1.0 => format!(
            "{passes}; the general preset takes {:.3} of that, in 95 of 100 cases {:.3} to {:.3}, and nothing that was measured and gives up \
             no more is surely faster: the scene is left alone.",
            share.median, share.low, share.high
        ),
        Some(ms) if ms > 0.0 => format!(
            "{passes}; with the general preset variable rate pays from {ms:.3} ms, and no other that was measured and gives up no more is \
             surely faster: the scene is left alone."
        ),
        Some(_) => {
            format!("{passes}, and nothing in them is provably empty: the scene is left alone.")
        }
        None => {
            format!(
                "{passes}, and no less by the general preset, whatever it leaves unshaded: the scene is left alone."
            )
        }
    }
}

/// Why a pass is left alone, and from what time on it would not be.
fn light(general: &Point, name: &str) -> Option<String> {
    let mut passes = general.time.passes.iter();
    let pass = passes.find(|pass| pass.name == name)?;
    let full = pass.full_ms?;
    let from = match pass_break_even_ms(pass, general.seen.primary_share) {
        Some(ms) => format!("; it would pay from some {ms:.3} ms"),
        None => String::new(),
    };
    Some(format!(
        "{name} stays as its author wrote it: {full:.3} ms at full rate, {:.3} ms rewritten{from}.",
        pass.variable_ms
    ))
}

/// From what time at full rate on a pass alone gains by variable rate, in milliseconds, if `shaded` of its pixels are shaded: what
/// it takes beyond that share of its time is held to be the same for a heavier pass. Nothing if all pixels are shaded.
pub fn pass_break_even_ms(pass: &PassTime, shaded: f64) -> Option<f64> {
    let beyond = pass.variable_ms - shaded * pass.full_ms?;
    (shaded < 1.0).then(|| beyond.max(0.0) / (1.0 - shaded))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::study::{Effect, Errors, Seen, Span, Times};

    fn pass(name: &str, full_ms: f64, variable_ms: f64) -> PassTime {
        PassTime {
            name: name.to_owned(),
            full_ms: Some(full_ms),
            variable_ms,
            full_p95_ms: Some(full_ms),
            variable_p95_ms: variable_ms,
        }
    }

    fn point(name: &str, setting: Setting, share: f64, flip_mean: f64) -> Point {
        let preset = presets().into_iter().find(|preset| preset.name == name);
        Point {
            name: name.to_owned(),
            preset: preset.map(|preset| preset.name.to_owned()),
            peer: false,
            settings: setting.to_sweep(),
            setting,
            gives_up: None,
            seen: Seen {
                primary_share: 0.5,
                identical: flip_mean == 0.0,
                error: Errors {
                    flip_mean,
                    ..Errors::default()
                },
                ..Seen::default()
            },
            time: Times {
                full_ms: 1.0,
                variable_ms: share,
                share: Span {
                    median: share,
                    low: share - 0.01,
                    high: share + 0.01,
                },
                passes: vec![pass("rays", 0.9, 0.4), pass("composite", 0.1, 0.12)],
                ..Times::default()
            },
            pictures: Default::default(),
        }
    }

    fn study(shares: [f64; 3]) -> SceneStudy {
        let mut points: Vec<Point> = presets()
            .into_iter()
            .zip(shares)
            .zip([0.0, 0.01, 0.02])
            .map(|((preset, share), flip)| point(preset.name, preset.setting, share, flip))
            .collect();
        points.push(point(UNTOUCHED, Setting::untouched(), 1.0, 0.0));
        SceneStudy {
            points,
            effects: vec![
                Effect {
                    name: "motion".to_owned(),
                    frame_ms: Span {
                        median: 0.05,
                        low: 0.04,
                        high: 0.06,
                    },
                    ..Effect::default()
                },
                Effect {
                    name: "deblocking".to_owned(),
                    frame_ms: Span {
                        median: 0.01,
                        low: -0.01,
                        high: 0.02,
                    },
                    ..Effect::default()
                },
            ],
            ..SceneStudy::default()
        }
    }

    #[test]
    fn a_pass_that_gets_slower_and_an_effect_that_costs_are_tried_without() {
        let found = candidates(SceneName::Foliage, &study([0.97, 0.7, 0.6]));
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            [
                "Balanced, composite at full rate",
                "Balanced without motion, composite at full rate",
                "Fast, composite at full rate",
                "Fast without motion, composite at full rate",
            ]
        );
        assert!(!found[1].1.motion && found[1].1.full_rate == [PassName::Composite]);
    }

    #[test]
    fn the_fastest_that_gives_up_no_more_is_chosen_and_says_why() {
        let mut study = study([0.97, 0.7, 0.6]);
        for (name, setting) in candidates(SceneName::Foliage, &study) {
            let (share, flip) = match name.starts_with("Balanced without") {
                // faster, and no worse
                true => (0.65, 0.009),
                // faster, and worse than its general preset
                false => (0.5, 0.03),
            };
            study.points.push(point(&name, setting, share, flip));
        }
        let chosen = choose(SceneName::Foliage, &study);
        let names: Vec<&str> = chosen
            .iter()
            .map(|chosen| study.points[chosen.point].name.as_str())
            .collect();
        assert_eq!(
            names,
            [
                "Exact",
                "Balanced without motion, composite at full rate",
                "Fast"
            ]
        );
        let because = chosen[1].because.join("\n");
        for said in [
            "0.650 of full rate",
            "composite stays as its author wrote it: 0.100 ms at full rate, 0.120 ms rewritten; it would pay from some 0.140 ms",
            "Without motion: it adds +0.050 ms",
        ] {
            assert!(because.contains(said), "{said}: {because}");
        }
        assert!(chosen[2].because[0].contains("general preset"));
    }

    #[test]
    fn no_preset_loses_time_what_is_not_surely_faster_is_left_alone() {
        let study = study([1.02, 0.995, 1.4]);
        let chosen = choose(SceneName::Foliage, &study);
        assert_eq!(chosen.len(), 3);
        for chosen in chosen {
            let setting = &study.points[chosen.point].setting;
            assert!(is_idle(SceneName::Foliage, setting), "{chosen:?}");
            assert!(chosen.because[0].contains("left alone"), "{chosen:?}");
            assert!(chosen.plan.iter().any(|line| line.starts_with("no build")));
        }
    }

    #[test]
    fn what_may_be_faster_and_is_not_surely_is_told_with_its_interval() {
        let mut study = study([0.99, 0.995, 1.4]);
        for point in &mut study.points {
            point.time.passes.push(PassTime {
                full_ms: None,
                full_p95_ms: None,
                ..pass("build", 0.0, 0.1)
            });
        }
        let chosen = choose(SceneName::Foliage, &study);
        let because = |preset: &str| {
            let of = chosen.iter().find(|chosen| chosen.preset == preset);
            of.expect("a preset").because.join(" ")
        };
        let balanced = because("Balanced");
        assert!(
            balanced.contains("0.995 of that, in 95 of 100 cases 0.985 to 1.005"),
            "{balanced}"
        );
        assert!(because("Fast").contains("left alone"));
    }

    #[test]
    fn a_time_by_chance_of_the_authors_own_passes_is_full_rates() {
        // nothing in the hall is empty: its Exact is the scene as its author wrote it
        let study = study([0.6, 0.7, 0.65]);
        let chosen = choose(SceneName::Interior, &study);
        let names: Vec<&str> = chosen
            .iter()
            .map(|chosen| study.points[chosen.point].name.as_str())
            .collect();
        assert_eq!(names[1..], ["Balanced", "Fast"]);
        assert!(chosen[0].because[0].contains("left alone"));
    }

    #[test]
    fn what_flickers_is_not_chosen_but_named() {
        let mut study = study([1.0, 0.7, 0.6]);
        let setting = Setting {
            threshold: 0.3,
            ..Setting::default()
        };
        let mut other = point("restless", setting, 0.5, 0.005);
        other.seen.error.flips = 0.2;
        study.points.push(other);
        let chosen = choose(SceneName::Foliage, &study);
        let balanced = chosen.iter().find(|c| c.preset == "Balanced").expect("one");
        assert_eq!(study.points[balanced.point].name, "Balanced");
        let because = balanced.because.join("\n");
        assert!(because.contains("restless is faster still"), "{because}");
    }

    #[test]
    fn a_pass_pays_from_what_it_takes_beyond_its_share() {
        let found = pass_break_even_ms(&pass("rays", 1.0, 0.6), 0.5).expect("a time");
        assert!((found - 0.2).abs() < 1e-12);
        assert_eq!(pass_break_even_ms(&pass("rays", 1.0, 0.4), 0.5), Some(0.0));
        assert_eq!(pass_break_even_ms(&pass("rays", 1.0, 1.1), 1.0), None);
    }
}
