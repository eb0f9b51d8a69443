//! The geometry of time: history that is not there, of another size, of another place, or of another surface.

use vrcs::{
    Rate,
    analyse::{Colour, Inputs, Reason, Settings, settings::*},
};

use crate::{
    case::{Case, Family},
    stage::{all_are, grey, noise, quads, rates, twins},
};

pub const FAMILY: Family = Family {
    name: "time",
    about: "First frames, cuts, other resolutions, teleports, both ways of depth and every scale of the world.",
    cases: &[
        Case {
            id: "E36",
            name: "the first frame, a cut, and a resolution that changes in every frame",
            hazard: "stale history at the wrong place: corrupted rates",
            bound: "no history: all 1x1; another size: the same rates at the same place of the picture",
            guard: "params.has_history and params.ratio; with a ratio of 1 stripes lie where the old size had them (tried: column 14 of 48×28)",
            run: history,
        },
        Case {
            id: "E33",
            name: "teleports: vectors of 1e9 to 1e30, NaN and ∞; whole frames and single pixels",
            hazard: "a position wraps to one inside the picture",
            bound: "1x1 around each such pixel, and nowhere else",
            guard: "past::source refuses magnitudes of 2^23 and more by their bits; without it a position overflows (tried)",
            run: teleports,
        },
        Case {
            id: "E33-z",
            name: "one scene by standard and by reversed depth",
            hazard: "the nearest surface is taken for the furthest",
            bound: "the same mask of disocclusion",
            guard: "params.reversed_z; with 1 in its place nothing is hidden by standard depth (tried)",
            run: both_ways_of_depth,
        },
        Case {
            id: "E33-w",
            name: "cameras whose matrices put the world behind them, are singular, or hold NaN and ∞",
            hazard: "w ≤ 0 mirrors a place into the picture; a division by zero lands anywhere",
            bound: "1x1 for every such pixel, by both ways of depth; a camera at rest keeps the plain rates",
            guard: "reproject::camera_motion refuses a w that is not above 0 or not finite; with `w == 0` alone what was behind the camera is fetched from its mirror image (tried: 2x2). This test found that an infinite w put everything into the middle of the picture",
            run: cameras,
        },
        Case {
            id: "E34",
            name: "one scene at 0.01, 1 and 100 times its size",
            hazard: "an absolute threshold in view space finds all or nothing hidden",
            bound: "the same mask of disocclusion",
            guard: "params::is_hidden compares inverse depths as a share of each other; against a fixed difference the masks at 0.01, 1 and 100 differ (tried), and so E33-z finds nothing hidden",
            run: scales,
        },
        Case {
            id: "E35",
            name: "a floor that recedes steeply, slanted to one side, seen by a camera that moves a pixel a frame",
            hazard: "linear depth is not affine on the screen: floors are taken for edges",
            bound: "no quad is disoccluded from row 12 below the horizon on, where a pixel's step is less than the tolerance; some are above, and so the test looks",
            guard: "params::is_hidden compares inverse depths, which are affine on the screen, as a share of each other. With distances that may differ by 0.2 a quad below row 12 is hidden; with an eighth of the tolerance 75 are (tried both)",
            run: steep_floor,
        },
        Case {
            id: "E32",
            name: "one pixel that stands still among fast ones",
            hazard: "the least speed of a large tile is 0 for one static pixel: no gain in motion anywhere",
            bound: "only quads whose window holds it lose the gain",
            guard: "the least speed of the window of 4×4 pixels counts; with the least of the picture all 256 quads lose the gain (tried)",
            run: still_pixel,
        },
    ],
};

fn history() -> Result<String, String> {
    let size = [32, 16];
    let plain = grey(size, |_, _| 0.5);
    let inputs = Inputs {
        has_history: false,
        ..Inputs::of_colour(size, Colour::Linear(&plain))
    };
    for found in twins(&inputs, &Settings::default())? {
        all_are(&found.sri, Rate::R1X1, "no history")?;
        if found.reasons[0] != Reason::NoHistory as u8 {
            return Err(format!("reason {}", found.reasons[0]));
        }
    }
    // stripes down in the right half, at a resolution that changes in every frame
    let sizes = [
        [64, 36],
        [60, 34],
        [48, 28],
        [33, 19],
        [32, 18],
        [47, 27],
        [64, 36],
        [128, 72],
        [1, 1],
        [64, 36],
    ];
    let mut times = 0;
    for pair in sizes.windows(2) {
        let [before, now] = [pair[0], pair[1]];
        let picture = grey(before, |x, y| match x * 2 < before[0] {
            true => 0.5,
            false => (y / 2 % 2) as f32,
        });
        let inputs = Inputs {
            size: now,
            previous_size: before,
            ..Inputs::of_colour(before, Colour::Linear(&picture))
        };
        let found = rates(&inputs, &Settings::default());
        for ([x, _], code) in quads(&found) {
            // the middle of the quad, in the picture; the windows that reach over the edge may be either
            let place = (x as f32 * 2.0 + 1.0) / now[0] as f32;
            let reach = 3.0 / now[0] as f32 + 2.0 / before[0] as f32;
            let wanted = match place < 0.5 {
                true => Rate::R2X2,
                false => Rate::R2X1,
            };
            let is_scaled_up = now[0] * 4 > before[0] * 5;
            if (place - 0.5).abs() > reach
                && !is_scaled_up
                && before[0] > 1
                && code != wanted.code()
            {
                return Err(format!(
                    "{before:?} to {now:?}: column {x} is {code}, not {wanted}"
                ));
            }
            times += 1;
        }
    }
    Ok(format!(
        "{} changes of size, {times} quads",
        sizes.len() - 1
    ))
}

fn reprojected() -> Settings {
    Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        ..Settings::default()
    }
}

fn teleports() -> Result<String, String> {
    let size = [32, 16];
    let plain = grey(size, |_, _| 0.5);
    let mut times = 0;
    for far in [
        1e9,
        -1e9,
        3e38,
        1e30,
        -1e30,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        65_504.0,
    ] {
        for axis in 0..2 {
            for at in [None, Some([0u32, 0]), Some([17, 8])] {
                let mut vectors = vec![[0.0f32; 2]; 512];
                for (i, vector) in vectors.iter_mut().enumerate() {
                    if at.is_none_or(|[x, y]| y * 32 + x == i as u32) {
                        vector[axis] = far;
                    }
                }
                let inputs = Inputs {
                    motion: Some(&vectors),
                    ..Inputs::of_colour(size, Colour::Linear(&plain))
                };
                for found in twins(&inputs, &reprojected())? {
                    for ([x, y], code) in quads(&found.sri) {
                        let near =
                            |quad: u32, at: u32| (quad * 2..quad * 2 + 4).contains(&(at + 1));
                        let is_lost = at.is_none_or(|at| near(x, at[0]) && near(y, at[1]));
                        let wanted = if is_lost { Rate::R1X1 } else { Rate::R2X2 };
                        if code != wanted.code() {
                            return Err(format!("{far} at {at:?}: quad {x},{y} is {code}"));
                        }
                        times += 1;
                    }
                }
            }
        }
    }
    Ok(format!("held for {times} quads"))
}

fn cameras() -> Result<String, String> {
    use glam::{DMat4, DVec3};
    use vrcs::analyse::reproject::camera_motions;
    let size = [16, 16];
    let plain = grey(size, |_, _| 0.5);
    let depth = vec![0.5f32; 256];
    let mut times = 0;
    for (near, far) in [(0.1, 100.0), (100.0, 0.1)] {
        let now = DMat4::perspective_rh(1.0, 1.0, near, far);
        let mut broken = vec![
            // turned about, and moved past the surface
            now * DMat4::from_rotation_y(std::f64::consts::PI),
            now * DMat4::from_translation(DVec3::new(0.0, 0.0, 500.0)),
            DMat4::ZERO,
            DMat4::from_diagonal(glam::DVec4::new(1.0, 1.0, 1.0, 0.0)),
        ];
        for bad in [f64::NAN, f64::INFINITY] {
            for at in [0, 11, 15] {
                let mut values = now.to_cols_array();
                values[at] = bad;
                broken.push(DMat4::from_cols_array(&values));
            }
        }
        let run = |now: &DMat4, before: &DMat4| {
            let vectors = camera_motions(size, &depth, now, before);
            let inputs = Inputs {
                motion: Some(&vectors),
                ..Inputs::of_colour(size, Colour::Linear(&plain))
            };
            twins(&inputs, &reprojected())
        };
        for found in run(&now, &now)? {
            all_are(&found.sri, Rate::R2X2, "at rest")?;
        }
        for (index, before) in broken.iter().enumerate() {
            for found in run(&now, before)? {
                all_are(&found.sri, Rate::R1X1, &format!("before, {index}"))?;
            }
            times += 1;
        }
        // a matrix that has no inverse
        for found in run(&DMat4::ZERO, &now)? {
            all_are(&found.sri, Rate::R1X1, "now, singular")?;
        }
    }
    Ok(format!("{times} cameras"))
}

/// Which quads are disoccluded, of a scene given by distances now and before; depth by a projection.
fn hidden(
    size: [u32; 2],
    now: &dyn Fn(u32, u32) -> f64,
    before: &dyn Fn(u32, u32) -> f64,
    vector: [f32; 2],
    reversed: bool,
) -> Result<Vec<bool>, String> {
    let (near, far) = (0.01, 100_000.0);
    let depth = |z: f64| {
        // 1 at the near plane, 0 at the far one
        let toward = (near * (far - z)) / (z * (far - near));
        (if reversed { toward } else { 1.0 - toward }) as f32
    };
    let of = |z: &dyn Fn(u32, u32) -> f64| -> Vec<f32> {
        (0..size[0] * size[1])
            .map(|i| depth(z(i % size[0], i / size[0])))
            .collect()
    };
    let (depth, previous_depth) = (of(now), of(before));
    let count = depth.len();
    let (vectors, plain) = (vec![vector; count], grey(size, |_, _| 0.5));
    let inputs = Inputs {
        motion: Some(&vectors),
        depth: Some(&depth),
        previous_depth: Some(&previous_depth),
        ..Inputs::of_colour(size, Colour::Linear(&plain))
    };
    let settings = Settings {
        reprojection: Some(Reprojection {
            reversed_z: reversed,
            near_over_far: near / far,
            ..Reprojection::default()
        }),
        ..reprojected()
    };
    let [fixed, real] = twins(&inputs, &settings)?;
    if fixed.reasons != real.reasons {
        return Err("the twins' reasons differ".to_owned());
    }
    let pitch = fixed.sri.layout().pitch;
    Ok(quads(&fixed.sri)
        .map(|([x, y], _)| fixed.reasons[(y * pitch + x) as usize] == Reason::Disoccluded as u8)
        .collect())
}

/// A wall with a pillar before it, which was further left: distances at a scale.
fn pillar(scale: f64, left: u32) -> impl Fn(u32, u32) -> f64 {
    move |x, y| {
        let wall = 8.0 + f64::from(x) * 0.02 + f64::from(y) * 0.05;
        scale
            * if (left..left + 8).contains(&x) {
                3.0
            } else {
                wall
            }
    }
}

fn both_ways_of_depth() -> Result<String, String> {
    let masks = [true, false].map(|reversed| {
        hidden(
            [48, 24],
            &pillar(1.0, 20),
            &pillar(1.0, 12),
            [0.0; 2],
            reversed,
        )
    });
    let [reversed, standard] = masks;
    let (reversed, standard) = (reversed?, standard?);
    let count = reversed.iter().filter(|&&hidden| hidden).count();
    match reversed == standard && count > 0 && count < reversed.len() / 2 {
        true => Ok(format!("{count} of {} quads, by both", reversed.len())),
        false => Err(format!(
            "{count} by reversed, {} by standard",
            standard.iter().filter(|&&h| h).count()
        )),
    }
}

fn scales() -> Result<String, String> {
    let mut masks = Vec::new();
    for scale in [0.01, 1.0, 100.0] {
        masks.push(hidden(
            [48, 24],
            &pillar(scale, 20),
            &pillar(scale, 12),
            [0.0; 2],
            true,
        )?);
    }
    let count = masks[0].iter().filter(|&&hidden| hidden).count();
    match masks[0] == masks[1] && masks[1] == masks[2] && count > 0 {
        true => Ok(format!("{count} of {} quads at each", masks[0].len())),
        false => Err("the masks differ".to_owned()),
    }
}

fn steep_floor() -> Result<String, String> {
    let size = [48, 64];
    // a floor under a camera at eye height: distance is inverse to the row below the horizon, which is slanted a little
    let floor = |x: u32, y: u32| 1.7 * 60.0 / (f64::from(y) + 1.0 + 0.3 * f64::from(x));
    let width = size[0] as usize / 2;
    let mut text = Vec::new();
    for (name, vector) in [("sideways", [1.0, 0.0]), ("towards it", [0.0, 1.0])] {
        let mask = hidden(size, &floor, &floor, vector, true)?;
        let (above, below) = mask.split_at(width * 6);
        let count = |mask: &[bool]| mask.iter().filter(|&&hidden| hidden).count();
        text.push(format!(
            "{name} {} of {} below row 12, {} above",
            count(below),
            below.len(),
            count(above)
        ));
        if count(below) > 0 || vector[1] > 0.0 && count(above) == 0 {
            return Err(text.join("; "));
        }
    }
    Ok(text.join("; "))
}

fn still_pixel() -> Result<String, String> {
    let size = [32, 32];
    let picture = noise(size, 0.8);
    let run = |still: Option<usize>| {
        let mut vectors = vec![[6.0f32, 6.0]; 1024];
        if let Some(at) = still {
            vectors[at] = [0.0; 2];
        }
        let inputs = Inputs {
            motion: Some(&vectors),
            ..Inputs::of_colour(size, Colour::Linear(&picture))
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            ..Settings::default()
        };
        rates(&inputs, &settings)
    };
    let (fast, one) = (run(None), run(Some(16 * 32 + 16)));
    all_are(&fast, Rate::R2X2, "in fast motion")?;
    let finer = quads(&one)
        .filter(|&(_, code)| code != Rate::R2X2.code())
        .count();
    match (1..=4).contains(&finer) {
        true => Ok(format!("{finer} of 256 quads")),
        false => Err(format!("{finer} quads")),
    }
}
