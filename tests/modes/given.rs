//! `vrcs_copies()` and `vrcs_rate()` in every mode, and rays by them.

use std::collections::HashMap;

use fastrand::Rng;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use vrcs::{
    Rate,
    build::{BuildOptions, cpu::Coordinates, primary::Order},
    check::{Job, Law, Verdict, check_rewritten, rates::Pattern},
    coverage::{Coverage, cpu::Samples},
    sri::Sri,
};
use vrcs_passes::{
    Rewritten, Source,
    graded::{self, Given},
    options::{MaxRate, Mode, Sky},
};

use super::{Scene, Shader, common, rewrite};

/// For each pixel, the members of its group.
fn groups(twin: &Coordinates) -> HashMap<u32, Vec<[u32; 2]>> {
    let width = twin.extent[0];
    let mut groups: HashMap<u32, Vec<[u32; 2]>> = HashMap::new();
    for (at, primary) in (0..).zip(twin.map()) {
        groups
            .entry(primary)
            .or_default()
            .push([at % width, at / width]);
    }
    groups
}

/// The side of the smallest aligned block of 1, 2 or 4 that holds all of these.
fn block(members: &[[u32; 2]], axis: usize) -> u32 {
    [1, 2, 4]
        .into_iter()
        .find(|side| {
            members
                .iter()
                .all(|m| m[axis] / side == members[0][axis] / side)
        })
        .expect("a group lies in a block of 4")
}

#[test]
fn every_mode_tells_a_pixel_what_it_shares() {
    let gpu = common::gpu();
    let seed = common::seed();
    let text = include_str!("shares.wgsl");
    let coverage = Coverage {
        surfaces: true,
        ..Coverage::default()
    };
    let mut shared = [0; 2];
    for (index, largest) in [Rate::R2X2, Rate::R4X4].into_iter().enumerate() {
        let extent = [[61, 47], [33, 31]][index];
        let mut rng = Rng::with_seed(seed + index as u64);
        let sri = Pattern::Patches.image(extent[0], extent[1], &mut rng);
        let samples = Samples {
            size: extent,
            surfaces: (0..extent[0] * extent[1])
                .map(|at| at % extent[0] / 5 + rng.u32(0..8) / 7)
                .collect(),
            ..Samples::default()
        };
        let scene = Scene {
            extent,
            options: BuildOptions {
                largest,
                coverage,
                ..BuildOptions::default()
            },
            sri: &sri,
            samples: Some(&samples),
            order: Order::Rotating(1),
        };
        let twin = scene.twin();
        let view = scene.view(&gpu);
        for mode in Mode::ALL {
            let options = rewrite(mode, Sky::Skip, &scene.options);
            let words = Shader::new(&gpu, "shares.wgsl", text, options).draw(&gpu, &view, 0, 0);
            for members in groups(&twin).values() {
                let rate = [0, 1].map(|axis| block(members, axis));
                let copies = match mode {
                    Mode::Graded => members.len() as u32 - 1,
                    _ => 0,
                };
                for [x, y] in members {
                    let word = words[(y * extent[0] + x) as usize];
                    let got = (word & 0xff, [word >> 8 & 0xff, word >> 16]);
                    assert_eq!(got, (copies, rate), "{mode:?} ({x}, {y}) of {members:?}");
                }
                shared[usize::from(members.len() > 1)] += 1;
            }
        }
    }
    assert!(shared[0] > 100 && shared[1] > 100, "{shared:?}");
}

/// The laws for shaders that ask: what each pixel holds is what the original gives with the answer that is due to it.
#[test]
fn the_laws_hold_for_shaders_that_ask() {
    let source = common::shader("asks_rate");
    for (index, mode) in Mode::ALL.into_iter().enumerate() {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = 32;
        job.options.mode = mode;
        job.options.max_rate = [MaxRate::R4x4, MaxRate::R2x2][index % 2];
        let report = common::run(&source, &job);
        common::assert_passed(&report);
        assert!(report.held[&Law::Replication] >= 4, "{mode:?}: {report:?}");
    }
    let rays = with_helpers(include_str!("rays.wgsl"));
    let mut job = Job::new("main");
    job.seed = common::seed();
    job.cases = 32;
    job.options.mode = Mode::Graded;
    for (name, value) in [("frame.size", vec![61.0, 47.0]), ("frame.rays", vec![9.0])] {
        job.settings.set.insert(name.to_owned(), value);
    }
    common::assert_passed(&common::run(&Source::new("rays.wgsl", rays), &job));
}

/// A rewrite that tells every pixel that nothing is shared is caught.
#[test]
fn an_answer_that_is_wrong_is_caught() {
    let source = common::shader("asks_rate");
    let (module, info) = common::parse(&source);
    for mode in Mode::ALL {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.options.mode = mode;
        let rewritten =
            vrcs_passes::rewrite(&module, &info, "main", &job.options).expect("a rewrite");
        let silent = graded::with_given(&rewritten.module, Given::NOTHING);
        let validated = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&silent)
            .expect("a valid module");
        let broken = Rewritten {
            module: silent,
            info: validated,
            ..rewritten
        };
        let report = check_rewritten(
            &common::gpu(),
            &source,
            &module,
            &info,
            &broken,
            &job,
            &mut |_| {},
        )
        .expect("a check");
        assert_eq!(
            report.verdict,
            Verdict::Failed,
            "{mode:?}: {:?}",
            report.why
        );
    }
}

fn with_helpers(text: &str) -> String {
    format!("{text}\n{}", graded::RAYS)
}

/// Over frames, a group's rays come to what one pixel would fire: within six standard errors of the mean, where each pixel rounds
/// on its own. No pixel ever fires none. Where a share is less than a ray, each counts less.
#[test]
fn rays_are_never_none_and_right_on_average() {
    const FRAMES: u32 = 24;
    let gpu = common::gpu();
    let extent = [64, 48];
    let text = with_helpers(include_str!("rays.wgsl"));
    for (rate, pixels) in [
        (Rate::R1X1, 1),
        (Rate::R2X1, 2),
        (Rate::R2X2, 4),
        (Rate::R4X4, 16),
    ] {
        let sri = Sri::uniform(extent[0], extent[1], rate);
        let scene = Scene {
            extent,
            options: BuildOptions {
                largest: Rate::R4X4,
                ..BuildOptions::default()
            },
            sri: &sri,
            samples: None,
            order: Order::Fixed,
        };
        let view = scene.view(&gpu);
        let options = rewrite(Mode::Graded, Sky::Skip, &scene.options);
        let shader = Shader::new(&gpu, "rays.wgsl", &text, options);
        for rays in [1, 2, 3, 5, 16, 17] {
            let share = f64::from(rays) / f64::from(pixels);
            let mut fired = 0u64;
            for frame in 0..FRAMES {
                let counts = shader.draw(&gpu, &view, frame, rays);
                for &count in &counts {
                    let near = [share.floor().max(1.0), share.floor() + 1.0];
                    assert!(
                        near.contains(&f64::from(count)),
                        "{rays} at {rate}: {count}"
                    );
                    fired += u64::from(count);
                }
            }
            let (_, weight) = graded::share(rays, pixels - 1, 0.0);
            let samples = f64::from(FRAMES * extent[0] * extent[1]);
            let mean = fired as f64 * f64::from(weight) / samples;
            // a rounded share is a whole number and a coin that falls with the broken part
            let part = match share < 1.0 {
                true => 0.0,
                false => share.fract(),
            };
            let bound = 6.0 * (part * (1.0 - part) / samples).sqrt() + 1e-6;
            assert!(
                (mean - share).abs() <= bound,
                "{rays} rays at {rate}: {mean} is not {share} within {bound}"
            );
        }
    }
}

/// The same on the CPU, where the noise is a regular grid: the mean is exact.
#[test]
fn shares_are_exact_over_a_grid_of_noise() {
    for copies in 0..16 {
        for rays in 1..40 {
            let pixels = 1 + copies;
            let sum: f64 = (0..pixels)
                .map(|step| (step as f32 + 0.5) / pixels as f32)
                .map(|noise| graded::share(rays, copies, noise))
                .map(|(fired, weight)| {
                    assert!(fired > 0);
                    f64::from(fired) * f64::from(weight)
                })
                .sum();
            assert!(
                (sum - f64::from(rays)).abs() < 1e-5,
                "{rays} {copies}: {sum}"
            );
        }
    }
}
