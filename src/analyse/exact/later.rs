//! The oracle's last steps: blocks that have to agree, neighbours, the application's own rates, half the resolution.

use super::{Found, past};
use crate::{
    analyse::{
        half::HalfResolution,
        inputs::{Inputs, flags},
        settings::{Settings, Smoothing},
    },
    rate::{LargestAxis, Rate},
    sri::{Sri, SriLayout},
};

/// The quads of a square around or from one, as far as they are there.
fn near(layout: SriLayout, low: [i64; 2], high: [i64; 2]) -> impl Iterator<Item = usize> {
    let [width, height] = [layout.width, layout.height].map(i64::from);
    let rows = low[1].max(0)..high[1].min(height);
    rows.flat_map(move |y| {
        (low[0].max(0)..high[0].min(width)).map(move |x| (y * width + x) as usize)
    })
}

/// Every quad's rate, once 4 holds only for aligned blocks of 4×4 pixels all of whose quads have it; 4x4 itself, where it is not asked
/// for, is fine on the axis of the larger error (NVIDIA's sample: 2x4 where dx > dy).
pub(super) fn in_blocks(
    all: &[Found],
    layout: SriLayout,
    largest: Rate,
    of: fn(&Found) -> Rate,
    errors: fn(&Found) -> [f64; 2],
) -> Vec<Rate> {
    let mut rates: Vec<Rate> = all.iter().map(of).collect();
    for y in (0..i64::from(layout.height)).step_by(2) {
        for x in (0..i64::from(layout.width)).step_by(2) {
            let block: Vec<usize> = near(layout, [x, y], [x + 2, y + 2]).collect();
            let coarsest = match block.len() {
                4 => block
                    .iter()
                    .map(|&at| of(&all[at]))
                    .fold(Rate::R4X4, Rate::meet),
                _ => Rate::R2X2,
            };
            let coarsest = match coarsest == Rate::R4X4 && largest != Rate::R4X4 {
                false => coarsest.join(Rate::R2X2),
                true => {
                    let sum = |axis: usize| -> f64 {
                        block.iter().map(|&at| errors(&all[at])[axis]).sum()
                    };
                    match sum(0) > sum(1) {
                        true => Rate::R2X4,
                        false => Rate::R4X2,
                    }
                }
            };
            for at in block {
                rates[at] = rates[at].meet(coarsest);
            }
        }
    }
    rates
}

/// Rates limited by those around: of quads, or of tiles that are so many quads wide.
pub(super) fn smoothed(
    rates: &[Rate],
    layout: SriLayout,
    smoothing: Smoothing,
    side: u32,
) -> Vec<Rate> {
    if smoothing == Smoothing::None {
        return rates.to_vec();
    }
    let side = i64::from(side);
    (0..rates.len())
        .map(|at| {
            let (x, y) = (
                at as i64 % i64::from(layout.width),
                at as i64 / i64::from(layout.width),
            );
            let corner = [x / side * side, y / side * side];
            // the first quad of each area around that is there
            let around: Vec<[u32; 2]> = (-1..2)
                .flat_map(|dy| (-1..2).map(move |dx| [dx, dy]))
                .flat_map(|[dx, dy]: [i64; 2]| {
                    let first = [corner[0] + dx * side, corner[1] + dy * side];
                    near(layout, first, [first[0] + 1, first[1] + 1])
                })
                .map(|other| rates[other].log2())
                .collect();
            let own = rates[at].log2();
            Rate::from_log2([0, 1].map(|axis: usize| {
                let logs = around.iter().map(|logs| logs[axis]);
                match smoothing {
                    Smoothing::None => own[axis],
                    // §5.4: no more than 2× apart
                    Smoothing::Limit => own[axis].min(logs.min().unwrap_or_default() + 1),
                    // GDC, pass 3: only fine blends into coarse
                    Smoothing::Conservative => {
                        let sum: u32 = logs.map(|log| log.min(own[axis])).sum();
                        sum / around.len() as u32
                    }
                }
            }))
        })
        .collect()
}

/// Rates combined with what the application states of each pixel; a quad has the finest of its pixels.
pub(super) fn with_own(
    rates: &[Rate],
    inputs: &Inputs,
    settings: &Settings,
    doubtful: &mut [bool],
) -> Vec<Rate> {
    // a stage by tiles leaves the mask to this
    let is_there = settings.own.is_some() || settings.is_by_tiles();
    if !is_there {
        return rates.to_vec();
    }
    let own = settings.own.clone().unwrap_or_default();
    let [width, height] = inputs.size;
    let across = width.div_ceil(2);
    let clamp = match settings.largest.width().max(settings.largest.height()) {
        4 => LargestAxis::Four,
        _ => LargestAxis::Two,
    };
    let mut pixel = |found: Rate, at: usize, quad: usize| -> Rate {
        let mut rate = found;
        if let (Some(by_id), Some(ids)) = (&own.ids, inputs.ids)
            && let Some(Some(stated)) = by_id.rates.get(usize::from(ids[at]))
        {
            rate = by_id.combiner.combine(rate, *stated, clamp);
        }
        if let (Some(ladder), Some(depth)) = (&own.distance, inputs.depth) {
            let inverse =
                past::inverse_distance(depth[at], ladder.near / ladder.far, ladder.reversed_z);
            let Some(inverse) = inverse else {
                return Rate::R1X1;
            };
            // z = near / inverse, to be compared with each step
            let steps = ladder.steps.iter().filter(|(from, _)| from.is_finite());
            let slack = 8.0 / f64::from(1 << 30);
            let is_near =
                |&&(from, _): &&(f64, Rate)| (inverse - ladder.near / from).abs() <= slack;
            doubtful[quad] |= steps.clone().any(|step| is_near(&step));
            let mut reached = steps.filter(|(from, _)| ladder.near / inverse >= *from);
            if let Some((_, stated)) = reached.next_back() {
                rate = ladder.combiner.combine(rate, *stated, clamp);
            }
        }
        let mark = inputs.flags.map_or(0, |flags| flags[at]);
        if let Some(particles) = own.particles
            && mark & flags::PARTICLE != 0
        {
            rate = particles.combiner.combine(rate, particles.rate, clamp);
        }
        match mark & flags::FULL {
            0 => rate,
            _ => Rate::R1X1,
        }
    };
    rates
        .iter()
        .enumerate()
        .map(|(quad, &found)| {
            let (x, y) = (quad as u32 % across * 2, quad as u32 / across * 2);
            let pixels = (y..(y + 2).min(height))
                .flat_map(|y| (x..(x + 2).min(width)).map(move |x| (y * width + x) as usize));
            pixels
                .map(|at| pixel(found, at, quad))
                .fold(settings.largest, Rate::meet)
        })
        .collect()
}

/// The rates of half the resolution: each quad the finest of the four that it covers.
pub(super) fn half(rates: &[Rate], layout: SriLayout, size: [u32; 2], kind: HalfResolution) -> Sri {
    let [width, height] = size.map(|side| side.div_ceil(2));
    Sri::from_fn(width, height, |x, y| {
        let first = [x, y].map(|at| i64::from(at) * 2);
        let covered = near(layout, first, [first[0] + 2, first[1] + 2]);
        let finest = covered.map(|at| rates[at]).fold(Rate::R4X4, Rate::meet);
        match kind {
            HalfResolution::Code => finest.code(),
            // as many pixels of the screen
            HalfResolution::Footprint => {
                Rate::from_log2(finest.log2().map(|log| log.max(1) - 1)).code()
            }
        }
    })
}
