// The workgroup's size is an override, and so is the length of what it shares.

override WIDTH: u32 = 8;
override HEIGHT: u32 = 8;

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var<uniform> size: vec4<u32>;
@group(0) @binding(2) var<storage, read_write> result: array<vec4<f32>>;

var<workgroup> tile: array<vec4<f32>, WIDTH * HEIGHT>;

@compute @workgroup_size(WIDTH, HEIGHT)
fn main(@builtin(local_invocation_id) lid: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let pixel = group.xy * vec2(WIDTH, HEIGHT) + lid.xy;
    let lane = lid.y * WIDTH + lid.x;
    tile[lane] = textureLoad(image, pixel, 0);
    workgroupBarrier();
    let left = tile[lid.y * WIDTH + max(lid.x, 1u) - 1u];
    let above = tile[(max(lid.y, 1u) - 1u) * WIDTH + lid.x];
    if pixel.x < size.x && pixel.y < size.y {
        result[pixel.x + pixel.y * size.x] = tile[lane] * 0.5 + left * 0.25 + above * 0.25;
    }
}
