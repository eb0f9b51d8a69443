// One pass of a separable blur as it is commonly written: a workgroup is a piece of a row, 64 pixels wide, with an apron of its
// neighbours in workgroup memory.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var blurred: texture_storage_2d<rgba16float, write>;

const REACH: u32 = 4u;

var<workgroup> piece: array<vec4<f32>, 72>;

fn fetch(x: i32, y: u32) -> vec4<f32> {
    let last = i32(textureDimensions(image).x) - 1;
    return textureLoad(image, vec2<u32>(u32(clamp(x, 0, last)), y), 0);
}

@compute @workgroup_size(64, 1)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = i32(gid.x - lane) - i32(REACH);
    piece[lane] = fetch(first + i32(lane), gid.y);
    if lane < 2u * REACH {
        piece[lane + 64u] = fetch(first + 64 + i32(lane), gid.y);
    }
    workgroupBarrier();
    if any(gid.xy >= textureDimensions(blurred)) {
        return;
    }
    var sum = vec4<f32>(0.0);
    var weights = 0.0;
    for (var i = 0u; i <= 2u * REACH; i++) {
        let away = f32(i) - f32(REACH);
        let weight = exp(-0.125 * away * away);
        sum += weight * piece[lane + i];
        weights += weight;
    }
    textureStore(blurred, gid.xy, sum / weights);
}
