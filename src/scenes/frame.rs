//! One frame of a scene: its number, its time, where the camera stands and stood.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3, Vec4};

use super::SceneName;

/// Frames a second.
pub const FRAME_RATE: f32 = 60.0;
/// The distance of the near plane.
const NEAR: f32 = 0.05;
/// Nothing is seen beyond this.
const FAR: f32 = 400.0;

/// A camera, as in the shaders' `Camera`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Camera {
    /// Where it stands.
    pub position: [f32; 3],
    /// The distance of the near plane.
    pub near: f32,
    /// To the right, a unit vector.
    pub right: [f32; 3],
    /// How far the picture reaches to the right at distance 1. Set by [`Frame::new`] from the picture's shape.
    pub reach_x: f32,
    /// Upwards.
    pub up: [f32; 3],
    /// How far the picture reaches upwards at distance 1.
    pub reach_y: f32,
    /// Into the picture.
    pub forward: [f32; 3],
    /// Nothing is seen beyond this distance.
    pub far: f32,
}

impl Camera {
    /// A camera at a place that looks at another; `reach` is the tangent of half its vertical angle of view.
    pub fn look(from: Vec3, at: Vec3, reach: f32) -> Camera {
        let forward = (at - from).normalize();
        let right = Vec3::Y.cross(forward).normalize();
        let up = forward.cross(right);
        Camera {
            position: from.to_array(),
            near: NEAR,
            right: right.to_array(),
            reach_x: reach,
            up: up.to_array(),
            reach_y: reach,
            forward: forward.to_array(),
            far: FAR,
        }
    }

    fn for_size(self, size: [u32; 2]) -> Camera {
        Camera {
            reach_x: self.reach_y * size[0] as f32 / size[1] as f32,
            ..self
        }
    }

    /// From the world to clip space, with reversed Z and no far plane: depth is `near / distance`, as the G-buffer has it.
    pub fn view_projection(&self) -> Mat4 {
        let [right, up, forward, position] =
            [self.right, self.up, self.forward, self.position].map(Vec3::from_array);
        let row = |v: Vec3, scale: f32| (v.extend(-v.dot(position))) / scale;
        Mat4::from_cols(
            row(right, self.reach_x),
            row(up, self.reach_y),
            Vec4::new(0.0, 0.0, 0.0, self.near),
            row(forward, 1.0),
        )
        .transpose()
    }
}

/// A frame's uniforms, as in the shaders' `Frame`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// The frame's number.
    pub number: u32,
    /// Where all chance comes from.
    pub seed: u32,
    /// Seconds.
    pub time: f32,
    /// Seconds, of the frame before.
    pub time_before: f32,
    padding: [u32; 2],
    /// The camera.
    pub camera: Camera,
    /// The camera of the frame before.
    pub camera_before: Camera,
}

impl Frame {
    /// Frame `number` of a scene.
    pub fn new(scene: SceneName, number: u32, size: [u32; 2], seed: u32) -> Frame {
        let time = number as f32 / FRAME_RATE;
        let time_before = number.saturating_sub(1) as f32 / FRAME_RATE;
        Frame {
            size,
            number,
            seed,
            time,
            time_before,
            padding: [0; 2],
            camera: scene.camera(time).for_size(size),
            camera_before: scene.camera(time_before).for_size(size),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_near_over_distance_and_the_middle_is_in_the_middle() {
        let camera = Camera::look(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 9.0), 0.5);
        let clip = camera.view_projection() * Vec4::new(1.0, 2.0, 7.0, 1.0);
        assert_eq!(clip.truncate() / clip.w, Vec3::new(0.0, 0.0, NEAR / 4.0));
        let clip = camera.view_projection() * Vec4::new(1.0 + 2.0, 2.0 + 1.0, 7.0, 1.0);
        assert_eq!((clip.x / clip.w, clip.y / clip.w), (1.0, 0.5));
    }
}
