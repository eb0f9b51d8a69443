//! The oracle: the stage in f64, by the formulas as they stand in the papers.

use super::{
    fixed, hysteresis,
    inputs::{Colour, Inputs, Output, WrongInput},
    integer::pairs,
    luma::{WEIGHTS, from_srgb},
    motion,
    params::Params,
    pipeline::{self, Numbers, Place},
    settings::{Blur, Difference, Form, Norm, Settings, Stability, Transfer, curve},
};
use std::cell::RefCell;

/// What the oracle finds.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The stage's output.
    pub output: Output,
    /// How near to its threshold each quad's error came, as a share of it, row by row: 0 is on it.
    pub margins: Vec<f64>,
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
    };
    let output = pipeline::run(&numbers, inputs, settings, &params)?;
    Ok(Exact {
        output,
        margins: numbers.margins.into_inner(),
    })
}

struct Reals<'a> {
    settings: &'a Settings,
    inputs: &'a Inputs<'a>,
    /// Red, green, blue in units of white.
    pictures: [Vec<Option<[f64; 3]>>; 2],
    margins: RefCell<Vec<f64>>,
}

struct Window {
    errors: [f64; 2],
    luma: f64,
}

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

fn luma(pixel: [f64; 3]) -> f64 {
    (0..3).map(|c| WEIGHTS[c] * pixel[c]).sum()
}

impl Reals<'_> {
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

    fn stability(&self, log2: u8, previous: u8) -> f64 {
        let norm = self.settings.content.norm;
        match self.settings.stability {
            Stability::None => 1.0,
            Stability::Compensate => hysteresis::gain(norm, previous),
            Stability::Hysteresis if previous >= log2 => 1.0 + hysteresis::epsilon(norm, log2),
            Stability::Hysteresis => 1.0 - hysteresis::epsilon(norm, log2),
        }
    }
}

impl Numbers for Reals<'_> {
    type Window = Window;

    fn window(&self, picture: usize, sources: &[u32; 16], corner: [u32; 2]) -> Window {
        let pixels =
            sources.map(|from| self.pictures[picture][from as usize].unwrap_or([f64::NAN; 3]));
        let content = &self.settings.content;
        let darkest = pixels
            .iter()
            .map(|&p| luma(p))
            .fold(f64::INFINITY, f64::min);
        let errors = std::array::from_fn(|axis| {
            let halves = pairs(content.pairs, axis, corner).map(|(a, b)| {
                let (a, b) = (pixels[a], pixels[b]);
                let channels: [f64; 3] = std::array::from_fn(|c| (a[c] - b[c]).abs());
                let d = match content.difference {
                    Difference::Luma => (luma(a) - luma(b)).abs(),
                    Difference::LargestChannel => channels.into_iter().fold(0.0, f64::max),
                    Difference::Rgb => luma(channels),
                };
                let relative = match content.form {
                    Form::Window => d,
                    Form::Pairwise { .. } if d == 0.0 => 0.0,
                    Form::Pairwise { sensitivity } => {
                        let bs = sensitivity * (1.0 - (50.0 * darkest - 2.5).clamp(0.0, 1.0));
                        (d / (luma(a).min(luma(b)) + bs)).min(16_383.0 / 1024.0)
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
                Norm::L2 => (sum / n).sqrt(),
                Norm::LInf => most,
            }
        });
        Window {
            errors,
            luma: pixels.iter().map(|&p| luma(p)).sum::<f64>() / 16.0,
        }
    }

    fn is_below(&self, window: &Window, axis: usize, log2: u8, place: &Place, again: bool) -> bool {
        let content = &self.settings.content;
        let speed = motion::speed_at(place.speed[axis]);
        let scaled = matches!(self.settings.motion, Some(motion) if motion.blur == Blur::Scaled);
        let b = match (log2, scaled) {
            (1, true) => motion::half(speed),
            (1, false) => 1.0,
            (_, true) => motion::quarter(speed, content.k),
            (_, false) => content.k,
        };
        let base = match content.form {
            Form::Window => window.luma + content.ambient,
            Form::Pairwise { .. } => 1.0,
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
        error < threshold
    }

    fn error(&self, window: &Window, axis: usize) -> f64 {
        window.errors[axis]
    }

    fn sqrt_luma(&self, pixel: usize) -> u8 {
        let last = &self.pictures[usize::from(self.settings.transparents)];
        last[pixel].map_or(255, |p| (luma(p).sqrt() * 255.0).round() as u8)
    }

    fn is_valid(&self, picture: usize, pixel: usize) -> bool {
        self.pictures[picture][pixel].is_some()
    }
}
