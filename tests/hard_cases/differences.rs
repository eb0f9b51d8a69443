//! Sums and differences: what is added to a picture, the order of a sum, the driver, the density of samples.

use vrcs::{
    Rate,
    analyse::{Colour, Inputs, Settings, settings::*},
    plan::ColourForm,
    sri::Sri,
};

use crate::{
    case::{Case, Family},
    common,
    driver::Kernel,
    stage::{all_are, apart, grey, noise, of_picture, quads, rates, twins},
};

pub const FAMILY: Family = Family {
    name: "differences",
    about: "What is added to a picture, the order of a sum, the width of a subgroup and the driver change nothing that they should not.",
    cases: &[
        Case {
            id: "E8",
            name: "one ramp by all pairs, every other pair, one in four, the quad's own and Sobel's filter",
            hazard: "a normaliser that is right for one density only",
            bound: "the same rate at 40 slopes, but within 2 % of the threshold",
            guard: "integer::count is the number of pairs that are summed; 12 for sub-sampled ramps makes them 2x2 where all others say 1x2 (tried)",
            run: densities,
        },
        Case {
            id: "E17",
            name: "a constant added to a picture, 0 to 15/16 of white, against a fixed threshold",
            hazard: "a variance as E[x²] − E[x]² cancels, and bright pictures lose their detail",
            bound: "bit for bit: sums of differences do not see the constant",
            guard: "joined takes differences first; from a² + b² − 2ab in f32, L1 has other rates at + 0.1875 (tried)",
            run: offsets,
        },
        Case {
            id: "E18",
            name: "the kernel on this driver, by 12 settings, against its integer twin; and whether a kernel asks for subgroups",
            hazard: "float sums depend on their order, and so on subgroup and driver: tiles flip from GPU to GPU",
            bound: "every byte; the hash that stands here is the same on every driver, as this table is; no kernel of the runtime names subgroups, so that their width cannot matter",
            guard: "only integers decide, the same in kernel and twin; with the kernel's luma rounded down a quad differs (tried)",
            run: drivers,
        },
        Case {
            id: "E16",
            name: "±1 % of noise on E at its threshold, 256 frames",
            hazard: "the rate flips from frame to frame",
            bound: "at most one transition with hysteresis, by L2 and L∞; more without",
            guard: "Params::new asks hysteresis::epsilon; with ε = 0 it flips 132 times (tried)",
            run: noisy_thresholds,
        },
        Case {
            id: "E19",
            name: "c² in place of sRGB, over every code",
            hazard: "thresholds shift in the dark: −48 % at 0.04",
            bound: "both rise with the code; at least 90 % of quads have the same rate",
            guard: "params::tables; with 0 for code 200 it falls (tried)",
            run: transfers,
        },
        Case {
            id: "E20",
            name: "edges between colours of one luma: red and green, and blue on black",
            hazard: "luma cannot see them: neon signs and HUDs are blurred",
            bound: "2x2 by luma, as documented; 1x2 by channels and by the largest channel",
            guard: "Integers::difference; with luma in the arm of the largest channel red on green is 2x2 (tried)",
            run: equal_luma,
        },
        Case {
            id: "E21",
            name: "a dark ramp from √luma in eight bits",
            hazard: "linear luma in eight bits has steps of half the dark threshold: random full rate",
            bound: "at least 95 % of quads as from the colour itself; linear eight bits would have fewer",
            guard: "sqrt_code is a root. Stored linearly the ramp alone did not tell (tried): it is coarse either way. So every luma is also sent to and fro",
            run: dark_ramps,
        },
        Case {
            id: "E26",
            name: "a picture and its transpose, by every norm and every set of pairs but the chequerboard",
            hazard: "x and y are swapped somewhere: vertical stripes become coarse across",
            bound: "transposed rates, bit for bit",
            guard: "pairs() and sobel() by axis; with the axes of pairs() swapped quad 7,0 differs, and E8, E18, E36 and the shift fail as well (tried)",
            run: transposes,
        },
        Case {
            id: "shift",
            name: "a picture moved by one pixel",
            hazard: "pairs that straddle a quad's border are lost, and rates flicker as the picture moves",
            bound: "fewer than a quarter of the quads change, and fewer than by the quad's own pairs",
            guard: "the window is the quad and a border of one pixel; with the quad's own pairs in place of all, 947 quads change (tried)",
            run: shifts,
        },
    ],
};

const PAIRS: [Pairs; 5] = [
    Pairs::All,
    Pairs::Interleaved,
    Pairs::SubSampled,
    Pairs::Quad,
    Pairs::Sobel,
];

fn with(content: Content) -> Settings {
    Settings {
        content,
        ..Settings::default()
    }
}

fn densities() -> Result<String, String> {
    let size = [16, 16];
    let mut near = 0;
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        for i in 0..40u16 {
            let share = 0.5 + f32::from(i) / 40.0;
            let step = 2.0 * 0.02 * share;
            let ramp = grey(size, |x, _| 0.1 + step * x as f32);
            let found = PAIRS.map(|pairs| {
                let content = Content {
                    norm,
                    pairs,
                    form: Form::Absolute,
                    threshold: 0.02,
                    ..Content::default()
                };
                of_picture(size, &ramp, &with(content)).code(3, 3)
            });
            if found.iter().any(|&code| code != found[0]) {
                if (share - 1.0).abs() > 0.02 {
                    return Err(format!("{norm:?} at {share} of the threshold: {found:?}"));
                }
                near += 1;
            }
        }
    }
    Ok(format!("the same, {near} of 120 on the threshold"))
}

fn offsets() -> Result<String, String> {
    let size = [32, 32];
    // exact in units of white / 16384, so that the constant moves no rounding
    let small: Vec<[f32; 4]> = noise(size, 1.0)
        .iter()
        .map(|p| [(p[0] * 800.0).round() / 16_384.0; 4])
        .collect();
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        let content = Content {
            norm,
            form: Form::Absolute,
            threshold: 0.008,
            ..Content::default()
        };
        let wanted = of_picture(size, &small, &with(content));
        for sixteenths in 1..=15u8 {
            let constant = f32::from(sixteenths) / 16.0;
            let moved: Vec<[f32; 4]> = small.iter().map(|p| p.map(|v| v + constant)).collect();
            if of_picture(size, &moved, &with(content)) != wanted {
                return Err(format!("{norm:?}: + {constant}"));
            }
        }
        let codes: Vec<u8> = quads(&wanted).map(|quad| quad.1).collect();
        if codes.iter().all(|code| code == &codes[0]) {
            return Err("the picture is the same everywhere, and cannot tell".to_owned());
        }
    }
    Ok("equal at 15 constants, 3 norms".to_owned())
}

fn drivers() -> Result<String, String> {
    for folder in ["shaders", "shaders/analyse", "shaders/build"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(&path).map_err(|error| error.to_string())? {
            let path = entry.map_err(|error| error.to_string())?.path();
            let is_kernel = path.extension().is_some_and(|ending| ending == "wgsl");
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            if is_kernel && (text.is_empty() || text.contains("subgroup")) {
                return Err(format!("{} names subgroups, or is empty", path.display()));
            }
        }
    }
    let gpu = common::gpu();
    let size = [131, 67];
    let mut rng = fastrand::Rng::with_seed(11);
    let codes: Vec<[u8; 4]> = (0..size[0] * size[1])
        .map(|i| {
            let ramp = (i % size[0] + i / size[0] * 2) as u8;
            std::array::from_fn(|_| ramp.wrapping_add(rng.u8(..24)))
        })
        .collect();
    // FNV-1a
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for norm in [Norm::L1, Norm::L2, Norm::LInf, Norm::Root] {
        for (form, threshold) in [
            (Form::Window, if norm == Norm::Root { 0.5 } else { 0.1 }),
            (Form::Pairwise { sensitivity: 0.05 }, 0.2),
            (Form::Absolute, 0.02),
        ] {
            let settings = Settings {
                content: Content {
                    norm,
                    form,
                    threshold,
                    difference: Difference::Rgb,
                    ..Content::default()
                },
                largest: Rate::R4X4,
                smoothing: Smoothing::Conservative,
                ..Settings::default()
            };
            let kernel = Kernel::new(&gpu, ColourForm::Codes, &settings)?;
            let found = kernel.of_codes(size, &codes)?;
            let wanted = rates(&Inputs::of_colour(size, Colour::Codes(&codes)), &settings);
            if found != wanted {
                return Err(format!(
                    "{} quads differ: {settings:?}",
                    apart(&found, &wanted)
                ));
            }
            for (_, code) in quads(&found) {
                hash = (hash ^ u64::from(code)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    Ok(format!("equal; {:016x}", hash))
}

fn noisy_thresholds() -> Result<String, String> {
    let size = [8, 8];
    let mut text = Vec::new();
    for norm in [Norm::L2, Norm::LInf] {
        let mut transitions = [0; 2];
        for (index, stability) in [Stability::None, Stability::Hysteresis]
            .into_iter()
            .enumerate()
        {
            let settings = Settings {
                stability,
                ..with(Content {
                    norm,
                    ..Content::default()
                })
            };
            let mut rng = fastrand::Rng::with_seed(3);
            let mut before = Sri::uniform(size[0], size[1], Rate::R1X1);
            let mut last = None;
            for _ in 0..256 {
                // stripes whose E is t (I + l), within 1 %
                let d = 2.0 * 0.15 * (0.5 + 0.05) * (0.99 + 0.02 * rng.f32());
                let picture = grey(size, |x, _| 0.5 + d * ((x % 2) as f32 - 0.5));
                let inputs = Inputs {
                    previous_rates: Some(&before),
                    ..Inputs::of_colour(size, Colour::Linear(&picture))
                };
                before = rates(&inputs, &settings);
                let now = before.code(1, 1);
                transitions[index] += usize::from(last.is_some_and(|last| last != now));
                last = Some(now);
            }
        }
        if transitions[1] > 1 || transitions[0] < 8 {
            return Err(format!(
                "{norm:?}: {transitions:?} without and with hysteresis"
            ));
        }
        text.push(format!("{norm:?} {} → {}", transitions[0], transitions[1]));
    }
    Ok(text.join(", "))
}

fn transfers() -> Result<String, String> {
    let settings = |transfer| {
        with(Content {
            transfer,
            ..Content::default()
        })
    };
    for transfer in [Transfer::Srgb, Transfer::Square] {
        let table = vrcs::analyse::params::tables(&settings(transfer), false, 1.0);
        if table[..256].windows(2).any(|pair| pair[1] < pair[0]) {
            return Err(format!("{transfer:?} falls"));
        }
    }
    let size = [256, 64];
    let mut rng = fastrand::Rng::with_seed(5);
    let codes: Vec<[u8; 4]> = (0..size[0] * size[1])
        .map(|i| [(i % size[0]) as u8; 4].map(|code: u8| code.saturating_add(rng.u8(..24))))
        .collect();
    let inputs = Inputs::of_colour(size, Colour::Codes(&codes));
    let [a, b] = [Transfer::Srgb, Transfer::Square].map(|t| rates(&inputs, &settings(t)));
    let same = 100.0 - 100.0 * apart(&a, &b) as f64 / 4096.0;
    match same >= 90.0 {
        true => Ok(format!("{same:.1} % the same")),
        false => Err(format!("{same:.1} % the same")),
    }
}

fn equal_luma() -> Result<String, String> {
    let size = [16, 16];
    let pictures: [Vec<[f32; 4]>; 2] = [
        // red and a green of its luma
        [[0.587, 0.0, 0.0, 1.0], [0.0, 0.299, 0.0, 1.0]],
        // a blue that luma takes for near black
        [[0.0, 0.0, 0.1, 1.0], [0.0, 0.0, 0.0, 1.0]],
    ]
    .map(|pair| (0..256).map(|i| pair[i % 2]).collect());
    for (picture, by_rgb) in pictures.iter().zip([Rate::R1X2, Rate::R2X2]) {
        for (difference, wanted) in [
            (Difference::Luma, Rate::R2X2),
            (Difference::LargestChannel, Rate::R1X2),
            (Difference::Rgb, by_rgb),
        ] {
            let settings = with(Content {
                difference,
                ..Content::default()
            });
            let inputs = Inputs::of_colour(size, Colour::Linear(picture));
            for found in twins(&inputs, &settings)? {
                all_are(&found.sri, wanted, &format!("{difference:?}"))?;
            }
        }
    }
    Ok("as documented; weighted channels see red on green, not a dark blue on black".to_owned())
}

fn dark_ramps() -> Result<String, String> {
    use vrcs::analyse::fixed;
    for luma in 0..=fixed::ONE {
        let back = fixed::sqrt_luma(fixed::sqrt_code(luma) as u8);
        // half a code of the root, and the rounding of both
        let step = (f64::from(luma) * f64::from(fixed::ONE)).sqrt() / 255.0 + 1.0;
        if f64::from(back.abs_diff(luma)) > step {
            return Err(format!("{luma} comes back as {back}"));
        }
    }
    let size = [128, 32];
    // 0 to 0.04 of white: ten steps of a linear byte
    let ramp = grey(size, |x, y| (x as f32 + y as f32 * 0.3) / 137.0 * 0.04);
    let settings = with(Content {
        threshold: 0.02,
        ..Content::default()
    });
    let root = root_of(&ramp);
    let wanted = of_picture(size, &ramp, &settings);
    let from_root = rates(&Inputs::of_colour(size, Colour::SqrtLuma(&root)), &settings);
    let linear: Vec<[f32; 4]> = ramp
        .iter()
        .map(|p| p.map(|v| (v * 255.0).round() / 255.0))
        .collect();
    let from_linear = of_picture(size, &linear, &settings);
    let share = |found: &Sri| 100.0 - 100.0 * apart(found, &wanted) as f64 / 1024.0;
    let text = format!(
        "{:.1} % by √luma, {:.1} % by linear bytes",
        share(&from_root),
        share(&from_linear)
    );
    match share(&from_root) >= 95.0 && share(&from_linear) < share(&from_root) {
        true => Ok(text),
        false => Err(text),
    }
}

/// √luma of a grey picture, as the analysis writes it.
fn root_of(picture: &[[f32; 4]]) -> Vec<u8> {
    use vrcs::analyse::fixed;
    picture
        .iter()
        .map(|p| fixed::quantise(p[0], 0).map_or(255, |luma| fixed::sqrt_code(luma) as u8))
        .collect()
}

fn transposes() -> Result<String, String> {
    let size = [32, 32];
    let picture = noise(size, 0.5);
    let turned: Vec<[f32; 4]> = (0..1024).map(|i| picture[i % 32 * 32 + i / 32]).collect();
    let mut times = 0;
    for norm in [Norm::L1, Norm::L2, Norm::LInf, Norm::Root] {
        // GDC's chequerboard is none of its own transposes: a step across starts where one down does not
        for pairs in PAIRS
            .into_iter()
            .filter(|&pairs| pairs != Pairs::Interleaved)
        {
            let settings = with(Content {
                norm,
                pairs,
                threshold: if norm == Norm::Root { 0.5 } else { 0.15 },
                ..Content::default()
            });
            let a = of_picture(size, &picture, &settings);
            let b = of_picture(size, &turned, &settings);
            for ([x, y], code) in quads(&a) {
                let rate = Rate::from_code_or_full(code);
                if b.code(y, x) != rate.transposed().code() {
                    return Err(format!("{norm:?} {pairs:?}: quad {x},{y}"));
                }
            }
            times += 1;
        }
    }
    let stripes = grey(size, |x, _| (x % 2) as f32);
    all_are(
        &of_picture(size, &stripes, &Settings::default()),
        Rate::R1X2,
        "vertical stripes",
    )?;
    Ok(format!("equal by {times} settings"))
}

fn shifts() -> Result<String, String> {
    let size = [130, 64];
    // smooth noise: sums of waves
    let of = |x: f32, y: f32| {
        let waves = [
            (0.31, 0.12, 0.08),
            (0.11, -0.4, 0.07),
            (0.73, 0.5, 0.05),
            (1.4, -0.9, 0.04),
        ];
        0.4 + waves
            .iter()
            .map(|&(a, b, c)| c * (a * x + b * y).sin())
            .sum::<f32>()
    };
    let changed = |pairs| {
        let settings = with(Content {
            pairs,
            threshold: 0.06,
            ..Content::default()
        });
        let [a, b] = [0.0, 1.0].map(|shift| {
            let picture = grey(size, |x, y| of(x as f32 + shift, y as f32));
            of_picture(size, &picture, &settings)
        });
        apart(&a, &b)
    };
    let (all, quad) = (changed(Pairs::All), changed(Pairs::Quad));
    let text = format!("{all} of 2080 quads; by the quad's own pairs {quad}");
    match all * 4 < 2080 && all < quad {
        true => Ok(text),
        false => Err(text),
    }
}
