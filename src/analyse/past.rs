//! Where a pixel was in the previous picture, on the deterministic path: the twin of `shaders/analyse/source.wgsl`.

use super::{
    fixed,
    inputs::Inputs,
    params::{self, Params},
    reasons::Reason,
    settings::Settings,
};

/// Why a pixel has no source.
pub(super) type NoSource = Reason;

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
