//! √luma for the next frame, written in the same pass.

use fastrand::Rng;
use vrcs::{
    Rate,
    analyse::{fixed, params::linear_code},
    deblock::{Luma, Packing, Picture, Transfer, Weights, cpu},
    sri::Sri,
};
use wgpu::TextureFormat;

use crate::{
    bench::Bench,
    case::{Case, SIZES, random_color, random_rates},
    common,
};

#[test]
fn the_luma_of_the_next_frame_comes_with_it() {
    let bench = Bench::new();
    let seed = common::seed();
    for (s, extent) in SIZES.into_iter().enumerate() {
        for luma in [Luma::linear(2), Luma::SRGB] {
            let mut rng = Rng::with_seed(seed + s as u64);
            let picture = Picture::Buffer(Packing::Rgba32Float);
            let mut case = Case::new(extent, random_rates(extent, &mut rng), |_, _| [0.0; 4]);
            case.colors.fill_with(|| random_color(&mut rng));
            if let Some(color) = case.colors.get_mut(11) {
                color[1] = f32::NAN;
            }
            let plain = bench.run(&case, picture);
            let deblocker = bench.deblocker(&case, picture, Some(luma), true);
            let got = bench.run_with(&deblocker, &case);
            assert_eq!(got.words, plain.words, "luma changes no pixel");
            let wanted = cpu::deblock(&case.scene());
            for (i, &code) in got.luma.iter().enumerate() {
                let wanted = code_at(&luma, extent, &wanted.colors, i);
                // f32 against f64, of a channel that was filtered: near 0 a unit of it is worth a few codes
                let is_filtered = got.words[4 * i..4 * i + 3] != case_words(&case, i);
                let most = if is_filtered { 4 } else { 0 };
                assert!(
                    code.abs_diff(wanted) <= most,
                    "{extent:?} pixel {i}: {code} for {wanted}"
                );
            }
        }
    }
    let luma = Luma::linear(0);
    let codes = |quad: [f32; 4]| cpu::luma_codes(&luma, quad.map(|v| Some([v; 4])));
    assert_eq!(
        codes([1.0, 0.0, 0.2501, 2.0]),
        [255, 0, 128, 255],
        "the root of a quarter is half; above white is white"
    );
}

/// Whatever lies around it: white beside a white neighbour or black beside a black one would hide.
#[test]
fn a_quad_that_is_not_finite_asks_for_full_rate() {
    let bench = Bench::new();
    let luma = Luma::linear(0);
    let picture = Picture::Buffer(Packing::Rgba32Float);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for around in [0.0, 1.0] {
            for at in [[6, 4], [7, 4], [6, 5], [7, 5], [12, 8]] {
                let extent = [13, 9];
                let case = Case::new(extent, Sri::uniform(13, 9, Rate::R2X2), |x, y| {
                    [if [x, y] == at { bad } else { around }, around, around, 1.0]
                });
                let deblocker = bench.deblocker(&case, picture, Some(luma), true);
                let got = bench.run_with(&deblocker, &case);
                for (i, &code) in got.luma.iter().enumerate() {
                    let [x, y] = [i as u32 % 13, i as u32 / 13];
                    let is_bad = [x / 2, y / 2] == at.map(|v| v / 2);
                    let wanted = match (is_bad, (x + y) % 2) {
                        (true, odd) => odd as u8 * 255,
                        (false, _) => around as u8 * 255,
                    };
                    assert_eq!(
                        code, wanted,
                        "{bad} at {at:?} among {around}: pixel {x},{y}"
                    );
                }
            }
        }
    }
}

/// The code of a pixel as the twin has it.
fn code_at(luma: &Luma, extent: [u32; 2], colors: &[[f64; 4]], pixel: usize) -> u8 {
    let [x, y] = [pixel as u32 % extent[0], pixel as u32 / extent[0]];
    let quad = std::array::from_fn(|i| {
        let [x, y] = [(x & !1) + (i as u32 & 1), (y & !1) + (i as u32 >> 1)];
        let is_inside = x < extent[0] && y < extent[1];
        is_inside.then(|| colors[(y * extent[0] + x) as usize].map(|c| c as f32))
    });
    cpu::luma_codes(luma, quad)[((x & 1) + (y & 1) * 2) as usize]
}

/// The bits of a pixel's color.
fn case_words(case: &Case, pixel: usize) -> [u32; 3] {
    std::array::from_fn(|channel| case.colors[pixel][channel].to_bits())
}

/// The deblocker and the analysis write the same √luma for the same color, whatever it is but for what is not finite: of all bytes,
/// of linear values up to white and beyond, of negative ones.
#[test]
fn the_luma_is_that_of_the_analysis() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    let extent = [64, 64];
    let full = || Sri::uniform(extent[0], extent[1], Rate::R1X1);
    let bytes = Case::new(extent, full(), |x, y| {
        let byte = |v: u32| (v % 256) as f32 / 255.0;
        [
            byte(x + y * 64),
            byte(x * 5 + y * 3),
            byte(x * 11 + y * 17),
            1.0,
        ]
    });
    let mut linear = Case::new(extent, full(), |_, _| [0.0; 4]);
    linear.colors.fill_with(|| {
        std::array::from_fn(|_| match rng.u32(0..12) {
            0 => 4.0,
            1 => 4.0001,
            2 => -0.01,
            3 => -1e-7,
            _ => rng.f32() * 4.0,
        })
    });
    let analysis = |luma: &Luma, color: [f32; 4]| {
        let units = [color[0], color[1], color[2]].map(|channel| match luma.transfer {
            Some(transfer) => Some(linear_code((channel * 255.0).round() as u8, transfer)),
            None => fixed::quantise(channel, luma.white_log2),
        });
        match units {
            [Some(r), Some(g), Some(b)] => {
                fixed::sqrt_code(fixed::luma([r, g, b], luma.weights.fixed())) as u8
            }
            // integer::analyse: doubt is white
            _ => 255,
        }
    };
    let rec709 = |luma: Luma| Luma {
        weights: Weights::Rec709,
        ..luma
    };
    let squared = Luma {
        transfer: Some(Transfer::Square),
        ..Luma::SRGB
    };
    let mut seen = std::collections::BTreeSet::new();
    for (case, luma, picture) in [
        (
            &bytes,
            Luma::SRGB,
            Picture::Texture(TextureFormat::Rgba8Unorm),
        ),
        (
            &bytes,
            rec709(squared),
            Picture::R32Uint(Packing::Rgba8Unorm),
        ),
        (
            &linear,
            Luma::linear(2),
            Picture::Buffer(Packing::Rgba32Float),
        ),
        (
            &linear,
            rec709(Luma::linear(2)),
            Picture::Texture(TextureFormat::Rgba32Float),
        ),
    ] {
        let deblocker = bench.deblocker(case, picture, Some(luma), true);
        let got = bench.run_with(&deblocker, case);
        for (i, (&code, &color)) in got.luma.iter().zip(&case.colors).enumerate() {
            assert_eq!(
                code,
                analysis(&luma, color),
                "{luma:?} pixel {i}: {color:?}"
            );
            seen.insert(code);
        }
    }
    assert!(seen.len() > 200, "{} codes", seen.len());
}
