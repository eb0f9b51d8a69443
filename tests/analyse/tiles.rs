//! The stage by tiles of 16×16 pixels.

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{Cameras, Frame, Reason, integer, settings::*},
    plan::ColourForm,
};

use crate::{
    common,
    made::{Made, assert_equal},
};

// cameras without perspective and sides of powers of two: nothing is rounded, so that every byte has to be the twin's
#[test]
fn tiles_are_fetched_by_their_furthest_depth_as_in_the_twin() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let sizes = [
        [64u32, 32],
        [16, 16],
        [128, 64],
        [32, 8],
        [8, 64],
        [256, 16],
    ];
    let mut rates = std::collections::BTreeSet::new();
    let mut reasons = std::collections::BTreeSet::new();
    for case in 0..20 {
        let size = sizes[case % sizes.len()];
        // the first two are at rest: one full of mirrors, one plain
        let (is_known, is_mirror) = (case < 2, case == 0);
        let previous = match rng.u32(..3) {
            0 => size.map(|side| (side / 2).max(8)),
            _ => size,
        };
        let reversed_z = rng.bool();
        let mut made = Made::new(size, previous, &mut rng);
        for (i, depth) in made.depth.iter_mut().enumerate() {
            *depth = [0.25, 0.5, 0.75][(i / 5 + i / 97) % 3];
        }
        if is_known && !is_mirror {
            made.codes.fill([90; 4]);
        }
        if !is_known && rng.u32(..4) == 0 {
            let at = rng.usize(..made.depth.len());
            made.depth[at] = f32::NAN;
        }
        // nothing was nearer before than what is furthest now, but for a few pixels, one of which has no depth
        made.previous_depth
            .fill(if reversed_z { 0.25 } else { 0.75 });
        for _ in 0..rng.u32(..4) {
            let at = rng.usize(..made.previous_depth.len());
            made.previous_depth[at] = [0.26, 0.5, 0.74, 2.0][rng.usize(..4)];
        }
        let now = match reversed_z {
            true => glam::DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 8.0, 0.0),
            false => glam::DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 0.0, 8.0),
        };
        // what is further moves further: a shear
        let mut shear = glam::DMat4::IDENTITY;
        let mut sixteenths = |side: u32| f64::from(rng.i32(-32..=32)) / 32.0 / f64::from(side);
        if !is_known {
            shear.z_axis.x = sixteenths(size[0]);
            shear.z_axis.y = sixteenths(size[1]);
        }
        let scene = Scene {
            cameras: true,
            depth: true,
            flags: rng.bool(),
            materials: is_mirror || case == 2 || !is_known && rng.bool(),
            colour: match is_known {
                true => ColourForm::Codes,
                false => {
                    [ColourForm::Codes, ColourForm::Linear, ColourForm::SqrtLuma][rng.usize(..3)]
                }
            },
            attachment: true,
            reasons: true,
            ..Scene::default()
        };
        let settings = Settings {
            content: Content {
                norm: [Norm::L2, Norm::L1, Norm::LInf, Norm::Root][rng.usize(..4)],
                pairs: [
                    Pairs::All,
                    Pairs::Interleaved,
                    Pairs::SubSampled,
                    Pairs::Quad,
                    Pairs::Sobel,
                ][if is_known { 0 } else { rng.usize(..5) }],
                difference: [
                    Difference::Luma,
                    Difference::LargestChannel,
                    Difference::Rgb,
                ][rng.usize(..3)],
                form: [
                    Form::Window,
                    Form::Absolute,
                    Form::Pairwise { sensitivity: 0.07 },
                ][rng.usize(..3)],
                threshold: [0.15, 0.03, 0.6][rng.usize(..3)],
                ..Content::default()
            },
            motion: Some(Motion {
                blur: match case % 10 {
                    8 => Blur::Standalone { error: 0.5 },
                    9 => Blur::Ladder(Ladder::default()),
                    _ => Blur::Scaled,
                },
                ..Motion::default()
            }),
            reprojection: Some(Reprojection {
                fetch: Fetch::Tile,
                reversed_z,
                tolerance: [0.1, f64::INFINITY][if is_known { 1 } else { rng.usize(..2) }],
                ..Reprojection::default()
            }),
            materials: scene.materials.then(|| Materials {
                mirror: [0.8, 2.0][if is_mirror { 0 } else { rng.usize(..2) }],
                of: [MaterialsOf::This, MaterialsOf::Previous][rng.usize(..2)],
                ..Materials::default()
            }),
            smoothing: [Smoothing::None, Smoothing::Limit, Smoothing::Conservative][rng.usize(..3)],
            largest: [Rate::R2X2, Rate::R4X2, Rate::R4X4, Rate::R2X4][rng.usize(..4)],
            ..Settings::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let frame = Frame {
            previous_size: previous,
            has_history: is_known || rng.u32(..12) > 0,
            cameras: Some(Cameras {
                now,
                before: now * shear,
            }),
            ..Frame::of_size(size)
        };
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        let got = made.run(&gpu, &plan, &frame);
        println!("case {case}: {size:?}");
        assert_equal(&got, &wanted, &plan);
        rates.extend(wanted.sri.bytes().iter().copied());
        reasons.extend(wanted.reasons.iter().copied());
    }
    assert!(reasons.contains(&(Reason::Material as u8)), "{reasons:?}");
    // a tile that is coarse, and one that is not
    let is_coarse = |code: &u8| Rate::R2X2.is_within(Rate::from_code_or_full(*code));
    assert!(
        rates.contains(&0) && rates.iter().any(is_coarse),
        "{rates:?}"
    );
}

#[test]
fn tiles_refuse_what_looks_at_pixels() {
    let scene = Scene {
        cameras: true,
        depth: true,
        noise: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection {
            fetch: Fetch::Tile,
            ..Reprojection::default()
        }),
        half_rate: Some(HalfRate::default()),
        ..Settings::default()
    };
    let error = Plan::new(&scene, &settings).expect_err("noise is of pixels");
    assert_eq!(
        error.to_string(),
        "the extra half rate cannot be had where the previous picture is fetched by tiles of 16x16 pixels: fetch it by pixel \
         (Fetch::Pixel)"
    );
}
