//! Settings of a scene, timed in turns, so that a clock that drifts and a machine that others use meet all alike.
//!
//! *Does*: in each round draws one frame of the animation: first the control, a pass that never changes (the G-buffer); then, in an order
//! that is shuffled anew, the passes at full rate and every setting, each a submission of its own. What a setting takes is compared with
//! the full rate of the same round. *Guarantees*: a round in which the control was more than [`DRIFT`] off its median does not
//! count, and is made up for; if too few are left all are taken, and the times are said to be [unsteady](Times::is_steady). What does not
//! run in every frame is compared over as many rounds as it takes turns. *Needs*: a device with timestamps.

use std::collections::BTreeSet;

use super::{
    Trouble,
    clock::{FrameTimes, median_interval, quantile},
    study::{Effect, PassTime, Span, Times},
};
use crate::scenes::SceneName;

/// How far the control of a round that counts may be from its median, as a share.
pub const DRIFT: f64 = 0.05;

/// How many rounds are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounds {
    /// Rounds before any that counts.
    pub warm: u32,
    /// Rounds that shall count.
    pub counted: u32,
    /// The most that are tried for that, warm-up not among them.
    pub most: u32,
}

/// What one round took.
#[derive(Clone, Debug, Default)]
pub struct Round {
    /// The pass that never changes, in milliseconds.
    pub control: f64,
    /// The passes at full rate.
    pub full: FrameTimes,
    /// What each setting ran, in the order of the settings.
    pub settings: Vec<FrameTimes>,
}

/// Rounds, and which of them count.
#[derive(Clone, Debug, Default)]
pub struct Taken {
    rounds: Vec<Round>,
    counts: Vec<bool>,
    drift: f64,
    is_steady: bool,
}

fn total(times: &FrameTimes) -> f64 {
    times.values().sum()
}

/// How far the control of each round is off its median, as a share.
fn off_the_median(rounds: &[Round]) -> Vec<f64> {
    let controls: Vec<f64> = rounds.iter().map(|round| round.control).collect();
    let median = quantile(&controls, 0.5);
    let off = |control: &f64| (control / median - 1.0).abs();
    controls.iter().map(off).collect()
}

/// Runs rounds until enough of them count. `run` runs that many more, numbered on from the last.
///
/// # Errors
/// What `run` says.
pub fn take(
    rounds: Rounds,
    mut run: impl FnMut(u32) -> Result<Vec<Round>, Trouble>,
) -> Result<Taken, Trouble> {
    let mut all = Vec::new();
    let mut more = rounds.counted;
    loop {
        all.extend(run(more)?);
        let off = off_the_median(&all);
        let counts: Vec<bool> = off.iter().map(|&off| off <= DRIFT).collect();
        let counted = counts.iter().filter(|&&counts| counts).count() as u32;
        let left = rounds.most.saturating_sub(all.len() as u32);
        if counted >= rounds.counted || left == 0 {
            let is_steady = counted * 2 >= rounds.counted;
            return Ok(Taken {
                counts: match is_steady {
                    true => counts,
                    false => vec![true; all.len()],
                },
                drift: quantile(&off, 0.95),
                is_steady,
                rounds: all,
            });
        }
        more = (rounds.counted - counted).min(left);
    }
}

impl Taken {
    /// Rounds that count, and follow one another, in parts of `every`.
    fn parts(&self, every: u32) -> Vec<&[Round]> {
        let every = every.max(1) as usize;
        self.rounds
            .chunks_exact(every)
            .zip(self.counts.chunks_exact(every))
            .filter(|(_, counts)| counts.iter().all(|&counts| counts))
            .map(|(rounds, _)| rounds)
            .collect()
    }

    fn counted(&self) -> Vec<&Round> {
        self.parts(1).into_iter().flatten().collect()
    }

    /// What a setting took; `index` is its place among the settings, `every` how many frames its work repeats after.
    pub fn times(&self, scene: SceneName, index: usize, every: u32) -> Times {
        let counted = self.counted();
        let own = |round: &Round| round.settings.get(index).map_or(0.0, total);
        let full: Vec<f64> = counted.iter().map(|round| total(&round.full)).collect();
        let variable: Vec<f64> = counted.iter().map(|round| own(round)).collect();
        let control: Vec<f64> = counted.iter().map(|round| round.control).collect();
        let parts = self.parts(every);
        let mean_of = |part: &[Round]| part.iter().map(own).sum::<f64>() / part.len() as f64;
        let shares: Vec<f64> = parts
            .iter()
            .map(|part| {
                part.iter().map(own).sum::<f64>() / part.iter().map(|r| total(&r.full)).sum::<f64>()
            })
            .filter(|share| share.is_finite())
            .collect();
        let means: Vec<f64> = parts.iter().map(|part| mean_of(part)).collect();
        Times {
            full_ms: quantile(&full, 0.5),
            full_p95_ms: quantile(&full, 0.95),
            variable_ms: quantile(&means, 0.5),
            variable_p95_ms: quantile(&variable, 0.95),
            share: span(&shares),
            control_ms: quantile(&control, 0.5),
            control_p95_ms: quantile(&control, 0.95),
            rounds: counted.len() as u32,
            drift: self.drift,
            is_steady: self.is_steady,
            passes: passes(scene, &counted, index),
        }
    }

    /// What an effect adds: the setting at `with` less that at `without`, round by round. `rest` is what is known but times.
    pub fn effect(&self, scene: SceneName, with: usize, without: usize, rest: Effect) -> Effect {
        let counted = self.counted();
        let difference = |of: &dyn Fn(&FrameTimes) -> f64| {
            let samples: Vec<f64> = counted
                .iter()
                .filter_map(|round| {
                    Some(of(round.settings.get(with)?) - of(round.settings.get(without)?))
                })
                .collect();
            span(&samples)
        };
        let machinery = |times: &FrameTimes| -> f64 {
            let others = times.iter().filter(|(name, _)| !is_shading(scene, name));
            others.map(|(_, ms)| ms).sum()
        };
        Effect {
            machinery_ms: difference(&machinery),
            frame_ms: difference(&total),
            ..rest
        }
    }
}

fn is_shading(scene: SceneName, name: &str) -> bool {
    scene.passes().iter().any(|pass| pass.entry() == name)
}

/// The median of samples and its interval.
fn span(samples: &[f64]) -> Span {
    let [low, high] = median_interval(samples);
    Span {
        median: quantile(samples, 0.5),
        low,
        high,
    }
}

/// Each pass of a setting: machinery first, then shading in the scene's order, then what follows. What does not run in every frame counts for
/// the share of frames in which it does.
fn passes(scene: SceneName, rounds: &[&Round], index: usize) -> Vec<PassTime> {
    let amortised = |samples: Vec<f64>| {
        quantile(&samples, 0.5) * samples.len() as f64 / rounds.len().max(1) as f64
    };
    let own: Vec<&FrameTimes> = rounds
        .iter()
        .filter_map(|round| round.settings.get(index))
        .collect();
    let mut names: Vec<&str> = own
        .iter()
        .flat_map(|times| times.keys().map(String::as_str))
        .collect::<BTreeSet<&str>>()
        .into_iter()
        .collect();
    let order = |name: &str| {
        let known = ["camera motion", "analyse", "granularity", "build"];
        let shading = scene.passes().iter().map(|pass| pass.entry());
        known.into_iter().chain(shading).position(|k| k == name)
    };
    names.sort_by_key(|name| order(name).unwrap_or(usize::MAX));
    names
        .into_iter()
        .map(|name| {
            let of = |times: &&FrameTimes| times.get(name).copied();
            let full: Vec<f64> = rounds.iter().filter_map(|round| of(&&round.full)).collect();
            let variable: Vec<f64> = own.iter().filter_map(of).collect();
            let has_full = !full.is_empty();
            PassTime {
                name: name.to_owned(),
                full_p95_ms: has_full.then(|| quantile(&full, 0.95)),
                full_ms: has_full.then(|| amortised(full)),
                variable_p95_ms: quantile(&variable, 0.95),
                variable_ms: amortised(variable),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(parts: &[(&str, f64)]) -> FrameTimes {
        parts
            .iter()
            .map(|&(name, ms)| (name.to_owned(), ms))
            .collect()
    }

    /// A round on a machine that is `slow` times slower than it should be.
    fn round(slow: f64, settings: &[&[(&str, f64)]]) -> Round {
        let slowed = |parts: &[(&str, f64)]| -> FrameTimes {
            let parts = parts.iter().map(|&(name, ms)| (name, ms * slow));
            frame(&parts.collect::<Vec<_>>())
        };
        Round {
            control: slow,
            full: slowed(&[("material", 10.0)]),
            settings: settings.iter().map(|parts| slowed(parts)).collect(),
        }
    }

    fn taken(rounds: Vec<Round>) -> Taken {
        let wanted = Rounds {
            warm: 0,
            counted: rounds.len() as u32,
            most: rounds.len() as u32,
        };
        let mut once = Some(rounds);
        take(wanted, |_| Ok(once.take().unwrap_or_default())).expect("rounds")
    }

    const MOST: u32 = 24;

    /// Eight rounds of [`HALF`], with up to [`MOST`] tries, each on a machine as slow as it is told.
    fn eight_of(mut slow: impl FnMut() -> f64) -> Times {
        let wanted = Rounds {
            warm: 0,
            counted: 8,
            most: MOST,
        };
        let found = take(wanted, |more| {
            Ok((0..more).map(|_| round(slow(), &[HALF])).collect())
        });
        found.expect("rounds").times(SceneName::Ramps, 0, 1)
    }

    const HALF: &[(&str, f64)] = &[("build", 1.0), ("material", 4.0)];

    #[test]
    fn of_no_rounds_there_is_no_time() {
        let none = Taken::default().times(SceneName::Ramps, 0, 1);
        assert_eq!(none, Times::default());
    }

    #[test]
    fn a_clock_that_drifts_slowly_changes_no_share() {
        let rounds = (0..20).map(|i| round(1.0 + 0.002 * f64::from(i), &[HALF]));
        let found = taken(rounds.collect()).times(SceneName::Ramps, 0, 1);
        assert!((found.share.median - 0.5).abs() < 1e-12);
        assert!((found.share.high - found.share.low).abs() < 1e-12);
        assert!(found.is_steady && found.rounds == 20);
    }

    #[test]
    fn rounds_with_a_control_far_from_its_median_are_made_up_for() {
        let mut number = 0;
        let found = eight_of(|| {
            number += 1;
            if number % 4 == 0 { 1.5 } else { 1.0 }
        });
        assert_eq!((found.rounds, found.full_p95_ms), (8, 10.0));
        assert!(found.is_steady && found.drift > 0.4, "{}", found.drift);
        assert_eq!(number, 10, "two were made up for");
    }

    #[test]
    fn a_machine_that_is_never_steady_is_said_to_be_so_and_all_rounds_count() {
        let mut slow = 1.0;
        let found = eight_of(|| {
            slow *= 1.2;
            slow
        });
        assert!(!found.is_steady);
        assert_eq!(found.rounds, MOST);
        assert!(
            (found.share.median - 0.5).abs() < 1e-12,
            "and still shares hold"
        );
    }

    #[test]
    fn what_runs_in_every_other_frame_counts_half() {
        let with: &[(&str, f64)] = &[("analyse", 4.0), ("material", 5.0)];
        let rounds = (0..10).map(|i| match i % 2 {
            0 => round(1.0, &[with]),
            _ => round(1.0, &[&with[1..]]),
        });
        let found = taken(rounds.collect()).times(SceneName::Ramps, 0, 2);
        assert_eq!((found.full_ms, found.control_ms), (10.0, 1.0));
        assert_eq!((found.variable_ms, found.variable_p95_ms), (7.0, 9.0));
        assert_eq!((found.machinery_ms(), found.share.median), (2.0, 0.7));
        assert_eq!(found.passes[0].name, "analyse");
        assert_eq!(found.passes[1].full_ms, Some(10.0));
        assert_eq!(found.saved_share(), 0.5);
    }

    #[test]
    fn an_effect_is_the_difference_of_the_same_rounds_and_may_be_within_noise() {
        let without: &[(&str, f64)] = &[("build", 1.0), ("material", 4.5)];
        let noisy = |i: u32| 1.0 + 0.02 * f64::from(i % 3);
        let rounds = (0..20).map(|i| round(noisy(i), &[HALF, without, HALF]));
        let found = taken(rounds.collect());
        let effect = found.effect(SceneName::Ramps, 0, 1, Effect::default());
        assert!(effect.machinery_ms.is_within_noise());
        assert!(!effect.frame_ms.is_within_noise());
        assert!((effect.frame_ms.median + 0.51).abs() < 0.02);
        let none = found.effect(SceneName::Ramps, 0, 2, Effect::default());
        assert!(none.frame_ms.is_within_noise());
    }
}
