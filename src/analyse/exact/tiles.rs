//! The oracle's stage by tiles (GDC 2019, passes 1 and 2): each tile's data where it was by its furthest depth, with linear interpolation.

use super::{Estimate, Found, Place, Reals, light, past};
use crate::{
    analyse::{reasons::Reason, settings::Norm, tiles::SIDE},
    rate::Rate,
};

/// A previous tile's estimate, and its most smoothness · Rf0; nothing where a pixel has no luma, or an axis nothing to tell.
type Data = Option<(Estimate, f64)>;

/// What every tile gets, row by row.
pub(super) fn all(reals: &Reals) -> Vec<Found> {
    let data = data(reals);
    let [across, down] = reals.inputs.size.map(|side| side.div_ceil(SIDE));
    (0..down)
        .flat_map(|y| (0..across).map(move |x| [x, y]))
        .map(|tile| rate(reals, &data, tile))
        .collect()
}

fn data(reals: &Reals) -> Vec<Data> {
    let [width, height] = reals.inputs.previous_size;
    let of = |[x, y]: [u32; 2]| -> Data {
        let (left, top) = (x * SIDE, y * SIDE);
        let (right, bottom) = ((left + SIDE).min(width), (top + SIDE).min(height));
        let pixels: Vec<usize> = (top..bottom)
            .flat_map(|y| (left..right).map(move |x| (y * width + x) as usize))
            .collect();
        let light: Option<Vec<[f64; 3]>> = pixels.iter().map(|&at| reals.pictures[0][at]).collect();
        let extent = [right - left, bottom - top].map(|side| side as usize);
        let content = &reals.settings.content;
        let found = light::estimate(&light?, extent, &light::Shape::Tile, content);
        let is_alone = extent[0] == 1 && width > 1 || extent[1] == 1 && height > 1;
        let surfaces = reals
            .inputs
            .materials
            .filter(|_| reals.settings.has_materials_before());
        let shine = surfaces.map_or(0.0, |surfaces| {
            let of = |&at: &usize| surfaces[at].map(|byte| f64::from(byte) / 255.0);
            let each = pixels.iter().map(of).map(|[smooth, rf0]| smooth * rf0);
            each.fold(0.0, f64::max)
        });
        (!found.is_blind[0] && !found.is_blind[1] && !is_alone).then_some((found, shine))
    };
    (0..height.div_ceil(SIDE))
        .flat_map(|y| (0..width.div_ceil(SIDE)).map(move |x| [x, y]))
        .map(of)
        .collect()
}

/// How a tile moved, by its furthest depth.
fn moved(reals: &Reals, pixels: &[usize], middle: [f64; 2]) -> Option<[f64; 2]> {
    let inputs = reals.inputs;
    let (depth, cameras) = (inputs.depth?, inputs.cameras?);
    let reversed_z = reals.settings.reprojection.is_some_and(|r| r.reversed_z);
    let depths = pixels.iter().map(|&at| depth[at]);
    if !depths.clone().all(|depth| (0.0..=1.0).contains(&depth)) {
        return None;
    }
    let further = |a: f32, b: f32| if reversed_z { a.min(b) } else { a.max(b) };
    let far = depths.reduce(further)?;
    let moved = past::camera_motion(middle, inputs, far, &cameras.now, &cameras.before);
    moved.iter().all(|m| !m.is_nan()).then_some(moved)
}

fn rate(reals: &Reals, data: &[Data], tile: [u32; 2]) -> Found {
    let (inputs, settings) = (reals.inputs, reals.settings);
    let low = tile.map(|at| at * SIDE);
    let high = [0, 1].map(|axis: usize| (low[axis] + SIDE).min(inputs.size[axis]));
    let all: Vec<[u32; 2]> = (low[1]..high[1])
        .flat_map(|y| (low[0]..high[0]).map(move |x| [x, y]))
        .collect();
    let at = |[x, y]: [u32; 2]| (y * inputs.size[0] + x) as usize;
    let pixels: Vec<usize> = all.iter().copied().map(at).collect();
    let middle = [0, 1].map(|axis: usize| f64::from(low[axis] + high[axis]) / 2.0);
    let Some(moved) = moved(reals, &pixels, middle) else {
        return Found::full(Reason::NoMotion, false);
    };
    let sides = inputs.previous_size.map(f64::from);
    let (mut is_doubtful, mut is_outside, mut is_covered) = (false, false, false);
    for &pixel in &all {
        let centre = pixel.map(|side| f64::from(side) + 0.5);
        let place = past::place_before(centre, moved, inputs);
        is_doubtful |= place
            .iter()
            .any(|(at, off)| (at - off).floor() != (at + off).floor());
        let from = place.map(|(at, _)| at.floor());
        if (0..2).any(|axis| !(0.0..sides[axis]).contains(&from[axis])) {
            is_outside = true;
            continue;
        }
        let from = from[1] as usize * inputs.previous_size[0] as usize + from[0] as usize;
        let (Some(now), Some(before), Some(reprojection)) =
            (inputs.depth, inputs.previous_depth, settings.reprojection)
        else {
            continue;
        };
        if !settings.tests_depth() {
            continue;
        }
        let inverse = |depth| {
            let near_over_far = reprojection.near_over_far.clamp(0.0, 1.0);
            past::inverse_distance(depth, near_over_far, reprojection.reversed_z)
        };
        match (inverse(now[at(pixel)]), inverse(before[from])) {
            (Some(now), Some(then)) => {
                let (is_hidden, is_near) = past::is_hidden(now, then, reprojection.tolerance);
                is_covered |= is_hidden && then > now;
                is_doubtful |= is_near;
            }
            _ => is_covered = true,
        }
    }
    if is_outside || is_covered {
        let reason = if is_outside {
            Reason::OffScreen
        } else {
            Reason::Disoccluded
        };
        return Found::full(reason, is_doubtful);
    }
    let nominal = low.map(|low| f64::from(low) + f64::from(SIDE) / 2.0);
    let place = past::place_before(nominal, moved, inputs);
    let Some((estimate, shine)) = between(reals, data, place) else {
        return Found::full(Reason::Invalid, is_doubtful);
    };
    let steps = [0, 1].map(|axis: usize| reals.steps(axis));
    let weight = settings.motion.unwrap_or_default().weight;
    let speed = [0, 1].map(|axis: usize| {
        let most = 1023.0 / steps[axis];
        (moved[axis] * weight).abs().min(most)
    });
    let place = Place {
        speed,
        slow: [0, 1].map(
            |axis: usize| match (speed[axis] * steps[axis]).fract() == 0.0 {
                true => speed[axis],
                false => (speed[axis] - 2.0 / steps[axis]).max(0.0),
            },
        ),
        is_lost: false,
        previous: Rate::R1X1,
        quads: vec![tile.map(|at| at * 8)],
        shine: match settings.has_materials_before() {
            true => shine,
            false => inputs.materials.map_or(0.0, |surfaces| {
                let of = |&at: &usize| surfaces[at].map(|byte| f64::from(byte) / 255.0);
                let each = pixels.iter().map(of).map(|[smooth, rf0]| smooth * rf0);
                each.fold(0.0, f64::max)
            }),
        },
        noise: 1.0,
    };
    let mut found = reals.decide(&[estimate], &place, false);
    found.is_doubtful |= is_doubtful;
    found
}

/// Data between the middles of four tiles.
fn between(reals: &Reals, data: &[Data], place: [(f64, f64); 2]) -> Option<(Estimate, f64)> {
    let tiles = reals
        .inputs
        .previous_size
        .map(|side| i64::from(side.div_ceil(SIDE)));
    let side = f64::from(SIDE);
    let at = place.map(|(at, _)| at / side - 0.5);
    let first = at.map(f64::floor);
    let part = [at[0] - first[0], at[1] - first[1]];
    let is_exact = place
        .iter()
        .all(|&(at, off)| off == 0.0 && (at * side).fract() == 0.0);
    let mut four: Vec<(&(Estimate, f64), f64)> = Vec::new();
    for step in [[0, 0], [1, 0], [0, 1], [1, 1]] {
        let weight: f64 = (0..2)
            .map(|axis| {
                if step[axis] == 1 {
                    part[axis]
                } else {
                    1.0 - part[axis]
                }
            })
            .product();
        let of = |axis: usize| (first[axis] as i64 + step[axis]).clamp(0, tiles[axis] - 1);
        let found = data[(of(1) * tiles[0] + of(0)) as usize].as_ref();
        // a share below the deterministic path's smallest is none there
        match found {
            Some(found) => four.push((found, weight)),
            None if weight == 0.0 => {}
            None => return None,
        }
    }
    let is_square = reals.settings.content.norm == Norm::L2;
    // means of squares, and of halves whose root is taken last
    let power = match reals.settings.content.norm {
        Norm::L2 | Norm::Root => 2,
        Norm::L1 | Norm::LInf => 1,
    };
    let mean = |of: &dyn Fn(&(Estimate, f64)) -> f64| -> f64 {
        four.iter().map(|&(found, weight)| of(found) * weight).sum()
    };
    let most = |of: &dyn Fn(&(Estimate, f64)) -> f64| -> f64 {
        four.iter().map(|&(found, _)| of(found)).fold(0.0, f64::max)
    };
    let mut off = most(&|found| found.0.off) + light::UNIT;
    let errors = std::array::from_fn(|axis| {
        let of = |found: &(Estimate, f64)| found.0.errors[axis].powi(power);
        let blended = mean(&of);
        if !is_exact {
            // shares have 1/256
            let spread = blended + most(&of) * 4.0 / 256.0;
            off += match is_square {
                true => spread.sqrt() - blended.sqrt(),
                false => spread - blended,
            };
        }
        match power {
            2 => blended.sqrt(),
            _ => blended,
        }
    });
    let estimate = Estimate {
        errors,
        luma: mean(&|found| found.0.luma),
        off: match is_exact {
            true => off,
            // the luma's share, which the threshold has
            false => off + most(&|found| found.0.luma) * 4.0 / 256.0,
        },
        is_blind: [false; 2],
    };
    Some((estimate, mean(&|found| found.1)))
}
