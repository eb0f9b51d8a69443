//! The loop: the analysis is fed pictures that its own rates made coarse.

use vrcs::{
    Rate,
    analyse::{Colour, Inputs, Settings, settings::*},
    sri::Sri,
};

use crate::{
    case::{Case, Family},
    stage::{Way, apart, quads, rates, shade, shade_as_built},
};

pub const FAMILY: Family = Family {
    name: "closed_loop",
    about: "64 frames of the analysis on its own output. Flips are changes of a quad's rate from one frame to the next, per quad and frame, in the last 32; E/τ runs from 0.5 to 2.",
    cases: &[
        Case {
            id: "E15",
            name: "ramps, by every norm and both ways of stability",
            hazard: "copies change E by the norm's gain, and the rate swings; L∞, the official sample's, is worst",
            bound: "0 flips with the derived ε and with the gain divided out; more than 0 for L∞ with neither",
            guard: "hysteresis::epsilon; with ε = 0 L1 alone flips 4608 times (tried), and with the endless ramp's gain, √2 by L2 and 1 by L1, both swing: that is how the window's was found",
            run: ramps,
        },
        Case {
            id: "E15-pictures",
            name: "noise, an edge, text and foliage at rest, with the derived ε",
            hazard: "an ε that is right for ramps lets other pictures swing",
            bound: "a fixed point is reached and kept: 0 flips in the last 32 frames",
            guard: "as above; with ε = 0 noise never settles (tried); the bare loop is shown beside it",
            run: pictures,
        },
        Case {
            id: "E15-rotation",
            name: "the same with a primary that rotates from frame to frame",
            hazard: "each frame shows other pixels of a coarse quad, and the estimate moves with them",
            bound: "0 flips in the last 32 frames",
            guard: "as above; the bare loops beside it flip",
            run: rotation,
        },
        Case {
            id: "E15-deblock",
            name: "ramps, noise, an edge, text and foliage through coordinates, copies and deblocker, primaries at rest and rotating",
            hazard: "the deblocker's means are another picture than copies: an ε for copies need not do for them",
            bound: "0 flips in the last 32 frames",
            guard: "as above; with ε = 0 the loops with it flip as often as the bare ones beside them (tried)",
            run: deblocked,
        },
        Case {
            id: "E37",
            name: "a thin highlight that moves 0.3 pixels a frame over a plain surface",
            hazard: "it falls between the pixels of a coarse quad and is lost, or leaves blocks behind",
            bound: "every frame, by every norm, with and without deblocking and rotation: full across where it is, once it was seen; the frame after it appears on a shaded pixel",
            guard: "the window's border of one pixel: with the quad's own pairs in place of all, quad 4 is 2x2 when the highlight enters it in frame 5 (tried)",
            run: highlight,
        },
    ],
};

const SIZE: [u32; 2] = [32, 32];
const AT_REST: Way = Way::Copies { rotates: false };
const NORMS: [Norm; 4] = [Norm::L1, Norm::L2, Norm::LInf, Norm::Root];
const WAYS: [Way; 4] = [
    Way::Copies { rotates: false },
    Way::Copies { rotates: true },
    Way::Deblocked { rotates: false },
    Way::Deblocked { rotates: true },
];

/// A threshold for a norm, and the contrast of a picture around a luma of a half whose error is `share` of it: a half step of share · t (I + l).
/// A ramp has to fit between black and white.
fn contrast(norm: Norm, is_ramp: bool, share: f64) -> (f64, f64) {
    let threshold = match (norm, is_ramp) {
        (Norm::Root, true) => 0.1,
        (Norm::Root, false) => 0.4,
        (_, true) => 0.01,
        (_, false) => 0.15,
    };
    let error = threshold * (0.5 + 0.05) * share;
    match norm {
        // the root of a half step
        Norm::Root => (threshold, 2.0 * error * error),
        _ => (threshold, 2.0 * error),
    }
}

/// What a loop did.
struct Loop {
    /// Flips of the last 32 frames.
    flips: usize,
    /// The last frame that changed anything.
    settled: usize,
}

/// A frame that is shaded at rates.
fn shade_in(
    way: Way,
    rates: &Sri,
    frame: u32,
    largest: Rate,
    truth: &dyn Fn(u32, u32) -> f32,
) -> Vec<[f32; 4]> {
    match way {
        Way::Copies { rotates } => {
            let phase = if rotates { frame % 4 } else { 0 };
            shade(SIZE, rates, largest, phase, truth)
        }
        Way::Deblocked { rotates } => shade_as_built(SIZE, rates, frame, rotates, truth),
    }
}

fn run(settings: &Settings, way: Way, truth: &dyn Fn(u32, u32) -> f32) -> Loop {
    let mut before = Sri::uniform(SIZE[0], SIZE[1], Rate::R1X1);
    let mut found = Loop {
        flips: 0,
        settled: 0,
    };
    for frame in 0..64 {
        let number = frame as u32;
        let shaded = shade_in(way, &before, number, settings.largest, truth);
        let inputs = Inputs {
            previous_rates: Some(&before),
            ..Inputs::of_colour(SIZE, Colour::Linear(&shaded))
        };
        let now = rates(&inputs, settings);
        let flips = apart(&now, &before);
        if flips > 0 {
            found.settled = frame;
        }
        if frame >= 32 {
            found.flips += flips;
        }
        before = now;
    }
    found
}

fn settings(norm: Norm, stability: Stability, threshold: f64) -> Settings {
    Settings {
        content: Content {
            norm,
            threshold,
            ..Content::default()
        },
        stability,
        ..Settings::default()
    }
}

fn ramps() -> Result<String, String> {
    let mut text = Vec::new();
    for norm in NORMS {
        let mut flips = [0; 3];
        let mut settled = 0;
        for i in 0..24u16 {
            let share = 0.5 + f64::from(i) / 16.0;
            let (threshold, step) = contrast(norm, true, share);
            let ramp = |x: u32, _: u32| (0.5 + step * (f64::from(x) - 16.0)) as f32;
            let ways = [
                Stability::None,
                Stability::Hysteresis,
                Stability::Compensate,
            ];
            for (index, stability) in ways.into_iter().enumerate() {
                let found = run(&settings(norm, stability, threshold), AT_REST, &ramp);
                flips[index] += found.flips;
                if index == 1 {
                    settled = settled.max(found.settled);
                }
            }
        }
        if flips[1] > 0 || flips[2] > 0 || norm == Norm::LInf && flips[0] == 0 {
            return Err(format!("{norm:?}: bare, ε, divided: {flips:?}"));
        }
        let per_quad = flips[0] as f64 / (24.0 * 32.0 * 256.0);
        text.push(format!(
            "{norm:?} bare {per_quad:.3}, with ε 0 from frame {}",
            settled + 1
        ));
    }
    Ok(text.join("; "))
}

/// A picture of the loops, by its name, with a contrast.
fn picture(name: &str, x: u32, y: u32) -> f32 {
    // a value from a place: the same on every run
    let hash = |x: u32, y: u32| {
        let mut h = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
        ((h ^ (h >> 13)) & 0xffff) as f32 / 65_535.0
    };
    match name {
        "noise" => hash(x, y) - 0.5,
        // its half step in the middle is half the contrast
        "ramp" => x as f32 - 16.0,
        "edge" => {
            if x + y / 3 < 21 {
                -0.5
            } else {
                0.5
            }
        }
        "text" => match (x / 7).is_multiple_of(2)
            && (y / 9).is_multiple_of(2)
            && (x % 7 < 2 || y % 9 == 4)
        {
            true => -0.5,
            false => 0.5,
        },
        // leaves: dark and bright patches of two to four pixels with holes
        _ => hash(x / 3, y / 2) * 0.7 + hash(x, y) * 0.3 - 0.5,
    }
}

const PICTURES: [&str; 4] = ["noise", "edge", "text", "foliage"];

/// Flips of a picture over contrasts from half to twice the threshold and every norm, bare and with ε; the last frame that
/// changed anything with ε.
fn flips_of(name: &str, way: Way, step: usize) -> ([usize; 2], usize) {
    let mut flips = [0; 2];
    let mut settled = 0;
    for norm in NORMS {
        for i in (0..7u8).step_by(step) {
            let share = 0.5 + f64::from(i) / 4.0;
            let (threshold, contrast) = contrast(norm, name == "ramp", share);
            let truth = |x: u32, y: u32| 0.5 + contrast as f32 * picture(name, x, y);
            for (index, stability) in [Stability::None, Stability::Hysteresis]
                .into_iter()
                .enumerate()
            {
                let found = run(&settings(norm, stability, threshold), way, &truth);
                flips[index] += found.flips;
                if index == 1 {
                    settled = settled.max(found.settled);
                }
            }
        }
    }
    (flips, settled)
}

fn per_quad(flips: usize) -> f64 {
    flips as f64 / (28.0 * 32.0 * 256.0)
}

fn pictures() -> Result<String, String> {
    let mut text = Vec::new();
    for name in PICTURES {
        let ([bare, with], settled) = flips_of(name, AT_REST, 1);
        text.push(format!(
            "{name} bare {:.4}, with ε {:.4} from frame {}",
            per_quad(bare),
            per_quad(with),
            settled + 1
        ));
        if with > 0 {
            return Err(text.join("; "));
        }
    }
    Ok(text.join("; "))
}

fn rotation() -> Result<String, String> {
    let mut text = Vec::new();
    let mut holds = true;
    for name in PICTURES {
        let ([bare, with], _) = flips_of(name, Way::Copies { rotates: true }, 1);
        text.push(format!(
            "{name} bare {:.4}, with ε {:.4}",
            per_quad(bare),
            per_quad(with)
        ));
        holds &= with == 0;
    }
    match holds {
        true => Ok(text.join("; ")),
        false => Err(text.join("; ")),
    }
}

fn deblocked() -> Result<String, String> {
    let mut text = Vec::new();
    let mut holds = true;
    for rotates in [false, true] {
        for name in ["ramp", "noise", "edge", "text", "foliage"] {
            // contrasts of 0.5, 1, 1.5 and 2 times the threshold
            let ([bare, with], _) = flips_of(name, Way::Deblocked { rotates }, 2);
            let per_quad = |flips: usize| flips as f64 / (16.0 * 32.0 * 256.0);
            text.push(format!(
                "{name} bare {:.4}, with ε {:.4}",
                per_quad(bare),
                per_quad(with)
            ));
            holds &= with == 0;
        }
    }
    let text = format!(
        "at rest: {}; rotating: {}",
        text[..5].join(", "),
        text[5..].join(", ")
    );
    match holds {
        true => Ok(text),
        false => Err(text),
    }
}

/// One pixel wide, by its coverage of the two that it lies on.
fn line(at: f32) -> impl Fn(u32, u32) -> f32 {
    move |x, _| 0.2 + 0.7 * (1.0 - (x as f32 - at).abs()).max(0.0)
}

/// How many of 64 frames are at full rate across where the highlight will be in the next one.
fn tracked(norm: Norm, way: Way) -> Result<u32, String> {
    let (threshold, _) = contrast(norm, false, 1.0);
    let settings = settings(norm, Stability::Hysteresis, threshold);
    // known at first: the frame before was at full rate
    let mut before = Sri::uniform(SIZE[0], SIZE[1], Rate::R1X1);
    for frame in 0..64u16 {
        let at = 6.0 + 0.3 * f32::from(frame);
        let shaded = shade_in(way, &before, frame.into(), Rate::R2X2, &line(at));
        let inputs = Inputs {
            previous_rates: Some(&before),
            ..Inputs::of_colour(SIZE, Colour::Linear(&shaded))
        };
        let now = rates(&inputs, &settings);
        let next = at + 0.3;
        for ([x, y], code) in quads(&now) {
            let covers = next > x as f32 * 2.0 - 0.5 && next < x as f32 * 2.0 + 1.5;
            if covers && code >> 2 != 0 {
                return Err(format!(
                    "{norm:?}, {way:?}, frame {frame}: it is at {at:.1}, and quad {x},{y} is {code}"
                ));
            }
        }
        before = now;
    }
    Ok(64)
}

fn highlight() -> Result<String, String> {
    let mut frames = 0;
    for norm in NORMS {
        for way in WAYS {
            frames += tracked(norm, way)?;
        }
    }
    let settings = settings(Norm::L2, Stability::Hysteresis, 0.15);
    // unknown: it appears while all is coarse
    let mut waits = Vec::new();
    for at in [8u8, 9] {
        let mut before = Sri::uniform(SIZE[0], SIZE[1], Rate::R2X2);
        let wait = (1..=8).find(|&frame| {
            let shaded = shade(SIZE, &before, Rate::R2X2, frame - 1, line(f32::from(at)));
            let inputs = Inputs {
                previous_rates: Some(&before),
                ..Inputs::of_colour(SIZE, Colour::Linear(&shaded))
            };
            before = rates(&inputs, &settings);
            before.code(4, 8) >> 2 == 0
        });
        waits.push(wait.ok_or_else(|| format!("at column {at} it is never seen"))?);
    }
    match waits[0] == 1 && waits[1] <= 2 {
        true => Ok(format!(
            "tracked in {frames} of 1024 frames, by 4 norms in 4 ways; appears: {} frame on a shaded pixel, {} on another, by rotation",
            waits[0], waits[1]
        )),
        false => Err(format!("{waits:?} frames")),
    }
}
