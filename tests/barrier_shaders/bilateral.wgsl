// A bilateral filter: depth and colour of a tile with its apron lie in workgroup memory; the centre's depth decides what
// counts. The group is 8 by 4.

struct In {
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
}

@group(0) @binding(0) var color: texture_2d<f32>;
@group(0) @binding(1) var depth: texture_2d<f32>;
@group(0) @binding(2) var filtered: texture_storage_2d<rgba8unorm, write>;

var<workgroup> colors: array<array<vec3<f32>, 12>, 8>;
var<workgroup> depths: array<array<f32, 12>, 8>;

@compute @workgroup_size(8, 4)
fn main(in: In) {
    let size = textureDimensions(color);
    let origin = in.gid.xy - in.lid.xy;
    for (var i = in.lane; i < 96u; i += 32u) {
        let place = vec2<u32>(i % 12u, i / 12u);
        let at = clamp(vec2<i32>(origin + place) - 2, vec2<i32>(0), vec2<i32>(size) - 1);
        colors[place.y][place.x] = textureLoad(color, at, 0).rgb;
        depths[place.y][place.x] = textureLoad(depth, at, 0).x;
    }
    workgroupBarrier();
    if any(in.gid.xy >= size) {
        return;
    }
    let center = in.lid.xy + 2u;
    let here = depths[center.y][center.x];
    var sum = vec3<f32>(0.0);
    var total = 0.0;
    for (var y = 0u; y < 5u; y++) {
        for (var x = 0u; x < 5u; x++) {
            let other = in.lid.xy + vec2<u32>(x, y);
            let weight = max(0.0, 1.0 - 4.0 * abs(depths[other.y][other.x] - here));
            sum += weight * colors[other.y][other.x];
            total += weight;
        }
    }
    textureStore(filtered, in.gid.xy, vec4<f32>(sum / max(total, 0.001), 1.0));
}
