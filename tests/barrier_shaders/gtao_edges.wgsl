// Denoising by edges: what an invocation computes for its pixel is read by its neighbours behind the barrier, twice.
@group(0) @binding(0) var raw: texture_2d<f32>;
@group(0) @binding(1) var out_: texture_storage_2d<r32float, write>;
struct P { beta: f32, passes: u32, }
@group(0) @binding(2) var<uniform> p: P;
var<workgroup> value: array<f32, 100>;
var<workgroup> edge: array<vec4<f32>, 100>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) gid: vec3<u32>, @builtin(local_invocation_id) lid: vec3<u32>, @builtin(local_invocation_index) li: u32) {
    let base = vec2<i32>(gid.xy - lid.xy) - 1;
    for (var k = li; k < 100u; k += 64u) {
        let at = max(base + vec2<i32>(i32(k % 10u), i32(k / 10u)), vec2<i32>(0));
        let t = textureLoad(raw, at, 0);
        value[k] = t.x;
        edge[k] = t;
    }
    workgroupBarrier();
    let me = (lid.y + 1u) * 10u + lid.x + 1u;
    var result = value[me];
    for (var pass_ = 0u; pass_ < min(p.passes, 3u); pass_++) {
        let e = edge[me];
        let sum = value[me] * p.beta + value[me - 1u] * e.x + value[me + 1u] * e.y + value[me - 10u] * e.z + value[me + 10u] * e.w;
        result = sum / (p.beta + e.x + e.y + e.z + e.w + 0.001);
        workgroupBarrier();
        value[me] = result;
        workgroupBarrier();
    }
    textureStore(out_, gid.xy, vec4<f32>(result));
}
