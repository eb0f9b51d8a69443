//! The twins against each other, and the hazards of any doubt. All on the CPU.

mod content;
mod history;
mod kernels;
mod later;

use super::{Colour, Inputs, Reason, Settings, exact, inputs::flags, integer, settings::*};
use crate::{Rate, sri::Sri};
use fastrand::Rng;

fn rng() -> Rng {
    let seed = std::env::var("VRCS_SEED")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or_else(|| fastrand::u64(..1_000_000_007));
    println!("VRCS_SEED={seed}");
    Rng::with_seed(seed)
}

/// A picture like nature: sums of waves whose amplitude falls as 1/f.
fn natural(size: [u32; 2], contrast: f64, rng: &mut Rng) -> Vec<[u8; 4]> {
    let waves: Vec<[f64; 5]> = (0..48)
        .map(|_| {
            let f = 0.01 * 60f64.powf(rng.f64());
            let angle = rng.f64() * std::f64::consts::TAU;
            [
                f * angle.cos(),
                f * angle.sin(),
                rng.f64() * 6.3,
                0.01 / f,
                rng.f64(),
            ]
        })
        .collect();
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (f64::from(i % size[0]), f64::from(i / size[0]));
            let mut v = [0.45; 3];
            for [fx, fy, phase, amplitude, tint] in &waves {
                let wave = (std::f64::consts::TAU * (fx * x + fy * y) + phase).sin()
                    * amplitude
                    * contrast;
                for (c, v) in v.iter_mut().enumerate() {
                    *v += wave * (0.6 + 0.4 * if c == 0 { *tint } else { 1.0 - tint });
                }
            }
            let [r, g, b] = v.map(|v| (v * 255.0).clamp(0.0, 255.0) as u8);
            [r, g, b, 255]
        })
        .collect()
}

fn adversarial(size: [u32; 2], case: u32) -> Vec<[u8; 4]> {
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let v = match case % 6 {
                0 => ((x + y) % 2 * 255) as u8,
                1 => (x * 3 % 256) as u8,
                2 => {
                    if (x / 7 + y / 5) % 2 == 0 {
                        20
                    } else {
                        24
                    }
                }
                3 => u8::from(x == y) * 255,
                4 => 0,
                _ => (x * 11 + y * 7) as u8 % 12,
            };
            [v, v.wrapping_mul(if case >= 6 { 3 } else { 1 }), v, 255]
        })
        .collect()
}

fn random(size: [u32; 2], span: u8, rng: &mut Rng) -> Vec<[u8; 4]> {
    let low = rng.u8(..=255 - span);
    (0..size[0] * size[1])
        .map(|_| std::array::from_fn(|_| low + rng.u8(..=span)))
        .collect()
}

fn contents() -> Vec<Content> {
    let mut all = Vec::new();
    for norm in [Norm::L2, Norm::L1, Norm::LInf, Norm::Root] {
        for pairs in [
            Pairs::All,
            Pairs::Interleaved,
            Pairs::SubSampled,
            Pairs::Quad,
            Pairs::Sobel,
        ] {
            for difference in [
                Difference::Luma,
                Difference::LargestChannel,
                Difference::Rgb,
            ] {
                for form in [
                    Form::Window,
                    Form::Absolute,
                    Form::Pairwise { sensitivity: 0.07 },
                ] {
                    all.push(Content {
                        norm,
                        pairs,
                        difference,
                        form,
                        ..Content::default()
                    });
                }
            }
        }
    }
    all
}

/// Quads where the twins differ, and all that may: those that the oracle finds [doubtful](exact::Exact::doubtful). A difference elsewhere
/// is a failure.
fn compare(inputs: &Inputs, settings: &Settings) -> [usize; 3] {
    let exact = exact::analyse(inputs, settings).expect("inputs that fit");
    let integer = integer::analyse(inputs, settings).expect("inputs that fit");
    let layout = exact.output.sri.layout();
    let [mut apart, mut may] = [0; 2];
    for y in 0..layout.height {
        for x in 0..layout.width {
            let codes = [exact.output.sri.code(x, y), integer.sri.code(x, y)];
            // a rate of 4 hangs on its block
            let is_doubtful = (0..4).any(|i| {
                let (bx, by) = ((x & !1) + i % 2, (y & !1) + i / 2);
                bx < layout.width
                    && by < layout.height
                    && exact.doubtful[(by * layout.width + bx) as usize]
            });
            may += usize::from(is_doubtful);
            if codes[0] != codes[1] {
                assert!(
                    is_doubtful,
                    "quad {x},{y}: {codes:?}, {} from its threshold\n{settings:?}",
                    exact.margins[(y * layout.width + x) as usize]
                );
                apart += 1;
            }
        }
    }
    [apart, may, (layout.width * layout.height) as usize]
}

fn twins(inputs: &Inputs, settings: &Settings) -> [super::Output; 2] {
    [
        integer::analyse(inputs, settings).expect("inputs that fit"),
        exact::analyse(inputs, settings)
            .expect("inputs that fit")
            .output,
    ]
}
