//! The settings as the deterministic path takes them: quantised once, on the CPU, for the kernel and its twin alike.

use bytemuck::{Pod, Zeroable};

use super::{
    fixed::{self, Mag},
    hysteresis,
    inputs::Frame,
    integer, luma, motion,
    settings::{Blur, Content, Form, Norm, Settings, Stability, Transfer, curve},
};
use crate::{rate::Rate, sri::SriLayout};

/// The uniform of `shaders/analyse.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    /// The picture's size.
    pub size: [u32; 2],
    /// The previous pictures' size.
    pub previous: [u32; 2],
    /// Previous pixels for a pixel, in 1/2^24.
    pub ratio: [u32; 2],
    /// Words in a row of rates.
    pub sri_pitch: u32,
    /// Words in a row of √luma.
    pub luma_pitch: u32,
    /// Steps of the table of speeds for one unit of a motion vector.
    pub speed_scale: [f32; 2],
    /// 1/512 previous pixels for one unit of a motion vector, from now to before.
    pub offset_scale: [f32; 2],
    /// t times the factor of stability, packed ([`Mag::packed`]): half rate after a previous 1, 2, 4; then room.
    pub reach_half: [u32; 4],
    /// The same of the quarter rate.
    pub reach_quarter: [u32; 4],
    /// What the base is compared with under the tolerance that holds everywhere, packed ([`limit`]): half rate after a previous 1, 2,
    /// 4; then room.
    pub limit_half: [u32; 4],
    /// The same of the quarter rate.
    pub limit_quarter: [u32; 4],
    /// l, in units of luma.
    pub ambient: u32,
    /// C of the pairwise form, in units of luma.
    pub sensitivity: u32,
    /// White as a power of two.
    pub white_log2: i32,
    /// Tolerance everywhere, a factor.
    pub tolerance: u32,
    /// The safe area's width.
    pub safe_width: u32,
    /// Its tolerance, a factor.
    pub safe_tolerance: u32,
    /// The largest rate's code.
    pub largest: u32,
    /// Tolerance of the smoothest metal at rest, a factor.
    pub material_least: u32,
    /// The speed from which on materials do not matter.
    pub material_slow: u32,
    /// smoothness · Rf0, in 1/65025, from which on the rate is full.
    pub material_mirror: u32,
    /// Tolerance of the second look, a factor.
    pub half_tolerance: u32,
    /// The speed from which on there is no second look.
    pub half_fast: u32,
    /// Whether there is history.
    pub has_history: u32,
    /// Entries of the falloff for a squared distance, in 1/2^32.
    pub falloff_scale: u32,
    /// Where one looks, in pixels.
    pub centre: [i32; 2],
    /// The least difference of inverse depth that means disocclusion, in 1/65536 of the smaller.
    pub depth_tolerance: u32,
    /// Near over far, in 1/2^30.
    pub depth_offset: u32,
    /// Whether depth 1 is near.
    pub reversed_z: u32,
    /// Words in a row of the previous frame's rates.
    pub previous_pitch: u32,
    /// Where the view lies in this frame's pictures.
    pub origin: [u32; 2],
    /// Where it lay in the previous frame's.
    pub previous_origin: [u32; 2],
}

/// Where things are in the table buffer, in words.
pub const TABLE_SPEEDS: usize = 256;
/// The falloff's start.
pub const TABLE_FALLOFF: usize = TABLE_SPEEDS + 2 * motion::SPEEDS as usize;
/// The falloff's entries: over the squared distance, up to 4 times half the height.
pub const FALLOFF: usize = 256;
/// What floats compare errors with where nothing moves: two words, for the half and the quarter rate.
pub const TABLE_SURE: usize = TABLE_FALLOFF + FALLOFF;
/// Where it says, in the highest bit, that floats cannot: a limit is beyond what they hold.
pub const TABLE_DOUBT: usize = TABLE_SURE + 2;
/// All words of it.
pub const TABLE_WORDS: usize = TABLE_DOUBT + 1;

/// Inverse depth from depth, in 1/2^30: 1 at the near plane; `None` for what is no depth.
pub fn inverse_depth(depth: f32, params: &Params) -> Option<u32> {
    inverse_distance(depth, params.depth_offset, params.reversed_z != 0)
}

/// Inverse distance from depth, in 1/2^30: 1 at the near plane; `None` for what is no depth. `offset` is near over far in the same
/// unit.
pub fn inverse_distance(depth: f32, offset: u32, is_reversed: bool) -> Option<u32> {
    let bits = depth.to_bits();
    if bits != 0x8000_0000 && bits > 0x3f80_0000 {
        return None;
    }
    let toward_near = match is_reversed {
        true => (depth * 1_073_741_824.0) as u32,
        false => (1 << 30) - (depth * 1_073_741_824.0) as u32,
    };
    // the near plane itself is 2^30, of which two bits more would be lost
    let share = toward_near.min((1 << 30) - 1) << 2;
    Some(toward_near + offset - fixed::mul_high(share, offset))
}

/// Whether two inverse depths are of different surfaces.
pub fn is_hidden(now: u32, before: u32, params: &Params) -> bool {
    now.abs_diff(before) > fixed::mul_high(now.min(before), params.depth_tolerance << 16)
}

/// Whether there was something nearer before.
pub fn was_covered(now: u32, before: u32, params: &Params) -> bool {
    before > now && is_hidden(now, before, params)
}

impl Params {
    /// The parameters of a frame.
    pub fn new(settings: &Settings, inputs: &Frame) -> Params {
        let [width, height] = inputs.size;
        let content = &settings.content;
        let tolerance = fixed::factor(curve(&settings.overshoot, inputs.resolution_scale));
        let reaches = reaches(settings);
        let limits = limits_everywhere(settings, inputs.resolution_scale);
        let mut motion = settings.motion.unwrap_or_default();
        if inputs.cameras.is_some() {
            // what follows from cameras is in pixels
            motion.scale = [1.0; 2];
        }
        let steps = |axis: usize| match motion.blur {
            Blur::Ladder(_) => 8192.0 / f64::from(inputs.size[axis]),
            _ => 16.0,
        };
        let speed = |pixels: f64| (pixels * 16.0).clamp(0.0, 65535.0) as u32;
        let materials = settings.materials.unwrap_or_default();
        let half_rate = settings.half_rate.unwrap_or_default();
        let safe = settings.safe_area.unwrap_or_default();
        let reprojection = settings.reprojection.unwrap_or_default();
        let foveation = settings.foveation.clone().unwrap_or_default();
        let reach = f64::from(height) * 2.0;
        Params {
            size: inputs.size,
            previous: inputs.previous_size,
            ratio: std::array::from_fn(|axis| {
                let ratio = f64::from(inputs.previous_size[axis]) / f64::from(inputs.size[axis]);
                (ratio * 16_777_216.0).round().min(4_294_967_295.0) as u32
            }),
            sri_pitch: SriLayout::new(width, height).pitch / 4,
            luma_pitch: luma_pitch(inputs.previous_size[0]) / 4,
            speed_scale: std::array::from_fn(|axis| {
                (motion.scale[axis] * motion.weight * steps(axis)).abs() as f32
            }),
            offset_scale: std::array::from_fn(|axis| {
                let ratio = f64::from(inputs.previous_size[axis]) / f64::from(inputs.size[axis]);
                (motion.scale[axis] * ratio * -512.0) as f32
            }),
            reach_half: reaches[0].map(Mag::packed),
            reach_quarter: reaches[1].map(Mag::packed),
            limit_half: limits[0].map(Mag::packed),
            limit_quarter: limits[1].map(Mag::packed),
            ambient: units(content.ambient),
            sensitivity: match content.form {
                Form::Window | Form::Absolute => 0,
                Form::Pairwise { sensitivity } => units(sensitivity),
            },
            white_log2: content.white_log2,
            tolerance,
            safe_width: safe.width,
            safe_tolerance: fixed::factor(safe.tolerance),
            largest: u32::from(settings.largest.code()),
            material_least: fixed::factor(materials.least).min(fixed::FACTOR_ONE),
            material_slow: speed(materials.slow),
            material_mirror: (materials.mirror * 65_025.0).clamp(0.0, 65_536.0) as u32,
            half_tolerance: fixed::factor(half_rate.tolerance).min(fixed::FACTOR_ONE),
            half_fast: speed(half_rate.fast),
            has_history: u32::from(inputs.has_history),
            centre: [
                (foveation.centre[0] * f64::from(width)) as i32,
                (foveation.centre[1] * f64::from(height)) as i32,
            ],
            falloff_scale: (FALLOFF as f64 / (reach * reach) * 4_294_967_296.0).min(4_294_967_295.0)
                as u32,
            depth_tolerance: (reprojection.tolerance * 65_536.0).clamp(0.0, 65_535.0) as u32,
            depth_offset: (reprojection.near_over_far.clamp(0.0, 1.0) * 1_073_741_824.0) as u32,
            reversed_z: u32::from(reprojection.reversed_z),
            previous_pitch: SriLayout::new(inputs.previous_size[0], inputs.previous_size[1]).pitch
                / 4,
            origin: inputs.origin,
            previous_origin: inputs.previous_origin,
        }
    }

    /// The largest rate.
    pub fn largest_rate(&self) -> Rate {
        Rate::from_code_or_full(self.largest as u8)
    }
}

/// What the base is multiplied by before an error is compared with it, rounded down: the reach under a tolerance, for as many pairs as
/// there are, and squared where the errors are.
pub fn limit(reach: Mag, tolerance: u32, content: &Content) -> Mag {
    let limit = reach.times_below(Mag::below(tolerance));
    let pairs = Mag::below(integer::count(content.pairs));
    match content.norm {
        Norm::L1 => limit.times_below(pairs),
        Norm::LInf => limit,
        Norm::L2 | Norm::Root => limit.times_below(limit).times_below(pairs),
    }
}

/// What a limit is multiplied by for motion, rounded down: 1 / b, squared where errors are, with all powers of two by which the units of
/// errors and bases differ.
fn blurred(b: u32, content: &Content) -> Mag {
    let b = Mag::inverse(b);
    match content.norm {
        Norm::L1 | Norm::LInf => b.scaled(-3 - 24),
        // the mean of halves against the square of the threshold
        Norm::Root => b.times_below(b).scaled(-integer::root_shift(content.form)),
        Norm::L2 => b.times_below(b).scaled(-6 - 48),
    }
}

/// Whether, where there is motion, what bases are multiplied by hangs on nothing but speed, so that the table has all of it: no previous
/// rates, no tolerance of the place, no second look.
pub(crate) fn has_fixed_limits(settings: &Settings) -> bool {
    settings.motion.is_some()
        && settings.stability == Stability::None
        && settings.safe_area.is_none()
        && settings.foveation.is_none()
        && settings.materials.is_none()
        && settings.half_rate.is_none()
}

/// t times the factor of stability, after a previous 1, 2, 4, and no known one: for the half rate and the quarter rate.
fn reaches(settings: &Settings) -> [[Mag; 4]; 2] {
    let content = &settings.content;
    let granularity = settings.granularity_of_rates();
    let threshold = Mag::below(fixed::factor(content.threshold));
    [1u8, 2].map(|log2| {
        let factors: [u32; 4] = std::array::from_fn(|had| match (settings.stability, had) {
            (Stability::None, _) | (_, 3) => fixed::FACTOR_ONE,
            (Stability::Compensate, had) => {
                fixed::factor(hysteresis::swell(content, granularity, had as u8))
            }
            (Stability::Hysteresis, had) => {
                let epsilon = hysteresis::epsilon(content, granularity, log2);
                match had as u8 >= log2 {
                    true => fixed::factor(1.0 + epsilon),
                    false => fixed::factor(1.0 - epsilon),
                }
            }
        });
        factors.map(|factor| threshold.times_below(Mag::below(factor)))
    })
}

/// Limits under the tolerance that holds everywhere.
fn limits_everywhere(settings: &Settings, resolution_scale: f64) -> [[Mag; 4]; 2] {
    let tolerance = fixed::factor(curve(&settings.overshoot, resolution_scale));
    let content = &settings.content;
    reaches(settings).map(|of| of.map(|reach| limit(reach, tolerance, content)))
}

fn units(value: f64) -> u32 {
    match value > 0.0 {
        true => (value * f64::from(fixed::ONE))
            .round()
            .min(f64::from(fixed::ONE)) as u32,
        false => 0,
    }
}

/// Bytes from row to row of a √luma buffer: four pixels to a word, padded to 256.
pub fn luma_pitch(width: u32) -> u32 {
    width.max(1).next_multiple_of(crate::sri::ROW_ALIGNMENT)
}

/// Linear light of an 8-bit code, in units of luma.
pub fn linear_code(code: u8, transfer: Transfer) -> u32 {
    let encoded = f64::from(code) / 255.0;
    let value = match transfer {
        Transfer::Srgb => luma::from_srgb(encoded),
        Transfer::Square => encoded * encoded,
    };
    (value * f64::from(fixed::ONE)).round() as u32
}

/// The table buffer: linear light of 8-bit codes; over speed, two words, for the half and the quarter rate: what limits are multiplied by,
/// or that times the limits if they are everywhere the same, packed ([`Mag::packed`]), or where motion alone decides what
/// [`motion::table`] has; tolerance over squared distance.
pub fn tables(settings: &Settings, is_sqrt_luma: bool, resolution_scale: f64) -> Vec<u32> {
    let content = &settings.content;
    let codes = (0..256).map(|code| match is_sqrt_luma {
        true => fixed::sqrt_luma(code as u8),
        false => linear_code(code as u8, content.transfer),
    });
    let falloff = (0..FALLOFF).map(|index| {
        let distance = (index as f64 / FALLOFF as f64).sqrt() * 4.0;
        let foveation = settings.foveation.as_ref();
        fixed::factor(foveation.map_or(1.0, |f| f.tolerance(distance, resolution_scale)))
    });
    let blur = settings.motion.map(|motion| motion.blur);
    let is_motion_only = matches!(blur, Some(Blur::Standalone { .. } | Blur::Ladder(_)));
    let speeds = motion::table(blur, content.threshold, content.k);
    let limits = limits_everywhere(settings, resolution_scale).map(|limits| limits[0]);
    let is_fixed = has_fixed_limits(settings);
    let speeds = speeds.into_iter().flat_map(|entry| {
        [0, 1].map(|rate: usize| {
            let b = (entry >> (16 * rate)) & 0xffff;
            match (is_motion_only, is_fixed) {
                (true, _) => b,
                (false, true) => limits[rate].times_below(blurred(b, content)).packed(),
                (false, false) => blurred(b, content).packed(),
            }
        })
    });
    let sure = sure_limits(settings, resolution_scale);
    codes.chain(speeds).chain(falloff).chain(sure).collect()
}

/// What an error over its base, or over its base's square, has to be less than where nothing bears on it but content, for the half and the
/// quarter rate: bits of floats, which are exact; then, in the highest bit, whether one is beyond what a kernel may multiply by
/// (`shaders/analyse/sure.wgsl`).
fn sure_limits(settings: &Settings, resolution_scale: f64) -> [u32; 3] {
    let content = &settings.content;
    let [half, quarter] = limits_everywhere(settings, resolution_scale).map(|limits| limits[0]);
    let bounds = [(half, 1.0), (quarter, content.k)].map(|(limit, b)| {
        let limit = limit.times_below(blurred(fixed::factor_up(b), content));
        limit.as_float()
    });
    let [half, quarter] = bounds.map(|bound| bound.unwrap_or(0.0).to_bits());
    [half, quarter, u32::from(bounds.contains(&None)) << 31]
}
