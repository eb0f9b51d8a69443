// A 3x3 blur whose tile, with an apron of one pixel, is read once into workgroup memory.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var blurred: texture_storage_2d<rgba8unorm, write>;

const SIDE: u32 = 10u;
var<workgroup> tile: array<vec4<f32>, 100>;

fn pixel(at: vec2<i32>) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(image)) - 1;
    return textureLoad(image, clamp(at, vec2<i32>(0), last), 0);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    let corner = vec2<i32>(group.xy * 8u) - 1;
    for (var i = lane; i < SIDE * SIDE; i += 64u) {
        tile[i] = pixel(corner + vec2<i32>(vec2<u32>(i % SIDE, i / SIDE)));
    }
    workgroupBarrier();
    var sum = vec4<f32>(0.0);
    for (var y = 0u; y < 3u; y++) {
        for (var x = 0u; x < 3u; x++) {
            sum += tile[(lid.y + y) * SIDE + lid.x + x];
        }
    }
    if all(gid.xy < textureDimensions(image)) {
        textureStore(blurred, gid.xy, sum / 9.0);
    }
}
