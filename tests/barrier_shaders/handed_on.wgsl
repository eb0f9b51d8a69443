// Values that only the invocation itself can know are handed on: what it finds in its own place of workgroup memory before
// anyone meets, and what a private variable and a local come to on the way.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba32float, write>;

var<workgroup> scratch: array<u32, 128>;
var<private> seen: u32;

fn mix_up(value: u32) -> u32 {
    seen += value & 7u;
    return value * 1664525u + 1013904223u;
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let start = u32(textureLoad(image, gid.xy, 0).x * 255.0) + gid.x * 3u + gid.y * 7u;
    scratch[lane] = mix_up(start);
    scratch[lane + 64u] = mix_up(scratch[lane] ^ lane);
    let mine = scratch[lane + 64u] >> 5u;
    var odd = 0u;
    if (mine & 1u) != 0u {
        odd = mine & 15u;
    }
    workgroupBarrier();
    seen += 1u;
    let across = scratch[63u - lane] & 255u;
    let value = vec4<f32>(f32(mine & 1023u), f32(odd), f32(across), f32(seen));
    textureStore(result, gid.xy, value);
}
