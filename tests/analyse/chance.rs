//! Settings by chance, and a scene that serves them.

use fastrand::Rng;
use vrcs::{
    Rate, Scene,
    analyse::{
        HalfResolution, Lens, OwnRates,
        own::{DistanceLadder, IdRates, Particles},
        settings::*,
    },
    plan::ColourForm,
    rate::Combiner,
};

/// Settings, and what they need declared in the scene.
pub fn settings(rng: &mut Rng, scene: &mut Scene) -> Settings {
    let pick = |rng: &mut Rng| rng.u32(..3) == 0;
    let content = Content {
        norm: [Norm::L2, Norm::L1, Norm::LInf, Norm::Root][rng.usize(..4)],
        pairs: [
            Pairs::All,
            Pairs::Interleaved,
            Pairs::SubSampled,
            Pairs::Quad,
            Pairs::Sobel,
        ][rng.usize(..5)],
        weights: [Weights::Paper, Weights::Rec709][rng.usize(..2)],
        difference: [
            Difference::Luma,
            Difference::LargestChannel,
            Difference::Rgb,
        ][rng.usize(..3)],
        transfer: [Transfer::Srgb, Transfer::Square][rng.usize(..2)],
        form: if pick(rng) {
            Form::Pairwise { sensitivity: 0.07 }
        } else {
            [Form::Window, Form::Window, Form::Absolute][rng.usize(..3)]
        },
        threshold: [0.15, 0.03, 0.6][rng.usize(..3)],
        ambient: [0.05, 0.0][rng.usize(..2)],
        ..Content::default()
    };
    scene.colour = [ColourForm::Codes, ColourForm::Linear, ColourForm::SqrtLuma][rng.usize(..3)];
    scene.motion = rng.bool();
    scene.depth = rng.bool();
    scene.flags = rng.bool();
    scene.noise = rng.bool();
    scene.ids = rng.bool();
    scene.materials = rng.bool();
    // within the eight storage buffers that every device binds
    scene.after_transparents = scene.colour != ColourForm::SqrtLuma && rng.bool();
    scene.previous_rates = rng.bool();
    scene.attachment = true;
    scene.reasons = true;
    scene.sqrt_luma = rng.bool();
    let half_rate = rng.bool().then(|| HalfRate {
        tolerance: 0.3,
        fast: match scene.motion {
            true => [f64::INFINITY, 2.0][rng.usize(..2)],
            false => f64::INFINITY,
        },
    });
    scene.plain_rates = half_rate.is_some() && rng.bool();
    let blur = [
        Blur::Scaled,
        Blur::Linear,
        Blur::Standalone { error: 0.5 },
        Blur::Ladder(Ladder::default()),
    ][rng.usize(..4)];
    let motion = scene.motion.then(|| Motion {
        blur,
        weight: [1.0, 0.5][rng.usize(..2)],
        scale: [1.0, -1.0],
    });
    let is_scaled = scene.motion && matches!(blur, Blur::Scaled | Blur::Linear);
    scene.blur = scene.motion && matches!(blur, Blur::Scaled | Blur::Linear) && rng.bool();
    let settings = Settings {
        content,
        later_blur: scene.blur,
        // depths of the frame are around 0.3
        lens: (is_scaled && scene.depth && rng.bool()).then(|| Lens {
            focus: 0.1 / 0.31,
            infinity: [3.0, 100.0][rng.usize(..2)],
            far: [f64::INFINITY, 30.0][rng.usize(..2)],
            reversed_z: rng.bool(),
            ..Lens::default()
        }),
        motion,
        reprojection: (scene.motion && rng.bool()).then(|| Reprojection {
            reversed_z: rng.bool(),
            near_over_far: [0.0, 0.001][rng.usize(..2)],
            tolerance: [0.1, 0.1, f64::INFINITY][rng.usize(..3)],
            ..Reprojection::default()
        }),
        materials: (scene.materials && rng.bool()).then(|| Materials {
            of: [MaterialsOf::This, MaterialsOf::Previous][rng.usize(..2)],
            mirror: [0.8, 2.0][rng.usize(..2)],
            ..Materials::default()
        }),
        stability: match scene.previous_rates {
            true => [Stability::Hysteresis, Stability::Compensate][rng.usize(..2)],
            false => Stability::None,
        },
        half_rate,
        transparents: scene.after_transparents,
        foveation: pick(rng).then(Foveation::default),
        overshoot: if pick(rng) {
            vec![[0.85, 1.0], [1.0, 0.7]]
        } else {
            Vec::new()
        },
        safe_area: pick(rng).then(SafeArea::default),
        own: pick(rng).then(|| own(rng, scene)),
        half_resolution: [
            None,
            Some(HalfResolution::Code),
            Some(HalfResolution::Footprint),
        ][rng.usize(..3)],
        smoothing: [Smoothing::None, Smoothing::Limit, Smoothing::Conservative][rng.usize(..3)],
        largest: [Rate::R2X2, Rate::R4X2, Rate::R4X4, Rate::R2X4][rng.usize(..4)],
        granularity: match rng.bool() {
            true => Granularity::Quad,
            false => Granularity::ALL[rng.usize(..5)],
        },
        attachment: Granularity::ALL[rng.usize(..5)],
    };
    if !settings.is_by_motion_alone() {
        return settings;
    }
    // there is no error of the content's to tolerate
    (scene.after_transparents, scene.plain_rates) = (false, false);
    Settings {
        stability: Stability::None,
        half_rate: None,
        transparents: false,
        foveation: None,
        overshoot: Vec::new(),
        safe_area: None,
        ..settings
    }
}

/// Own rates of what the scene has.
pub fn own(rng: &mut Rng, scene: &Scene) -> OwnRates {
    let combiner = |rng: &mut Rng| Combiner::ALL[rng.usize(..6)];
    let rate = |rng: &mut Rng| Rate::ALL[rng.usize(..7)];
    OwnRates {
        ids: scene.ids.then(|| IdRates {
            rates: (0..20).map(|_| rng.bool().then(|| rate(rng))).collect(),
            combiner: combiner(rng),
        }),
        distance: scene.depth.then(|| DistanceLadder {
            // depths of the frame are around 0.3
            steps: [
                (0.1 / 0.315, rate(rng)),
                (0.1 / 0.305, rate(rng)),
                (f64::INFINITY, rate(rng)),
                (1e3, rate(rng)),
            ],
            combiner: combiner(rng),
            reversed_z: rng.bool(),
            far: [f64::INFINITY, 500.0][rng.usize(..2)],
            ..DistanceLadder::default()
        }),
        particles: scene.flags.then(|| Particles {
            rate: rate(rng),
            combiner: combiner(rng),
        }),
    }
}
