//! The integer twin: the deterministic path on the CPU, bit for bit what `shaders/analyse.wgsl` makes.
//!
//! *Guarantees*: within 1 % of a threshold it may differ from the [exact](super::exact) stage; elsewhere not.

use super::{
    decide::Place,
    fixed::{self, FACTOR_ONE, Mag, ONE},
    inputs::{Colour, Inputs, Output, WrongInput},
    params::{self, Params, TABLE_FALLOFF, TABLE_SPEEDS},
    pipeline,
    settings::{Difference, Form, Norm, Pairs, Settings},
};

/// Runs the deterministic path.
///
/// # Errors
/// If inputs have the wrong size or are missing.
pub fn analyse(inputs: &Inputs, settings: &Settings) -> Result<Output, WrongInput> {
    pipeline::check(inputs, settings)?;
    let params = Params::new(settings, &inputs.frame());
    let numbers = Integers::new(inputs, settings, &params);
    Ok(pipeline::run(&numbers, inputs, settings, &params))
}

/// A pixel: its luma and channels.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    luma: u32,
    channels: [u32; 3],
}

/// The arithmetic of the deterministic path.
pub(super) struct Integers<'a> {
    settings: &'a Settings,
    params: &'a Params,
    tables: Vec<u32>,
    pictures: [Vec<Option<Pixel>>; 2],
}

/// What the pixels of a quad's window, or of a tile, sum to: in units of a window's pairs and of its sixteen lumas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    errors: [u32; 2],
    luma: u32,
    /// How many pairs there are on each axis.
    pub(super) pairs: [u32; 2],
    /// Whether an axis has pixels to be shaded together, and no pair that tells of them.
    pub(super) is_blind: [bool; 2],
}

/// A share of a value, in 1/65536, rounded up.
pub(super) fn share_above(value: u32, weight: u32) -> u32 {
    (value >> 16) * weight + (((value & 0xffff) * weight + 0xffff) >> 16)
}

impl<'a> Integers<'a> {
    fn new(inputs: &Inputs, settings: &'a Settings, params: &'a Params) -> Integers<'a> {
        let is_sqrt = matches!(inputs.colour, Colour::SqrtLuma(_));
        let tables = params::tables(settings, is_sqrt, inputs.resolution_scale);
        let load = |colour: Colour| load(colour, &tables, settings, params.white_log2);
        let before = load(inputs.colour);
        let after = inputs.after.map_or_else(Vec::new, load);
        Integers {
            settings,
            params,
            tables,
            pictures: [before, after],
        }
    }

    fn difference(&self, a: Pixel, b: Pixel) -> u32 {
        let channels: [u32; 3] = std::array::from_fn(|c| a.channels[c].abs_diff(b.channels[c]));
        match self.settings.content.difference {
            Difference::Luma => a.luma.abs_diff(b.luma),
            Difference::LargestChannel => channels.into_iter().max().unwrap_or_default(),
            Difference::Rgb => fixed::luma(channels, self.settings.content.weights.fixed()),
        }
    }

    fn tolerance(&self, place: &Place, again: bool) -> u32 {
        let params = self.params;
        let mut tolerance = params.tolerance;
        let mut scale = |by: u32| tolerance = ((tolerance * by) >> 12).min(0xffff);
        if self.settings.safe_area.is_some() {
            let is_border = |axis: usize| {
                let at = place.inner[axis] * 2;
                at < params.safe_width || at + params.safe_width >= params.size[axis]
            };
            scale(if is_border(0) || is_border(1) {
                params.safe_tolerance
            } else {
                FACTOR_ONE
            });
        }
        if self.settings.foveation.is_some() {
            let d = [0, 1].map(|axis: usize| {
                (place.gaze[axis] as i32 * 2 - params.centre[axis]).unsigned_abs()
            });
            let index = fixed::mul_high(d[0] * d[0] + d[1] * d[1], params.falloff_scale);
            scale(self.tables[TABLE_FALLOFF + index.min(params::FALLOFF as u32 - 1) as usize]);
        }
        if self.settings.materials.is_some() {
            scale(material(place, params));
        }
        if again {
            // where there is half the noise there is half the reduction
            let less = (FACTOR_ONE - params.half_tolerance) * place.noise / 255;
            scale(FACTOR_ONE - less);
        }
        tolerance
    }
}

/// The tolerance of a material in motion: linear in smoothness · Rf0, and in speed up to the speed at which it does not matter.
pub(super) fn material(place: &Place, params: &Params) -> u32 {
    let speed = place.speed[0].max(place.speed[1]);
    if speed >= params.material_slow {
        return FACTOR_ONE;
    }
    let most = (FACTOR_ONE - params.material_least) * (place.shine >> 4) / 4064;
    let slow = most * (params.material_slow - speed) / params.material_slow;
    FACTOR_ONE - slow.min(FACTOR_ONE)
}

fn load(
    colour: Colour,
    tables: &[u32],
    settings: &Settings,
    white_log2: i32,
) -> Vec<Option<Pixel>> {
    let pixel = |channels: [u32; 3]| Pixel {
        luma: fixed::luma(channels, settings.content.weights.fixed()),
        channels,
    };
    match colour {
        Colour::Codes(codes) => codes
            .iter()
            .map(|code| Some(pixel(std::array::from_fn(|c| tables[usize::from(code[c])]))))
            .collect(),
        Colour::Linear(values) => values
            .iter()
            .map(|value| {
                let quantised = |c: usize| fixed::quantise(value[c], white_log2);
                Some(pixel([quantised(0)?, quantised(1)?, quantised(2)?]))
            })
            .collect(),
        Colour::SqrtLuma(codes) => codes
            .iter()
            .map(|&code| Some(tables[usize::from(code)]))
            .map(|luma| {
                luma.map(|luma| Pixel {
                    luma,
                    channels: [luma; 3],
                })
            })
            .collect(),
    }
}

/// What brings both sides of [`Norm::Root`]'s comparison to one unit, as a power of two: relative differences have four bits less
/// than lumas, and their threshold, which is squared, as well.
pub(super) fn root_shift(form: Form) -> i32 {
    match form {
        Form::Pairwise { .. } => 65,
        Form::Window | Form::Absolute => 69,
    }
}

fn weighted([a, b, c]: [Pixel; 3]) -> Pixel {
    Pixel {
        luma: a.luma + 2 * b.luma + c.luma,
        channels: std::array::from_fn(|i| a.channels[i] + 2 * b.channels[i] + c.channels[i]),
    }
}

/// The pairs of a window on an axis: indices of the two pixels, by the pairs' choice. `corner` is the parity of the window's
/// upper left pixel.
pub(super) fn pairs(
    pairs: Pairs,
    axis: usize,
    corner: [u32; 2],
) -> impl Iterator<Item = (usize, usize)> {
    (0..16usize).filter_map(move |i| {
        let (x, y) = (i % 4, i / 4);
        let along = if axis == 0 { x } else { y };
        if along == 3 {
            return None;
        }
        let (px, py) = (x as u32 + corner[0], y as u32 + corner[1]);
        let is_taken = match pairs {
            Pairs::All => true,
            Pairs::Interleaved => (px + py) & 1 == axis as u32,
            Pairs::SubSampled => px & 1 == 0 && py & 1 == 0,
            Pairs::Quad => along == 1 && (1..=2).contains(&if axis == 0 { y } else { x }),
            Pairs::Sobel => false,
        };
        is_taken.then(|| (i, i + if axis == 0 { 1 } else { 4 }))
    })
}

/// How many pairs there are on an axis.
pub(crate) fn count(pairs: Pairs) -> u32 {
    match pairs {
        Pairs::All => 12,
        Pairs::Interleaved => 6,
        Pairs::SubSampled | Pairs::Quad => 2,
        Pairs::Sobel => 4,
    }
}

/// Sobel's pixels before and after each of the quad's own on an axis; the middle one of three counts twice.
fn sobel(axis: usize) -> [[[usize; 3]; 2]; 4] {
    let (along, across) = if axis == 0 { (1, 4) } else { (4, 1) };
    [5usize, 6, 9, 10].map(|own| {
        [own - along, own + along].map(|middle| [middle - across, middle, middle + across])
    })
}

impl Integers<'_> {
    /// What a pair counts for, given its difference and the lesser luma.
    fn weighed(&self, d: u32, least: u32, sensitivity: u32) -> u32 {
        match (self.settings.content.form, d, least + sensitivity) {
            (Form::Window | Form::Absolute, ..) => d,
            (Form::Pairwise { .. }, 0, _) => 0,
            (Form::Pairwise { .. }, _, 0) => 16_383,
            (Form::Pairwise { .. }, d, base) => (d << 10).div_ceil(base).min(16_383),
        }
    }

    /// GDC: BS = C (1 - saturate(50 L - 2.5)), by the darkest of some pixels.
    fn sensitivity(&self, pixels: impl Iterator<Item = Pixel>) -> u32 {
        let darkest = pixels.map(|p| p.luma).min().unwrap_or_default();
        let ramp = (50 * darkest).saturating_sub(5 * ONE / 2).min(ONE);
        (self.params.sensitivity * (ONE - ramp)) >> 14
    }

    fn pixel(&self, picture: usize, from: u32) -> Pixel {
        self.pictures[picture][from as usize].unwrap_or(Pixel {
            luma: 0,
            channels: [0; 3],
        })
    }

    /// Sums a quad's window of the picture before (0) or after (1) transparents, given the 16 sources and the parity of the first pixel's place.
    pub(super) fn window(&self, picture: usize, sources: &[u32; 16], corner: [u32; 2]) -> Window {
        let pixels = sources.map(|from| self.pixel(picture, from));
        let content = &self.settings.content;
        let sensitivity = self.sensitivity(pixels.iter().copied());
        let errors = std::array::from_fn(|axis| {
            let mut sum = 0;
            let mut join = |d: u32, least: u32| {
                let d = self.weighed(d, least, sensitivity);
                match content.norm {
                    Norm::L1 | Norm::Root => sum += d,
                    Norm::L2 => sum += d * d,
                    Norm::LInf => sum = sum.max(d),
                }
            };
            for (a, b) in pairs(content.pairs, axis, corner) {
                let (a, b) = (pixels[a], pixels[b]);
                join(self.difference(a, b), a.luma.min(b.luma));
            }
            if content.pairs == Pairs::Sobel {
                for sides in sobel(axis) {
                    let [a, b] = sides.map(|side| weighted(side.map(|i| pixels[i])));
                    // eight steps from pixel to pixel
                    let d = self.difference(a, b).div_ceil(8);
                    join(d, a.luma.min(b.luma) >> 2);
                }
            }
            sum
        });
        Window {
            errors,
            luma: pixels.iter().map(|p| p.luma).sum(),
            pairs: [count(content.pairs); 2],
            is_blind: [false; 2],
        }
    }

    /// The same of a tile's own pixels, row by row; the tile starts at even places.
    pub(super) fn tile(
        &self,
        picture: usize,
        sources: &[u32],
        [width, height]: [u32; 2],
    ) -> Window {
        let content = &self.settings.content;
        let pixels: Vec<Pixel> = sources
            .iter()
            .map(|&from| self.pixel(picture, from))
            .collect();
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize];
        let (mut sums, mut most, mut counts) = ([0u64; 2], [0u32; 2], [0u32; 2]);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            // the pixels that the pairs of a quad are of
            let (left, top) = (x & !1, y & !1);
            let around = (top..(top + 3).min(height))
                .flat_map(|y| (left..(left + 3).min(width)).map(move |x| at(x, y)));
            let sensitivity = self.sensitivity(around);
            for axis in 0..2 {
                let (along, end) = if axis == 0 { (x, width) } else { (y, height) };
                let is_taken = match content.pairs {
                    Pairs::All => true,
                    Pairs::Interleaved => (x + y) & 1 == axis as u32,
                    Pairs::SubSampled => x & 1 == 0 && y & 1 == 0,
                    Pairs::Quad => along & 1 == 0,
                    Pairs::Sobel => false,
                };
                let found = match content.pairs {
                    Pairs::Sobel => {
                        let is_inside = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
                        is_inside.then(|| {
                            let side = |d: [i64; 2]| {
                                let middle = [i64::from(x) + d[0], i64::from(y) + d[1]];
                                weighted([-1i64, 0, 1].map(|i| {
                                    let step = if axis == 0 { [0, i] } else { [i, 0] };
                                    at((middle[0] + step[0]) as u32, (middle[1] + step[1]) as u32)
                                }))
                            };
                            let d = if axis == 0 { [1, 0] } else { [0, 1] };
                            let (a, b) = (side([-d[0], -d[1]]), side(d));
                            (self.difference(a, b).div_ceil(8), a.luma.min(b.luma) >> 2)
                        })
                    }
                    _ => (is_taken && along + 1 < end).then(|| {
                        let (a, b) = (
                            at(x, y),
                            if axis == 0 {
                                at(x + 1, y)
                            } else {
                                at(x, y + 1)
                            },
                        );
                        (self.difference(a, b), a.luma.min(b.luma))
                    }),
                };
                let Some((d, least)) = found else { continue };
                let d = self.weighed(d, least, sensitivity);
                counts[axis] += 1;
                most[axis] = most[axis].max(d);
                sums[axis] += match content.norm {
                    Norm::L2 => u64::from(d) * u64::from(d),
                    Norm::L1 | Norm::Root | Norm::LInf => u64::from(d),
                };
            }
        }
        let in_window = u64::from(count(content.pairs));
        let light: u32 = pixels.iter().map(|p| p.luma).sum();
        Window {
            errors: [0, 1].map(|axis: usize| match content.norm {
                Norm::LInf => most[axis],
                // rounded up
                _ => (sums[axis] * in_window).div_ceil(u64::from(counts[axis].max(1))) as u32,
            }),
            // rounded down: to a lower threshold
            luma: light * 16 / (width * height),
            pairs: counts,
            is_blind: [0, 1].map(|axis: usize| counts[axis] == 0 && [width, height][axis] > 1),
        }
    }

    /// Whether the error of a rate of 2^`log2` on an axis is surely below the threshold; `again` for the second look.
    pub(super) fn is_below(
        &self,
        window: &Window,
        axis: usize,
        log2: u8,
        place: &Place,
        again: bool,
    ) -> bool {
        let params = self.params;
        let content = &self.settings.content;
        let entry = TABLE_SPEEDS + 2 * place.speed[axis] as usize + usize::from(log2 > 1);
        let reach = match log2 {
            1 => params.reach_half,
            _ => params.reach_quarter,
        };
        let reach = Mag::unpacked(reach[usize::from(place.previous[axis].min(2))]);
        let base = Mag::below(match content.form {
            Form::Window => window.luma + 16 * params.ambient,
            Form::Pairwise { .. } => ONE,
            Form::Absolute => 16 * ONE,
        });
        let base = match content.norm {
            Norm::L1 | Norm::LInf => base,
            Norm::L2 | Norm::Root => base.times_below(base),
        };
        let entry = Mag::unpacked(self.tables[entry]);
        let limit = match params::has_fixed_limits(self.settings) {
            true => entry,
            false => params::limit(reach, self.tolerance(place, again), content).times_below(entry),
        };
        Mag::whole(window.errors[axis]).is_less(base.product(limit))
    }

    /// Windows blended, each with its share in 1/65536; errors are rounded up.
    pub(super) fn blend(&self, windows: &[(&Window, u32)]) -> Window {
        let errors = std::array::from_fn(|axis| {
            let all = windows.iter();
            all.map(|&(window, weight)| share_above(window.errors[axis], weight))
                .sum()
        });
        Window {
            errors,
            luma: windows
                .iter()
                .map(|&(window, weight)| (window.luma * (weight >> 4)) >> 12)
                .sum(),
            pairs: [count(self.settings.content.pairs); 2],
            is_blind: [false; 2],
        }
    }

    /// The error on an axis, up to a factor that all share.
    pub(super) fn error(&self, window: &Window, axis: usize) -> f64 {
        // a quarter, as the kernel sums four of them in 32 bits
        f64::from(window.errors[axis] >> 2)
    }

    /// √luma of a pixel of the previous picture.
    pub(super) fn sqrt_luma(&self, pixel: usize) -> u8 {
        let last = &self.pictures[usize::from(self.settings.transparents)];
        // what has no luma is white: it is at full rate as long as it is looked at, and white does not hide
        last[pixel].map_or(255, |p| fixed::sqrt_code(p.luma) as u8)
    }

    /// Whether a pixel of a picture has a luma.
    pub(super) fn is_valid(&self, picture: usize, pixel: usize) -> bool {
        self.pictures[picture][pixel].is_some()
    }
}
