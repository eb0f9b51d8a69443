//! What a quad or a tile gets, on the deterministic path: the twin of the decisions in `shaders/analyse.wgsl` and `shaders/tiles.wgsl`.
//!
//! Does: for an area (a quad with its window of 4×4 pixels, or a tile with its own pixels), finds doubt, what is flagged, how fast it
//! moves and how shiny it is; then decides by content and motion (Eq. 16 and 22), by transparents and by the extra half rate.
//! Guarantees: any doubt means full rate; no 4 beside a 1.

use super::{
    inputs::{Inputs, flags},
    integer::{Integers, Window},
    motion,
    optics::Optics,
    params::Params,
    past::NoSource,
    reasons::Reason,
    settings::{Blur, Settings},
};
use crate::rate::Rate;

/// Log2 of a rate on both axes.
pub type Logs = [u8; 2];

/// What a decision depends on beside the sums of pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// The least speed, as an index of the table, on each axis.
    pub(super) speed: [u32; 2],
    /// The previous frame's rate here; of a tile, the finest.
    pub(super) previous: Logs,
    /// The quad that is nearest to where one looks: of a quad itself.
    pub(super) gaze: [u32; 2],
    /// The quad that is nearest to the middle: of a quad itself.
    pub(super) inner: [u32; 2],
    /// The most smoothness · Rf0, in 1/65025.
    pub(super) shine: u32,
    /// The most noise, 0 to 255.
    pub(super) noise: u32,
    /// Whether a pixel has no known motion, and counts as standing still.
    pub(super) is_lost: bool,
}

/// A quad on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    pub(super) rate: Logs,
    pub(super) attachment: Logs,
    /// Before the extra half rate.
    pub(super) plain: Logs,
    pub(super) reason: Reason,
    pub(super) error: [f64; 2],
    /// Of the attachment.
    pub(super) attachment_error: [f64; 2],
}

impl Quad {
    pub(super) fn full(reason: Reason) -> Quad {
        Quad {
            rate: [0; 2],
            attachment: [0; 2],
            plain: [0; 2],
            reason,
            error: [0.0; 2],
            attachment_error: [0.0; 2],
        }
    }
}

/// Pixels that are decided on together.
struct Area {
    /// Whose content, motion and doubt count, row by row.
    around: Vec<usize>,
    /// Whose flags, materials and noise count.
    own: Vec<usize>,
    /// The first pixel of each quad.
    quads: Vec<usize>,
    gaze: [u32; 2],
    inner: [u32; 2],
}

pub(super) struct Stage<'a> {
    pub(super) numbers: &'a Integers<'a>,
    pub(super) inputs: &'a Inputs<'a>,
    pub(super) settings: &'a Settings,
    pub(super) params: &'a Params,
    pub(super) sources: &'a [Result<u32, NoSource>],
    pub(super) speeds: Vec<u32>,
    pub(super) optics: Optics,
}

impl Stage<'_> {
    fn pixel(&self, x: i64, y: i64) -> usize {
        let [width, height] = self.inputs.size.map(i64::from);
        (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize
    }

    /// A quad, by its window.
    pub(super) fn quad(&self, quad: [u32; 2]) -> Quad {
        let (left, top) = (i64::from(quad[0]) * 2 - 1, i64::from(quad[1]) * 2 - 1);
        let window: [usize; 16] =
            std::array::from_fn(|i| self.pixel(left + i as i64 % 4, top + i as i64 / 4));
        let area = Area {
            around: window.to_vec(),
            own: [5, 6, 9, 10].map(|i| window[i]).to_vec(),
            quads: vec![window[5]],
            gaze: quad,
            inner: quad,
        };
        self.area(&area, |picture, sources| {
            let sources = std::array::from_fn(|i| sources[i]);
            let corner = [left as u32 & 1, top as u32 & 1];
            self.numbers.window(picture, &sources, corner)
        })
    }

    /// A tile of a side in pixels, by its own pixels.
    pub(super) fn tile(&self, tile: [u32; 2], side: u32) -> Quad {
        let low = tile.map(|at| at * side);
        let extent = [0, 1].map(|axis: usize| side.min(self.inputs.size[axis] - low[axis]));
        let pixels: Vec<usize> = (low[1]..low[1] + extent[1])
            .flat_map(|y| (low[0]..low[0] + extent[0]).map(move |x| (x, y)))
            .map(|(x, y)| self.pixel(i64::from(x), i64::from(y)))
            .collect();
        let width = self.inputs.size[0] as usize;
        let is_even = |&&at: &&usize| [at % width, at / width].iter().all(|side| side & 1 == 0);
        let nearest = |to: [u32; 2]| {
            [0, 1].map(|axis: usize| {
                let first = low[axis] / 2;
                to[axis].clamp(first, first + extent[axis].div_ceil(2) - 1)
            })
        };
        let area = Area {
            quads: pixels.iter().filter(is_even).copied().collect(),
            gaze: nearest(self.params.centre.map(|at| at.max(0) as u32 / 2)),
            inner: nearest(self.inputs.size.map(|side| side / 4)),
            own: pixels.clone(),
            around: pixels,
        };
        self.area(&area, |picture, sources| {
            self.numbers.tile(picture, sources, extent)
        })
    }

    fn area(&self, area: &Area, sums: impl Fn(usize, &[u32]) -> Window) -> Quad {
        let mut sources = Vec::with_capacity(area.around.len());
        for &pixel in &area.around {
            match self.sources[pixel] {
                Ok(from) => sources.push(from),
                Err(reason) => return Quad::full(reason),
            }
        }
        let pictures = if self.settings.transparents { 2 } else { 1 };
        let is_valid = |picture| {
            sources
                .iter()
                .all(|&from| self.numbers.is_valid(picture, from as usize))
        };
        if !(0..pictures).all(is_valid) {
            return Quad::full(Reason::Invalid);
        }
        let flagged = |bit: u8| {
            self.inputs
                .flags
                .is_some_and(|flags| area.own.iter().any(|&p| flags[p] & bit != 0))
        };
        if flagged(flags::FULL) {
            return Quad::full(Reason::Mask);
        }
        let place = self.place(area);
        if self.settings.materials.is_some() && place.shine >= self.params.material_mirror {
            return Quad::full(Reason::Material);
        }
        let sums = [0, 1].map(|picture| (picture < pictures).then(|| sums(picture, &sources)));
        self.decide(&sums, &place, flagged(flags::NO_HALF_RATE))
    }

    fn place(&self, area: &Area) -> Place {
        let around = &area.around;
        let speed = match (self.settings.motion, self.inputs.motion) {
            (Some(_), Some(vectors)) => std::array::from_fn(|axis| {
                let of = |&pixel: &usize| {
                    let fixed = self
                        .inputs
                        .flags
                        .is_some_and(|f| f[pixel] & flags::STATIC != 0);
                    let speed = match fixed {
                        true => 0,
                        false => {
                            motion::speed_index(vectors[pixel][axis], self.params.speed_scale[axis])
                        }
                    };
                    // a later blur of a width hides what motion of that speed does (Eq. 17)
                    let blur = self.inputs.blur.filter(|_| self.settings.later_blur);
                    let lens = self.inputs.depth.filter(|_| self.settings.lens.is_some());
                    speed
                        .max(blur.map_or(0, |blur| motion::speed_index(blur[pixel], 16.0)))
                        .max(lens.map_or(0, |depth| self.optics.blur(depth[pixel])))
                };
                around.iter().map(of).min().unwrap_or_default()
            }),
            _ => [0; 2],
        };
        let is_lost = match (self.settings.motion, self.inputs.motion) {
            (Some(_), Some(vectors)) => around.iter().any(|&pixel| {
                let marks = self.inputs.flags.map_or(0, |flags| flags[pixel]);
                marks & flags::STATIC == 0 && vectors[pixel].iter().any(|c| c.is_nan())
            }),
            _ => false,
        };
        let previous = self.inputs.previous_rates.map_or([0; 2], |rates| {
            let of_quad = area.quads.iter().map(|&pixel| {
                let from = self.source_of(pixel);
                let across = self.params.previous[0];
                let code = rates.code(from % across / 2, from / across / 2);
                logs_of(Rate::from_code_or_full(code))
            });
            let finest = of_quad.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]);
            finest.unwrap_or_default()
        });
        let is_before = self.settings.has_materials_before();
        let shine = self.inputs.materials.map_or(0, |materials| {
            let of = |&pixel: &usize| {
                let surface = match is_before {
                    true => materials[self.source_of(pixel) as usize],
                    false => materials[pixel],
                };
                u32::from(surface[0]) * u32::from(surface[1])
            };
            area.own.iter().map(of).max().unwrap_or_default()
        });
        let noise = self.inputs.noise.map_or(255, |noise| {
            area.own
                .iter()
                .map(|&p| u32::from(noise[p]))
                .max()
                .unwrap_or_default()
        });
        Place {
            speed,
            previous,
            gaze: area.gaze,
            inner: area.inner,
            shine,
            noise,
            is_lost,
        }
    }

    /// The source of a pixel that has one.
    fn source_of(&self, pixel: usize) -> u32 {
        self.sources[pixel].unwrap_or_default()
    }

    pub(super) fn logs(&self, window: &Window, place: &Place, again: bool) -> Logs {
        let largest = self.params.largest_rate().code();
        std::array::from_fn(|axis| {
            if window.is_blind[axis] {
                return 0;
            }
            let below = |log2| self.numbers.is_below(window, axis, log2, place, again);
            let log = u8::from(below(1)) + u8::from(below(1) && below(2));
            log.min(if axis == 0 { largest >> 2 } else { largest & 3 })
        })
    }

    fn decide(&self, sums: &[Option<Window>; 2], place: &Place, no_half_rate: bool) -> Quad {
        let Some(before) = &sums[0] else {
            return Quad::full(Reason::Invalid);
        };
        let motion_only = self.motion_only(place);
        let found =
            |window: &Window| motion_only.unwrap_or_else(|| self.logs(window, place, false));
        let solid = legal(found(before));
        let after = sums[1].as_ref();
        let attachment = after.map_or(solid, |after| legal(found(after)));
        // transparents can make a solid coarser, never finer
        let mut rate: Logs = std::array::from_fn(|axis| solid[axis].max(attachment[axis]));
        let error_of = |window: &Window| [0, 1].map(|axis| self.numbers.error(window, axis));
        let error = error_of(before);
        let plain = rate;
        let is_fast = (0..2).all(|axis| place.speed[axis] >= self.params.half_fast);
        let mut reason = match (rate == logs_cap(self.params), motion_only) {
            (true, _) => Reason::None,
            (false, _) if place.is_lost => Reason::NoMotion,
            (false, None) => Reason::Content,
            (false, Some(_)) => Reason::Motion,
        };
        let again = self.settings.half_rate.is_some()
            && rate.iter().all(|&log| log >= 1)
            && !is_fast
            && !no_half_rate
            && place.noise > 0
            && motion_only.is_none();
        if again {
            let second = half_rate(rate, self.logs(before, place, true), || {
                error[0] <= error[1]
            });
            if second != rate {
                reason = Reason::HalfRate;
            }
            rate = second;
        }
        Quad {
            rate,
            attachment,
            plain,
            reason,
            error,
            attachment_error: after.map_or(error, error_of),
        }
    }

    pub(super) fn motion_only(&self, place: &Place) -> Option<Logs> {
        let motion = self.settings.motion?;
        let entry = |axis: usize| self.speeds[place.speed[axis] as usize];
        let logs = match motion.blur {
            Blur::Scaled | Blur::Linear => return None,
            Blur::Standalone { .. } => [0, 1].map(|axis| {
                let entry = entry(axis);
                (entry & 1) as u8 + ((entry & 1) & (entry >> 16)) as u8
            }),
            Blur::Ladder(_) => {
                let step = entry(0).max(entry(1)) & 0xffff;
                logs_of(motion::LADDER[step.min(4) as usize])
            }
        };
        let largest = self.params.largest_rate().code();
        Some([logs[0].min(largest >> 2), logs[1].min(largest & 3)])
    }
}

fn logs_of(rate: Rate) -> Logs {
    rate.log2().map(|log| log as u8)
}

/// The coarsest rate.
pub(super) fn logs_cap(params: &Params) -> Logs {
    logs_of(params.largest_rate())
}

/// No 4 beside a 1.
pub fn legal([x, y]: Logs) -> Logs {
    [
        if y == 0 { x.min(1) } else { x },
        if x == 0 { y.min(1) } else { y },
    ]
}

/// The extra half rate's rule: what was coarse on both axes takes the second look's rate where that is finer, and stays coarse
/// on the axis of the smaller error if the second look would have neither.
pub fn half_rate(rate: Logs, second: Logs, is_flatter_across: impl FnOnce() -> bool) -> Logs {
    let met = legal([rate[0].min(second[0]), rate[1].min(second[1])]);
    match met {
        [0, 0] if is_flatter_across() => [1, 0],
        [0, 0] => [0, 1],
        met => met,
    }
}
