// Helper functions with barriers inside, as libraries of reductions have them.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba32float, write>;

var<workgroup> scratch: array<f32, 64>;
var<workgroup> lanes: array<u32, 64>;

fn sync() {
    workgroupBarrier();
}

fn highest(lane: u32, value: f32) -> f32 {
    scratch[lane] = value;
    sync();
    for (var step = 32u; step > 0u; step >>= 1u) {
        if lane < step {
            scratch[lane] = max(scratch[lane], scratch[lane + step]);
        }
        sync();
    }
    let found = scratch[0];
    sync();
    return found;
}

fn mirrored(lane: u32, value: u32, twice: bool) -> u32 {
    lanes[lane] = value;
    workgroupBarrier();
    if twice {
        let first = lanes[63u - lane];
        workgroupBarrier();
        return first * 2u;
    }
    let only = lanes[63u - lane];
    workgroupBarrier();
    return only;
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let color = textureLoad(image, min(gid.xy, textureDimensions(image) - 1u), 0);
    let most = highest(lane, color.x);
    let green = highest(lane, color.y) + most;
    let other = mirrored(lane, gid.x * 3u + gid.y, true) + mirrored(lane, gid.y, false);
    if all(gid.xy < textureDimensions(image)) {
        textureStore(result, gid.xy, vec4<f32>(color.x / max(most, 0.001), green, f32(other), 1.0));
    }
}
