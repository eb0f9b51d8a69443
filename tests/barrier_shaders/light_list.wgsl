// The classic: cull into a list by an atomic counter, meet, shade from the list. An integer sum, so the list's order is no matter.
struct Frame { size: vec2<u32>, lights: u32, pad: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> lights: array<vec4<f32>>;
@group(0) @binding(2) var result: texture_storage_2d<r32uint, write>;
var<workgroup> n: atomic<u32>;
var<workgroup> list: array<u32, 64>;
@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(workgroup_id) wid: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if lane == 0u { atomicStore(&n, 0u); }
    workgroupBarrier();
    let count = min(min(frame.lights, 64u), arrayLength(&lights));
    for (var i = lane; i < count; i += 256u) {
        if distance(lights[i].xy * 4.0, vec2<f32>(wid.xy)) < lights[i].w * 8.0 {
            let at = atomicAdd(&n, 1u);
            list[at] = i;
        }
    }
    workgroupBarrier();
    if gid.x >= frame.size.x || gid.y >= frame.size.y { return; }
    var sum = 0u;
    let m = atomicLoad(&n);
    for (var j = 0u; j < m; j++) {
        sum += list[j] * (gid.x + 1u) + gid.y;
    }
    textureStore(result, gid.xy, vec4<u32>(sum));
}
