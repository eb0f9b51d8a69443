// A pixel found by the number of its invocation in the workgroup, as engines write it: columns by `&`, rows by `>>`, in helpers and as
// `i32`; a mask of 8 x 4 pixels that says early that nothing is to be done.
struct Params {
    size: vec2<u32>,
    seed: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> masks: array<u32>;
@group(0) @binding(2) var shadow: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var<storage, read_write> distances: array<f32>;

fn lane_place(lane: i32) -> vec2<i32> {
    return vec2<i32>(lane % 8, lane / 8);
}

@compute @workgroup_size(8, 4)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = vec2<i32>(group.xy * vec2<u32>(8u, 4u)) + lane_place(i32(lane));
    let pixel = group.xy * vec2<u32>(8u, 4u) + vec2<u32>(lane & 7u, lane >> 3u);
    if any(pixel >= params.size) {
        return;
    }
    let mask = masks[(pixel.x ^ params.seed) % arrayLength(&masks)];
    let index = pixel.y * params.size.x + pixel.x;
    if (mask & 3u) == 0u {
        textureStore(shadow, at, vec4<f32>(0.0));
        distances[index] = -1.0;
        return;
    }
    let lit = f32((mask >> lane) & 1u);
    textureStore(shadow, at, vec4<f32>(lit, f32(pixel.x & 15u) / 16.0, f32(pixel.y & 15u) / 16.0, 1.0));
    distances[index] = f32(pixel.x) * 3.0 + f32(pixel.y);
}
