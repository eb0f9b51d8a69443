//! Motion from depth and the cameras of both frames.

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{Analysis, Cameras, Frame, Inputs, integer, settings::*},
    plan::Binding,
    sri::{Sri, SriLayout},
};

use crate::{common, made::Made};

/// Depths of a slanted wall before a far one, by a camera.
fn wall(size: [u32; 2], camera: &glam::DMat4) -> Vec<f32> {
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (f64::from(i % size[0]), f64::from(i / size[0]));
            let z = match x < f64::from(size[0]) * 0.6 {
                true => 3.0 + x * 0.05 + y * 0.02,
                false => 40.0,
            };
            let clip = *camera * glam::DVec4::new(0.0, 0.0, -z, 1.0);
            (clip.z / clip.w) as f32
        })
        .collect()
}

/// Projections with standard and reversed depth.
fn projections() -> [(bool, glam::DMat4); 2] {
    [(false, 0.1, 100.0), (true, 100.0, 0.1)]
        .map(|(reversed, near, far)| (reversed, glam::DMat4::perspective_rh(1.0, 1.6, near, far)))
}

// fails when the sign of y is lost, when w before is not looked at, or when what is flagged moves with the world
#[test]
fn the_camera_moves_pixels_on_the_gpu_as_in_f64_but_for_a_step_of_speed() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [96, 60];
    let steps = [
        glam::DVec3::new(0.05, 0.0, 0.0),
        glam::DVec3::new(0.0, -0.08, 0.3),
        glam::DVec3::new(0.3, 0.1, -0.5),
    ];
    let scene = Scene {
        cameras: true,
        depth: true,
        flags: true,
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let plan = Plan::new(&scene, &settings).expect("a plan");
    assert!(!plan.bindings.contains(&Binding::Motion), "{plan}");
    let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
    let (mut apart, mut coarse) = (0, 0);
    for (reversed_z, projection) in projections() {
        for step in steps {
            let before = projection * glam::DMat4::from_translation(step);
            let mut made = Made::new(size, size, &mut rng);
            for code in &mut made.codes {
                *code = [rng.u8(60..200); 4];
            }
            made.depth = wall(size, &projection);
            made.flags = (0..size[0] * size[1])
                .map(|i| u8::from(i % size[0] < 12))
                .collect();
            let frame = Frame {
                cameras: Some(Cameras {
                    now: projection,
                    before,
                }),
                ..Frame::of_size(size)
            };
            let got = made.run_with(&gpu, &analysis, &frame);
            let inputs = made.inputs(&plan, &frame);
            let vectors =
                vrcs::analyse::reproject::camera_motions(size, &made.depth, &projection, &before);
            // the twin's own, a step slower and a step faster
            let twins = [0.0f32, -1.0 / 16.0, 1.0 / 16.0].map(|more| {
                let near: Vec<[f32; 2]> = vectors
                    .iter()
                    .map(|v| v.map(|v| (v.abs() + more).max(0.0)))
                    .collect();
                let inputs = Inputs {
                    motion: (more != 0.0).then_some(&near[..]),
                    ..inputs
                };
                integer::analyse(&inputs, &settings).expect("inputs").sri
            });
            let layout = twins[0].layout();
            for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
                let code = got[0][(y * layout.pitch + x) as usize];
                apart += usize::from(code != twins[0].code(x, y));
                coarse += usize::from(code != 0);
                for axis in [2, 0] {
                    let of = |twin: &Sri| twin.code(x, y) >> axis & 3;
                    assert!(
                        twins.iter().any(|twin| of(twin) == code >> axis & 3),
                        "{x},{y}: {code}, {step}, reversed {reversed_z}"
                    );
                }
                if x < 5 {
                    let still = twins[0].code(x, y);
                    assert_eq!(code, still, "{x},{y} does not move with the world");
                }
            }
        }
    }
    let all = 6 * 48 * 30;
    println!("{apart} of {all} quads differ, by a step of speed; {coarse} are coarse");
    assert!(apart * 50 < all && coarse * 20 > all, "{apart} {coarse}");
}

#[test]
fn a_camera_that_shows_nothing_or_is_not_given_leaves_full_rate() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [40, 24];
    for (reversed_z, projection) in projections() {
        let mut made = Made::new(size, size, &mut rng);
        made.codes.fill([90; 4]);
        made.depth = wall(size, &projection);
        if let Some(last) = made.depth.last_mut() {
            *last = f32::NAN;
        }
        made.previous_depth.clone_from(&made.depth);
        let scene = Scene {
            cameras: true,
            depth: true,
            attachment: true,
            reasons: true,
            ..Scene::default()
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            reprojection: Some(Reprojection {
                reversed_z,
                near_over_far: 0.001,
                ..Reprojection::default()
            }),
            ..Settings::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
        let turned = projection * glam::DMat4::from_rotation_y(std::f64::consts::PI);
        let cases = [
            (None, 0u8),
            (Some(turned), 0),
            (Some(glam::DMat4::ZERO), 0),
            (Some(projection), Rate::R2X2.code()),
        ];
        for (before, wanted) in cases {
            let frame = Frame {
                cameras: before.map(|before| Cameras {
                    now: projection,
                    before,
                }),
                ..Frame::of_size(size)
            };
            let got = made.run_with(&gpu, &analysis, &frame);
            // away from the border, which a rounding may put off the screen
            let layout = SriLayout::new(size[0], size[1]);
            assert_eq!(
                got[0][(5 * layout.pitch + 6) as usize],
                wanted,
                "{before:?}"
            );
            // the last pixel has no depth
            let last = ((layout.height - 1) * layout.pitch + layout.width - 1) as usize;
            assert_eq!(got[0][last], 0, "{before:?}");
        }
    }
}
