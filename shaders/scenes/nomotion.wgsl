// In place of motion.wgsl, for a scene without motion vectors: no texture, nothing written.

fn note_motion_of(pixel: vec2<u32>, point: vec3<f32>, surface: u32) {}

fn note_motion_of_sky(pixel: vec2<u32>, direction: vec3<f32>) {}
