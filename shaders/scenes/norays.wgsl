// In place of rays.wgsl, for a scene that has neither occlusion nor reflections: no pass, no texture.

const TRACES_SKY: bool = false;

fn traced_at(at: vec2<i32>) -> vec4<f32> {
    return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
