//! The twins against each other, and the hazards of any doubt. All on the CPU.

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

// fails without the rounding up of magnitudes in `Mag::above`: quads outside the band become coarse
#[test]
fn the_integer_twin_equals_the_oracle_but_in_the_derived_band() {
    let mut rng = rng();
    let size = [46, 30];
    let [mut apart, mut may, mut total] = [0; 3];
    for content in contents() {
        let pictures = [
            natural(size, rng.f64(), &mut rng),
            random(size, 40, &mut rng),
            adversarial(size, rng.u32(..12)),
        ];
        for picture in &pictures {
            for largest in [Rate::R2X2, Rate::R4X2] {
                // ties of the larger error may fall either way, so 4x2 alone
                let settings = Settings {
                    content,
                    largest,
                    ..Settings::default()
                };
                let found = compare(&Inputs::of_colour(size, Colour::Codes(picture)), &settings);
                apart += found[0];
                may += found[1];
                total += found[2];
            }
        }
    }
    println!("{apart} of {total} quads differ, of {may} whose errors lie in the derived band");
    assert!(apart * 100 < total, "{apart} of {total}");
    // a band that is nearly everything would prove nothing
    assert!(may * 8 < total, "{may} of {total}");
}

#[test]
fn paper_eq_16_has_three_branches() {
    // a ramp of light whose half-step is E: x is 1, 2 or 4 wide by E against t (I + l)
    let at = |step: f32| {
        let picture: Vec<[f32; 4]> = (0..64u32)
            .map(|i| [0.3 + step * (i % 8) as f32; 4])
            .collect();
        let settings = Settings {
            largest: Rate::R4X2,
            ..Settings::default()
        };
        let exact = exact::analyse(
            &Inputs::of_colour([8, 8], Colour::Linear(&picture)),
            &settings,
        )
        .expect("inputs");
        exact.output.sri.code(1, 1)
    };
    assert_eq!(at(0.01), Rate::R4X2.code(), "k E < t (I + l)");
    assert_eq!(at(0.08), Rate::R2X2.code());
    assert_eq!(at(-0.04), Rate::R2X2.code());
    let stripes: Vec<[f32; 4]> = (0..64u32).map(|i| [(i % 2) as f32; 4]).collect();
    let found = exact::analyse(
        &Inputs::of_colour([8, 8], Colour::Linear(&stripes)),
        &Settings::default(),
    )
    .expect("inputs");
    assert_eq!(
        found.output.sri,
        Sri::uniform(8, 8, Rate::R1X2),
        "E >= t (I + l)"
    );
}

#[test]
fn e1_e2_e3_any_doubt_is_full_rate_around_it_and_nowhere_else() {
    for bad in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -0.5,
        65504.0,
        1e30,
    ] {
        for at in [[0, 0], [15, 15], [7, 8], [31, 2]] {
            let mut picture = vec![[0.5f32; 4]; 32 * 16];
            picture[at[1] * 32 + at[0]][1] = bad;
            for found in twins(
                &Inputs::of_colour([32, 16], Colour::Linear(&picture)),
                &Settings::default(),
            ) {
                for q in 0..16 * 8 {
                    let (x, y) = (q % 16, q / 16);
                    let near = (x as i64 * 2 - 1..=x as i64 * 2 + 2).contains(&(at[0] as i64))
                        && (y as i64 * 2 - 1..=y as i64 * 2 + 2).contains(&(at[1] as i64));
                    let wanted = if near { Rate::R1X1 } else { Rate::R2X2 };
                    assert_eq!(
                        found.sri.code(x, y),
                        wanted.code(),
                        "{bad} at {at:?}, quad {x},{y}"
                    );
                    let why = if near { Reason::Invalid } else { Reason::None };
                    assert_eq!(found.reasons[(y * 256 + x) as usize], why as u8);
                }
            }
        }
    }
}

fn twins(inputs: &Inputs, settings: &Settings) -> [super::Output; 2] {
    [
        integer::analyse(inputs, settings).expect("inputs that fit"),
        exact::analyse(inputs, settings)
            .expect("inputs that fit")
            .output,
    ]
}

#[test]
fn e4_e5_black_is_coarse_with_ambient_light_and_full_without() {
    let black = vec![[0u8, 0, 0, 255]; 64];
    for (ambient, wanted) in [(0.05, Rate::R2X2), (0.0, Rate::R1X1)] {
        let content = Content {
            ambient,
            ..Content::default()
        };
        for found in twins(
            &Inputs::of_colour([8, 8], Colour::Codes(&black)),
            &Settings {
                content,
                ..Settings::default()
            },
        ) {
            assert_eq!(found.sri, Sri::uniform(8, 8, wanted));
        }
    }
    // pairwise, C = 0: no difference is no error, and 0.5 beside 0 is full
    let content = Content {
        form: Form::Pairwise { sensitivity: 0.0 },
        ..Content::default()
    };
    let settings = Settings {
        content,
        ..Settings::default()
    };
    for found in twins(&Inputs::of_colour([8, 8], Colour::Codes(&black)), &settings) {
        assert_eq!(found.sri, Sri::uniform(8, 8, Rate::R2X2));
    }
    let edge: Vec<[u8; 4]> = (0..64)
        .map(|i| if i % 8 < 4 { [188; 4] } else { [0; 4] })
        .collect();
    for found in twins(&Inputs::of_colour([8, 8], Colour::Codes(&edge)), &settings) {
        assert_eq!(found.sri.code(1, 1), Rate::R1X2.code());
    }
}

#[test]
fn e8_a_constant_gradient_has_the_same_error_at_every_density() {
    let picture: Vec<[f32; 4]> = (0..256u32)
        .map(|i| [0.1 + 0.05 * (i % 16) as f32; 4])
        .collect();
    let rates = [Pairs::All, Pairs::Interleaved, Pairs::SubSampled].map(|pairs| {
        let content = Content {
            pairs,
            ..Content::default()
        };
        let inputs = Inputs::of_colour([16, 16], Colour::Linear(&picture));
        exact::analyse(
            &inputs,
            &Settings {
                content,
                ..Settings::default()
            },
        )
        .expect("inputs")
        .output
        .sri
    });
    assert!(rates[0] == rates[1] && rates[1] == rates[2]);
}

#[test]
fn e20_edges_of_equal_luma_are_seen_in_rgb_and_by_the_largest_channel() {
    // red against a green of the same luma
    let picture: Vec<[f32; 4]> = (0..256u32)
        .map(|i| {
            if i % 2 == 0 {
                [0.587, 0.0, 0.0, 1.0]
            } else {
                [0.0, 0.299, 0.0, 1.0]
            }
        })
        .collect();
    for (difference, wanted) in [
        (Difference::Luma, Rate::R2X2),
        (Difference::LargestChannel, Rate::R1X2),
        (Difference::Rgb, Rate::R1X2),
    ] {
        let content = Content {
            difference,
            ..Content::default()
        };
        for found in twins(
            &Inputs::of_colour([16, 16], Colour::Linear(&picture)),
            &Settings {
                content,
                ..Settings::default()
            },
        ) {
            assert_eq!(found.sri, Sri::uniform(16, 16, wanted), "{difference:?}");
        }
    }
}

#[test]
fn e22_odd_sizes_repeat_their_border() {
    for size in [[1, 1], [2, 3], [7, 1], [17, 9], [3, 33]] {
        let plain = vec![[120u8; 4]; (size[0] * size[1]) as usize];
        for found in twins(
            &Inputs::of_colour(size, Colour::Codes(&plain)),
            &Settings::default(),
        ) {
            assert_eq!(
                found.sri,
                Sri::uniform(size[0], size[1], Rate::R2X2),
                "{size:?}"
            );
        }
    }
}

#[test]
fn e26_transposing_the_picture_transposes_the_rates() {
    let mut rng = rng();
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        let picture = natural([32, 32], 0.7, &mut rng);
        let turned: Vec<[u8; 4]> = (0..1024).map(|i| picture[i % 32 * 32 + i / 32]).collect();
        let settings = Settings {
            content: Content {
                norm,
                ..Content::default()
            },
            ..Settings::default()
        };
        let [a, b] = [&picture, &turned].map(|p| {
            integer::analyse(&Inputs::of_colour([32, 32], Colour::Codes(p)), &settings)
                .expect("inputs")
                .sri
        });
        for q in 0..256 {
            let (x, y) = (q % 16, q / 16);
            let code = a.code(x, y);
            assert_eq!(
                b.code(y, x),
                code >> 2 | (code & 3) << 2,
                "{norm:?} quad {x},{y}"
            );
        }
    }
}

#[test]
fn e33_e34_e36_what_was_not_seen_is_full_rate() {
    let size = [32, 16];
    let picture = vec![[120u8; 4]; 512];
    let depth = vec![0.25f32; 512];
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        ..Settings::default()
    };
    let run = |vector: [f32; 2], before: f32, has_history: bool| {
        let motion = vec![vector; 512];
        let previous = vec![before; 512];
        let inputs = Inputs {
            has_history,
            motion: Some(&motion),
            depth: Some(&depth),
            previous_depth: Some(&previous),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        let [a, b] = twins(&inputs, &settings);
        assert_eq!(a.sri, b.sri);
        a
    };
    assert_eq!(
        run([0.0; 2], 0.25, true).sri,
        Sri::uniform(32, 16, Rate::R2X2)
    );
    assert_eq!(
        run([0.0; 2], 0.25, false).sri,
        Sri::uniform(32, 16, Rate::R1X1),
        "E36"
    );
    for hidden in [0.3, 0.2, f32::NAN, -1.0, 2.0] {
        let found = run([0.0; 2], hidden, true);
        assert_eq!(found.sri, Sri::uniform(32, 16, Rate::R1X1), "E34: {hidden}");
        assert_eq!(found.reasons[0], Reason::Disoccluded as u8);
    }
    assert_eq!(
        run([0.0; 2], 0.26, true).sri,
        Sri::uniform(32, 16, Rate::R2X2)
    );
    for far in [1e30, f32::NAN, f32::INFINITY, -1e9] {
        assert_eq!(
            run([far, 0.0], 0.25, true).sri,
            Sri::uniform(32, 16, Rate::R1X1),
            "E33: {far}"
        );
    }
    // what came from the left border has no past
    let found = run([4.0, 0.0], 0.25, true);
    assert_eq!(found.sri.code(0, 0), 0);
    assert_eq!(found.reasons[0], Reason::OffScreen as u8);
    assert_eq!(found.sri.code(3, 0), Rate::R2X2.code());
}

#[test]
fn e38_the_extra_half_rate_is_never_full_and_never_coarser() {
    for code in Rate::ALL
        .into_iter()
        .filter(|rate| Rate::R2X2.is_within(*rate))
    {
        for second in 0..9u8 {
            for error in [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]] {
                let rate = [code.code() >> 2, code.code() & 3];
                let out = super::decide::half_rate(rate, [second / 3, second % 3], || {
                    error[0] <= error[1]
                });
                let out = Rate::from_code(out[0] << 2 | out[1]).expect("a rate, so no 4x1");
                assert!(
                    out.is_within(code) && out != Rate::R1X1,
                    "{code} {second} {out}"
                );
            }
        }
    }
}

#[test]
fn the_extra_half_rate_leaves_the_attachment_alone_and_heeds_noise_and_materials() {
    let picture: Vec<[f32; 4]> = (0..256u32)
        .map(|i| [0.3 + 0.012 * (i % 16) as f32 + 0.009 * (i / 16) as f32; 4])
        .collect();
    let settings = Settings {
        half_rate: Some(HalfRate {
            tolerance: 0.02,
            ..HalfRate::default()
        }),
        ..Settings::default()
    };
    let run = |noise: Option<&[u8]>, flags: Option<&[u8]>| {
        let inputs = Inputs {
            noise,
            flags,
            ..Inputs::of_colour([16, 16], Colour::Linear(&picture))
        };
        let [a, b] = twins(&inputs, &settings);
        let is_masked = flags.is_some_and(|all| all[0] & flags::FULL != 0);
        let wanted = if is_masked { Rate::R1X1 } else { Rate::R2X2 };
        assert_eq!(
            a.attachment,
            Sri::uniform(16, 16, wanted),
            "no half rate in the attachment"
        );
        assert_eq!(a.sri, b.sri);
        a.sri
    };
    let boosted = run(None, None);
    assert!(
        (0..64).all(|q| [1, 4].contains(&boosted.code(q % 8, q / 8))),
        "{boosted:?}"
    );
    assert_eq!(run(Some(&[255; 256]), None), boosted);
    assert_eq!(
        run(Some(&[0; 256]), None),
        Sri::uniform(16, 16, Rate::R2X2),
        "no noise here"
    );
    assert_eq!(
        run(None, Some(&[flags::NO_HALF_RATE; 256])),
        Sri::uniform(16, 16, Rate::R2X2),
        "foliage"
    );
    assert_eq!(run(None, Some(&[flags::FULL; 256])).code(3, 3), 0, "masked");
}

#[test]
fn e39_transparents_make_solids_coarser_and_never_finer() {
    let mut rng = rng();
    let size = [32, 32];
    let (before, after) = (natural(size, 0.8, &mut rng), natural(size, 0.5, &mut rng));
    let alone = |picture: &[[u8; 4]]| {
        integer::analyse(
            &Inputs::of_colour(size, Colour::Codes(picture)),
            &Settings::default(),
        )
        .expect("inputs")
    };
    let inputs = Inputs {
        after: Some(Colour::Codes(&after)),
        ..Inputs::of_colour(size, Colour::Codes(&before))
    };
    let both = integer::analyse(
        &inputs,
        &Settings {
            transparents: true,
            ..Settings::default()
        },
    )
    .expect("inputs");
    let (solid, seen) = (alone(&before), alone(&after));
    assert_eq!(both.attachment, seen.attachment);
    for q in 0..256 {
        let rate = |sri: &Sri| Rate::from_code_or_full(sri.code(q % 16, q / 16));
        assert_eq!(rate(&both.sri), rate(&solid.sri).join(rate(&seen.sri)));
    }
}

#[test]
fn motion_makes_coarse_and_a_single_still_pixel_keeps_fine() {
    // E32: the least speed of a window counts
    let size = [32, 32];
    let picture = random(size, 90, &mut rng());
    let still = vec![[0.0f32; 2]; 1024];
    let mut fast = vec![[6.0f32, 0.0]; 1024];
    let settings = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let run = |motion: &[[f32; 2]]| {
        let inputs = Inputs {
            motion: Some(motion),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        compare(&inputs, &settings);
        integer::analyse(&inputs, &settings).expect("inputs").sri
    };
    let plain = integer::analyse(
        &Inputs::of_colour(size, Colour::Codes(&picture)),
        &Settings::default(),
    )
    .expect("inputs")
    .sri;
    assert_eq!(run(&still), plain, "neutral");
    let moving = run(&fast);
    let coarser = |sri: &Sri| {
        (0..256)
            .filter(|q| sri.code(q % 16, q / 16) >> 2 > 0)
            .count()
    };
    assert!(coarser(&moving) > coarser(&plain));
    for vector in fast.iter_mut().step_by(2) {
        *vector = [f32::NAN, 0.0];
    }
    assert_eq!(run(&fast), plain, "what is no speed is none");
}

#[test]
fn e15_e16_hysteresis_settles_where_the_bare_loop_swings() {
    // a ramp near its threshold, shaded at the rates that it gets, by copies of each group's first pixel
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        let mut flips = [0, 0, 0];
        for step in 0..24 {
            let slope = 0.5 + f64::from(step) / 16.0;
            for (index, stability) in [
                Stability::None,
                Stability::Hysteresis,
                Stability::Compensate,
            ]
            .into_iter()
            .enumerate()
            {
                flips[index] += closed_loop(norm, stability, slope);
            }
        }
        println!(
            "{norm:?}: flips in frames 32 to 64 without, with hysteresis, compensated: {flips:?}"
        );
        assert_eq!(flips[1], 0, "{norm:?}: {flips:?}");
        if norm == Norm::LInf {
            assert!(
                flips[0] > 0,
                "{norm:?}: the bare loop should swing: {flips:?}"
            );
        }
    }
}

/// Flips of the last 32 of 64 frames of a horizontal ramp at E / τ = `slope` in the middle.
fn closed_loop(norm: Norm, stability: Stability, slope: f64) -> usize {
    let size = [32u32, 4];
    let step = 2.0 * 0.15 * (0.5 + 0.05) * slope / 8.0;
    let truth: Vec<f32> = (0..128u32)
        .map(|i| (0.5 + step * (f64::from(i % 32) - 16.0) / 4.0) as f32)
        .collect();
    let content = Content {
        norm,
        threshold: 0.15 / 32.0,
        ..Content::default()
    };
    let settings = Settings {
        content,
        stability,
        ..Settings::default()
    };
    let mut rates = Sri::uniform(32, 4, Rate::R1X1);
    let mut flips = 0;
    for frame in 0..64 {
        let shaded: Vec<[f32; 4]> = (0..128u32)
            .map(|i| {
                let (x, y) = (i % 32, i / 32);
                let rate = rates.rate(x / 2, y / 2, Rate::R2X2);
                let from = (y & !(rate.height() - 1)) * 32 + (x & !(rate.width() - 1));
                [truth[from as usize]; 4]
            })
            .collect();
        let inputs = Inputs {
            previous_rates: Some(&rates),
            ..Inputs::of_colour(size, Colour::Linear(&shaded))
        };
        let next = integer::analyse(&inputs, &settings).expect("inputs").sri;
        if frame >= 32 {
            flips += (0..32)
                .filter(|q| next.code(q % 16, q / 16) != rates.code(q % 16, q / 16))
                .count();
        }
        rates = next;
    }
    flips
}

#[test]
fn a_neutral_input_changes_no_byte() {
    let mut rng = rng();
    let size = [34, 22];
    let count = (size[0] * size[1]) as usize;
    let picture = natural(size, 0.7, &mut rng);
    let plain = Inputs::of_colour(size, Colour::Codes(&picture));
    let wanted = integer::analyse(&plain, &Settings::default()).expect("inputs");
    let (still, depth) = (vec![[0.0; 2]; count], vec![0.5; count]);
    let (dull, quiet, none) = (vec![[255, 0]; count], vec![0; count], vec![0; count]);
    let full = Sri::uniform(size[0], size[1], Rate::R1X1);
    let inputs = Inputs {
        after: Some(Colour::Codes(&picture)),
        motion: Some(&still),
        depth: Some(&depth),
        previous_depth: Some(&depth),
        previous_rates: Some(&full),
        materials: Some(&dull),
        noise: Some(&quiet),
        flags: Some(&none),
        ..plain
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        materials: Some(Materials::default()),
        stability: Stability::Compensate,
        half_rate: Some(HalfRate::default()),
        transparents: true,
        foveation: Some(Foveation::default()),
        overshoot: vec![[0.85, 1.0], [1.0, 1.0]],
        safe_area: Some(SafeArea {
            width: 0,
            ..SafeArea::default()
        }),
        ..Settings::default()
    };
    let found = integer::analyse(&inputs, &settings).expect("inputs");
    assert_eq!(found.sri, wanted.sri);
    assert_eq!(found.attachment, wanted.attachment);
    // by tiles, and the attachment by quads
    for granularity in Granularity::ALL {
        let of = |settings: &Settings| Settings {
            granularity,
            attachment: Granularity::Quad,
            ..settings.clone()
        };
        let found = integer::analyse(&inputs, &of(&settings)).expect("inputs");
        let wanted = integer::analyse(&plain, &of(&Settings::default())).expect("inputs");
        assert_eq!(found.sri, wanted.sri, "{granularity:?}");
        assert_eq!(found.attachment, wanted.sri, "{granularity:?}");
    }
}

#[test]
fn a_shift_by_one_pixel_changes_few_quads() {
    // a quad's window holds its neighbours, so that pairs are not lost when the picture moves (§3.1)
    let mut rng = rng();
    let wide = natural([130, 64], 0.6, &mut rng);
    let cut = |left: u32| -> Sri {
        let picture: Vec<[u8; 4]> = (0..128 * 64u32)
            .map(|i| wide[(i / 128 * 130 + i % 128 + left) as usize])
            .collect();
        let inputs = Inputs::of_colour([128, 64], Colour::Codes(&picture));
        integer::analyse(&inputs, &Settings::default())
            .expect("inputs")
            .sri
    };
    let (here, shifted) = (cut(0), cut(1));
    let changed = (0..64 * 32)
        .filter(|q| here.code(q % 64, q / 64) != shifted.code(q % 64, q / 64))
        .count();
    println!("{changed} of 2048 quads change under a shift by one pixel");
    assert!(changed * 4 < 2048, "{changed}");
}

#[test]
fn e36_a_change_of_resolution_rescales_history() {
    // the left half plain, the right half striped, at two resolutions
    let picture = |width: u32, height: u32| -> Vec<[u8; 4]> {
        (0..width * height)
            .map(|i| match i % width < width / 2 {
                true => [120; 4],
                false => [(i / width % 2 * 255) as u8; 4],
            })
            .collect()
    };
    let before = picture(32, 16);
    let inputs = Inputs {
        size: [64, 32],
        previous_size: [32, 16],
        ..Inputs::of_colour([32, 16], Colour::Codes(&before))
    };
    let found = integer::analyse(&inputs, &Settings::default()).expect("inputs");
    for y in 0..16 {
        assert_eq!(found.sri.code(3, y), Rate::R2X2.code());
        assert_eq!(found.sri.code(28, y), Rate::R2X1.code(), "row {y}");
    }
}

#[test]
fn inputs_that_do_not_fit_are_refused_by_name() {
    let picture = [[0u8; 4]; 12];
    let inputs = Inputs::of_colour([4, 4], Colour::Codes(&picture));
    let error = integer::analyse(&inputs, &Settings::default()).expect_err("12 of 16 pixels");
    assert_eq!(
        error.to_string(),
        "colour has 12 pixels; its picture has 16"
    );
    let inputs = Inputs::of_colour([4, 3], Colour::Codes(&picture));
    let settings = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let error = integer::analyse(&inputs, &settings).expect_err("no motion");
    assert_eq!(
        error.to_string(),
        "the settings call for motion vectors, which is not given"
    );
}

#[test]
fn a_later_blur_counts_as_motion_of_its_width() {
    let size = [32, 32];
    let picture = random(size, 90, &mut rng());
    let (still, moving) = (vec![[0.0f32; 2]; 1024], vec![[6.0f32; 2]; 1024]);
    let run = |motion: &[[f32; 2]], blur: f32| {
        let blur = vec![blur; 1024];
        let inputs = Inputs {
            motion: Some(motion),
            blur: Some(&blur),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            later_blur: true,
            ..Settings::default()
        };
        integer::analyse(&inputs, &settings).expect("inputs").sri
    };
    assert_eq!(run(&still, 6.0), run(&moving, 0.0));
    assert_ne!(run(&still, 6.0), run(&still, 0.0));
    assert_eq!(
        run(&still, f32::NAN),
        run(&still, 0.0),
        "no number hides nothing"
    );
}

/// The numbers of the resources that a module binds.
fn bound(module: &naga::Module) -> Vec<u32> {
    let mut numbers: Vec<u32> = module
        .global_variables
        .iter()
        .filter_map(|(_, global)| global.binding.as_ref().map(|binding| binding.binding))
        .collect();
    numbers.sort_unstable();
    numbers
}

// what is not declared is not even in the text that is compiled: counted in the composed modules, for each effect alone and for all
#[test]
fn kernels_bind_what_their_plan_says_and_nothing_else() {
    use crate::{
        kernel::{compose, shader},
        plan::{Binding, Plan, Scene},
    };
    let everything = Scene {
        after_transparents: true,
        motion: true,
        depth: true,
        previous_rates: true,
        materials: true,
        noise: true,
        ids: true,
        flags: true,
        blur: true,
        attachment: true,
        sqrt_luma: true,
        reasons: true,
        ..Scene::default()
    };
    let bare = Scene {
        flags: false,
        attachment: false,
        sqrt_luma: false,
        reasons: false,
        ..everything
    };
    let motion = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let own = super::OwnRates {
        ids: Some(super::own::IdRates::default()),
        ..super::OwnRates::default()
    };
    let plans = [
        (bare, Settings::default(), 4),
        (bare, motion.clone(), 5),
        (
            bare,
            Settings {
                later_blur: true,
                ..motion.clone()
            },
            6,
        ),
        (
            bare,
            Settings {
                reprojection: Some(Reprojection::default()),
                ..motion.clone()
            },
            7,
        ),
        (
            bare,
            Settings {
                materials: Some(Materials::default()),
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                half_rate: Some(HalfRate::default()),
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                transparents: true,
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                stability: Stability::Hysteresis,
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                foveation: Some(Foveation::default()),
                safe_area: Some(SafeArea::default()),
                ..Settings::default()
            },
            4,
        ),
        (
            bare,
            Settings {
                granularity: Granularity::Tile16,
                ..Settings::default()
            },
            4,
        ),
        (
            everything,
            Settings {
                attachment: Granularity::Quad,
                ..Settings::default()
            },
            8,
        ),
        (everything, Settings::default(), 8),
        (
            everything,
            Settings {
                own: Some(own),
                half_resolution: Some(super::HalfResolution::Code),
                ..Settings::default()
            },
            8,
        ),
    ];
    for (scene, settings, count) in plans {
        let plan = Plan::new(&scene, &settings).expect("what it asks for is declared");
        let mut wanted: Vec<u32> = plan.bindings.iter().map(|b| b.index()).collect();
        wanted.sort_unstable();
        // the luma's kernel shares the group
        let first = match settings.granularity {
            Granularity::Quad => plan.kernel(),
            _ => shader!("tiles.wgsl"),
        };
        let mut found = bound(&compose(first, &plan.defs()));
        if plan.has_attachment_of_its_own() {
            // and so does that of the attachment's tiles, which has no other output
            let of_tiles = bound(&compose(shader!("tiles.wgsl"), &plan.defs_of_attachment()));
            for output in [Binding::Rates, Binding::Reasons, Binding::PlainRates] {
                assert!(!of_tiles.contains(&output.index()), "{plan}");
            }
            assert!(!found.contains(&Binding::Attachment.index()), "{plan}");
            found.extend(of_tiles);
        }
        if plan.pass("write_luma.wgsl").is_some() {
            found.extend(bound(&compose(shader!("write_luma.wgsl"), &plan.defs())));
        }
        found.sort_unstable();
        found.dedup();
        assert_eq!(found, wanted, "{plan}");
        assert_eq!(wanted.len(), count, "{plan}");
        for (name, source) in [
            ("own.wgsl", shader!("own.wgsl")),
            ("half.wgsl", shader!("half.wgsl")),
        ] {
            if let Some(pass) = plan.pass(name) {
                let defs: Vec<_> = pass.effects.iter().map(|&name| (name, 1)).collect();
                let found = bound(&compose(source, &defs));
                assert_eq!(found.len(), pass.bindings, "{name}: {plan}");
            }
        }
    }
}
