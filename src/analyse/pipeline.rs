//! The stage's steps, in order, for both CPU twins: what they share is which pixel is looked at, which decision follows
//! which, and the lattice of rates. What they do not share is arithmetic: [`Numbers`].
//!
//! 1. Each pixel's source in the previous picture ([`source`]); outside or hidden means doubt.
//! 2. Each quad's window of 4×4 pixels, the quad in its middle; at the border, pixels repeat.
//! 3. The rate by content and motion (Eq. 16 and 22), under the tolerance of the place.
//! 4. Transparents; the extra half rate; the mask.
//! 5. Rates of 4 hold for aligned blocks of 4×4 pixels (`agree`); 4x4 becomes 2x4 or 4x2.
//! 6. Smoothing.
//! 7. The application's own rates; then those of half the resolution.
//!
//! *Guarantees*: any doubt means full rate; 4x1 and 1x4 never come out.

use super::{
    fixed,
    inputs::{Inputs, Output, WrongInput, flags},
    motion,
    optics::Optics,
    params::{self, Params},
    reasons::Reason,
    settings::{Blur, Settings, Smoothing, Stability},
};
use crate::{
    rate::Rate,
    sri::{Sri, SriLayout},
};

/// Log2 of a rate on both axes.
pub type Logs = [u8; 2];

/// What a quad's decision depends on beside its window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// The least speed of the window, as an index of the table, on each axis.
    pub speed: [u32; 2],
    /// The previous frame's rate here.
    pub previous: Logs,
    /// The quad.
    pub quad: [u32; 2],
    /// The most smoothness · Rf0 of the quad, in 1/65025.
    pub shine: u32,
    /// The most noise of the quad, 0 to 255.
    pub noise: u32,
    /// Whether a pixel of the window has no known motion, and counts as standing still.
    pub is_lost: bool,
}

/// One twin's arithmetic.
pub trait Numbers {
    /// What is summed over a window.
    type Window;
    /// Sums a window of the picture before (0) or after (1) transparents, given the 16 sources.
    fn window(&self, picture: usize, sources: &[u32; 16], corner: [u32; 2]) -> Self::Window;
    /// Whether the error of a rate of 2^`log2` on an axis is surely below the threshold; `again` for the second look.
    fn is_below(
        &self,
        window: &Self::Window,
        axis: usize,
        log2: u8,
        place: &Place,
        again: bool,
    ) -> bool;
    /// The mean of a tile's windows.
    fn mean(&self, windows: &[Self::Window]) -> Self::Window;
    /// Windows blended, each with its share in 1/65536.
    fn blend(&self, windows: &[(&Self::Window, u32)]) -> Self::Window;
    /// The error on an axis, up to a factor that all windows share.
    fn error(&self, window: &Self::Window, axis: usize) -> f64;
    /// Whether the error across is at most that down.
    fn is_flatter_across(&self, window: &Self::Window, _place: &Place) -> bool {
        self.error(window, 0) <= self.error(window, 1)
    }
    /// √luma of a pixel of the previous picture.
    fn sqrt_luma(&self, pixel: usize) -> u8;
    /// Whether a pixel of a picture has a luma.
    fn is_valid(&self, picture: usize, pixel: usize) -> bool;
}

/// Why a pixel has no source.
type NoSource = Reason;

/// The pixel of the previous picture that a pixel shows (§5.1): along its motion vector, in normalised coordinates, so that
/// both may have any size. Positions are in 1/256 pixel; the source is the pixel that the position falls into.
pub fn source(
    x: u32,
    y: u32,
    inputs: &Inputs,
    settings: &Settings,
    params: &Params,
) -> Result<u32, NoSource> {
    let at = (y * inputs.size[0] + x) as usize;
    let mut position: [i32; 2] = std::array::from_fn(|axis| {
        let centre = [x, y][axis] * 256 + 128;
        fixed::mul_high(centre << 8, params.ratio[axis]) as i32
    });
    if let (Some(_), Some(motion)) = (settings.reprojection, inputs.motion) {
        if motion[at].iter().any(|component| component.is_nan()) {
            return Err(Reason::NoMotion);
        }
        for (axis, position) in position.iter_mut().enumerate() {
            let offset = motion[at][axis] * params.offset_scale[axis];
            // a magnitude below 2^23 surely is a number that fits
            if offset.to_bits() & 0x7fff_ffff >= 0x4b00_0000 {
                return Err(Reason::OffScreen);
            }
            // halves, so that rounding adds no floats, which a driver might fuse
            *position += (offset.floor() as i32 + 1) >> 1;
        }
        let inside = (0..2).all(|axis| {
            position[axis] >= 0 && (position[axis] >> 8) < params.previous[axis] as i32
        });
        if !inside {
            return Err(Reason::OffScreen);
        }
        let from =
            ((position[1] >> 8) as u32 * params.previous[0] + (position[0] >> 8) as u32) as usize;
        let before = inputs.previous_depth.filter(|_| settings.tests_depth());
        if let (Some(depth), Some(before)) = (inputs.depth, before) {
            let now = params::inverse_depth(depth[at], params);
            let then = params::inverse_depth(before[from], params);
            match (now, then) {
                (Some(now), Some(then)) if !params::is_hidden(now, then, params) => {}
                _ => return Err(Reason::Disoccluded),
            }
        }
    }
    let [px, py] = [0, 1]
        .map(|axis: usize| ((position[axis] >> 8).max(0) as u32).min(params.previous[axis] - 1));
    Ok(py * params.previous[0] + px)
}

fn check(inputs: &Inputs, settings: &Settings) -> Result<(), WrongInput> {
    inputs.check()?;
    let own = settings.own.clone().unwrap_or_default();
    let needs = [
        (
            settings.motion.is_some() || settings.reprojection.is_some(),
            inputs.motion.is_some() || inputs.cameras.is_some() && inputs.depth.is_some(),
            "motion vectors",
        ),
        (
            settings.lens.is_some(),
            inputs.depth.is_some() && settings.motion.is_some(),
            "depth and motion for the lens",
        ),
        (
            settings.later_blur,
            inputs.blur.is_some() && settings.motion.is_some(),
            "the later blur's width and motion vectors",
        ),
        (
            settings.materials.is_some(),
            inputs.materials.is_some(),
            "materials",
        ),
        (
            settings.transparents,
            inputs.after.is_some(),
            "the colour after transparents",
        ),
        (
            settings.stability != Stability::None,
            inputs.previous_rates.is_some(),
            "the previous frame's rates",
        ),
        (own.ids.is_some(), inputs.ids.is_some(), "ids"),
        (own.distance.is_some(), inputs.depth.is_some(), "depth"),
        (own.particles.is_some(), inputs.flags.is_some(), "flags"),
    ];
    match needs.into_iter().find(|&(needed, had, _)| needed && !had) {
        Some((_, _, name)) => Err(WrongInput::Missing(name)),
        None => Ok(()),
    }
}

/// The motion of a scene that has no vectors: its cameras', but for what does not move with the world.
fn camera_vectors(inputs: &Inputs, settings: &Settings) -> Option<Vec<[f32; 2]>> {
    let (None, Some(cameras), Some(depth), Some(_)) =
        (inputs.motion, inputs.cameras, inputs.depth, settings.motion)
    else {
        return None;
    };
    let mut vectors =
        super::reproject::camera_motions(inputs.size, depth, &cameras.now, &cameras.before);
    for (vector, mark) in vectors.iter_mut().zip(inputs.flags.unwrap_or_default()) {
        if mark & flags::STATIC != 0 {
            *vector = [0.0; 2];
        }
    }
    Some(vectors)
}

/// Runs the stage.
///
/// # Errors
/// If inputs have the wrong size or are missing.
pub fn run<N: Numbers>(
    numbers: &N,
    inputs: &Inputs,
    settings: &Settings,
    params: &Params,
) -> Result<Output, WrongInput> {
    check(inputs, settings)?;
    if let (true, Some(effect)) = (settings.is_by_tiles(), settings.first_by_pixel()) {
        return Err(WrongInput::ByTiles(effect));
    }
    if let (true, Some(effect)) = (settings.is_by_motion_alone(), settings.first_of_content()) {
        return Err(WrongInput::MotionAlone(effect));
    }
    let vectors = camera_vectors(inputs, settings);
    let inputs = &Inputs {
        motion: inputs.motion.or(vectors.as_deref()),
        ..*inputs
    };
    let [width, height] = inputs.size;
    let layout = SriLayout::new(width, height);
    let sources: Vec<Result<u32, NoSource>> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| source(x, y, inputs, settings, params))
        .collect();
    let content = &settings.content;
    let speeds = motion::table(
        settings.motion.map(|motion| motion.blur),
        content.threshold,
        content.k,
    );
    let stage = Stage {
        numbers,
        inputs,
        settings,
        params,
        sources: &sources,
        speeds,
        optics: Optics::new(settings, &inputs.frame()),
    };
    let mut quads = vec![Quad::full(Reason::NoHistory); (layout.width * layout.height) as usize];
    if inputs.has_history && settings.is_by_tiles() {
        stage.tiles(&mut quads, layout.width);
    } else if inputs.has_history {
        for (index, quad) in quads.iter_mut().enumerate() {
            *quad = stage.quad([index as u32 % layout.width, index as u32 / layout.width]);
        }
    }
    let block = |quads: &[Quad], x: u32, y: u32| -> [Option<Quad>; 4] {
        std::array::from_fn(|i| {
            let (qx, qy) = (x + i as u32 % 2, y + i as u32 / 2);
            (qx < layout.width && qy < layout.height)
                .then(|| quads[(qy * layout.width + qx) as usize])
        })
    };
    for y in (0..layout.height).step_by(2) {
        for x in (0..layout.width).step_by(2) {
            let four = block(&quads, x, y);
            let agreed = agree(four.map(|q| q.map(|q| q.rate)), &four, settings.largest);
            let after = agree(
                four.map(|q| q.map(|q| q.attachment)),
                &four,
                settings.largest,
            );
            let plain = agree(four.map(|q| q.map(|q| q.plain)), &four, settings.largest);
            for i in 0..4 {
                if four[i].is_some() {
                    let at = ((y + i as u32 / 2) * layout.width + x + i as u32 % 2) as usize;
                    quads[at].rate = agreed[i];
                    quads[at].attachment = after[i];
                    quads[at].plain = plain[i];
                }
            }
        }
    }
    let image = |of: fn(&Quad) -> Logs| {
        Sri::from_fn(width, height, |x, y| {
            code(of(&quads[(y * layout.width + x) as usize]))
        })
    };
    let mut reasons = vec![0; layout.bytes() as usize];
    for (index, quad) in quads.iter().enumerate() {
        let (x, y) = (index as u32 % layout.width, index as u32 / layout.width);
        reasons[(y * layout.pitch + x) as usize] = quad.reason as u8;
    }
    let sri = super::smoothing::smooth(&image(|q| q.rate), inputs.size, settings.smoothing);
    if settings.smoothing != Smoothing::None {
        for (at, reason) in reasons.iter_mut().enumerate() {
            let (x, y) = (at as u32 % layout.pitch, at as u32 / layout.pitch);
            if x < layout.width
                && sri.code(x, y) != code(quads[(y * layout.width + x) as usize].rate)
            {
                *reason = Reason::Neighbour as u8;
            }
        }
    }
    // a stage by tiles looks at no flags itself
    let by_tiles = settings.is_by_tiles().then(super::OwnRates::default);
    let own = settings.own.clone().or(by_tiles);
    let sri = match &own {
        Some(own) => super::own::combine(&sri, own, settings.largest, inputs, &mut reasons),
        None => sri,
    };
    let plain = super::smoothing::smooth(&image(|q| q.plain), inputs.size, settings.smoothing);
    let plain = match &own {
        Some(own) => super::own::combine(&plain, own, settings.largest, inputs, &mut []),
        None => plain,
    };
    let half = settings
        .half_resolution
        .map(|kind| super::half::half(&sri, inputs.size, kind));
    let [pw, ph] = inputs.previous_size;
    let pitch = params::luma_pitch(pw);
    let mut sqrt_luma = vec![0; (pitch * ph) as usize];
    for y in 0..ph {
        for x in 0..pw {
            sqrt_luma[(y * pitch + x) as usize] = numbers.sqrt_luma((y * pw + x) as usize);
        }
    }
    Ok(Output {
        sri,
        plain,
        half,
        attachment: super::smoothing::smooth(
            &image(|q| q.attachment),
            inputs.size,
            settings.smoothing,
        ),
        sqrt_luma,
        reasons,
    })
}

/// The code of a rate given by its logs; 4x1 and 1x4 become 2x1 and 1x2.
pub fn code([x, y]: Logs) -> u8 {
    Rate::from_code(x << 2 | y).map_or(x.min(1) << 2 | y.min(1), Rate::code)
}

/// A quad on its way.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    rate: Logs,
    attachment: Logs,
    /// Before the extra half rate.
    plain: Logs,
    reason: Reason,
    error: [f64; 2],
}

impl Quad {
    fn full(reason: Reason) -> Quad {
        Quad {
            rate: [0; 2],
            attachment: [0; 2],
            plain: [0; 2],
            reason,
            error: [0.0; 2],
        }
    }
}

/// Rates of 4 hold where all four quads of the aligned block have them; 4x4 keeps 4 on the axis of the smaller error
/// unless it is allowed. Quads outside the picture agree to nothing.
fn agree(four: [Option<Logs>; 4], quads: &[Option<Quad>; 4], largest: Rate) -> [Logs; 4] {
    let logs = four.map(Option::unwrap_or_default);
    let mut x = logs.iter().all(|l| l[0] == 2 && l[1] >= 1);
    let mut y = logs.iter().all(|l| l[1] == 2 && l[0] >= 1);
    if x && y && largest != Rate::R4X4 {
        let sum = |axis: usize| -> f64 { quads.iter().flatten().map(|q| q.error[axis]).sum() };
        // the axis of the larger error is the finer (GDC; NVIDIA's sample: 2x4 where dx > dy)
        x = sum(0) <= sum(1);
        y = !x;
    }
    let cap = |log: u8, is_four: bool| if is_four { log } else { log.min(1) };
    let mut out = logs.map(|[a, b]| [cap(a, x), cap(b, y)]);
    if x && y {
        out = [[2, 2]; 4];
    }
    out
}

struct Stage<'a, N> {
    numbers: &'a N,
    inputs: &'a Inputs<'a>,
    settings: &'a Settings,
    params: &'a Params,
    sources: &'a [Result<u32, NoSource>],
    speeds: Vec<u32>,
    optics: Optics,
}

impl<N: Numbers> Stage<'_, N> {
    fn pixel(&self, x: i64, y: i64) -> usize {
        let [width, height] = self.inputs.size.map(i64::from);
        (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize
    }

    fn quad(&self, quad: [u32; 2]) -> Quad {
        let (left, top) = (i64::from(quad[0]) * 2 - 1, i64::from(quad[1]) * 2 - 1);
        let window: [usize; 16] =
            std::array::from_fn(|i| self.pixel(left + i as i64 % 4, top + i as i64 / 4));
        let mut sources = [0; 16];
        for (slot, &pixel) in sources.iter_mut().zip(&window) {
            match self.sources[pixel] {
                Ok(from) => *slot = from,
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
        let own = [5, 6, 9, 10].map(|i| window[i]);
        let flagged = |bit: u8| {
            self.inputs
                .flags
                .is_some_and(|flags| own.iter().any(|&p| flags[p] & bit != 0))
        };
        if flagged(flags::FULL) {
            return Quad::full(Reason::Mask);
        }
        let place = self.place(quad, &window, &own, sources[5]);
        if self.settings.materials.is_some() && place.shine >= self.params.material_mirror {
            return Quad::full(Reason::Material);
        }
        let sums: [Option<N::Window>; 2] = std::array::from_fn(|picture| {
            (picture < pictures).then(|| {
                self.numbers
                    .window(picture, &sources, [left as u32 & 1, top as u32 & 1])
            })
        });
        self.decide(&sums, &place, flagged(flags::NO_HALF_RATE))
    }

    fn place(&self, quad: [u32; 2], window: &[usize; 16], own: &[usize; 4], from: u32) -> Place {
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
                window.iter().map(of).min().unwrap_or_default()
            }),
            _ => [0; 2],
        };
        let is_lost = match (self.settings.motion, self.inputs.motion) {
            (Some(_), Some(vectors)) => window.iter().any(|&pixel| {
                let marks = self.inputs.flags.map_or(0, |flags| flags[pixel]);
                marks & flags::STATIC == 0 && vectors[pixel].iter().any(|c| c.is_nan())
            }),
            _ => false,
        };
        let previous = self.inputs.previous_rates.map_or(0, |rates| {
            let (x, y) = (
                from % self.params.previous[0],
                from / self.params.previous[0],
            );
            Rate::from_code_or_full(rates.code(x / 2, y / 2)).code()
        });
        let shine = self.inputs.materials.map_or(0, |materials| {
            own.iter()
                .map(|&p| u32::from(materials[p][0]) * u32::from(materials[p][1]))
                .max()
                .unwrap_or_default()
        });
        let noise = self.inputs.noise.map_or(255, |noise| {
            own.iter()
                .map(|&p| u32::from(noise[p]))
                .max()
                .unwrap_or_default()
        });
        Place {
            speed,
            previous: [previous >> 2, previous & 3],
            quad,
            shine,
            noise,
            is_lost,
        }
    }

    fn logs(&self, window: &N::Window, place: &Place, again: bool) -> Logs {
        let largest = self.params.largest_rate().code();
        std::array::from_fn(|axis| {
            let below = |log2| self.numbers.is_below(window, axis, log2, place, again);
            let log = u8::from(below(1)) + u8::from(below(1) && below(2));
            log.min(if axis == 0 { largest >> 2 } else { largest & 3 })
        })
    }

    /// The quads of all tiles: see [`tiles`](super::tiles).
    fn tiles(&self, quads: &mut [Quad], across: u32) {
        let data = super::tiles::data(self.numbers, self.inputs);
        let [wide, high] = self
            .inputs
            .size
            .map(|side| side.div_ceil(super::tiles::SIDE));
        for tile in (0..high).flat_map(|y| (0..wide).map(move |x| [x, y])) {
            let logs = |window: &N::Window, place: &Place| self.logs(window, place, false);
            let (inputs, params) = (self.inputs, self.params);
            let (rate, error, reason) = super::tiles::rate(
                self.numbers,
                &data,
                inputs,
                self.settings,
                params,
                tile,
                logs,
            );
            let reason = match rate == logs_cap(params) {
                true => Reason::None,
                false => reason,
            };
            let quad = Quad {
                rate,
                attachment: rate,
                plain: rate,
                reason,
                error,
            };
            for (index, slot) in quads.iter_mut().enumerate() {
                let (x, y) = (index as u32 % across, index as u32 / across);
                if [x / 8, y / 8] == tile {
                    *slot = quad;
                }
            }
        }
    }

    fn decide(&self, sums: &[Option<N::Window>; 2], place: &Place, no_half_rate: bool) -> Quad {
        let Some(before) = &sums[0] else {
            return Quad::full(Reason::Invalid);
        };
        let motion_only = self.motion_only(place);
        let logs_of =
            |window: &N::Window| motion_only.unwrap_or_else(|| self.logs(window, place, false));
        let solid = legal(logs_of(before));
        let attachment = sums[1]
            .as_ref()
            .map_or(solid, |after| legal(logs_of(after)));
        // transparents can make a solid coarser, never finer
        let mut rate: Logs = std::array::from_fn(|axis| solid[axis].max(attachment[axis]));
        let error = [0, 1].map(|axis| self.numbers.error(before, axis));
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
                self.numbers.is_flatter_across(before, place)
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
        }
    }

    fn motion_only(&self, place: &Place) -> Option<Logs> {
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
                let rate = motion::LADDER[step.min(4) as usize];
                [rate.code() >> 2, rate.code() & 3]
            }
        };
        let largest = self.params.largest_rate().code();
        Some([logs[0].min(largest >> 2), logs[1].min(largest & 3)])
    }
}

fn logs_cap(params: &Params) -> Logs {
    let code = params.largest_rate().code();
    [code >> 2, code & 3]
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
