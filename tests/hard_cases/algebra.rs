//! Rates as numbers: what goes wrong where codes are taken for integers, and what every output of the analysis keeps.

use proptest::{prelude::*, test_runner::TestCaseResult};
use vrcs::{
    Rate,
    analyse::{
        Colour, HalfResolution, Inputs, OwnRates, Settings, decide, fixed, half, inputs::flags,
        integer, motion, own::*, params::inverse_distance, settings::*,
    },
    rate::{Combiner, LargestAxis},
    sri::Sri,
};

use crate::{
    case::{Case, Family},
    property,
    stage::quads,
};

pub const FAMILY: Family = Family {
    name: "algebra",
    about: "Rates as a lattice and not as integers; and, over random values, what every output keeps.",
    cases: &[
        Case {
            id: "E24",
            name: "the meet and the join of all 49 pairs of rates, and of all 343 triples",
            hazard: "an integer minimum or AND of codes: min(2x4, 4x2) is 2x4",
            bound: "idempotent, commutative, associative, absorbing, per axis; the integer minimum and AND are wrong for some pair",
            guard: "Rate::meet goes by axis; with self.0.min(other.0) 1x2 meets 2x1 at 1x2, and E38 and E40 fail as well (tried)",
            run: lattice,
        },
        Case {
            id: "E25",
            name: "random pictures with values that are none, under random settings and own rates",
            hazard: "4x1 and 1x4 come out of axes that are decided one by one; NaN makes a quad coarse",
            bound: "only the seven codes, nothing above the largest, 1x1 wherever a window holds doubt or a flag asks for it, in rates, attachment and half resolution",
            guard: "fixed::quantise and the places where axes become codes: decide::legal, agree and code",
            run: any_picture,
        },
        Case {
            id: "E38",
            name: "the extra half rate's rule over every rate, second look and order of errors",
            hazard: "the second look makes a quad 1x1, or coarser than the first",
            bound: "never 1x1, never coarser on either axis, and one of the seven codes",
            guard: "the arm [0, 0] of decide::half_rate; without it a second look of 1x1 is taken (tried: 2x2, then 0, gives 1x1)",
            run: second_looks,
        },
        Case {
            id: "E39",
            name: "random pictures before and after transparents",
            hazard: "transparents raise quality, or the coarser of both is taken for the attachment",
            bound: "the rate is the join of both pictures' own rates; the attachment is that of the second",
            guard: "max in Stage::decide; with min solids become finer under glass (tried: the attachment is no longer within the rate)",
            run: transparents,
        },
        Case {
            id: "E40",
            name: "every combiner over every pair of rates, strict and loose products, both largest axes",
            hazard: "a loose product gives 2 for 1·1; KEEP and REPLACE are swapped; 4x1 results",
            bound: "Vulkan's and D3D12's definitions by sizes, resolved to a rate; loose differs from strict only where an axis has 1 and 1",
            guard: "Combiner::combine and Rate::meet; with an integer minimum Min of 1x2 and 2x1 is 1x2 (tried)",
            run: combiners,
        },
        Case {
            id: "bits",
            name: "every pattern of bits as a luma, a depth and a speed",
            hazard: "a comparison that a NaN passes; a rounding that is not monotone",
            bound: "luma within half a unit or doubt; depth within one unit of 1/2^30, or none; speeds round to slow, NaN to rest",
            guard: "fixed::quantise, params::inverse_distance and motion::speed_index look at bits; `!(value > white)` in quantise gives NaN a luma of 0, and without the test of bits NaN is a depth (tried both)",
            run: patterns_of_bits,
        },
    ],
};

fn lattice() -> Result<String, String> {
    let (mut by_minimum, mut by_and) = (0, 0);
    for a in Rate::ALL {
        for b in Rate::ALL {
            let (meet, join) = (a.meet(b), a.join(b));
            let finest = [a.width().min(b.width()), a.height().min(b.height())];
            let coarsest = [a.width().max(b.width()), a.height().max(b.height())];
            if [meet.width(), meet.height()] != finest || [join.width(), join.height()] != coarsest
            {
                return Err(format!("{a} and {b}: {meet}, {join}"));
            }
            if !Rate::ALL.contains(&meet) || !Rate::ALL.contains(&join) {
                return Err(format!("{a} and {b} lead to no rate: {meet}, {join}"));
            }
            if meet != b.meet(a) || join != b.join(a) || a.meet(join) != a || a.join(meet) != a {
                return Err(format!("{a} and {b}: not commutative or not absorbing"));
            }
            by_minimum += u32::from(a.code().min(b.code()) != meet.code());
            by_and += u32::from(a.code() & b.code() != meet.code());
            for c in Rate::ALL {
                if a.meet(b).meet(c) != a.meet(b.meet(c)) || a.join(b).join(c) != a.join(b.join(c))
                {
                    return Err(format!("{a}, {b}, {c}: not associative"));
                }
            }
        }
    }
    match by_minimum > 0 && by_and > 0 {
        true => Ok(format!(
            "all hold; the integer minimum is wrong for {by_minimum} of 49 pairs, AND for {by_and}"
        )),
        false => Err("integers would do, so nothing was told".to_owned()),
    }
}

/// A value of a picture: mostly light, sometimes none.
fn value() -> impl Strategy<Value = f32> {
    prop_oneof![
        60 => 0.0f32..1.0,
        3 => Just(0.0f32),
        1 => any::<u32>().prop_map(f32::from_bits),
    ]
}

const SIZE: [u32; 2] = [13, 9];
const PIXELS: usize = 117;

fn picture() -> impl Strategy<Value = Vec<[f32; 4]>> {
    prop::collection::vec([value(), value(), value(), value()], PIXELS)
}

fn rate() -> impl Strategy<Value = Rate> {
    prop::sample::select(Rate::ALL.to_vec())
}

fn combiner() -> impl Strategy<Value = Combiner> {
    prop::sample::select(Combiner::ALL.to_vec())
}

fn largest() -> impl Strategy<Value = Rate> {
    prop::sample::select(vec![Rate::R2X2, Rate::R2X4, Rate::R4X2, Rate::R4X4])
}

fn norm() -> impl Strategy<Value = Norm> {
    prop::sample::select(vec![Norm::L1, Norm::L2, Norm::LInf, Norm::Root])
}

fn check_codes(sri: &Sri, largest: Rate) -> TestCaseResult {
    for (_, code) in quads(sri) {
        let rate = Rate::from_code(code);
        prop_assert!(rate.is_some(), "code {}", code);
        prop_assert!(rate.is_some_and(|rate| rate.is_within(largest)), "{}", code);
    }
    Ok(())
}

fn any_picture() -> Result<String, String> {
    let smoothing = prop::sample::select(vec![
        Smoothing::None,
        Smoothing::Limit,
        Smoothing::Conservative,
    ]);
    let flagged = prop::collection::vec(prop_oneof![9 => Just(0u8), 1 => 0u8..16], PIXELS);
    let settings = (largest(), norm(), smoothing, 0.001f64..2.0, any::<bool>());
    let own = (rate(), combiner(), rate(), combiner());
    property::hold(
        192,
        &(picture(), flagged, settings, own),
        |(picture, flagged, (largest, norm, smoothing, threshold, half_rate), own)| {
            let settings = Settings {
                content: Content {
                    norm,
                    threshold,
                    ..Content::default()
                },
                half_rate: half_rate.then(HalfRate::default),
                smoothing,
                largest,
                own: Some(OwnRates {
                    ids: Some(IdRates {
                        rates: vec![None, Some(own.0)],
                        combiner: own.1,
                    }),
                    particles: Some(Particles {
                        rate: own.2,
                        combiner: own.3,
                    }),
                    distance: None,
                }),
                half_resolution: Some(HalfResolution::Code),
                ..Settings::default()
            };
            let ids: Vec<u8> = (0..PIXELS).map(|i| (i % 3) as u8).collect();
            let inputs = Inputs {
                ids: Some(&ids),
                flags: Some(&flagged),
                ..Inputs::of_colour(SIZE, Colour::Linear(&picture))
            };
            let found = integer::analyse(&inputs, &settings);
            let found = found.map_err(|error| TestCaseError::fail(error.to_string()))?;
            check_codes(&found.sri, largest)?;
            check_codes(&found.attachment, largest)?;
            let half = found.half.as_ref();
            let half = half.ok_or_else(|| TestCaseError::fail("no half resolution"))?;
            check_codes(half, largest)?;
            prop_assert_eq!(half, &half::half(&found.sri, SIZE, HalfResolution::Code));
            for ([x, y], _) in quads(&found.sri) {
                let pixel = |px: u32, py: u32| {
                    (py.min(SIZE[1] - 1) * SIZE[0] + px.min(SIZE[0] - 1)) as usize
                };
                let own = (0..4).map(|i| pixel(x * 2 + i % 2, y * 2 + i / 2));
                let is_flagged = own.clone().any(|at| flagged[at] & flags::FULL != 0);
                let in_doubt = (0..16).any(|i| {
                    let at = pixel(
                        (x * 2 + i % 4).saturating_sub(1),
                        (y * 2 + i / 4).saturating_sub(1),
                    );
                    // by its own words: no number, above white, or negative beyond rounding
                    let is_none =
                        |v: &f32| !(-0.5f32.powi(15)..=1.0).contains(v) || *v == -0.5f32.powi(15);
                    picture[at][..3].iter().any(is_none)
                });
                if is_flagged || in_doubt {
                    prop_assert_eq!(found.attachment.code(x, y), 0, "{},{}", x, y);
                }
                if is_flagged {
                    prop_assert_eq!(found.sri.code(x, y), 0, "{},{}", x, y);
                }
            }
            Ok(())
        },
    )
}

fn second_looks() -> Result<String, String> {
    let mut cases = 0;
    let coarse = [Rate::R2X2, Rate::R2X4, Rate::R4X2, Rate::R4X4];
    for first in coarse {
        for second in 0..9u8 {
            for error in [[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]] {
                let logs = [first.code() >> 2, first.code() & 3];
                let out =
                    decide::half_rate(logs, [second % 3, second / 3], || error[0] <= error[1]);
                let rate = Rate::from_code(out[0] << 2 | out[1]);
                let holds = rate.is_some_and(|rate| rate != Rate::R1X1 && rate.is_within(first));
                if !holds {
                    return Err(format!("{first}, then {second}: {out:?}"));
                }
                // the smaller error's axis stays coarse where neither would
                if second == 0 && (out[0] > 0) != (error[0] <= error[1]) {
                    return Err(format!("{first}, errors {error:?}: {out:?}"));
                }
                cases += 1;
            }
        }
    }
    Ok(format!("{cases} of {cases}"))
}

fn transparents() -> Result<String, String> {
    property::hold(
        96,
        &(picture(), picture(), norm(), 0.05f64..1.0),
        |(before, after, norm, threshold)| {
            let settings = Settings {
                content: Content {
                    norm,
                    threshold,
                    ..Content::default()
                },
                // of each quad, as the rates are; by default it is of tiles of its own, whose estimate is another
                attachment: Granularity::Quad,
                ..Settings::default()
            };
            let run = |colour: &[[f32; 4]], after: Option<&[[f32; 4]]>| {
                let inputs = Inputs {
                    after: after.map(Colour::Linear),
                    ..Inputs::of_colour(SIZE, Colour::Linear(colour))
                };
                let settings = Settings {
                    transparents: after.is_some(),
                    ..settings.clone()
                };
                integer::analyse(&inputs, &settings)
                    .map_err(|error| TestCaseError::fail(error.to_string()))
            };
            let (first, second) = (run(&before, None)?, run(&after, None)?);
            let both = run(&before, Some(&after))?;
            for ([x, y], code) in quads(&both.sri) {
                let of = |sri: &Sri| Rate::from_code_or_full(sri.code(x, y));
                let (first, second) = (of(&first.sri), of(&second.sri));
                // doubt in either picture is doubt in both
                let attachment = of(&both.attachment);
                prop_assert!(attachment == second || attachment == Rate::R1X1);
                let rate = Rate::from_code_or_full(code);
                prop_assert!(rate == first.join(second) || rate == Rate::R1X1);
                prop_assert!(attachment.is_within(rate));
            }
            Ok(())
        },
    )
}

fn combiners() -> Result<String, String> {
    let size = |side: u32, most: u32| side.min(most);
    let mut cases = 0;
    for largest in [LargestAxis::Two, LargestAxis::Four] {
        let most = largest.rate().width();
        for combiner in Combiner::ALL {
            for a in Rate::ALL {
                for b in Rate::ALL {
                    let axis = |a: u32, b: u32| {
                        let (a, b) = (size(a, most), size(b, most));
                        match combiner {
                            Combiner::Passthrough => a,
                            Combiner::Override => b,
                            Combiner::Min => a.min(b),
                            Combiner::Max => a.max(b),
                            Combiner::Sum => a * b,
                            // sums of powers of two, rounded down to one
                            Combiner::LooseSum => 1 << (a + b).ilog2(),
                        }
                    };
                    let sides = [axis(a.width(), b.width()), axis(a.height(), b.height())];
                    let wanted = Rate::from_log2(sides.map(u32::ilog2)).meet(largest.rate());
                    let got = combiner.combine(a, b, largest);
                    if got != wanted {
                        return Err(format!("{combiner:?} of {a} and {b}: {got}, not {wanted}"));
                    }
                    cases += 1;
                }
            }
        }
    }
    Ok(format!("{cases} of {cases}"))
}

fn patterns_of_bits() -> Result<String, String> {
    property::hold(20_000, &any::<u32>(), |bits| {
        // a magnitude of 15 bits lies on its own side of what it stands for, and strictly so where bits were lost
        let (up, down) = (fixed::Mag::above(bits), fixed::Mag::below(bits));
        prop_assert!(!up.is_less(down), "{}", bits);
        let lost = bits.checked_ilog2().unwrap_or(0).saturating_sub(14);
        prop_assert_eq!(down.is_less(up), bits & ((1 << lost) - 1) != 0, "{}", bits);
        let v = f32::from_bits(bits);
        match fixed::quantise(v, 0) {
            Some(units) => {
                prop_assert!((-0.5f32.powi(15)..=1.0).contains(&v), "{} is {}", v, units);
                let exact = f64::from(v).max(0.0) * f64::from(fixed::ONE);
                prop_assert!((f64::from(units) - exact).abs() <= 0.5, "{}: {}", v, units);
            }
            None => prop_assert!(!(0.0..=1.0).contains(&v), "{}", v),
        }
        for is_reversed in [true, false] {
            match inverse_distance(v, 0, is_reversed) {
                Some(units) => {
                    let toward = if is_reversed { v } else { 1.0 - v };
                    let exact = f64::from(toward) * 1_073_741_824.0;
                    prop_assert!((f64::from(units) - exact).abs() <= 64.0, "{}: {}", v, units);
                    prop_assert!((0.0..=1.0).contains(&v));
                }
                None => prop_assert!(!(0.0..=1.0).contains(&v), "{}", v),
            }
        }
        let index = motion::speed_index(v, 16.0);
        match v.is_nan() {
            true => prop_assert_eq!(index, 0),
            false => {
                let exact = f64::from(v.abs()) * 16.0;
                let wanted = exact.min(f64::from(motion::SPEEDS - 1)).floor();
                prop_assert_eq!(f64::from(index), wanted, "{}", v);
            }
        }
        Ok(())
    })
}
