// Samples loaded by everybody for shared memory and reused by the own pixel: live values.
@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var s: sampler;
@group(0) @binding(2) var result: texture_storage_2d<rgba16float, write>;
struct Tap { c: vec3<f32>, w: f32 }
var<workgroup> taps: array<array<Tap, 10>, 10>;
var<private> weight: f32 = 0.5;
fn tap(p: vec2<i32>) -> Tap {
    let d = vec2<i32>(textureDimensions(image));
    let c = textureSampleLevel(image, s, (vec2<f32>(p) + 0.5) / vec2<f32>(d), 0.0);
    weight += c.w * 0.25;
    return Tap(c.rgb, weight);
}
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>, @builtin(workgroup_id) wid: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let corner = vec2<i32>(wid.xy * 8u) - 1;
    for (var i = lane; i < 100u; i += 64u) {
        taps[i / 10u][i % 10u] = tap(corner + vec2<i32>(vec2<u32>(i % 10u, i / 10u)));
    }
    workgroupBarrier();
    var sum = vec3<f32>();
    var w = weight;
    for (var y = 0u; y < 3u; y++) {
        for (var x = 0u; x < 3u; x++) {
            let t = &taps[lid.y + y][lid.x + x];
            sum += (*t).c * (*t).w;
            w += (*t).w;
        }
    }
    textureStore(result, gid.xy, vec4<f32>(sum / max(w, 0.01), w));
}
