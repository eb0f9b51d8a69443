//! The kernel of √luma's content alone, in which floats compare first: the same bytes as the twin's, also where floats are not sure.

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{Frame, integer, settings::*},
    plan::ColourForm,
};

use crate::{
    common,
    made::{Made, assert_equal},
};

/// Settings by chance that ask for nothing but the content of √luma.
fn settings(rng: &mut Rng, scene: &mut Scene) -> Settings {
    scene.colour = ColourForm::SqrtLuma;
    scene.attachment = rng.bool();
    Settings {
        content: Content {
            norm: [Norm::L2, Norm::L2, Norm::L1, Norm::Root][rng.usize(..4)],
            form: [Form::Window, Form::Window, Form::Absolute][rng.usize(..3)],
            weights: [Weights::Paper, Weights::Rec709][rng.usize(..2)],
            transfer: [Transfer::Srgb, Transfer::Square][rng.usize(..2)],
            threshold: [0.15, 0.03, 0.6, 0.0, 15.0][rng.usize(..5)],
            ambient: [0.05, 0.0, 1.0][rng.usize(..3)],
            ..Content::default()
        },
        overshoot: match rng.bool() {
            true => vec![[0.5, 0.4], [1.0, 1.7]],
            false => Vec::new(),
        },
        smoothing: [Smoothing::None, Smoothing::Limit][rng.usize(..2)],
        largest: [
            Rate::R2X2,
            Rate::R2X2,
            Rate::R4X4,
            Rate::R4X2,
            Rate::R2X4,
            Rate::R2X1,
            Rate::R1X1,
        ][rng.usize(..7)],
        attachment: Granularity::ALL[rng.usize(..5)],
        ..Settings::default()
    }
}

#[test]
fn the_content_of_luma_alone_makes_the_bytes_of_the_integer_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let sizes = [
        [1u32, 1],
        [2, 2],
        [3, 5],
        [8, 8],
        [9, 7],
        [64, 32],
        [67, 35],
        [130, 9],
        [255, 21],
        [257, 17],
        [264, 12],
        [17, 70],
        // widths of whole words of rates have a pipeline of their own where both pictures are alike
        [16, 9],
        [128, 34],
        [272, 19],
        [520, 6],
    ];
    for case in 0..80 {
        let mut rng = Rng::with_seed(seed + case);
        let mut scene = Scene::default();
        let settings = settings(&mut rng, &mut scene);
        let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
        assert_eq!(plan.passes[0].kernel, "luma_lines.wgsl", "{plan}");
        let size = sizes[rng.usize(..sizes.len())];
        let previous = match rng.u32(..4) {
            0 => [size[0].div_ceil(2) + 1, size[1] + 3],
            1 => [size[0] + 5, size[1]],
            _ => size,
        };
        let frame = Frame {
            previous_size: previous,
            has_history: rng.u32(..16) > 0,
            resolution_scale: 0.5 + rng.f64() / 2.0,
            ..Frame::of_size(size)
        };
        let made = Made::new(size, previous, &mut rng);
        println!("case {case}: {size:?}");
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        assert_equal(&made.run(&gpu, &plan, &frame), &wanted, &plan);
    }
}

#[test]
fn whatever_else_is_asked_for_has_the_kernel_that_knows_it() {
    let luma = Scene {
        colour: ColourForm::SqrtLuma,
        ..Scene::default()
    };
    let kernel = |scene: &Scene, settings: &Settings| {
        Plan::new(scene, settings).expect("a plan").passes[0].kernel
    };
    let plain = Settings::default();
    assert_eq!(kernel(&luma, &plain), "luma_lines.wgsl");
    assert_eq!(kernel(&Scene::default(), &plain), "analyse.wgsl", "codes");
    let with_motion = Scene {
        motion: true,
        ..luma
    };
    // vectors that nothing asks for are not read
    assert_eq!(kernel(&with_motion, &plain), "luma_lines.wgsl");
    let moving = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    assert_eq!(kernel(&with_motion, &moving), "analyse.wgsl");
    let with_reasons = Scene {
        reasons: true,
        ..luma
    };
    assert_eq!(kernel(&with_reasons, &plain), "analyse.wgsl");
    let of = |content| Settings {
        content,
        ..Settings::default()
    };
    let fewer = of(Content {
        pairs: Pairs::Interleaved,
        ..Content::default()
    });
    let largest = of(Content {
        norm: Norm::LInf,
        ..Content::default()
    });
    let pairwise = of(Content {
        form: Form::Pairwise { sensitivity: 0.07 },
        ..Content::default()
    });
    let at_the_border = Settings {
        safe_area: Some(SafeArea::default()),
        ..Settings::default()
    };
    for settings in [fewer, largest, pairwise, at_the_border] {
        assert_eq!(kernel(&luma, &settings), "analyse.wgsl", "{settings:?}");
    }
}

/// Stripes whose error is close to the threshold: their shares of it.
fn shares(codes: [u8; 2], ambient: f64) -> f64 {
    let [a, b] = codes.map(|code| (f64::from(code) / 255.0).powi(2));
    (a - b).abs() / 2.0 / ((a + b) / 2.0 + ambient)
}

#[test]
fn what_floats_are_not_sure_of_integers_decide() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [256u32, 256];
    let frame = Frame::of_size(size);
    let mut close = 0;
    for threshold in [0.15, 0.3, 0.7, 0.9] {
        let settings = Settings {
            content: Content {
                threshold,
                transfer: Transfer::Square,
                ..Content::default()
            },
            ..Settings::default()
        };
        // as the kernel has them
        let exact = (threshold * 4096.0f64).round() / 4096.0;
        let ambient = (0.05 * 16384.0f64).round() / 16384.0;
        let pairs: Vec<([u8; 2], f64)> = (0..=255u8)
            .flat_map(|a| (0..a).map(move |b| [a, b]))
            .map(|codes| (codes, shares(codes, ambient) / exact - 1.0))
            .filter(|(_, apart)| apart.abs() < 1e-3)
            .collect();
        assert!(!pairs.is_empty());
        let mut made = Made::new(size, size, &mut rng);
        let stripes: Vec<[u8; 2]> = (0..32 * 32)
            .map(|_| {
                let (codes, apart) = pairs[rng.usize(..pairs.len())];
                close += usize::from(apart.abs() < 1e-4);
                codes
            })
            .collect();
        for y in 0..size[1] {
            for x in 0..size[0] {
                let cell = (y / 8 * 32 + x / 8) as usize;
                let along = if cell.is_multiple_of(2) { x } else { y };
                let at = (y * size[0] + x) as usize;
                let code = stripes[cell][along as usize % 2];
                made.sqrt[at] = code;
            }
        }
        let scene = Scene {
            colour: ColourForm::SqrtLuma,
            ..Scene::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        assert_equal(&made.run(&gpu, &plan, &frame), &wanted, &plan);
    }
    assert!(
        close > 100,
        "{close} cells of stripes within 0.01 % of the threshold"
    );
}
