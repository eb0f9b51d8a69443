//! The oracle: the stage in f64, by the formulas as they stand in the papers and talks.
//!
//! Does: all of the stage once more, in real numbers and in steps of its own: where pixels were, what areas tell, what is decided, what
//! smoothing, own rates and half the resolution make of it. Beside each quad it says whether its own numbers lie so near to a threshold
//! that the deterministic path may decide otherwise.
//! Needs: what [`integer`](super::integer) needs.
//! Guarantees: shares settings, inputs and the algebra of rates ([`Rate`], [`Combiner`](crate::rate::Combiner), tested exhaustively by
//! themselves) with the deterministic path, and no step or decision of it; of its numbers, only the sizes of its units.

mod later;
mod light;
mod past;
mod tiles;

use super::{
    inputs::{Inputs, Output, WrongInput, flags},
    motion,
    params::luma_pitch,
    pipeline,
    reasons::Reason,
    settings::{Blur, Form, Granularity, Norm, Settings, Stability, curve},
    {fixed, hysteresis},
};
use crate::{
    rate::Rate,
    sri::{Sri, SriLayout},
};
use light::{Shape, UNIT};
use past::Past;

/// What the oracle finds.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The stage's output.
    pub output: Output,
    /// How near to its threshold each quad's error came, as a share of it, row by row: 0 is on it.
    pub margins: Vec<f64>,
    /// Whether any number of the quad lies so near to a threshold that the deterministic path may decide otherwise, row by row: nearer
    /// than what its quantisation can do to both, as derived from these very pixels. See `doubt` in the source.
    pub doubtful: Vec<bool>,
    /// The same of the attachment's rates, which may be of other areas.
    pub attachment_doubtful: Vec<bool>,
}

/// Runs the stage exactly.
///
/// # Errors
/// If inputs have the wrong size or are missing.
pub fn analyse(inputs: &Inputs, settings: &Settings) -> Result<Exact, WrongInput> {
    pipeline::check(inputs, settings)?;
    let needs_motion = settings.motion.is_some() || settings.reprojection.is_some();
    let vectors = needs_motion.then(|| past::vectors(inputs)).flatten();
    let pasts = past::sources(inputs, settings, vectors.as_deref());
    let reals = Reals {
        settings,
        inputs,
        pictures: [
            light::load(inputs.colour, settings),
            inputs
                .after
                .map_or_else(Vec::new, |c| light::load(c, settings)),
        ],
        vectors,
        pasts,
    };
    let quads = reals.decided(settings.granularity_of_rates());
    let of_attachment = settings.granularity_of_attachment();
    let attached = match of_attachment == settings.granularity_of_rates() {
        true => quads.clone(),
        false => reals.decided(of_attachment),
    };
    Ok(reals.finished(&quads, &attached))
}

/// The rounding of a factor of the deterministic path.
const FACTOR: f64 = 0.5 / fixed::FACTOR_ONE as f64;

/// What pixels tell.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    /// Across and down, in units of white.
    errors: [f64; 2],
    /// The mean.
    luma: f64,
    /// By how much the deterministic path's mean of halves may be off.
    off: f64,
    /// Whether an axis has pixels that a coarse rate would shade together, and no difference that tells of them.
    is_blind: [bool; 2],
}

/// What an area is beside its light.
#[derive(Clone, Debug)]
struct Place {
    /// The least speed in pixels a frame, and what the deterministic path may take it for.
    speed: [f64; 2],
    slow: [f64; 2],
    is_lost: bool,
    previous: Rate,
    /// Its quads.
    quads: Vec<[u32; 2]>,
    /// smoothness · Rf0, 0 to 1.
    shine: f64,
    /// 0 to 1.
    noise: f64,
}

/// What an area got.
#[derive(Clone, Copy, Debug)]
struct Found {
    rate: Rate,
    attachment: Rate,
    plain: Rate,
    reason: Reason,
    errors: [f64; 2],
    attachment_errors: [f64; 2],
    margin: f64,
    is_doubtful: bool,
}

impl Found {
    fn full(reason: Reason, is_doubtful: bool) -> Found {
        Found {
            rate: Rate::R1X1,
            attachment: Rate::R1X1,
            plain: Rate::R1X1,
            reason,
            errors: [0.0; 2],
            attachment_errors: [0.0; 2],
            margin: f64::INFINITY,
            is_doubtful,
        }
    }
}

/// A decision's side notes: how near it came, and whether it may be otherwise.
struct Notes {
    margin: f64,
    is_doubtful: bool,
}

struct Reals<'a> {
    settings: &'a Settings,
    inputs: &'a Inputs<'a>,
    /// Red, green, blue in units of white.
    pictures: [Vec<Option<[f64; 3]>>; 2],
    vectors: Option<Vec<[f64; 2]>>,
    pasts: Vec<Past>,
}

impl Reals<'_> {
    /// Every quad, row by row, each with what its area got.
    fn decided(&self, granularity: Granularity) -> Vec<Found> {
        let layout = SriLayout::new(self.inputs.size[0], self.inputs.size[1]);
        let all = (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| [x, y]));
        if !self.inputs.has_history {
            return all.map(|_| Found::full(Reason::NoHistory, false)).collect();
        }
        if granularity == Granularity::Quad {
            return all.map(|quad| self.quad(quad)).collect();
        }
        let side = granularity.side();
        let [across, down] = self.inputs.size.map(|of| of.div_ceil(side));
        let tiles: Vec<Found> = match self.settings.is_by_tiles() {
            true => tiles::all(self),
            false => (0..down)
                .flat_map(|y| (0..across).map(move |x| [x, y]))
                .map(|tile| self.tile(tile, side))
                .collect(),
        };
        all.map(|[x, y]| tiles[(y * 2 / side * across + x * 2 / side) as usize])
            .collect()
    }

    fn at(&self, x: i64, y: i64) -> usize {
        let [width, height] = self.inputs.size.map(i64::from);
        (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize
    }

    fn quad(&self, quad: [u32; 2]) -> Found {
        let [left, top] = quad.map(|at| i64::from(at) * 2);
        let square =
            |low: i64, high: i64| (low..high).flat_map(move |y| (low..high).map(move |x| (x, y)));
        let pixel = |(x, y)| self.at(left + x, top + y);
        let around: Vec<usize> = square(-1, 3).map(pixel).collect();
        let own: Vec<usize> = square(0, 2).map(pixel).collect();
        let corner = [left, top].map(|at| (at + 1) as usize % 2);
        self.area(&around, &own, vec![quad], [4, 4], &Shape::Window(corner))
    }

    fn tile(&self, tile: [u32; 2], side: u32) -> Found {
        let low = tile.map(|at| at * side);
        let high = [0, 1].map(|axis: usize| (low[axis] + side).min(self.inputs.size[axis]));
        let rows = low[1]..high[1];
        let pixels: Vec<usize> = rows
            .flat_map(|y| (low[0]..high[0]).map(move |x| (x, y)))
            .map(|(x, y)| self.at(i64::from(x), i64::from(y)))
            .collect();
        let quads = (low[1] / 2..high[1].div_ceil(2))
            .flat_map(|y| (low[0] / 2..high[0].div_ceil(2)).map(move |x| [x, y]));
        let extent = [0, 1].map(|axis: usize| (high[axis] - low[axis]) as usize);
        self.area(&pixels, &pixels, quads.collect(), extent, &Shape::Tile)
    }

    /// Decides on pixels: those that count for light, motion and doubt, and those that count for flags, materials and noise.
    fn area(
        &self,
        around: &[usize],
        own: &[usize],
        quads: Vec<[u32; 2]>,
        extent: [usize; 2],
        shape: &Shape,
    ) -> Found {
        let settings = self.settings;
        let is_doubtful = around.iter().any(|&at| self.pasts[at].is_doubtful);
        let lost = around.iter().find_map(|&at| self.pasts[at].from.err());
        if let Some(reason) = lost {
            return Found::full(reason, is_doubtful);
        }
        let froms: Vec<usize> = around
            .iter()
            .filter_map(|&at| self.pasts[at].from.ok())
            .collect();
        let pictures = if settings.transparents { 2 } else { 1 };
        let light = |picture: usize| -> Option<Vec<[f64; 3]>> {
            let of = &self.pictures[picture];
            froms.iter().map(|&from| of[from]).collect()
        };
        let lights: Option<Vec<Vec<[f64; 3]>>> = (0..pictures).map(light).collect();
        let Some(lights) = lights else {
            return Found::full(Reason::Invalid, is_doubtful);
        };
        let has = |bit: u8| {
            let flagged = |flags: &[u8]| own.iter().any(|&at| flags[at] & bit != 0);
            self.inputs.flags.is_some_and(flagged)
        };
        if has(flags::FULL) {
            return Found::full(Reason::Mask, is_doubtful);
        }
        let place = self.place(around, own, quads);
        let estimates: Vec<Estimate> = lights
            .iter()
            .map(|pixels| light::estimate(pixels, extent, shape, &settings.content))
            .collect();
        let mut found = self.decide(&estimates, &place, has(flags::NO_HALF_RATE));
        found.is_doubtful |= is_doubtful;
        found
    }

    fn place(&self, around: &[usize], own: &[usize], quads: Vec<[u32; 2]>) -> Place {
        let inputs = self.inputs;
        let speeds: Vec<[[f64; 2]; 2]> = match self.settings.motion {
            Some(_) => around.iter().map(|&at| self.speed(at)).collect(),
            None => vec![[[0.0; 2]; 2]],
        };
        let least = |which: usize| {
            [0, 1].map(|axis: usize| {
                let of = speeds.iter().map(|speed| speed[which][axis]);
                of.fold(f64::INFINITY, f64::min)
            })
        };
        let is_still = |at: usize| inputs.flags.is_some_and(|f| f[at] & flags::STATIC != 0);
        let is_nan = |at: usize| {
            let vector = self.vectors.as_ref().map_or([0.0; 2], |v| v[at]);
            vector.iter().any(|component| component.is_nan())
        };
        let from = |at: usize| self.pasts[at].from.unwrap_or_default();
        let across = inputs.previous_size[0] as usize;
        let previous = inputs.previous_rates.map_or(Rate::R1X1, |rates| {
            quads
                .iter()
                .map(|&[x, y]| {
                    let from = from(self.at(i64::from(x) * 2, i64::from(y) * 2));
                    let place = [from % across / 2, from / across / 2];
                    Rate::from_code_or_full(rates.code(place[0] as u32, place[1] as u32))
                })
                .reduce(Rate::meet)
                .unwrap_or(Rate::R1X1)
        });
        let most = |of: &dyn Fn(usize) -> f64| own.iter().map(|&at| of(at)).fold(0.0, f64::max);
        let is_before = self.settings.has_materials_before();
        let shine = inputs.materials.map_or(0.0, |surfaces| {
            most(&|at| {
                let surface = surfaces[if is_before { from(at) } else { at }];
                f64::from(surface[0]) / 255.0 * (f64::from(surface[1]) / 255.0)
            })
        });
        Place {
            speed: least(0),
            slow: least(1),
            is_lost: self.settings.motion.is_some()
                && around.iter().any(|&at| !is_still(at) && is_nan(at)),
            previous,
            quads,
            shine,
            noise: inputs
                .noise
                .map_or(1.0, |noise| most(&|at| f64::from(noise[at]) / 255.0)),
        }
    }

    /// A pixel's speed on both axes, by motion or by what a later blur hides (Eq. 17); and what the deterministic path, which has steps
    /// of 1/16 pixel up to 64, may take it for.
    fn speed(&self, at: usize) -> [[f64; 2]; 2] {
        let settings = self.settings;
        let motion = settings.motion.unwrap_or_default();
        let scale = past::scale_of(self.inputs, settings);
        let is_still = self
            .inputs
            .flags
            .is_some_and(|f| f[at] & flags::STATIC != 0);
        let steps = |axis: usize| self.steps(axis);
        let rounded = |speed: f64, axis: usize, slack: f64| {
            let most = f64::from(motion::SPEEDS - 1) / steps(axis);
            let is_step = slack == 0.0 && (speed * steps(axis)).fract() == 0.0;
            match is_step {
                true => [speed.min(most); 2],
                false => [
                    speed.min(most),
                    (speed.min(most) - 1.0 / steps(axis) - slack).max(0.0),
                ],
            }
        };
        let by_camera = self.inputs.motion.is_none();
        let moved = self.vectors.as_ref().map_or([0.0; 2], |v| v[at]);
        let mut all: [[f64; 2]; 2] = std::array::from_fn(|axis| {
            let speed = (moved[axis] * scale[axis] * motion.weight).abs();
            match is_still || speed.is_nan() {
                true => [0.0; 2],
                false => rounded(speed, axis, if by_camera { 1.0 / 16.0 } else { 0.0 }),
            }
        });
        let mut wide = |width: f64, slack: f64| {
            for (axis, speed) in all.iter_mut().enumerate() {
                let hidden = rounded(width, axis, slack);
                *speed = [speed[0].max(hidden[0]), speed[1].max(hidden[1])];
            }
        };
        if let (true, Some(blur)) = (settings.later_blur, self.inputs.blur) {
            let width = f64::from(blur[at]).abs();
            wide(if width.is_nan() { 0.0 } else { width }, 0.0);
        }
        if let (Some(lens), Some(depth)) = (settings.lens, self.inputs.depth) {
            let inverse = past::inverse_distance(depth[at], lens.near / lens.far, lens.reversed_z);
            // infinity · |1 − focus / z|, sharp without depth
            let width = inverse.map_or(0.0, |inverse| {
                let circle = lens.infinity * (1.0 - lens.focus / lens.near * inverse).abs();
                circle.min(lens.most)
            });
            // standard depth loses bits where it is near 1
            wide(width, 0.02);
        }
        [[all[0][0], all[1][0]], [all[0][1], all[1][1]]]
    }

    /// Steps of the deterministic path's table for a pixel a frame: of a ladder, 8192 for the picture.
    fn steps(&self, axis: usize) -> f64 {
        match self.settings.motion.map(|motion| motion.blur) {
            Some(Blur::Ladder(_)) => 8192.0 / f64::from(self.inputs.size[axis]),
            _ => 16.0,
        }
    }

    /// How much of the threshold a place is given.
    fn tolerance(&self, place: &Place, speed: f64, again: bool) -> f64 {
        let settings = self.settings;
        let size = self.inputs.size;
        let mut tolerance = curve(&settings.overshoot, self.inputs.resolution_scale);
        if let Some(safe) = settings.safe_area {
            let is_border = |quad: &[u32; 2]| {
                (0..2).any(|axis| {
                    let at = quad[axis] * 2;
                    at < safe.width || at + safe.width >= size[axis]
                })
            };
            // what reaches into the middle is no border
            if place.quads.iter().all(is_border) {
                tolerance *= safe.tolerance;
            }
        }
        if let Some(foveation) = &settings.foveation {
            let distance = |quad: &[u32; 2]| {
                let d = [0, 1].map(|axis: usize| {
                    let centre = (foveation.centre[axis] * f64::from(size[axis])).trunc();
                    f64::from(quad[axis]) * 2.0 - centre
                });
                d[0].hypot(d[1]) / (f64::from(size[1]) / 2.0)
            };
            let nearest = place
                .quads
                .iter()
                .map(distance)
                .fold(f64::INFINITY, f64::min);
            tolerance *= foveation.tolerance(nearest, self.inputs.resolution_scale);
        }
        if let Some(materials) = settings.materials {
            let slow = (1.0 - speed / materials.slow).max(0.0);
            // a speed of nothing is not fast, where nothing is slow
            let slow = if slow.is_nan() { 0.0 } else { slow };
            tolerance *= 1.0 - (1.0 - materials.least) * place.shine * slow;
        }
        if let (true, Some(half_rate)) = (again, settings.half_rate) {
            tolerance *= 1.0 - (1.0 - half_rate.tolerance.min(1.0)) * place.noise;
        }
        tolerance
    }

    fn stability(&self, log2: u8, previous: u8) -> f64 {
        let content = &self.settings.content;
        let side = self.settings.granularity_of_rates();
        let epsilon = hysteresis::epsilon(content, side, log2);
        match self.settings.stability {
            Stability::None => 1.0,
            Stability::Compensate => hysteresis::swell(content, side, previous),
            Stability::Hysteresis if previous >= log2 => 1.0 + epsilon,
            Stability::Hysteresis => 1.0 - epsilon,
        }
    }

    /// What motion leaves of the error of a rate (Eq. 20 to 22).
    fn left(&self, speed: f64, log2: u8) -> f64 {
        let k = self.settings.content.k;
        let both = match self.settings.motion.map(|motion| motion.blur) {
            Some(Blur::Scaled) => [motion::half(speed), motion::quarter(speed, k)],
            Some(Blur::Linear) => motion::linear(speed, k),
            _ => [1.0, k],
        };
        both[usize::from(log2) - 1]
    }

    /// By how much the deterministic path's error may be off.
    fn off(&self, estimate: &Estimate, error: f64) -> f64 {
        match self.settings.content.norm {
            // the root of what is off
            Norm::Root => (error * error + estimate.off).sqrt() - error,
            _ => estimate.off,
        }
    }

    /// Whether the deterministic path, rounding as [`fixed`] says, might find the other side of `b · error < threshold`.
    fn doubt(&self, estimate: &Estimate, error: f64, b: f64, threshold: f64, factor: f64) -> bool {
        let settings = self.settings;
        let content = &settings.content;
        let off = self.off(estimate, error);
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

    /// Whether the error of a rate of 2^`log2` pixels is below its threshold (Eq. 15, 16, 22).
    fn is_below(
        &self,
        estimate: &Estimate,
        axis: usize,
        log2: u8,
        place: &Place,
        again: bool,
        notes: &mut Notes,
    ) -> bool {
        let content = &self.settings.content;
        let base = match content.form {
            Form::Window => estimate.luma + content.ambient,
            Form::Pairwise { .. } | Form::Absolute => 1.0,
        };
        let previous = place.previous.log2()[axis] as u8;
        let stability = self.stability(log2, previous);
        let error = estimate.errors[axis];
        // at its speed, and at the one that the deterministic path may take it for
        let sides = [place.speed, place.slow].map(|speed| {
            let b = self.left(speed[axis], log2);
            let factor = self.tolerance(place, speed[0].max(speed[1]), again) * stability;
            let threshold = content.threshold * base * factor;
            let is_near = self.doubt(estimate, error, b, threshold, factor);
            (b * error, threshold, is_near)
        });
        let is_below = sides.map(|(error, threshold, _)| error < threshold);
        let (error, threshold, _) = sides[0];
        let margin = ((error - threshold) / threshold).abs();
        notes.margin = match margin.is_nan() {
            true => 0.0,
            false => notes.margin.min(margin),
        };
        notes.is_doubtful |=
            is_below[0] != is_below[1] || sides.iter().any(|&(_, _, is_near)| is_near);
        is_below[0]
    }

    /// The rate by content (Eq. 16), or by motion alone (Eq. 24; Wicked Engine).
    fn rate(&self, estimate: &Estimate, place: &Place, again: bool, notes: &mut Notes) -> Rate {
        let most = self.settings.largest.log2();
        if let Some(rates) = self.by_motion_alone(place) {
            notes.is_doubtful |= rates[0] != rates[1];
            return rates[0];
        }
        Rate::from_log2([0, 1].map(|axis: usize| {
            if estimate.is_blind[axis] {
                return 0;
            }
            let mut below = |log2| self.is_below(estimate, axis, log2, place, again, &mut *notes);
            let log = match below(1) {
                false => 0,
                true => 1 + u32::from(below(2)),
            };
            log.min(most[axis])
        }))
    }

    /// The rate that speed alone gives, and the one that the deterministic path may see.
    fn by_motion_alone(&self, place: &Place) -> Option<[Rate; 2]> {
        let motion = self.settings.motion?;
        let (content, size) = (&self.settings.content, self.inputs.size.map(f64::from));
        let most = self.settings.largest.log2();
        let capped = |logs: [u32; 2]| Rate::from_log2([0, 1].map(|i: usize| logs[i].min(most[i])));
        let of = |speed: [f64; 2]| match motion.blur {
            Blur::Scaled | Blur::Linear => None,
            Blur::Standalone { error } => Some(capped(speed.map(|v| {
                let half = motion::half(v) * error < content.threshold;
                let quarter = motion::quarter(v, content.k) * error < content.threshold;
                u32::from(half) + u32::from(half && quarter)
            }))),
            Blur::Ladder(steps) => {
                let fastest = (speed[0] / size[0]).max(speed[1] / size[1]);
                Some(capped(motion::ladder(fastest, &steps).log2()))
            }
        };
        Some([of(place.speed)?, of(place.slow)?])
    }

    fn decide(&self, estimates: &[Estimate], place: &Place, no_half_rate: bool) -> Found {
        let settings = self.settings;
        let mut notes = Notes {
            margin: f64::INFINITY,
            is_doubtful: false,
        };
        if let Some(materials) = settings.materials {
            let apart = (place.shine - materials.mirror) * 65_025.0;
            // the border is rounded down
            if apart >= 0.0 {
                return Found::full(Reason::Material, apart < 1.0);
            }
            notes.is_doubtful |= apart > -1.0;
        }
        let before = &estimates[0];
        let solid = self.rate(before, place, false, &mut notes);
        let attachment = match estimates.get(1) {
            Some(after) => self.rate(after, place, false, &mut notes),
            None => solid,
        };
        // transparents can reduce a solid's rate, and cannot increase it
        let plain = solid.join(attachment);
        let alone = settings.is_by_motion_alone();
        let mut reason = match plain == settings.largest {
            true => Reason::None,
            false if place.is_lost => Reason::NoMotion,
            false if alone => Reason::Motion,
            false => Reason::Content,
        };
        let mut rate = plain;
        let errors = before.errors;
        if let Some(half) = settings.half_rate {
            let is_coarse = plain.width() > 1 && plain.height() > 1;
            let is_fast = |speed: [f64; 2]| speed.iter().all(|&speed| speed >= half.fast);
            notes.is_doubtful |= is_fast(place.speed) != is_fast(place.slow);
            let is_left_out = is_fast(place.speed) || no_half_rate || place.noise == 0.0 || alone;
            if is_coarse && !is_left_out {
                let second = self.rate(before, place, true, &mut notes).meet(plain);
                rate = match second {
                    // 1x1 is disallowed
                    Rate::R1X1 => {
                        let slack = self.off(before, errors[0]) + self.off(before, errors[1]);
                        // the deterministic path drops two bits of each sum besides
                        notes.is_doubtful |= (errors[0] - errors[1]).abs() <= slack + UNIT;
                        match errors[0] <= errors[1] {
                            true => Rate::R2X1,
                            false => Rate::R1X2,
                        }
                    }
                    second => second,
                };
                if rate != plain {
                    reason = Reason::HalfRate;
                }
            }
        }
        let mut found = Found {
            rate,
            attachment,
            plain,
            reason,
            errors,
            attachment_errors: estimates.last().map_or(errors, |last| last.errors),
            margin: notes.margin,
            is_doubtful: notes.is_doubtful,
        };
        // which of two axes keeps its 4 hangs on their errors
        for (rate, estimate) in [
            (rate, before),
            (attachment, estimates.last().unwrap_or(before)),
        ] {
            if rate == Rate::R4X4 && settings.largest != Rate::R4X4 {
                let [across, down] = estimate.errors;
                let slack = self.off(estimate, across) + self.off(estimate, down) + UNIT;
                found.is_doubtful |= (across - down).abs() <= slack;
            }
        }
        found
    }

    /// What follows once every quad is decided on.
    fn finished(&self, quads: &[Found], attached: &[Found]) -> Exact {
        let (settings, inputs) = (self.settings, self.inputs);
        let [width, height] = inputs.size;
        let layout = SriLayout::new(width, height);
        let side = settings.granularity_of_rates();
        let image = |all: &[Found], of: fn(&Found) -> Rate, errors: fn(&Found) -> [f64; 2]| {
            later::in_blocks(all, layout, settings.largest, of, errors)
        };
        let smoothed = |rates: &[Rate], side: Granularity| {
            later::smoothed(rates, layout, settings.smoothing, side.side() / 2)
        };
        let raw = image(quads, |q| q.rate, |q| q.errors);
        let raw_plain = image(quads, |q| q.plain, |q| q.errors);
        let raw_attachment = image(attached, |q| q.attachment, |q| q.attachment_errors);
        let smooth = smoothed(&raw, side);
        let doubtful_of =
            |all: &[Found]| -> Vec<bool> { all.iter().map(|found| found.is_doubtful).collect() };
        let mut doubtful = doubtful_of(quads);
        let own = later::with_own(&smooth, inputs, settings, &mut doubtful);
        let plain = later::with_own(&smoothed(&raw_plain, side), inputs, settings, &mut doubtful);
        let sri_of = |rates: &[Rate]| {
            Sri::from_fn(width, height, |x, y| {
                rates[(y * layout.width + x) as usize].code()
            })
        };
        let mut reasons = vec![0; layout.bytes() as usize];
        for (at, quad) in quads.iter().enumerate() {
            let (x, y) = (at as u32 % layout.width, at as u32 / layout.width);
            let why = match (own[at] != smooth[at], smooth[at] != raw[at]) {
                (true, _) => Reason::Own,
                (false, true) => Reason::Neighbour,
                (false, false) => quad.reason,
            };
            reasons[(y * layout.pitch + x) as usize] = why as u8;
        }
        Exact {
            output: Output {
                sri: sri_of(&own),
                plain: sri_of(&plain),
                half: settings
                    .half_resolution
                    .map(|kind| later::half(&own, layout, inputs.size, kind)),
                attachment: sri_of(&smoothed(
                    &raw_attachment,
                    settings.granularity_of_attachment(),
                )),
                sqrt_luma: self.sqrt_luma(),
                reasons,
            },
            margins: quads.iter().map(|quad| quad.margin).collect(),
            doubtful,
            attachment_doubtful: doubtful_of(attached),
        }
    }

    fn sqrt_luma(&self) -> Vec<u8> {
        let [width, height] = self.inputs.previous_size;
        let pitch = luma_pitch(width);
        let last = &self.pictures[usize::from(self.settings.transparents)];
        let mut rows = vec![0; (pitch * height) as usize];
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let pixel = last[(y * width + x) as usize];
            let luma = |pixel| light::luma(pixel, &self.settings.content);
            // what has none is white, which hides nothing
            let code = pixel.map_or(255.0, |pixel| (luma(pixel).sqrt() * 255.0).round());
            rows[(y * pitch + x) as usize] = code as u8;
        }
        rows
    }
}
