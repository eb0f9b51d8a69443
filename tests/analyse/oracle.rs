//! The kernel against the oracle in f64.

use fastrand::Rng;
use vrcs::{
    Plan, Scene,
    analyse::{Analysis, Colour, Frame, Inputs, settings::*},
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
    use vrcs::analyse::exact;
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
