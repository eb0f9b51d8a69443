//! Motion of the camera from depth and two matrices (Yang et al., I3D 2019, §5.2): for scenes that have no motion vectors.
//!
//! It takes standard and reversed Z alike: the matrices say which. Objects that move by themselves, and those that move with
//! the camera (a hand weapon), need [`flags::STATIC`](super::inputs::flags::STATIC) or vectors of their own. *Guarantees*: what
//! is behind either camera, or no depth, is no number, which the analysis takes as doubt: full rate.

use glam::{DMat4, DVec3, DVec4};

use super::{inputs::Inputs, params::Params, past, settings::Settings};

/// The vector from where a surface was to where it is, in pixels of a picture of `size`, for the centre of a pixel.
pub fn camera_motion(
    pixel: [u32; 2],
    size: [u32; 2],
    depth: f32,
    now_from_clip: &DMat4,
    clip_before: &DMat4,
) -> [f32; 2] {
    let centre = [f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5];
    motion_of(centre, size, depth, now_from_clip, clip_before)
}

/// The same of any place, in pixels.
pub(super) fn motion_of(
    centre: [f64; 2],
    size: [u32; 2],
    depth: f32,
    now_from_clip: &DMat4,
    clip_before: &DMat4,
) -> [f32; 2] {
    const NONE: [f32; 2] = [f32::NAN; 2];
    if !(0.0..=1.0).contains(&depth) {
        return NONE;
    }
    let [width, height] = size.map(f64::from);
    // clip space has y up, pixels have y down
    let clip = DVec4::new(
        centre[0] / width * 2.0 - 1.0,
        1.0 - centre[1] / height * 2.0,
        f64::from(depth),
        1.0,
    );
    let world = *now_from_clip * clip;
    // the plane at infinity has w = 0 and still a place in the picture; only the sign of w before counts
    let before = *clip_before * world;
    let w = before.w * if world.w < 0.0 { -1.0 } else { 1.0 };
    // an infinite w would put everything into the middle of the picture
    if !w.is_finite() || w <= 0.0 {
        return NONE;
    }
    let place = DVec3::new(before.x, before.y, before.z) / before.w;
    let was = [
        (place.x + 1.0) / 2.0 * width,
        (1.0 - place.y) / 2.0 * height,
    ];
    [(centre[0] - was[0]) as f32, (centre[1] - was[1]) as f32]
}

/// The vectors of a whole picture, row by row: [`Inputs::motion`](super::Inputs::motion) with a scale of 1.
///
/// `view_projection` and `previous` take the world to clip space, of this frame and the one before.
pub fn camera_motions(
    size: [u32; 2],
    depth: &[f32],
    view_projection: &DMat4,
    previous: &DMat4,
) -> Vec<[f32; 2]> {
    let now_from_clip = view_projection.inverse();
    depth
        .iter()
        .enumerate()
        .map(|(index, &depth)| {
            let pixel = [index as u32 % size[0], index as u32 / size[0]];
            camera_motion(pixel, size, depth, &now_from_clip, previous)
        })
        .collect()
}

/// The depth of the frame before as far as this frame tells it, for [`Inputs::previous_depth`] where that is not had: each surface that
/// is seen now, carried back along its motion; where two come from one place, the nearer. So what was hidden by something that can
/// still be seen is found; what was hidden by something that has left the picture is not.
///
/// Row by row, of `inputs.previous_size`; where nothing comes from, the furthest depth, which nothing looks up.
pub fn depth_before(inputs: &Inputs, settings: &Settings) -> Vec<f32> {
    let depth = inputs.depth.unwrap_or_default();
    let vectors = inputs
        .cameras
        .filter(|_| inputs.motion.is_none())
        .map(|cameras| camera_motions(inputs.size, depth, &cameras.now, &cameras.before));
    let inputs = Inputs {
        motion: vectors.as_deref().or(inputs.motion),
        previous_depth: None,
        ..*inputs
    };
    let is_reversed = settings.reprojection.unwrap_or_default().reversed_z;
    let params = Params::new(settings, &inputs.frame());
    let [width, height] = inputs.previous_size;
    let furthest: f32 = if is_reversed { 0.0 } else { 1.0 };
    let mut before = vec![furthest; width as usize * height as usize];
    for (at, &depth) in depth.iter().enumerate() {
        let (x, y) = (at as u32 % inputs.size[0], at as u32 / inputs.size[0]);
        let Ok(from) = past::source(x, y, &inputs, settings, &params) else {
            continue;
        };
        let there = &mut before[from as usize];
        *there = match is_reversed {
            true => depth.max(*there),
            false => depth.min(*there),
        };
    }
    before
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 32];

    /// Standard and reversed Z of one camera: near 0.1, far 100.
    fn projections() -> [DMat4; 2] {
        [(0.1, 100.0), (100.0, 0.1)].map(|(near, far)| DMat4::perspective_rh(1.0, 2.0, near, far))
    }

    #[test]
    fn e33_both_conventions_of_z_give_the_same_motion() {
        let step = DMat4::from_translation(DVec3::new(-0.2, 0.1, 0.3));
        let found = projections().map(|projection| {
            let point = DVec3::new(0.4, -0.3, -5.0);
            let clip = projection * point.extend(1.0);
            let depth = (clip.z / clip.w) as f32;
            let pixel = [
                ((clip.x / clip.w + 1.0) / 2.0 * 64.0) as u32,
                ((1.0 - clip.y / clip.w) / 2.0 * 32.0) as u32,
            ];
            camera_motion(
                pixel,
                SIZE,
                depth,
                &projection.inverse(),
                &(projection * step),
            )
        });
        assert!(found[0][0] > 0.0, "the world moved right: {found:?}");
        for axis in 0..2 {
            assert!((found[0][axis] - found[1][axis]).abs() < 1e-3, "{found:?}");
        }
    }

    #[test]
    fn e33_what_was_behind_the_camera_or_has_no_depth_is_no_number() {
        for projection in projections() {
            let clip = projection * DVec4::new(0.0, 0.0, -2.0, 1.0);
            let depth = (clip.z / clip.w) as f32;
            // the camera was five metres further on
            let before = projection * DMat4::from_translation(DVec3::new(0.0, 0.0, 5.0));
            let inverse = projection.inverse();
            for depth in [depth, f32::NAN, -1.0, f32::INFINITY] {
                let found = camera_motion([32, 16], SIZE, depth, &inverse, &before);
                assert!(found[0].is_nan() && found[1].is_nan(), "{depth}: {found:?}");
            }
        }
    }

    #[test]
    fn a_camera_at_rest_moves_nothing() {
        for projection in projections() {
            let depth: Vec<f32> = (0..64 * 32u16).map(|i| f32::from(i) / 2048.0).collect();
            for vector in camera_motions(SIZE, &depth, &projection, &projection) {
                assert!(
                    vector[0].abs() < 1e-6 && vector[1].abs() < 1e-6,
                    "{vector:?}"
                );
            }
        }
    }
}
