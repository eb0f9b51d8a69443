//! The kernel against the oracle in f64.

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{
        Analysis, Cameras, Colour, Frame, HalfResolution, Inputs, Lens, OwnRates, exact,
        own::{IdRates, Particles},
        settings::*,
    },
    plan::{Binding, ColourForm},
};

use crate::{common, made::Made};

/// Pictures as nature makes them (amplitudes of 1/f, by octaves), at random, and against the estimator: stripes, chequers, single pixels.
fn picture(kind: u32, size: [u32; 2], rng: &mut Rng) -> Vec<[u8; 4]> {
    let octaves: Vec<(u32, Vec<f32>)> = (0..5)
        .map(|octave| (1 << octave, (0..4096).map(|_| rng.f32() - 0.5).collect()))
        .collect();
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let natural: f32 = octaves
                .iter()
                .map(|(side, values)| {
                    let at = (x / side + y / side * 61) as usize % values.len();
                    values[at] * *side as f32 / 16.0
                })
                .sum();
            let value = match (kind, (x / 13 + y / 11) % 4) {
                (0, _) => 110.0 + natural * 60.0,
                (1, _) => 100.0 + rng.f32() * 40.0,
                (_, 0) => ((x + y) % 2 * 140) as f32,
                (_, 1) => (x / 2 % 2 * 90) as f32 + 20.0,
                (_, 2) => {
                    if rng.u32(..30) == 0 {
                        255.0
                    } else {
                        80.0
                    }
                }
                _ => (x * 3 + y) as f32,
            };
            [value.clamp(0.0, 255.0) as u8; 4]
        })
        .collect()
}

// the kernel against the formulas as they stand in the papers, without the integer twin between them
#[test]
fn the_gpu_equals_the_f64_twin_but_in_the_band_that_it_derives() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [94, 62];
    let [mut apart, mut may, mut all] = [0; 3];
    for norm in [Norm::L2, Norm::L1, Norm::LInf] {
        for form in [Form::Window, Form::Pairwise { sensitivity: 0.07 }] {
            let settings = Settings {
                content: Content {
                    norm,
                    form,
                    ..Content::default()
                },
                ..Settings::default()
            };
            let scene = Scene::default();
            let plan = Plan::new(&scene, &settings).expect("a plan");
            let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
            for kind in 0..3 {
                let mut made = Made::new(size, size, &mut rng);
                made.codes = picture(kind, size, &mut rng);
                let got = made.run_with(&gpu, &analysis, &Frame::of_size(size));
                let inputs = Inputs::of_colour(size, Colour::Codes(&made.codes));
                let wanted = exact::analyse(&inputs, &settings).expect("inputs");
                let layout = wanted.output.sri.layout();
                for y in 0..layout.height {
                    for x in 0..layout.width {
                        let is_doubtful = wanted.doubtful[(y * layout.width + x) as usize];
                        let same =
                            got[0][(y * layout.pitch + x) as usize] == wanted.output.sri.code(x, y);
                        assert!(same || is_doubtful, "{x},{y}: {norm:?}, {form:?}, {kind}");
                        apart += usize::from(!same);
                        may += usize::from(is_doubtful);
                        all += 1;
                    }
                }
            }
        }
    }
    println!("{apart} of {all} quads differ, of {may} whose errors lie in the derived band");
    assert!(apart * 100 < all && may * 8 < all, "{apart} {may} {all}");
}

/// An effect, and what is declared and set for it.
type Effect = (&'static str, fn(&mut Scene, &mut Settings));

fn moving(scene: &mut Scene, settings: &mut Settings, blur: Blur) {
    scene.motion = true;
    settings.motion = Some(Motion {
        blur,
        ..Motion::default()
    });
}

/// One row for each effect of the stage. What decides by numbers of its own is held against the formulas as they stand in the papers.
const EFFECTS: &[Effect] = &[
    ("√luma", |scene, _| scene.colour = ColourForm::SqrtLuma),
    ("linear light", |scene, _| scene.colour = ColourForm::Linear),
    ("c² for sRGB, BT.709", |_, settings| {
        settings.content.transfer = Transfer::Square;
        settings.content.weights = Weights::Rec709;
    }),
    ("interleaved pairs, the largest channel", |_, settings| {
        settings.content.pairs = Pairs::Interleaved;
        settings.content.difference = Difference::LargestChannel;
    }),
    ("sub-sampled pairs, differences in RGB", |_, settings| {
        settings.content.pairs = Pairs::SubSampled;
        settings.content.difference = Difference::Rgb;
    }),
    ("the quad's own pairs, absolute", |_, settings| {
        settings.content.pairs = Pairs::Quad;
        settings.content.form = Form::Absolute;
    }),
    ("Sobel, maximum", |_, settings| {
        settings.content.pairs = Pairs::Sobel;
        settings.content.norm = Norm::LInf;
    }),
    ("VALAR's root", |_, settings| {
        settings.content.norm = Norm::Root;
        settings.content.threshold = 0.6;
    }),
    ("another k and l", |_, settings| {
        settings.content.k = 3.5;
        settings.content.ambient = 0.3;
    }),
    ("motion, Eq. 20 to 22", |scene, settings| {
        moving(scene, settings, Blur::Scaled)
    }),
    ("motion by VALAR's lines", |scene, settings| {
        moving(scene, settings, Blur::Linear)
    }),
    ("motion alone, Eq. 23 and 24", |scene, settings| {
        moving(scene, settings, Blur::Standalone { error: 0.5 });
    }),
    ("motion by Wicked's ladder", |scene, settings| {
        moving(scene, settings, Blur::Ladder(Ladder::default()));
    }),
    ("reprojection by pixel, with depth", |scene, settings| {
        moving(scene, settings, Blur::Scaled);
        scene.depth = true;
        settings.reprojection = Some(Reprojection::default());
    }),
    ("reprojection by tile", |scene, settings| {
        (scene.cameras, scene.depth) = (true, true);
        settings.motion = Some(Motion::default());
        settings.reprojection = Some(Reprojection {
            fetch: Fetch::Tile,
            tolerance: f64::INFINITY,
            ..Reprojection::default()
        });
    }),
    ("materials in slow motion", |scene, settings| {
        moving(scene, settings, Blur::Scaled);
        scene.materials = true;
        settings.materials = Some(Materials::default());
    }),
    ("hysteresis", |scene, settings| {
        scene.previous_rates = true;
        settings.stability = Stability::Hysteresis;
    }),
    ("the previous rate's gain divided out", |scene, settings| {
        scene.previous_rates = true;
        settings.stability = Stability::Compensate;
    }),
    (
        "extra half rate by a mask of noise, rates without it beside",
        |scene, settings| {
            (scene.noise, scene.plain_rates) = (true, true);
            settings.half_rate = Some(HalfRate {
                tolerance: 0.3,
                ..HalfRate::default()
            });
        },
    ),
    ("transparents", |scene, settings| {
        scene.after_transparents = true;
        settings.transparents = true;
    }),
    ("foveation, overshoot, safe area", |_, settings| {
        settings.foveation = Some(Foveation::default());
        settings.overshoot = vec![[0.5, 1.3], [1.0, 0.7]];
        settings.safe_area = Some(SafeArea::default());
    }),
    ("a later blur and a lens", |scene, settings| {
        moving(scene, settings, Blur::Scaled);
        (scene.blur, scene.depth, settings.later_blur) = (true, true, true);
        settings.lens = Some(Lens {
            focus: 0.1 / 0.31,
            infinity: 20.0,
            ..Lens::default()
        });
    }),
    ("own rates and flags", |scene, settings| {
        (scene.ids, scene.flags) = (true, true);
        settings.own = Some(OwnRates {
            ids: Some(IdRates {
                rates: (0..20)
                    .map(|id| (id % 3 == 0).then_some(Rate::R2X1))
                    .collect(),
                ..IdRates::default()
            }),
            particles: Some(Particles::default()),
            ..OwnRates::default()
        });
    }),
    ("neighbours' limit", |_, settings| {
        settings.smoothing = Smoothing::Limit;
    }),
    ("conservative blur, half resolution", |_, settings| {
        settings.smoothing = Smoothing::Conservative;
        settings.half_resolution = Some(HalfResolution::Code);
    }),
];

/// Of an effect: quads that differ from the oracle's, quads whose errors lie in the derived band, all.
fn held(gpu: &vrcs::check::gpu::Gpu, effect: &Effect, rng: &mut Rng) -> [usize; 3] {
    let (name, declare) = effect;
    let mut settings = Settings {
        // both thresholds decide
        largest: Rate::R4X4,
        ..Settings::default()
    };
    let mut scene = Scene {
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    declare(&mut scene, &mut settings);
    // where a camera's matrices are divided through, sides of powers of two round nothing
    let size = [[94, 62], [128, 64]][usize::from(scene.cameras)];
    let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
    let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
    let frame = Frame {
        resolution_scale: 0.7,
        cameras: scene.cameras.then(|| {
            let still = glam::DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 8.0, 0.0);
            Cameras {
                now: still,
                before: still,
            }
        }),
        ..Frame::of_size(size)
    };
    let mut counts = [0; 3];
    for kind in 0..3 {
        let mut made = Made::new(size, size, rng);
        made.codes = picture(kind, size, rng);
        made.after_codes = picture((kind + 1) % 3, size, rng);
        made.sqrt = made.codes.iter().map(|code| code[0]).collect();
        let light = |code: &[u8; 4]| code.map(|c| (f32::from(c) / 255.0).powi(2));
        made.linear = made.codes.iter().map(light).collect();
        let got = made.run_with(gpu, &analysis, &frame);
        let wanted = exact::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs");
        let output = &wanted.output;
        let layout = output.sri.layout();
        // rates of 4 hold for blocks of four quads that agree, and smoothing hands a rate on to the quads around
        let reach = u32::from(settings.smoothing != Smoothing::None);
        let from = |at: u32| at.saturating_sub(reach) & !1;
        let to = |at: u32, side: u32| ((at + reach) | 1).min(side - 1);
        let doubtful = |x: u32, y: u32| {
            (from(y)..=to(y, layout.height)).any(|y| {
                (from(x)..=to(x, layout.width))
                    .any(|x| wanted.doubtful[(y * layout.width + x) as usize])
            })
        };
        for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
            let at = (y * layout.pitch + x) as usize;
            let mut all = vec![(got[0][at], output.sri.code(x, y))];
            all.push((got[1][at], output.attachment.code(x, y)));
            if scene.plain_rates {
                all.push((got[5][at], output.plain.code(x, y)));
            }
            let is_same = all.iter().all(|(got, wanted)| got == wanted);
            let is_doubtful = doubtful(x, y);
            assert!(
                is_same || is_doubtful,
                "{name}, picture {kind}: {x},{y}: {all:?}"
            );
            counts[0] += usize::from(!is_same);
            counts[1] += usize::from(is_doubtful);
            counts[2] += 1;
        }
        if plan.bindings.contains(&Binding::HalfRates) {
            let half = output.half.as_ref().expect("asked for");
            let of_half = half.layout();
            for (x, y) in (0..of_half.height).flat_map(|y| (0..of_half.width).map(move |x| (x, y)))
            {
                let any = (0..4).any(|i| {
                    let (x, y) = (x * 2 + i % 2, y * 2 + i / 2);
                    x < layout.width && y < layout.height && doubtful(x, y)
                });
                let is_same = got[4][(y * of_half.pitch + x) as usize] == half.code(x, y);
                assert!(is_same || any, "{name}, picture {kind}: half of {x},{y}");
            }
        }
    }
    counts
}

/// For every effect: the kernel's rates are those of the oracle in f64 on every quad, but where its own error lies so near to a threshold
/// that the deterministic path's rounding, which is derived for each window, may decide otherwise. How many quads are in that band, and how many
/// of them do differ, is reported.
#[test]
fn the_gpu_equals_the_f64_twin_for_every_effect() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let mut sums = [0; 3];
    for effect in EFFECTS {
        let counts = held(&gpu, effect, &mut rng);
        let [apart, may, all] = counts;
        println!(
            "{}: {apart} of {all} quads differ, {may} in the band",
            effect.0
        );
        assert!(apart * 20 < all, "{}: {counts:?}", effect.0);
        sums = std::array::from_fn(|i| sums[i] + counts[i]);
    }
    let [apart, may, all] = sums;
    println!("all effects: {apart} of {all} quads differ, {may} in the band");
    assert!(apart * 100 < all && may * 5 < all, "{sums:?}");
}
