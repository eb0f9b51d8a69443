// Checkerboard rendering: every second pixel of a row, which of them a uniform says, into a target half as wide. Two pixels have one
// place, but never in the same frame.
@group(0) @binding(0) var<uniform> frame: u32;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var packed: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if ((id.x + id.y) & 1u) != (frame & 1u) { return; }
    textureStore(packed, vec2(id.x >> 1u, id.y), textureLoad(source, id.xy, 0));
}
