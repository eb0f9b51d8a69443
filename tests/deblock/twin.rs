//! GPU and CPU make one picture, in every format, on every run.

use fastrand::Rng;
use vrcs::{
    Rate,
    deblock::{
        Deblocker, Depth, DepthKind, Luma, Packing, Picture, Way,
        cpu::{self, Deblocked},
    },
    sri::Sri,
};
use wgpu::TextureFormat;

use crate::{
    bench::{Bench, Got},
    case::{Case, FORMATS, SIZES, packing_of, random_color, random_rates},
    common,
};

/// The largest distance that rounding to a picture's format makes, of a value.
fn rounding(picture: Picture, value: f64, channel: usize) -> f64 {
    let relative =
        |bits: i32, smallest: i32| (value.abs() * 2f64.powi(-bits)).max(2f64.powi(smallest));
    // a little over half a step, for f32 arithmetic; a driver may cut off rather than round to small floats, and may take either of the
    // two nearest codes (Vulkan, "Floating-Point Format Conversions" and "Conversion from Floating-Point to Normalized Fixed-Point"): a
    // whole step
    let f32_step = value.abs() * 2f64.powi(-21);
    let by_driver = matches!(picture, Picture::Texture(_));
    f32_step
        + match packing_of(picture) {
            Packing::Rgba8Unorm if by_driver => 1.0 / 255.0,
            Packing::Rgba8Unorm => 0.502 / 255.0,
            Packing::Rgba16Float => relative(10, -24),
            Packing::Rg11b10Ufloat if channel == 2 => relative(5, -19),
            Packing::Rg11b10Ufloat => relative(6, -20),
            Packing::Rgba32Float => 0.0,
        }
}

/// Expects that the GPU made what the twin makes, within what rounding explains.
pub fn assert_twins(got: &Got, wanted: &Deblocked, picture: Picture, what: &str) {
    assert_eq!(got.counters, wanted.counters, "{what}");
    for (index, (got, wanted)) in got.colors.iter().zip(&wanted.colors).enumerate() {
        for channel in 0..3 {
            let (g, w) = (f64::from(got[channel]), wanted[channel]);
            let is_near = (g - w).abs() <= rounding(picture, w, channel);
            assert!(
                is_near || (g.is_nan() && w.is_nan()) || g == w,
                "{what}: pixel {index}: {got:?} for {wanted:?}"
            );
        }
    }
}

#[test]
fn the_gpu_makes_what_its_twin_makes() {
    let bench = Bench::new();
    let seed = common::seed();
    let (mut tried, mut doubtful) = (0, 0);
    // every format with a third of the sizes, every size with a third of the formats; VRCS_ALL tries all
    let all = std::env::var_os("VRCS_ALL").is_some();
    for (f, picture) in FORMATS.into_iter().enumerate() {
        let packing = packing_of(picture);
        for (s, extent) in SIZES.into_iter().enumerate() {
            if !all && (f + s / 3) % 3 != s % 3 {
                continue;
            }
            tried += 1;
            let mut rng = Rng::with_seed(seed + (f * 100 + s) as u64);
            let rates = random_rates(extent, &mut rng);
            let mut case = Case::new(extent, rates, |_, _| [0.0; 4]);
            case.order = rng.u32(0..5);
            // few different colors, so that split blocks have equal pixels; not copied, the law is about any picture
            let colors: Vec<_> = (0..4).map(|_| random_color(&mut rng)).collect();
            case.colors.fill_with(|| colors[rng.usize(0..4)]);
            let pixels = case.colors.len();
            if s % 2 == 0 {
                case.surfaces = Some((0..pixels).map(|_| u32::from(rng.u32(0..9) == 0)).collect());
            }
            if s % 3 != 0 {
                let kind = [
                    DepthKind::Reversed,
                    DepthKind::Linear,
                    DepthKind::Standard {
                        near: 0.5,
                        far: 100.0,
                    },
                    DepthKind::ReversedFinite {
                        near: 0.5,
                        far: 100.0,
                    },
                ][rng.usize(0..4)];
                // two planes with jumps between them
                let values = (0..pixels)
                    .map(|i| {
                        let (x, y) = (i as u32 % extent[0], i as u32 / extent[0]);
                        let is_far = rng.u32(0..6) == 0;
                        let inverse =
                            0.2 + 0.0002 * f64::from(x % 256) + 0.0001 * f64::from(y % 256);
                        let z = 1.0 / (inverse * if is_far { 0.3 } else { 1.0 });
                        (match kind {
                            DepthKind::Linear => z,
                            DepthKind::Reversed => 0.5 / z,
                            DepthKind::Standard { near, far } => {
                                let (n, f) = (f64::from(near), f64::from(far));
                                f / (f - n) - f * n / (f - n) / z
                            }
                            DepthKind::ReversedFinite { near, far } => {
                                let (n, f) = (f64::from(near), f64::from(far));
                                f * n / (f - n) / z - n / (f - n)
                            }
                        }) as f32
                    })
                    .collect();
                case.depth = Some((Depth::new(kind), values));
            }
            let case = case.rounded(packing);
            let wanted = cpu::deblock(&case.scene());
            if wanted.margin < 1e-4 {
                // a comparison too near for f32 to tell
                doubtful += 1;
                continue;
            }
            let got = bench.run(&case, picture);
            assert_twins(
                &got,
                &wanted,
                picture,
                &format!("{picture:?} {extent:?} order {}", case.order),
            );
        }
    }
    assert!(
        tried >= 24 && doubtful * 3 < tried,
        "{doubtful} of {tried} cases told nothing"
    );
}

#[test]
fn whole_quads_are_filtered_as_their_pixels_are() {
    // where nothing is counted and no surface asked for, a quad is filtered at once, unless coverage has split it
    let bench = Bench::new();
    let seed = common::seed();
    let formats = [
        Picture::Texture(TextureFormat::Rgba8Unorm),
        Picture::R32Uint(Packing::Rg11b10Ufloat),
        Picture::Buffer(Packing::Rgba32Float),
    ];
    for (f, picture) in formats.into_iter().enumerate() {
        let packing = packing_of(picture);
        for (s, extent) in SIZES.into_iter().enumerate() {
            if (f + s) % 2 == 0 {
                continue;
            }
            let mut rng = Rng::with_seed(seed + 5000 + (f * 100 + s) as u64);
            let rates = random_rates(extent, &mut rng);
            let mut case = Case::new(extent, rates, |_, _| [0.0; 4]);
            (case.order, case.is_counted) = (rng.u32(0..5), false);
            case.has_coverage = (f + s) % 4 == 1;
            let mut colors: Vec<_> = (0..5).map(|_| random_color(&mut rng)).collect();
            if packing == Packing::Rgba32Float {
                colors.extend([[f32::INFINITY, 0.5, 0.5, 1.0], [0.5, 1e38, f32::NAN, 1.0]]);
            }
            case.colors.fill_with(|| colors[rng.usize(0..colors.len())]);
            let case = case.rounded(packing);
            let mut known = case.clone();
            if !case.has_coverage {
                // what is marked as split is left alone
                known.rates = Sri::from_fn(extent[0], extent[1], |x, y| {
                    let byte = case.rates.code(x, y);
                    if byte & 0x80 == 0 { byte } else { 0 }
                });
            }
            let wanted = Deblocked {
                counters: Default::default(),
                ..cpu::deblock(&known.scene())
            };
            let what = format!("{picture:?} {extent:?} order {}", case.order);
            assert_twins(&bench.run(&case, picture), &wanted, picture, &what);
            if f == 0 {
                let luma = bench.deblocker(&case, picture, Some(Luma::SRGB), true);
                assert_twins(&bench.run_with(&luma, &case), &wanted, picture, &what);
            }
        }
    }
}

#[test]
fn every_format_is_told_how_it_is_stored() {
    let bench = Bench::new();
    let case = Case::new([20, 12], Sri::uniform(20, 12, Rate::R2X2), |x, y| {
        [x as f32 / 20.0, y as f32 / 12.0, 0.5, 1.0]
    });
    for format in [
        TextureFormat::Rgba8Unorm,
        TextureFormat::Rgba16Float,
        TextureFormat::Rgba32Float,
    ] {
        // without the adapter only what WebGPU guarantees: through a scratch texture; the picture is the same, bit for bit
        let portable = bench.deblocker(&case, Picture::Texture(format), None, false);
        assert_eq!(portable.way(), Way::Scratch);
        let own = bench.deblocker(&case, Picture::Texture(format), None, true);
        println!("{format:?}: {}", own.way());
        assert_eq!(
            bench.run_with(&portable, &case).words,
            bench.run_with(&own, &case).words
        );
    }
    let r11 = Picture::Texture(TextureFormat::Rg11b10Ufloat);
    match Deblocker::new(&bench.gpu.device, Some(&bench.adapter), case.options(r11)) {
        Ok(deblocker) => {
            println!("rg11b10ufloat: {}", deblocker.way());
            let case = case.clone().copied().rounded(Packing::Rg11b10Ufloat);
            let wanted = cpu::deblock(&case.scene());
            assert_twins(
                &bench.run_with(&deblocker, &case),
                &wanted,
                r11,
                "rg11b10ufloat",
            );
        }
        Err(error) => assert!(
            error.to_string().contains("not stored by this device"),
            "{error}"
        ),
    }
    let refused = Deblocker::new(
        &bench.gpu.device,
        None,
        case.options(Picture::Texture(TextureFormat::R8Unorm)),
    );
    assert!(
        refused
            .unwrap_err()
            .to_string()
            .contains("R8Unorm is not supported")
    );
    let refused = Deblocker::new(
        &bench.gpu.device,
        None,
        case.options(Picture::R32Uint(Packing::Rgba16Float)),
    );
    assert!(refused.unwrap_err().to_string().contains("one word"));
}

/// E30. The slides' filter, in place, races. This one's samples are never written.
#[test]
fn fifty_runs_are_one_run() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    let extent = [257, 131];
    let mut case = Case::new(extent, random_rates(extent, &mut rng), |_, _| [0.0; 4]);
    case.colors.fill_with(|| random_color(&mut rng));
    case.surfaces = Some((0..extent[0] * extent[1]).map(|i| i / 50 % 2).collect());
    for picture in [
        Picture::Texture(TextureFormat::Rgba8Unorm),
        Picture::Buffer(Packing::Rgba16Float),
    ] {
        let luma = Luma::linear(0);
        let deblocker = bench.deblocker(&case, picture, Some(luma), true);
        let first = bench.run_with(&deblocker, &case);
        for run in 1..50 {
            let got = bench.run_with(&deblocker, &case);
            assert_eq!(got.words, first.words, "run {run}");
            assert_eq!(
                (got.counters, &got.luma),
                (first.counters, &first.luma),
                "run {run}"
            );
        }
    }
}
