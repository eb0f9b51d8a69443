//! What a camera and its lens tell of a pixel by its depth: the motion of a scene without vectors (Yang et al., I3D 2019, §5.2), and the
//! width of a later depth of field (DOOM, "Coarse DOF calculation in Shading Rate generation shader?").
//!
//! Does: makes the kernel's uniform, and is its twin for the lens; the twin for motion is [`reproject`](super::reproject), in f64.
//! Needs: this frame's depth; for motion, both frames' [`Cameras`].
//! Guarantees: the lens is decided by integers, bit for bit on every driver. Motion divides in float on the GPU, and may differ from the
//! twin by one step of the table of speeds, 1/16 pixel. What is no depth is sharp, and has no known motion.
//! Refuses: nothing; a lens that is no number blurs nothing.

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec4};

use super::{fixed, inputs::Frame, motion, params, settings::Settings};

/// The cameras of two frames, as matrices from the world to clip space, z from 0 to 1; standard or reversed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cameras {
    /// This frame's.
    pub now: DMat4,
    /// The previous frame's.
    pub before: DMat4,
}

/// A thin lens: the circle of confusion of a distance z is `infinity · |1 − focus / z|`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Lens {
    /// The distance that is in focus, in units of the scene, as `near`.
    pub focus: f64,
    /// How wide what is infinitely far is blurred, in pixels: f² / (N (focus − f)), on the sensor, times pixels for its width.
    pub infinity: f64,
    /// The widest blur that the renderer makes, in pixels.
    pub most: f64,
    /// The near plane's distance.
    pub near: f64,
    /// The far plane's distance; may be infinite.
    pub far: f64,
    /// Whether depth 1 is near.
    pub reversed_z: bool,
}

impl Default for Lens {
    /// Focused at 5, 8 pixels at infinity, 16 at most.
    fn default() -> Lens {
        Lens {
            focus: 5.0,
            infinity: 8.0,
            most: 16.0,
            near: 0.1,
            far: f64::INFINITY,
            reversed_z: true,
        }
    }
}

/// The kernel's uniform.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Optics {
    reprojection: [f32; 16],
    world_w: [f32; 4],
    focus: u32,
    blur_scale: u32,
    most_blur: u32,
    depth_offset: u32,
    reversed_z: u32,
    room: [u32; 3],
}

/// In 1/2^30; what is no number is 0.
fn share(value: f64) -> u32 {
    (value * 1_073_741_824.0).clamp(0.0, 1_073_741_824.0) as u32
}

impl Optics {
    pub(crate) fn new(settings: &Settings, frame: &Frame) -> Optics {
        let lens = settings.lens.unwrap_or(Lens {
            infinity: 0.0,
            ..Lens::default()
        });
        let speed = |pixels: f64| pixels * 16.0;
        // without cameras, w is 0 everywhere: doubt
        let (reprojection, world_w) = frame.cameras.map_or((DMat4::ZERO, DVec4::ZERO), |cameras| {
            let to_world = cameras.now.inverse();
            (cameras.before * to_world, to_world.row(3))
        });
        let [x, y, z, w] = world_w.to_array();
        Optics {
            // multiplied in f64, so that a world far from its origin loses nothing
            reprojection: reprojection.as_mat4().to_cols_array(),
            world_w: [x, y, z, w].map(|value| value as f32),
            focus: share(lens.near / lens.focus),
            // rounded down: to less blur
            blur_scale: (speed(lens.infinity) * lens.focus / lens.near).clamp(0.0, 4_294_967_295.0)
                as u32,
            most_blur: speed(lens.most).clamp(0.0, f64::from(motion::SPEEDS - 1)) as u32,
            depth_offset: share(lens.near / lens.far),
            reversed_z: u32::from(lens.reversed_z),
            room: [0; 3],
        }
    }

    /// The width of the circle of confusion, as a speed that would blur as wide.
    pub(crate) fn blur(&self, depth: f32) -> u32 {
        let inverse = params::inverse_distance(depth, self.depth_offset, self.reversed_z != 0);
        inverse.map_or(0, |inverse| {
            let apart = inverse.abs_diff(self.focus).min((1 << 30) - 1);
            fixed::mul_high(apart << 2, self.blur_scale).min(self.most_blur)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(lens: Lens) -> Optics {
        let settings = Settings {
            lens: Some(lens),
            ..Settings::default()
        };
        Optics::new(&settings, &Frame::of_size([64, 64]))
    }

    #[test]
    fn the_circle_of_confusion_is_that_of_a_thin_lens_in_both_ways_of_depth() {
        for reversed_z in [true, false] {
            for (near, far) in [(0.1, 1000.0), (0.1, f64::INFINITY), (1.0, 50.0)] {
                let lens = Lens {
                    reversed_z,
                    near,
                    far,
                    most: 60.0,
                    ..Lens::default()
                };
                let optics = of(lens);
                for z in [1.0, 2.5, 4.9, 5.0, 5.1, 8.0, 20.0, 49.0] {
                    let toward = match far.is_finite() {
                        true => near / z * (far - z) / (far - near),
                        false => near / z,
                    };
                    let depth = if reversed_z { toward } else { 1.0 - toward } as f32;
                    let exact = lens.infinity * (1.0 - lens.focus / z).abs();
                    let found = f64::from(optics.blur(depth)) / 16.0;
                    // standard depth loses bits where it is near 1
                    let slack = if reversed_z { 0.001 } else { 0.02 };
                    assert!(
                        found <= exact + slack && found >= exact - 1.0 / 16.0 - slack,
                        "{z}: {found}, not {exact}; {lens:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn e1_what_is_no_depth_is_sharp_and_no_lens_blurs_nothing() {
        let optics = of(Lens::default());
        for bad in [f32::NAN, -1.0, 2.0, f32::INFINITY] {
            assert_eq!(optics.blur(bad), 0, "{bad}");
        }
        assert!(optics.blur(0.0) > 0, "infinity is blurred");
        assert_eq!(optics.blur(1.0), 16 * 16, "as wide as it gets");
        for infinity in [0.0, -3.0, f64::NAN] {
            let optics = of(Lens {
                infinity,
                ..Lens::default()
            });
            assert_eq!(optics.blur(0.0), 0, "{infinity}");
        }
    }
}
