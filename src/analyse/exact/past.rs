//! The oracle's sources: where a pixel was (Yang et al., §5.1, §5.2), and whether it can be told.

use glam::{DMat4, DVec4};

use crate::analyse::{
    inputs::{Inputs, flags},
    reasons::Reason,
    settings::Settings,
};

/// Where a pixel was in the previous picture, or why that is not known; and whether the deterministic path's rounding may see it otherwise.
#[derive(Clone, Copy)]
pub(super) struct Past {
    pub(super) from: Result<usize, Reason>,
    pub(super) is_doubtful: bool,
}

/// By how much the deterministic path's positions may be off, in pixels of the previous picture: 1/256 for what is rounded, as much for
/// sizes that differ.
const OFF: f64 = 2.0 / 256.0;

/// The motion of a place by cameras, in pixels: from where a surface of a depth was to where it is. Not a number for what cannot be seen.
pub(super) fn camera_motion(
    [x, y]: [f64; 2],
    inputs: &Inputs,
    depth: f32,
    now: &DMat4,
    before: &DMat4,
) -> [f64; 2] {
    let [width, height] = inputs.size.map(f64::from);
    let is_depth = (0.0..=1.0).contains(&depth);
    let clip = DVec4::new(
        2.0 * x / width - 1.0,
        1.0 - 2.0 * y / height,
        f64::from(depth),
        1.0,
    );
    let world = now.inverse() * clip;
    let was = *before * world;
    // in front of the camera, whichever sign the homogeneous world has
    let w = was.w * if world.w < 0.0 { -1.0 } else { 1.0 };
    match is_depth && w > 0.0 && w.is_finite() {
        true => [
            x - (was.x / was.w + 1.0) / 2.0 * width,
            y - (1.0 - was.y / was.w) / 2.0 * height,
        ],
        false => [f64::NAN; 2],
    }
}

/// The motion of each pixel in pixels, before a scale; what does not move with the world stands still.
pub(super) fn vectors(inputs: &Inputs) -> Option<Vec<[f64; 2]>> {
    if let Some(vectors) = inputs.motion {
        return Some(vectors.iter().map(|v| v.map(f64::from)).collect());
    }
    let (cameras, depth) = (inputs.cameras?, inputs.depth?);
    let width = inputs.size[0] as usize;
    let of = |(at, &depth): (usize, &f32)| {
        let is_still = inputs.flags.is_some_and(|f| f[at] & flags::STATIC != 0);
        let centre = [at % width, at / width].map(|side| side as f64 + 0.5);
        match is_still {
            true => [0.0; 2],
            false => camera_motion(centre, inputs, depth, &cameras.now, &cameras.before),
        }
    };
    Some(depth.iter().enumerate().map(of).collect())
}

/// Distance over the near plane's, the inverse of it: 1 at the near plane. Nothing for what is no depth.
pub(super) fn inverse_distance(depth: f32, near_over_far: f64, reversed_z: bool) -> Option<f64> {
    let toward_near = match reversed_z {
        true => f64::from(depth),
        false => 1.0 - f64::from(depth),
    };
    (0.0..=1.0)
        .contains(&depth)
        .then_some(toward_near + (1.0 - toward_near) * near_over_far)
}

/// Whether two inverse distances are of different surfaces, and whether that is near the border: floats of standard depth have 2^-24.
pub(super) fn is_hidden(now: f64, then: f64, tolerance: f64) -> (bool, bool) {
    let (apart, least) = ((now - then).abs(), now.min(then));
    let slack = least / 65_536.0 + 16.0 / f64::from(1 << 30);
    (
        apart > least * tolerance,
        (apart - least * tolerance).abs() <= slack,
    )
}

/// The scale of motion: what follows from cameras is in pixels.
pub(super) fn scale_of(inputs: &Inputs, settings: &Settings) -> [f64; 2] {
    match inputs.motion {
        Some(_) => settings.motion.unwrap_or_default().scale,
        None => [1.0; 2],
    }
}

/// A place of this picture in the previous one, given how it moved; and by how much the deterministic path may be off.
pub(super) fn place_before(place: [f64; 2], moved: [f64; 2], inputs: &Inputs) -> [(f64, f64); 2] {
    std::array::from_fn(|axis| {
        let (now, before) = (
            f64::from(inputs.size[axis]),
            f64::from(inputs.previous_size[axis]),
        );
        let at = (place[axis] - moved[axis]) * before / now;
        let is_exact = now == before && (moved[axis] * 256.0).fract() == 0.0;
        (at, if is_exact { 0.0 } else { OFF })
    })
}

/// The source of each pixel.
pub(super) fn sources(
    inputs: &Inputs,
    settings: &Settings,
    vectors: Option<&[[f64; 2]]>,
) -> Vec<Past> {
    let width = inputs.size[0] as usize;
    let count = width * inputs.size[1] as usize;
    (0..count)
        .map(|at| {
            let centre = [at % width, at / width].map(|side| side as f64 + 0.5);
            let moved = vectors.map(|vectors| vectors[at]);
            source(at, centre, inputs, settings, moved)
        })
        .collect()
}

fn source(
    at: usize,
    centre: [f64; 2],
    inputs: &Inputs,
    settings: &Settings,
    moved: Option<[f64; 2]>,
) -> Past {
    let sides = inputs.previous_size.map(f64::from);
    let reprojection = settings.reprojection.filter(|_| moved.is_some());
    let scale = scale_of(inputs, settings);
    let vector = match (reprojection, moved) {
        (Some(_), Some(moved)) => [moved[0] * scale[0], moved[1] * scale[1]],
        _ => [0.0; 2],
    };
    let lost = |reason, is_doubtful| Past {
        from: Err(reason),
        is_doubtful,
    };
    if vector.iter().any(|component| component.is_nan()) {
        return lost(Reason::NoMotion, false);
    }
    let place = place_before(centre, vector, inputs);
    // another pixel, or none, is as near as the deterministic path may be off
    let is_doubtful = place
        .iter()
        .any(|(at, off)| (at - off).floor() != (at + off).floor());
    let is_outside = (0..2).any(|axis| !(0.0..sides[axis]).contains(&place[axis].0));
    if reprojection.is_some() && is_outside {
        return lost(Reason::OffScreen, is_doubtful);
    }
    let pixel =
        [0, 1].map(|axis: usize| place[axis].0.floor().clamp(0.0, sides[axis] - 1.0) as usize);
    let from = pixel[1] * inputs.previous_size[0] as usize + pixel[0];
    if let (Some(reprojection), Some(now), Some(before)) =
        (reprojection, inputs.depth, inputs.previous_depth)
        && settings.tests_depth()
    {
        let inverse = |depth| {
            inverse_distance(
                depth,
                reprojection.near_over_far.clamp(0.0, 1.0),
                reprojection.reversed_z,
            )
        };
        match (inverse(now[at]), inverse(before[from])) {
            (Some(now), Some(then)) => {
                let (is_hidden, is_near) = is_hidden(now, then, reprojection.tolerance);
                if is_hidden {
                    return lost(Reason::Disoccluded, is_doubtful || is_near);
                }
                return Past {
                    from: Ok(from),
                    is_doubtful: is_doubtful || is_near,
                };
            }
            _ => return lost(Reason::Disoccluded, is_doubtful),
        }
    }
    Past {
        from: Ok(from),
        is_doubtful,
    }
}
