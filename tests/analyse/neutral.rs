//! What a scene does not declare is not there; and what is there with nothing to say changes no byte.

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{
        Analysis, Cameras, Frame, HalfResolution, Lens, OwnRates,
        inputs::flags,
        own::{DistanceLadder, IdRates, Particles},
        settings::*,
    },
    rate::Combiner,
    sri::Sri,
};

use crate::{common, made::Made};

/// An effect, what the scene must declare for it, and inputs under which it has nothing to say.
type Neutral = (
    &'static str,
    fn(&mut Scene),
    fn(&mut Settings),
    fn(&mut Made),
);

/// One row for each effect that a scene declares: with a neutral input its bytes are those of a plan that leaves it out.
const NEUTRAL: &[Neutral] = &[
    (
        "zero motion",
        |scene| scene.motion = true,
        |settings| settings.motion = Some(Motion::default()),
        |made| made.motion.fill([0.0; 2]),
    ),
    (
        "zero motion, reprojected, over one depth",
        |scene| (scene.motion, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.reprojection = Some(Reprojection::default());
        },
        |made| {
            made.motion.fill([0.0; 2]);
            made.depth.fill(0.5);
            made.previous_depth.fill(0.5);
        },
    ),
    (
        "cameras at rest",
        |scene| (scene.cameras, scene.depth) = (true, true),
        |settings| settings.motion = Some(Motion::default()),
        |made| made.depth.fill(0.5),
    ),
    (
        "cameras at rest, reprojected, over one depth",
        |scene| (scene.cameras, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.reprojection = Some(Reprojection::default());
        },
        |made| {
            made.depth.fill(0.5);
            made.previous_depth.fill(0.5);
        },
    ),
    (
        "zero motion, reprojected, without a depth test",
        |scene| (scene.motion, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.reprojection = Some(Reprojection {
                tolerance: f64::INFINITY,
                ..Reprojection::default()
            });
        },
        |made| made.motion.fill([0.0; 2]),
    ),
    (
        "motion that has no weight",
        |scene| scene.motion = true,
        |settings| {
            settings.motion = Some(Motion {
                weight: 0.0,
                ..Motion::default()
            });
        },
        |made| made.motion.fill([9.0; 2]),
    ),
    (
        "a later blur of no width",
        |scene| (scene.motion, scene.blur) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.later_blur = true;
        },
        |made| {
            made.motion.fill([0.0; 2]);
            made.blur.fill(0.0);
        },
    ),
    (
        "a lens that blurs nothing",
        |scene| (scene.motion, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.lens = Some(Lens {
                infinity: 0.0,
                ..Lens::default()
            });
        },
        |made| made.motion.fill([0.0; 2]),
    ),
    (
        "materials that reflect nothing",
        |scene| scene.materials = true,
        |settings| settings.materials = Some(Materials::default()),
        |made| made.materials.fill([255, 0]),
    ),
    (
        "no noise anywhere",
        |scene| scene.noise = true,
        |settings| settings.half_rate = Some(HalfRate::default()),
        |made| made.noise.fill(0),
    ),
    (
        "no noise anywhere, and a second image without the half rate",
        |scene| (scene.noise, scene.plain_rates) = (true, true),
        |settings| settings.half_rate = Some(HalfRate::default()),
        |made| made.noise.fill(0),
    ),
    (
        "an extra half rate that foliage is left out of",
        |scene| scene.flags = true,
        |settings| settings.half_rate = Some(HalfRate::default()),
        |made| made.flags.fill(flags::NO_HALF_RATE),
    ),
    (
        "√luma for later frames",
        |scene| scene.sqrt_luma = true,
        |_| {},
        |_| {},
    ),
    (
        "no transparents",
        |scene| scene.after_transparents = true,
        |settings| settings.transparents = true,
        |made| made.after_codes.clone_from(&made.codes),
    ),
    (
        "flags that say nothing",
        |scene| scene.flags = true,
        |_| {},
        |made| made.flags.fill(0),
    ),
    (
        "a previous frame at full rate, compensated",
        |scene| scene.previous_rates = true,
        |settings| settings.stability = Stability::Compensate,
        |made| made.rates = Sri::uniform(made.previous[0], made.previous[1], Rate::R1X1),
    ),
    (
        "foveation at full resolution",
        |_| {},
        |settings| settings.foveation = Some(Foveation::default()),
        |_| {},
    ),
    (
        "quality overshoot below 85 %",
        |_| {},
        |settings| settings.overshoot = vec![[0.85, 1.0], [1.0, 1.0]],
        |_| {},
    ),
    (
        "a safe area of no width",
        |_| {},
        |settings| {
            settings.safe_area = Some(SafeArea {
                width: 0,
                ..SafeArea::default()
            });
        },
        |_| {},
    ),
    (
        "own rates of other ids, beyond all distances, without particles",
        |scene| (scene.ids, scene.depth, scene.flags) = (true, true, true),
        |settings| {
            settings.own = Some(OwnRates {
                ids: Some(IdRates {
                    rates: vec![Some(Rate::R4X4); 9],
                    combiner: Combiner::Override,
                }),
                distance: Some(DistanceLadder {
                    steps: [(1e6, Rate::R4X4); 4],
                    ..DistanceLadder::default()
                }),
                particles: Some(Particles::default()),
            });
        },
        |made| {
            made.ids.fill(9);
            made.depth.fill(0.5);
            made.flags.fill(0);
        },
    ),
    (
        "half the resolution",
        |_| {},
        |settings| settings.half_resolution = Some(HalfResolution::Code),
        |_| {},
    ),
];

// fails when an effect is not neutral: with `FACTOR_ONE - min(slow, FACTOR_ONE)` of the materials written as `FACTOR_ONE - 1`, the
// fourth row differs
#[test]
fn a_neutral_input_gives_the_bytes_of_a_plan_that_leaves_the_effect_out() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [46, 38];
    let base = Scene {
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let settings = Settings {
        smoothing: Smoothing::Conservative,
        largest: Rate::R4X2,
        ..Settings::default()
    };
    let camera = glam::DMat4::perspective_rh(1.0, 1.2, 100.0, 0.1);
    let at_rest = Cameras {
        now: camera,
        before: camera,
    };
    let without = Plan::new(&base, &settings).expect("a plan");
    let bare = Analysis::new(&gpu.device, &without).expect("a device for it");
    for (name, declare, ask, quiet) in NEUTRAL {
        let mut made = Made::new(size, size, &mut rng);
        quiet(&mut made);
        let (mut scene, mut with) = (base, settings.clone());
        declare(&mut scene);
        ask(&mut with);
        let frame = Frame {
            cameras: Some(at_rest),
            ..Frame::of_size(size)
        };
        let plan = Plan::new(&scene, &with).expect("what it asks for is declared");
        let plain = made.run_with(&gpu, &bare, &frame);
        let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
        let neutral = made.run_with(&gpu, &analysis, &frame);
        assert_eq!(analysis.pipeline_count(), plan.passes.len(), "{name}");
        for (i, output) in ["rates", "attachment", "reasons"].into_iter().enumerate() {
            assert_eq!(plain[i], neutral[i], "{name}: {output}");
        }
        // and nothing of it is there where it is not asked for, whatever is declared
        scene.plain_rates = false;
        let declared = Plan::new(&scene, &settings).expect("a plan");
        // flags and outputs are asked for by the scene itself
        let asked = usize::from(scene.flags) + usize::from(scene.sqrt_luma);
        let passes = without.passes.len() + usize::from(scene.sqrt_luma);
        assert_eq!(declared.passes.len(), passes, "{name}");
        assert_eq!(
            declared.bindings.len() + declared.later.len(),
            without.bindings.len() + asked,
            "{name}: {declared}"
        );
    }
}
