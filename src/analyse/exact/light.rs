//! The oracle's errors: Eq. 2, 25 and the forms of the talks, as they stand there, over any pixels.

use super::Estimate;
use crate::analyse::{
    fixed,
    inputs::Colour,
    luma::from_srgb,
    settings::{Content, Difference, Form, Norm, Pairs, Settings, Transfer},
};

/// A unit of luma of the deterministic path.
pub(super) const UNIT: f64 = 1.0 / fixed::ONE as f64;

/// A picture in units of white; nothing where there is no number, or one above white.
pub(super) fn load(colour: Colour, settings: &Settings) -> Vec<Option<[f64; 3]>> {
    let content = &settings.content;
    match colour {
        Colour::Codes(codes) => codes
            .iter()
            .map(|code| {
                Some(std::array::from_fn(|c| {
                    let encoded = f64::from(code[c]) / 255.0;
                    match content.transfer {
                        Transfer::Srgb => from_srgb(encoded),
                        Transfer::Square => encoded * encoded,
                    }
                }))
            })
            .collect(),
        Colour::Linear(values) => values
            .iter()
            .map(|value| {
                let white = 2f64.powi(content.white_log2);
                let channels = [0, 1, 2].map(|c: usize| f64::from(value[c]) / white);
                // what lies below 0 by less than half a unit is 0 by rounding
                let is_valid = channels.iter().all(|v| (-UNIT / 2.0..=1.0).contains(v));
                is_valid.then(|| channels.map(|v| v.max(0.0)))
            })
            .collect(),
        Colour::SqrtLuma(codes) => codes
            .iter()
            .map(|&code| Some([(f64::from(code) / 255.0).powi(2); 3]))
            .collect(),
    }
}

/// Luma (Eq. 25).
pub(super) fn luma(pixel: [f64; 3], content: &Content) -> f64 {
    let weights = content.weights.exact();
    (0..3).map(|c| weights[c] * pixel[c]).sum()
}

/// A difference: the pixels that it is of, each with its weight, and the pixel that it belongs to.
struct Step {
    of: [usize; 2],
    taps: Vec<([usize; 2], f64)>,
}

/// Pixels that are estimated together.
pub(super) enum Shape {
    /// A quad's window, 4×4 pixels, and the parity of the first one's place.
    Window([usize; 2]),
    /// A tile, whose first pixel lies at even places.
    Tile,
}

/// The differences of `width` × `height` pixels along an axis, by the papers' own words.
fn steps(pairs: Pairs, axis: usize, shape: &Shape, [width, height]: [usize; 2]) -> Vec<Step> {
    let corner = match shape {
        Shape::Window(corner) => *corner,
        Shape::Tile => [0, 0],
    };
    let all = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    if pairs == Pairs::Sobel {
        // wherever all neighbours are at hand; of a window, that is the quad
        let has_all = |&[x, y]: &[usize; 2]| x > 0 && y > 0 && x + 1 < width && y + 1 < height;
        return all.filter(has_all).map(|at| sobel(at, axis)).collect();
    }
    let next = |[x, y]: [usize; 2]| if axis == 0 { [x + 1, y] } else { [x, y + 1] };
    let is_there = |at: &[usize; 2]| at[axis] + 1 < [width, height][axis];
    let is_taken = |&[x, y]: &[usize; 2]| {
        let (px, py) = (x + corner[0], y + corner[1]);
        match pairs {
            Pairs::All => true,
            // GDC: a chequerboard of steps across and down
            Pairs::Interleaved => (px % 2 == py % 2) == (axis == 0),
            Pairs::SubSampled => px % 2 == 0 && py % 2 == 0,
            // steps inside of quads; of a window, inside its own
            Pairs::Quad => match shape {
                Shape::Window(_) => [x, y].iter().all(|i| (1..3).contains(i)) && [x, y][axis] == 1,
                Shape::Tile => [x, y][axis] % 2 == 0,
            },
            Pairs::Sobel => false,
        }
    };
    all.filter(is_there)
        .filter(is_taken)
        .map(|at| Step {
            of: at,
            taps: vec![(at, -1.0), (next(at), 1.0)],
        })
        .collect()
}

fn sobel([x, y]: [usize; 2], axis: usize) -> Step {
    let mut taps = Vec::new();
    for side in [0usize, 2] {
        for (i, weight) in [(0usize, 1.0), (1, 2.0), (2, 1.0)] {
            let at = if axis == 0 {
                [x - 1 + side, y - 1 + i]
            } else {
                [x - 1 + i, y - 1 + side]
            };
            taps.push((at, weight * (side as f64 - 1.0) / 8.0));
        }
    }
    Step { of: [x, y], taps }
}

/// What pixels tell, row by row, all of which have a luma.
pub(super) fn estimate(
    pixels: &[[f64; 3]],
    extent: [usize; 2],
    shape: &Shape,
    content: &Content,
) -> Estimate {
    let width = extent[0];
    let lumas: Vec<f64> = pixels.iter().map(|&p| luma(p, content)).collect();
    let at = |[x, y]: [usize; 2]| y * width + x;
    // GDC: the least luma around, in the talk of a thread's block
    let darkest_around = |[x, y]: [usize; 2]| -> f64 {
        let is_near = |i: usize, [left, top]: [usize; 2]| {
            (left..left + 3).contains(&(i % width)) && (top..top + 3).contains(&(i / width))
        };
        let near = (0..lumas.len()).filter(|&i| match shape {
            Shape::Window(_) => true,
            Shape::Tile => is_near(i, [x & !1, y & !1]),
        });
        near.map(|i| lumas[i]).fold(f64::INFINITY, f64::min)
    };
    let mut least_base = f64::INFINITY;
    let mut most_relative = 0.0f64;
    let mut is_blind = [false; 2];
    let errors = std::array::from_fn(|axis| {
        let all = steps(content.pairs, axis, shape, extent);
        is_blind[axis] = all.is_empty() && extent[axis] > 1;
        let halves: Vec<f64> = all
            .iter()
            .map(|step| {
                let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                    step.taps.iter().map(|&(p, w)| of(at(p)) * w).sum()
                };
                let channels: [f64; 3] = std::array::from_fn(|c| sum(&|i| pixels[i][c]).abs());
                let d = match content.difference {
                    Difference::Luma => sum(&|i| lumas[i]).abs(),
                    Difference::LargestChannel => channels.into_iter().fold(0.0, f64::max),
                    Difference::Rgb => luma(channels, content),
                };
                // the darker side
                let side = |sign: f64| -> f64 {
                    let of = step.taps.iter().filter(|tap| tap.1 * sign > 0.0);
                    let (sum, all) = of.fold((0.0, 0.0), |(sum, all), &(p, w)| {
                        (sum + lumas[at(p)] * w, all + w)
                    });
                    sum / all
                };
                let relative = match content.form {
                    Form::Window | Form::Absolute => d,
                    Form::Pairwise { sensitivity } => {
                        let darkest = darkest_around(step.of);
                        let bs = sensitivity * (1.0 - (50.0 * darkest - 2.5).clamp(0.0, 1.0));
                        let base = side(1.0).min(side(-1.0)) + bs;
                        if d > 0.0 {
                            least_base = least_base.min(base);
                            most_relative = most_relative.max((d / base).min(16.0));
                        }
                        // saturates (research, E6)
                        if d == 0.0 {
                            0.0
                        } else {
                            (d / base).min(16_383.0 / 1024.0)
                        }
                    }
                };
                relative / 2.0
            })
            .collect();
        let n = halves.len().max(1) as f64;
        let mean = halves.iter().sum::<f64>() / n;
        match content.norm {
            Norm::L1 => mean,
            Norm::Root => mean.sqrt(),
            Norm::L2 => (halves.iter().map(|half| half * half).sum::<f64>() / n).sqrt(),
            Norm::LInf => halves.into_iter().fold(0.0, f64::max),
        }
    });
    // a luma is off by half a unit for its channels and half for their sum, a difference by two, its half by one; a norm moves
    // no more than what goes into it, and a tile's mean is rounded once more
    let off = match content.form {
        Form::Window | Form::Absolute => match shape {
            Shape::Window(_) => UNIT,
            Shape::Tile => 1.5 * UNIT,
        },
        Form::Pairwise { sensitivity } => {
            // the base by one, and by the ramp's slope of 50
            let base = UNIT * (2.0 + 50.0 * sensitivity);
            let relative = (2.0 * UNIT + most_relative * base) / (least_base - base).max(1e-9);
            (relative + 2.0 / 1024.0) / 2.0
        }
    };
    Estimate {
        errors,
        luma: lumas.iter().sum::<f64>() / lumas.len() as f64,
        off,
        is_blind,
    }
}
