//! Values that are none, or beyond what a format holds, in every input of the analysis.

use vrcs::{
    Rate,
    analyse::{
        Colour, Inputs, Reason, Settings, fixed, motion, params::Params, refit, settings::*,
    },
    plan::ColourForm,
    sri::Sri,
};

use crate::{
    case::{Case, Family},
    driver::Kernel,
    stage::{all_are, grey, of_picture, quads, twins},
};

pub const FAMILY: Family = Family {
    name: "values",
    about: "NaN, ±∞, ±0, denormals, negatives, 65504 and 1e30 in every input of the analysis: any doubt means full rate, there and nowhere else.",
    cases: &[
        Case {
            id: "E1",
            name: "a colour that is NaN or infinite, one pixel and whole frames, each channel",
            hazard: "every comparison is false, and the quad falls to the coarsest rate",
            bound: "1x1 where a quad's window holds it, the plain rate elsewhere, in both twins",
            guard: "fixed::quantise looks at the bits; with `!(value > white)` NaN becomes 0 units, a black pixel, and windows are coarse (tried: quad 0,0 is 2x2)",
            run: colours_that_are_none,
        },
        Case {
            id: "E2",
            name: "colours of 65504 and 1e30, and white at every power of two",
            hazard: "squares and sums overflow; Inf − Inf is NaN; a packed sum wraps",
            bound: "1x1 above white, and the same rates for a picture and its white times 2^n, n from −16 to 16",
            guard: "quantise scales by white before anything is summed; without it white at 2^-16 gives other rates, and E9 fails at 1024 units (tried)",
            run: white_moves_with_the_picture,
        },
        Case {
            id: "E2-halves",
            name: "half-float and float textures on this driver: ±∞, NaN, 65504, −0.5, denormals at single pixels",
            hazard: "a driver flushes, clamps or compares such values in another way than the twin does",
            bound: "every byte as the integer twin; 1x1 in the windows that hold one, the plain rate elsewhere",
            guard: "quantise looks at bits, in the twin as in the kernel; with `!(value > white)` in the twin they differ at the first NaN (tried)",
            run: textures_of_floats,
        },
        Case {
            id: "E3",
            name: "negative light: −1e-30 to −1e30 at single pixels of plain, dark and noisy pictures",
            hazard: "min(A, B) + BS becomes negative and turns the sign of an error: coarse",
            bound: "1x1, or the rates of the picture with 0 in its place; by window and by pairs",
            guard: "quantise: what is negative beyond rounding is doubt; taken as a magnitude, −1 is a plain white and E1 fails as well (tried)",
            run: negative_light,
        },
        Case {
            id: "E4",
            name: "a bright quad in a black surrounding, C and l at 0 and above",
            hazard: "L is the least of the block, the pairs reach beyond it: x ÷ 0 and 0 ÷ 0",
            bound: "1x1 at its edges by every form; all black by pairs with C = 0 is an error of 0 in both twins, decided alike",
            guard: "joined: (d, base) with base 0 is 16383, and d 0 is 0; with a ratio that stops at 1 the bright quad's edge is 2x2 (tried)",
            run: black_surroundings,
        },
        Case {
            id: "E5",
            name: "black frames, with ambient light and without",
            hazard: "0 ≥ 0: letterboxes at full rate, or NaN",
            bound: "coarse with l > 0; full rate, as Eq. 15 says, with l = 0; alike in both twins, four norms",
            guard: "is_below is strict; where an error of 0 is below 0, black without ambient light is 2x2 (tried)",
            run: black_frames,
        },
        Case {
            id: "E6",
            name: "chequers of 0 and 1 by pairs, C from 0.001 to 0.07",
            hazard: "ratios of 14 to 1000 where the packing assumes 1: 128 · 14.3 · 255 runs into the neighbouring field",
            bound: "1x1 by every norm, and a sum that saturates: never finer at a larger C, never coarser than the exact stage",
            guard: "the ratio stops at 16383 of 1/1024; where it stops at 1, as in the published packing, the chequers are 2x2 by L1 at C = 0.001 (tried)",
            run: unbounded_ratios,
        },
        Case {
            id: "E7",
            name: "slow dark ramps with E within 10 % of its threshold",
            hazard: "truncation of a packed sum biases toward coarse: 6.5 % of the dark threshold in the published kernel",
            bound: "never coarser than the exact stage",
            guard: "every quantity is rounded to fine. Mag::above's own rounding is one part in 16,384, too little for these ramps (tried: they hold without it); `algebra::bits` sees that",
            run: no_bias_toward_coarse,
        },
        Case {
            id: "E9",
            name: "pictures of 1e3 to 1e5 units of light",
            hazard: "a sum in 32 bits overflows at 65,536 units: bright tiles wrap to dark",
            bound: "rates are those of the same picture at 1, where white is given; full rate where it is not",
            guard: "quantise has doubt above white; without it sums overflow where white is not given (tried)",
            run: bright_pictures,
        },
        Case {
            id: "E10",
            name: "speeds from 0 to ∞, NaN among them, through the vectors of a frame",
            hazard: "pow overflows; a hidden error of Inf · 0; NaN counts as fast",
            bound: "rates never grow finer with speed; NaN stands still; ∞ is as 1e30",
            guard: "motion::speed_index; without its test for NaN a frame of NaN vectors is coarser than a still one (tried)",
            run: speeds,
        },
        Case {
            id: "E11",
            name: "signed speeds on each axis alone: 600 from −1e30 to 1e30, and 0",
            hazard: "pow of a negative base is NaN; pow(0, y)",
            bound: "b_H, b_Q and the lines are even, finite, within 0 to 1 and 0 to k; the rate of −v is that of v",
            guard: "motion::still takes the magnitude; without it b_H of −1e-30 is NaN (tried)",
            run: signed_speeds,
        },
        Case {
            id: "E12",
            name: "VALAR's straight lines at 16 to 1,000 pixels a frame over black and white text",
            hazard: "1 − 0.0596 v is negative from 16.8 on: everything is coarse whatever it shows",
            bound: "the scalers are positive at every speed, and never grow with it",
            guard: "motion::linear stops at 16 pixels; without it b_H(17) is −0.013, and −0.497 at 25 (tried)",
            run: straight_lines,
        },
        Case {
            id: "E13",
            name: "the fits of Eq. 20 and 21 against the integral that they fit",
            hazard: "too optimistic a fit makes fast motion coarser than it may be",
            bound: "within 12 % up to 8 px/frame, 17 % at 16, 22 % at 32: as loose as the paper's own fit",
            guard: "refit::half integrates Eq. 17 to 19; with another box in place of the sinc the fits are off by 86 % (tried)",
            run: fits_against_integrals,
        },
        Case {
            id: "E14",
            name: "k by its definition, zero-phase boxes over a spectrum of 1/f",
            hazard: "k hangs on the convention: 2.126, 2.28 to 2.43, 2.05 or 2.03",
            bound: "2.126 ± 0.01; the paper's 2.13 within 0.3 %",
            guard: "refit::box_response is the sinc; with cos(π (n − 1) f), right for two pixels and wrong for four, k is 3.97 (tried)",
            run: k_by_its_definition,
        },
        Case {
            id: "materials",
            name: "smoothness and Rf0 of NaN, ±∞, −1 and 65504 in a float texture on this driver",
            hazard: "the conversion of NaN to an integer is whatever the driver makes of it: a mirror is taken for chalk",
            bound: "no number is the shiniest: 1x1; others are held between 0 and 1",
            guard: "byte_of in the kernel looks at bits; without that lavapipe makes 0 of NaN, and the mirror's quad is 2x2 (tried)",
            run: materials_that_are_none,
        },
        Case {
            id: "inputs",
            name: "NaN, ±∞, −1, 1e30 and denormals in depth, blur and motion, whole frames and single pixels",
            hazard: "an invalid depth passes the test of disocclusion; an invalid blur hides everything",
            bound: "depth: full rate; blur: hides nothing; motion: full rate under reprojection",
            guard: "params::inverse_distance and past::source; without the first test of bits NaN is a depth (tried)",
            run: other_inputs,
        },
    ],
};

const NONE: [f32; 7] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    -1.0,
    65504.0,
    1e30,
    -1e30,
];

fn colours_that_are_none() -> Result<String, String> {
    let size = [24, 12];
    let mut times = 0;
    for bad in NONE {
        for channel in 0..3 {
            for at in [[0u32, 0], [11, 5], [23, 11], [12, 6]] {
                let mut picture = grey(size, |_, _| 0.5);
                picture[(at[1] * size[0] + at[0]) as usize][channel] = bad;
                let inputs = Inputs::of_colour(size, Colour::Linear(&picture));
                for found in twins(&inputs, &Settings::default())? {
                    for ([x, y], code) in quads(&found.sri) {
                        // a window reaches one pixel beyond its quad
                        let near =
                            |quad: u32, at: u32| (quad * 2..quad * 2 + 4).contains(&(at + 1));
                        let wanted = match near(x, at[0]) && near(y, at[1]) {
                            true => Rate::R1X1,
                            false => Rate::R2X2,
                        };
                        if code != wanted.code() {
                            return Err(format!(
                                "{bad} at {at:?}: quad {x},{y} is {code}, not {wanted}"
                            ));
                        }
                    }
                    times += 1;
                }
            }
            let whole = vec![[bad; 4]; (size[0] * size[1]) as usize];
            all_are(
                &of_picture(size, &whole, &Settings::default()),
                Rate::R1X1,
                "whole frame",
            )?;
        }
    }
    Ok(format!("held {times} times"))
}

fn white_moves_with_the_picture() -> Result<String, String> {
    let size = [32, 16];
    let base = crate::stage::noise(size, 0.4);
    let settings = |white_log2| Settings {
        content: Content {
            white_log2,
            ..Content::default()
        },
        ..Settings::default()
    };
    let wanted = of_picture(size, &base, &settings(0));
    for log2 in -16..=16 {
        let scaled: Vec<[f32; 4]> = base
            .iter()
            .map(|p| p.map(|v| v * 2f32.powi(log2)))
            .collect();
        if of_picture(size, &scaled, &settings(log2)) != wanted {
            return Err(format!("white 2^{log2} gives other rates"));
        }
    }
    for bright in [1.0001, 65504.0, 1e30, f32::MAX] {
        let picture = grey(size, |_, _| bright);
        all_are(
            &of_picture(size, &picture, &settings(0)),
            Rate::R1X1,
            "above white",
        )?;
    }
    Ok("equal at 33 whites".to_owned())
}

fn no_bias_toward_coarse() -> Result<String, String> {
    let size = [16, 16];
    let (mut coarser, mut finer, mut total) = (0, 0, 0);
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        for i in 0..200u16 {
            // a dark ramp around 0.02 whose half step is 0.9 to 1.1 of its threshold
            let share = 0.9 + f32::from(i) / 1000.0;
            let step = 2.0 * 0.15 * (0.02 + 0.05) * share;
            let picture = grey(size, |x, _| 0.02 + step * (x % 2) as f32);
            let settings = Settings {
                content: Content {
                    norm,
                    ..Content::default()
                },
                ..Settings::default()
            };
            let inputs = Inputs::of_colour(size, Colour::Linear(&picture));
            let [fixed, real] = twins(&inputs, &settings)?;
            let (a, b) = (fixed.sri.code(3, 3), real.sri.code(3, 3));
            let (a, b) = (Rate::from_code_or_full(a), Rate::from_code_or_full(b));
            total += 1;
            coarser += usize::from(a != b && b.is_within(a));
            finer += usize::from(a != b && a.is_within(b));
        }
    }
    match coarser {
        0 => Ok(format!("0 coarser, {finer} finer of {total}")),
        _ => Err(format!(
            "{coarser} of {total} are coarser than the exact stage"
        )),
    }
}

fn bright_pictures() -> Result<String, String> {
    let size = [32, 32];
    let base = crate::stage::noise(size, 0.5);
    let plain = of_picture(size, &base, &Settings::default());
    for log2 in [10, 13, 16] {
        let scale = 2f32.powi(log2);
        let picture: Vec<[f32; 4]> = base.iter().map(|p| p.map(|v| v * scale)).collect();
        let settings = Settings {
            content: Content {
                white_log2: log2,
                ..Content::default()
            },
            ..Settings::default()
        };
        if of_picture(size, &picture, &settings) != plain {
            return Err(format!("at {scale} units the rates are others"));
        }
        all_are(
            &of_picture(size, &picture, &Settings::default()),
            Rate::R1X1,
            "white not given",
        )?;
    }
    Ok("equal at 1,024, 8,192 and 65,536 units".to_owned())
}

const SPEEDS: [f32; 15] = [
    0.0,
    1e-40,
    0.25,
    1.0,
    2.8,
    16.7,
    16.9,
    34.0,
    35.0,
    181.0,
    182.0,
    1e4,
    1e30,
    f32::MAX,
    f32::INFINITY,
];

fn of_speed(blur: Blur, speed: f32) -> Sri {
    let size = [16, 16];
    let text = grey(size, |x, y| if (x / 2 + y) % 3 == 0 { 0.9 } else { 0.05 });
    let vectors = vec![[speed; 2]; 256];
    let inputs = Inputs {
        motion: Some(&vectors),
        ..Inputs::of_colour(size, Colour::Linear(&text))
    };
    let settings = Settings {
        motion: Some(Motion {
            blur,
            ..Motion::default()
        }),
        largest: Rate::R4X4,
        ..Settings::default()
    };
    crate::stage::rates(&inputs, &settings)
}

fn speeds() -> Result<String, String> {
    for blur in [
        Blur::Scaled,
        Blur::Linear,
        Blur::Standalone { error: 0.5 },
        Blur::Ladder(Ladder::default()),
    ] {
        let mut last = of_speed(blur, 0.0);
        if of_speed(blur, f32::NAN) != last {
            return Err(format!("{blur:?}: NaN does not stand still"));
        }
        for speed in SPEEDS {
            let now = of_speed(blur, speed);
            if now != of_speed(blur, -speed) {
                return Err(format!("{blur:?}: {speed} and its negative differ"));
            }
            for (([x, y], now), (_, last)) in quads(&now).zip(quads(&last)) {
                let (now, last) = (Rate::from_code_or_full(now), Rate::from_code_or_full(last));
                if !last.is_within(now) {
                    return Err(format!(
                        "{blur:?}: quad {x},{y} is {last}, then {now} at {speed}"
                    ));
                }
            }
            last = now;
        }
    }
    Ok(format!("{} speeds, 4 ways", SPEEDS.len()))
}

fn straight_lines() -> Result<String, String> {
    let mut last = [1.0, 2.13];
    for speed in SPEEDS.map(f64::from).into_iter().chain([17.0, 20.0, 1e300]) {
        let b = motion::linear(speed, 2.13);
        if b.iter().any(|&b| b <= 0.0 || b.is_nan()) {
            return Err(format!("b({speed}) = {b:?}"));
        }
        if speed >= 16.0 && b != motion::linear(16.0, 2.13) || speed < 16.0 && b[0] > last[0] {
            return Err(format!("b({speed}) = {b:?} after {last:?}"));
        }
        last = b;
    }
    let table = motion::table(Some(Blur::Linear), 0.15, 2.13);
    match table
        .iter()
        .all(|entry| entry & 0xffff > 0 && entry >> 16 > 0)
    {
        true => Ok(format!("b_H ≥ {:.4}, b_Q ≥ {:.4}", last[0], last[1])),
        false => Err("an entry of the table is 0".to_owned()),
    }
}

fn fits_against_integrals() -> Result<String, String> {
    let mut most = [0.0f64; 3];
    for (band, speeds) in [&[0.5, 1.0, 2.0, 2.8, 4.0, 8.0][..], &[16.0], &[32.0]]
        .into_iter()
        .enumerate()
    {
        for &speed in speeds {
            let half = refit::half(&refit::natural, speed);
            let off = (motion::half(speed) / half - 1.0).abs();
            most[band] = most[band].max(off);
        }
    }
    let text = most.map(|off| format!("{:.1} %", off * 100.0)).join(", ");
    match most[0] < 0.12 && most[1] < 0.17 && most[2] < 0.22 {
        true => Ok(text),
        false => Err(text),
    }
}

fn other_inputs() -> Result<String, String> {
    let size = [16, 16];
    let picture = grey(size, |x, y| if (x + y) % 2 == 0 { 0.9 } else { 0.1 });
    let plain = grey(size, |_, _| 0.5);
    let (still, half) = (vec![[0.0f32; 2]; 256], vec![0.5f32; 256]);
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        ..Settings::default()
    };
    let inputs = Inputs {
        motion: Some(&still),
        depth: Some(&half),
        previous_depth: Some(&half),
        ..Inputs::of_colour(size, Colour::Linear(&plain))
    };
    let params = Params::new(&settings, &inputs.frame());
    let values = NONE.iter().chain(&[1e-40, -1e-40, 2.0]);
    let mut times = 0;
    for &bad in values {
        let whole = vec![bad; 256];
        // a denormal is a depth: at the far plane of reversed Z
        let is_depth = (0.0..=1.0).contains(&bad);
        if vrcs::analyse::params::inverse_depth(bad, &params).is_some() != is_depth {
            return Err(format!("{bad} as a depth"));
        }
        for depth in [&whole, &half] {
            for before in [&whole, &half] {
                if depth == &half && before == &half || is_depth && depth == before {
                    continue;
                }
                let inputs = Inputs {
                    depth: Some(depth),
                    previous_depth: Some(before),
                    ..inputs
                };
                for found in twins(&inputs, &settings)? {
                    all_are(&found.sri, Rate::R1X1, &format!("depth {bad}"))?;
                    if found.reasons[0] != Reason::Disoccluded as u8 {
                        return Err(format!("depth {bad}: reason {}", found.reasons[0]));
                    }
                    times += 1;
                }
            }
        }
        if bad.abs() > 100.0 || bad.is_nan() {
            let vectors = vec![[bad, 0.0]; 256];
            let inputs = Inputs {
                motion: Some(&vectors),
                ..inputs
            };
            all_are(
                &crate::stage::rates(&inputs, &settings),
                Rate::R1X1,
                "motion",
            )?;
        }
        let blur = vec![bad; 256];
        let inputs = Inputs {
            blur: Some(&blur),
            ..Inputs::of_colour(size, Colour::Linear(&picture))
        };
        let inputs = Inputs {
            motion: Some(&still),
            ..inputs
        };
        let blurred = Settings {
            motion: Some(Motion::default()),
            later_blur: true,
            ..Settings::default()
        };
        // no number hides nothing; a width, however large or its sign, does
        if bad.is_nan() || bad.abs() < 1e-30 {
            all_are(&crate::stage::rates(&inputs, &blurred), Rate::R1X1, "blur")?;
        }
        times += 1;
    }
    if fixed::quantise(1e-40, 0) != Some(0) || fixed::quantise(-0.0, 0) != Some(0) {
        return Err("a denormal or −0 is no black".to_owned());
    }
    Ok(format!("held {times} times"))
}

/// What a driver may take another way, as halves hold them.
const HALVES: [f32; 8] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    65504.0,
    -0.5,
    -0.0,
    6e-8,
    1.0,
];

fn textures_of_floats() -> Result<String, String> {
    let gpu = crate::common::gpu();
    let size = [37, 21];
    let mut times = 0;
    let kernel = Kernel::new(&gpu, ColourForm::Linear, &Settings::default())?;
    for format in [
        wgpu::TextureFormat::Rgba16Float,
        wgpu::TextureFormat::Rgba32Float,
    ] {
        for bad in HALVES {
            let mut picture = grey(size, |x, _| if x < 18 { 0.5 } else { 0.0 });
            for at in [0usize, 5 * 37 + 9, 12 * 37 + 30, 776] {
                picture[at][1] = bad;
            }
            let found = kernel.of_linear(size, &picture, format)?;
            let inputs = Inputs::of_colour(size, Colour::Linear(&picture));
            let [fixed, _] = twins(&inputs, &Settings::default())?;
            if found != fixed.sri {
                return Err(format!(
                    "{bad} in {format:?}: the driver's rates are others"
                ));
            }
            let is_light = (0.0..=1.0).contains(&bad);
            if !is_light && found.code(4, 2) != Rate::R1X1.code()
                || found.code(2, 8) != Rate::R2X2.code()
            {
                return Err(format!("{bad} in {format:?}: {}", found.code(4, 2)));
            }
            times += 1;
        }
    }
    Ok(format!("{times} pictures"))
}

fn negative_light() -> Result<String, String> {
    let size = [16, 16];
    let mut times = 0;
    for form in [
        Form::Window,
        Form::Pairwise { sensitivity: 0.02 },
        Form::Pairwise { sensitivity: 0.0 },
    ] {
        let settings = Settings {
            content: Content {
                form,
                ..Content::default()
            },
            ..Settings::default()
        };
        for base in [
            grey(size, |_, _| 0.5),
            grey(size, |_, _| 0.01),
            crate::stage::noise(size, 0.2),
        ] {
            for negative in [-1e-30f32, -1e-6, -1e-3, -0.5, -7.0, -1e30] {
                let (mut with, mut clamped) = (base.clone(), base.clone());
                with[5 * 16 + 7] = [negative; 4];
                clamped[5 * 16 + 7] = [0.0; 4];
                let clamped = of_picture(size, &clamped, &settings);
                let inputs = Inputs::of_colour(size, Colour::Linear(&with));
                for found in twins(&inputs, &settings)? {
                    for ([x, y], code) in quads(&found.sri) {
                        let (now, then) = (
                            Rate::from_code_or_full(code),
                            Rate::from_code_or_full(clamped.code(x, y)),
                        );
                        if !now.is_within(then) {
                            return Err(format!("{negative}: quad {x},{y} is {now}, not {then}"));
                        }
                    }
                }
                times += 1;
            }
        }
    }
    Ok(format!("{times} pictures"))
}

fn black_surroundings() -> Result<String, String> {
    let size = [16, 16];
    let inside = |x: u32| (6..10).contains(&x);
    let picture = grey(size, |x, y| match inside(x) && inside(y) {
        true => 0.5,
        false => 0.0,
    });
    let black = grey(size, |_, _| 0.0);
    let mut times = 0;
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        for (form, ambient) in [
            (Form::Pairwise { sensitivity: 0.0 }, 0.05),
            (Form::Pairwise { sensitivity: 0.05 }, 0.0),
            (Form::Window, 0.0),
            (Form::Window, 0.05),
        ] {
            let settings = Settings {
                content: Content {
                    norm,
                    form,
                    ambient,
                    ..Content::default()
                },
                ..Settings::default()
            };
            let inputs = Inputs::of_colour(size, Colour::Linear(&picture));
            for found in twins(&inputs, &settings)? {
                // the corner of what is bright: edges on both axes
                if found.sri.code(3, 3) != Rate::R1X1.code() {
                    return Err(format!("{norm:?} {form:?}: {}", found.sri.code(3, 3)));
                }
            }
            let inputs = Inputs::of_colour(size, Colour::Linear(&black));
            let [fixed, real] = twins(&inputs, &settings)?;
            if fixed.sri != real.sri {
                return Err(format!("{norm:?} {form:?}: black is decided otherwise"));
            }
            if matches!(form, Form::Pairwise { .. }) {
                all_are(&fixed.sri, Rate::R2X2, "all black, by pairs")?;
            }
            times += 1;
        }
    }
    Ok(format!("{times} ways"))
}

fn black_frames() -> Result<String, String> {
    let size = [8, 8];
    let black = grey(size, |_, _| 0.0);
    for norm in [Norm::L1, Norm::L2, Norm::LInf, Norm::Root] {
        for (ambient, wanted) in [(0.05, Rate::R2X2), (1e-3, Rate::R2X2), (0.0, Rate::R1X1)] {
            let settings = Settings {
                content: Content {
                    norm,
                    ambient,
                    ..Content::default()
                },
                ..Settings::default()
            };
            let inputs = Inputs::of_colour(size, Colour::Linear(&black));
            for found in twins(&inputs, &settings)? {
                all_are(&found.sri, wanted, &format!("{norm:?}, l = {ambient}"))?;
            }
        }
    }
    Ok("2x2 with l of 0.001 and more, 1x1 without".to_owned())
}

fn unbounded_ratios() -> Result<String, String> {
    let size = [16, 16];
    let chequers = grey(size, |x, y| ((x + y) % 2) as f32);
    let mut most = 0.0f64;
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        for sensitivity in [0.001, 0.01, 0.07] {
            for threshold in [0.15, 1.0, 4.0] {
                let settings = Settings {
                    content: Content {
                        norm,
                        form: Form::Pairwise { sensitivity },
                        threshold,
                        ..Content::default()
                    },
                    ..Settings::default()
                };
                let inputs = Inputs::of_colour(size, Colour::Linear(&chequers));
                let [fixed, real] = twins(&inputs, &settings)?;
                all_are(
                    &fixed.sri,
                    Rate::R1X1,
                    &format!("{norm:?} at C {sensitivity}"),
                )?;
                all_are(&real.sri, Rate::R1X1, "the exact stage")?;
                most = most.max(1.0 / sensitivity);
            }
        }
    }
    Ok(format!("ratios up to {most:.0}, 27 ways"))
}

fn signed_speeds() -> Result<String, String> {
    let mut times = 0;
    for step in 0..=300i32 {
        let speed = 10f64.powf(f64::from(step) / 5.0 - 30.0);
        for v in [speed, -speed, 0.0, -0.0] {
            let all = [
                (motion::half(v), 1.0),
                (motion::quarter(v, 2.13), 2.13),
                (motion::linear(v, 2.13)[0], 1.0),
                (motion::linear(v, 2.13)[1], 2.13),
            ];
            for (index, (b, most)) in all.into_iter().enumerate() {
                let again = [
                    motion::half(-v),
                    motion::quarter(-v, 2.13),
                    motion::linear(-v, 2.13)[0],
                    motion::linear(-v, 2.13)[1],
                ][index];
                if !(0.0..=most).contains(&b) || b != again {
                    return Err(format!("at {v}: {b}, and {again} at its negative"));
                }
            }
        }
        times += 2;
    }
    for speed in [0.3f32, 3.0, 30.0, 1e30] {
        if of_speed(Blur::Scaled, speed) != of_speed(Blur::Scaled, -speed) {
            return Err(format!("{speed} and its negative have other rates"));
        }
    }
    Ok(format!("{times} speeds"))
}

fn k_by_its_definition() -> Result<String, String> {
    let k = refit::k(&refit::natural);
    match (k - 2.126).abs() < 0.01 && (k / 2.13 - 1.0).abs() < 0.003 {
        true => Ok(format!("{k:.3}")),
        false => Err(format!("{k}")),
    }
}

fn materials_that_are_none() -> Result<String, String> {
    let gpu = crate::common::gpu();
    let settings = Settings {
        materials: Some(Materials::default()),
        ..Settings::default()
    };
    let kernel = Kernel::new(&gpu, ColourForm::Codes, &settings)?;
    let size = [16, 8];
    let mut times = 0;
    for (value, wanted) in [
        (f32::NAN, Rate::R1X1),
        (-f32::NAN, Rate::R1X1),
        (f32::INFINITY, Rate::R1X1),
        (65504.0, Rate::R1X1),
        (1.0, Rate::R1X1),
        (f32::NEG_INFINITY, Rate::R2X2),
        (-1.0, Rate::R2X2),
        (1e-40, Rate::R2X2),
        (0.0, Rate::R2X2),
    ] {
        let mut values = vec![[1.0f32, 0.0]; 128];
        values[3 * 16 + 7][1] = value;
        let found = kernel.of_materials(size, &values)?;
        for ([x, y], code) in quads(&found) {
            let wanted = match [x, y] {
                [3, 1] => wanted,
                _ => Rate::R2X2,
            };
            if code != wanted.code() {
                return Err(format!("{value}: quad {x},{y} is {code}, not {wanted}"));
            }
        }
        times += 1;
    }
    Ok(format!("{times} values"))
}
