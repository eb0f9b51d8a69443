//! The oracle: the stage in f64, by the formulas as they stand in the papers.

use super::{
    fixed, hysteresis,
    inputs::{Colour, Inputs, Output, WrongInput},
    luma::from_srgb,
    motion,
    params::Params,
    pipeline::{self, Numbers, Place},
    settings::{Blur, Difference, Form, Norm, Pairs, Settings, Stability, Transfer, curve},
};
use std::cell::RefCell;

/// What the oracle finds.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The stage's output.
    pub output: Output,
    /// How near to its threshold each quad's error came, as a share of it, row by row: 0 is on it.
    pub margins: Vec<f64>,
    /// Whether any error of the quad lies so near to a threshold that the deterministic path may decide otherwise, row by row: nearer
    /// than what its quantisation can do to both, as derived from this very window. See `doubt` in the source.
    pub doubtful: Vec<bool>,
}

/// Runs the stage exactly.
///
/// # Errors
/// If inputs have the wrong size or are missing.
pub fn analyse(inputs: &Inputs, settings: &Settings) -> Result<Exact, WrongInput> {
    inputs.check()?;
    let params = Params::new(settings, &inputs.frame());
    let quads = inputs.size[0].div_ceil(2) as usize * inputs.size[1].div_ceil(2) as usize;
    let numbers = Reals {
        settings,
        inputs,
        pictures: [
            load(inputs.colour, settings),
            inputs.after.map_or_else(Vec::new, |c| load(c, settings)),
        ],
        margins: RefCell::new(vec![f64::INFINITY; quads]),
        doubtful: RefCell::new(vec![false; quads]),
    };
    let output = pipeline::run(&numbers, inputs, settings, &params)?;
    Ok(Exact {
        output,
        margins: numbers.margins.into_inner(),
        doubtful: numbers.doubtful.into_inner(),
    })
}

struct Reals<'a> {
    settings: &'a Settings,
    inputs: &'a Inputs<'a>,
    /// Red, green, blue in units of white.
    pictures: [Vec<Option<[f64; 3]>>; 2],
    margins: RefCell<Vec<f64>>,
    doubtful: RefCell<Vec<bool>>,
}

struct Window {
    errors: [f64; 2],
    luma: f64,
    /// By how much the deterministic path's mean of halves may be off.
    off: f64,
}

/// A unit of luma of the deterministic path.
const UNIT: f64 = 1.0 / fixed::ONE as f64;
/// The rounding of one of its factors.
const FACTOR: f64 = 0.5 / fixed::FACTOR_ONE as f64;

fn load(colour: Colour, settings: &Settings) -> Vec<Option<[f64; 3]>> {
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
                let is_valid = value[..3]
                    .iter()
                    .all(|&v| fixed::quantise(v, content.white_log2).is_some());
                let white = 2f64.powi(content.white_log2);
                is_valid.then(|| std::array::from_fn(|c| f64::from(value[c]).max(0.0) / white))
            })
            .collect(),
        Colour::SqrtLuma(codes) => codes
            .iter()
            .map(|&code| Some([(f64::from(code) / 255.0).powi(2); 3]))
            .collect(),
    }
}

/// The differences of a window along an axis: pairs of pixels (column, row) by the papers' own words, and the weight of each.
/// `corner` is the parity of the window's upper left pixel.
fn steps(pairs: Pairs, axis: usize, corner: [u32; 2]) -> Vec<Vec<([usize; 2], f64)>> {
    let next = |[x, y]: [usize; 2]| if axis == 0 { [x + 1, y] } else { [x, y + 1] };
    let all = (0..4).flat_map(|y| (0..4).map(move |x| [x, y]));
    let starts: Vec<[usize; 2]> = all
        .filter(|&p| p[axis] < 3)
        .filter(|&[x, y]| {
            let (px, py) = (x + corner[0] as usize, y + corner[1] as usize);
            match pairs {
                Pairs::All => true,
                // GDC: a chequerboard of steps across and down
                Pairs::Interleaved => (px % 2 == py % 2) == (axis == 0),
                Pairs::SubSampled => px % 2 == 0 && py % 2 == 0,
                Pairs::Quad => [x, y].iter().all(|&i| i == 1 || i == 2) && [x, y][axis] == 1,
                Pairs::Sobel => false,
            }
        })
        .collect();
    let plain = starts.into_iter().map(|p| vec![(p, -1.0), (next(p), 1.0)]);
    let sobel = (1..3)
        .flat_map(|y| (1..3).map(move |x| [x, y]))
        .map(|[x, y]: [usize; 2]| {
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
            taps
        });
    match pairs {
        Pairs::Sobel => sobel.collect(),
        _ => plain.collect(),
    }
}

impl Reals<'_> {
    fn luma(&self, pixel: [f64; 3]) -> f64 {
        let weights = self.settings.content.weights.exact();
        (0..3).map(|c| weights[c] * pixel[c]).sum()
    }

    fn tolerance(&self, place: &Place, again: bool) -> f64 {
        let settings = self.settings;
        let mut tolerance = curve(&settings.overshoot, self.inputs.resolution_scale);
        if let Some(safe) = settings.safe_area {
            let is_border = |axis: usize| {
                let at = place.quad[axis] * 2;
                at < safe.width || at + safe.width >= self.inputs.size[axis]
            };
            tolerance *= if is_border(0) || is_border(1) {
                safe.tolerance
            } else {
                1.0
            };
        }
        if let Some(foveation) = &settings.foveation {
            let d = [0, 1].map(|axis: usize| {
                let centre = (foveation.centre[axis] * f64::from(self.inputs.size[axis])).trunc();
                f64::from(place.quad[axis]) * 2.0 - centre
            });
            let distance = d[0].hypot(d[1]) / (f64::from(self.inputs.size[1]) / 2.0);
            tolerance *= foveation.tolerance(distance, self.inputs.resolution_scale);
        }
        if let Some(materials) = settings.materials {
            let speed = motion::speed_at(place.speed[0].max(place.speed[1]));
            let slow = (1.0 - speed / materials.slow).max(0.0);
            tolerance *= 1.0 - (1.0 - materials.least) * f64::from(place.shine) / 65_025.0 * slow;
        }
        if let (true, Some(half_rate)) = (again, settings.half_rate) {
            tolerance *=
                1.0 - (1.0 - half_rate.tolerance.min(1.0)) * f64::from(place.noise) / 255.0;
        }
        tolerance
    }

    /// By how much the deterministic path's error may be off.
    fn off(&self, window: &Window, error: f64) -> f64 {
        match self.settings.content.norm {
            // the root of what is off
            Norm::Root => (error * error + window.off).sqrt() - error,
            _ => window.off,
        }
    }

    /// Whether the deterministic path, rounding as [`fixed`] says, might find the other side of `b · error < threshold`.
    fn doubt(&self, window: &Window, error: f64, b: f64, threshold: f64, factor: f64) -> bool {
        let settings = self.settings;
        let content = &settings.content;
        let off = self.off(window, error);
        // t, the tolerances and the stability are rounded, each product of magnitudes by 2^-14
        let mut share =
            FACTOR / content.threshold + 4.0 * FACTOR / factor.min(1.0) + 12.0 / 16_384.0;
        if settings.foveation.is_some() {
            // the falloff's table has 256 steps
            share += 0.03;
        }
        if settings.materials.is_some() {
            share += 1.0 / 128.0;
        }
        let base = match content.form {
            Form::Window => content.threshold * factor * 1.5 * UNIT,
            _ => 0.0,
        };
        let band = b * off + 2.0 * FACTOR * error + threshold * share + base;
        // what is no number was decided before
        (b * error - threshold).abs() <= band
    }

    /// Windows together, each with a share of one.
    fn weighted(&self, windows: &[(&Window, f64)]) -> Window {
        let is_square = self.settings.content.norm == Norm::L2;
        let sum = |of: &dyn Fn(&Window) -> f64| -> f64 {
            windows
                .iter()
                .map(|&(window, share)| of(window) * share)
                .sum()
        };
        Window {
            errors: std::array::from_fn(|axis| match is_square {
                true => sum(&|window| window.errors[axis] * window.errors[axis]).sqrt(),
                false => sum(&|window| window.errors[axis]),
            }),
            luma: sum(&|window| window.luma),
            // the deterministic path rounds up once more
            off: windows
                .iter()
                .map(|(window, _)| window.off)
                .fold(0.0, f64::max)
                + UNIT,
        }
    }

    fn stability(&self, log2: u8, previous: u8) -> f64 {
        let content = &self.settings.content;
        match self.settings.stability {
            Stability::None => 1.0,
            Stability::Compensate => hysteresis::swell(content, previous),
            Stability::Hysteresis if previous >= log2 => 1.0 + hysteresis::epsilon(content, log2),
            Stability::Hysteresis => 1.0 - hysteresis::epsilon(content, log2),
        }
    }
}

impl Numbers for Reals<'_> {
    type Window = Window;

    fn window(&self, picture: usize, sources: &[u32; 16], corner: [u32; 2]) -> Window {
        let pixels =
            sources.map(|from| self.pictures[picture][from as usize].unwrap_or([f64::NAN; 3]));
        let content = &self.settings.content;
        let lumas = pixels.map(|p| self.luma(p));
        let darkest = lumas.into_iter().fold(f64::INFINITY, f64::min);
        let mut least_base = f64::INFINITY;
        let mut most_relative = 0.0f64;
        let errors = std::array::from_fn(|axis| {
            let halves = steps(content.pairs, axis, corner).into_iter().map(|taps| {
                let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                    taps.iter().map(|&([x, y], w)| of(y * 4 + x) * w).sum()
                };
                let channels: [f64; 3] = std::array::from_fn(|c| sum(&|i| pixels[i][c]).abs());
                let d = match content.difference {
                    Difference::Luma => sum(&|i| lumas[i]).abs(),
                    Difference::LargestChannel => channels.into_iter().fold(0.0, f64::max),
                    Difference::Rgb => self.luma(channels),
                };
                // the darker side
                let side = |sign: f64| -> f64 {
                    let of = taps.iter().filter(|tap| tap.1 * sign > 0.0);
                    let (sum, all) = of.fold((0.0, 0.0), |(sum, all), &([x, y], w)| {
                        (sum + lumas[y * 4 + x] * w, all + w)
                    });
                    sum / all
                };
                let relative = match content.form {
                    Form::Window | Form::Absolute => d,
                    Form::Pairwise { .. } if d == 0.0 => 0.0,
                    Form::Pairwise { sensitivity } => {
                        let bs = sensitivity * (1.0 - (50.0 * darkest - 2.5).clamp(0.0, 1.0));
                        let base = side(1.0).min(side(-1.0)) + bs;
                        least_base = least_base.min(base);
                        most_relative = most_relative.max((d / base).min(16.0));
                        (d / base).min(16_383.0 / 1024.0)
                    }
                };
                relative / 2.0
            });
            let (mut sum, mut most, mut n) = (0.0, 0.0f64, 0.0);
            for half in halves {
                sum += if content.norm == Norm::L2 {
                    half * half
                } else {
                    half
                };
                most = most.max(half);
                n += 1.0;
            }
            match content.norm {
                Norm::L1 => sum / n,
                Norm::Root => (sum / n).sqrt(),
                Norm::L2 => (sum / n).sqrt(),
                Norm::LInf => most,
            }
        });
        // a luma is off by half a unit for its channels and half for their sum, a difference by two, its half by one; a norm moves
        // no more than what goes into it
        let off = match content.form {
            Form::Window | Form::Absolute => UNIT,
            Form::Pairwise { sensitivity } => {
                // the base by one, and by the ramp's slope of 50
                let base = UNIT * (2.0 + 50.0 * sensitivity);
                let relative = (2.0 * UNIT + most_relative * base) / (least_base - base).max(1e-9);
                (relative + 1.0 / 1024.0) / 2.0
            }
        };
        Window {
            off,
            errors,
            luma: lumas.iter().sum::<f64>() / 16.0,
        }
    }

    fn is_below(&self, window: &Window, axis: usize, log2: u8, place: &Place, again: bool) -> bool {
        let content = &self.settings.content;
        let speed = motion::speed_at(place.speed[axis]);
        let [half, quarter] = match self.settings.motion.map(|motion| motion.blur) {
            Some(Blur::Scaled) => [motion::half(speed), motion::quarter(speed, content.k)],
            Some(Blur::Linear) => motion::linear(speed, content.k),
            _ => [1.0, content.k],
        };
        let b = if log2 == 1 { half } else { quarter };
        let base = match content.form {
            Form::Window => window.luma + content.ambient,
            Form::Pairwise { .. } | Form::Absolute => 1.0,
        };
        let factor = self.tolerance(place, again) * self.stability(log2, place.previous[axis]);
        let threshold = content.threshold * base * factor;
        let error = b * window.errors[axis];
        let quad = (place.quad[1] * self.inputs.size[0].div_ceil(2) + place.quad[0]) as usize;
        let margin = ((error - threshold) / threshold).abs();
        let known = &mut self.margins.borrow_mut()[quad];
        *known = match margin.is_nan() {
            true => 0.0,
            false => known.min(margin),
        };
        if self.doubt(window, window.errors[axis], b, threshold, factor) {
            self.doubtful.borrow_mut()[quad] = true;
        }
        error < threshold
    }

    fn mean(&self, windows: &[Window]) -> Window {
        let count = windows.len() as f64;
        let all: Vec<(&Window, f64)> = windows.iter().map(|w| (w, 1.0 / count)).collect();
        let mut mean = self.weighted(&all);
        if self.settings.content.norm == Norm::LInf {
            mean.errors = std::array::from_fn(|axis| {
                windows.iter().map(|w| w.errors[axis]).fold(0.0, f64::max)
            });
        }
        mean
    }

    fn blend(&self, windows: &[(&Window, u32)]) -> Window {
        let all: Vec<(&Window, f64)> = windows
            .iter()
            .map(|&(window, weight)| (window, f64::from(weight) / 65_536.0))
            .collect();
        self.weighted(&all)
    }

    fn error(&self, window: &Window, axis: usize) -> f64 {
        window.errors[axis]
    }

    fn is_flatter_across(&self, window: &Window, place: &Place) -> bool {
        let [across, down] = window.errors;
        // the deterministic path drops two bits of each sum besides
        if (across - down).abs() <= self.off(window, across) + self.off(window, down) + UNIT {
            let quad = place.quad[1] * self.inputs.size[0].div_ceil(2) + place.quad[0];
            self.doubtful.borrow_mut()[quad as usize] = true;
        }
        across <= down
    }

    fn sqrt_luma(&self, pixel: usize) -> u8 {
        let last = &self.pictures[usize::from(self.settings.transparents)];
        last[pixel].map_or(255, |p| (self.luma(p).sqrt() * 255.0).round() as u8)
    }

    fn is_valid(&self, picture: usize, pixel: usize) -> bool {
        self.pictures[picture][pixel].is_some()
    }
}
