// Helpers with barriers, as one writes them when three shaders share them.
@group(0) @binding(0) var depth: texture_2d<f32>;
@group(0) @binding(1) var coc: texture_storage_2d<rg32float, write>;
struct Lens { focus: f32, aperture: f32, size: vec2<u32>, }
@group(0) @binding(2) var<uniform> lens: Lens;

var<workgroup> scratch: array<f32, 256>;
var<workgroup> tile: array<array<f32, 16>, 16>;

fn reduce_max(lane: u32, value: f32) -> f32 {
    scratch[lane] = value;
    workgroupBarrier();
    for (var s = 128u; s > 0u; s = s / 2u) {
        if lane < s {
            scratch[lane] = max(scratch[lane], scratch[lane + s]);
        }
        workgroupBarrier();
    }
    let found = scratch[0];
    workgroupBarrier();
    return found;
}

fn reduce_min(lane: u32, value: f32) -> f32 {
    return -reduce_max(lane, -value);
}

fn load_tile(gid: vec2<u32>, lid: vec2<u32>) -> f32 {
    let z = textureLoad(depth, min(gid, lens.size - 1u), 0).x;
    tile[lid.y][lid.x] = z;
    workgroupBarrier();
    return z;
}

fn circle(z: f32) -> f32 {
    return clamp((z - lens.focus) * lens.aperture, -1.0, 1.0);
}

@compute @workgroup_size(16, 16)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let z = load_tile(gid.xy, lid.xy);
    let farthest = reduce_max(lane, z);
    let nearest = reduce_min(lane, z);
    var sum = 0.0;
    for (var dy = -1; dy <= 1; dy++) {
        for (var dx = -1; dx <= 1; dx++) {
            let at = clamp(vec2<i32>(lid.xy) + vec2<i32>(dx, dy), vec2<i32>(0), vec2<i32>(15));
            sum += circle(tile[at.y][at.x]);
        }
    }
    let spread = farthest - nearest;
    if all(gid.xy < lens.size) {
        textureStore(coc, gid.xy, vec4<f32>(sum / 9.0 * (1.0 + spread), circle(z), 0.0, 0.0));
    }
}
