// Values of every shape that live through several regions: a struct, an array, a matrix, a vector, booleans, integers.
struct Surface { normal: vec3<f32>, roughness: f32, kind: i32, layers: array<f32, 3>, }
struct Setup { size: vec2<u32>, turns: u32, mixed: f32, }
@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> tables: array<mat2x2<f32>, 8>;
@group(0) @binding(3) var lit: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var more: texture_storage_2d<rgba32uint, write>;
var<workgroup> window: array<vec4<f32>, 128>;
var<workgroup> brightest: atomic<u32>;

fn surface_at(texel: vec4<f32>) -> Surface {
    var s: Surface;
    s.normal = normalize(texel.xyz + vec3<f32>(0.01));
    s.roughness = texel.w;
    s.kind = i32(texel.x * 4.0);
    s.layers = array<f32, 3>(texel.x, texel.y, texel.z);
    return s;
}

@compute @workgroup_size(16, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let texel = textureLoad(source, id.xy, 0);
    var surface = surface_at(texel);
    var basis = mat2x2<f32>(1.0, 0.0, 0.0, 1.0);
    var history: array<vec2<f32>, 4>;
    var is_bright = false;
    var bits = vec3<u32>(0u);
    window[lane] = texel;
    atomicMax(&brightest, u32(texel.x * 255.0));
    workgroupBarrier();
    let top = atomicLoad(&brightest);
    is_bright = u32(texel.x * 255.0) * 2u > top;
    for (var turn = 0u; turn < min(setup.turns, 5u); turn++) {
        let other = window[(lane + turn * 7u) % 128u];
        basis = basis * tables[turn];
        history[turn % 4u] = basis * other.xy;
        surface.layers[turn % 3u] += other.z;
        surface.kind += i32(is_bright);
        bits[turn % 3u] ^= u32(other.w * 65535.0);
        workgroupBarrier();
        window[lane] = window[lane] * 0.5 + texel * 0.25;
        workgroupBarrier();
    }
    surface.normal = mix(surface.normal, window[lane].xyz, setup.mixed);
    var sum = vec2<f32>(0.0);
    for (var i = 0; i < 4; i++) {
        sum += history[i];
    }
    if id.x >= setup.size.x || id.y >= setup.size.y {
        return;
    }
    textureStore(lit, id.xy, vec4<f32>(surface.normal.xy + sum, surface.layers[0] + surface.layers[2], f32(surface.kind)));
    textureStore(more, id.xy, vec4<u32>(bits, u32(is_bright)));
}
