// A shadow denoiser's first step: hits of 8x4 pixels as one word, then a filter that only mixed tiles run.
struct Shadow { size: vec2<u32>, sigma: f32, pad: f32, }
@group(0) @binding(0) var<uniform> shadow: Shadow;
@group(0) @binding(1) var hits: texture_2d<u32>;
@group(0) @binding(2) var depth: texture_2d<f32>;
@group(0) @binding(3) var mask_out: texture_storage_2d<r32float, write>;
var<workgroup> mask: atomic<u32>;

@compute @workgroup_size(8, 4)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    if lane == 0u { atomicStore(&mask, 0u); }
    workgroupBarrier();
    let is_hit = (textureLoad(hits, gid.xy, 0).x & 1u) == 1u;
    if is_hit { atomicOr(&mask, 1u << lane); }
    workgroupBarrier();
    let word = atomicLoad(&mask);
    if any(gid.xy >= shadow.size) { return; }
    if word == 0u || word == 0xffffffffu {
        textureStore(mask_out, gid.xy, vec4<f32>(f32(word & 1u)));
        return;
    }
    let z = textureLoad(depth, gid.xy, 0).x;
    var lit = 0.0;
    var weights = 0.0;
    for (var y = 0u; y < 4u; y++) {
        for (var x = 0u; x < 8u; x++) {
            let at = gid.xy - lid.xy + vec2<u32>(x, y);
            let dz = textureLoad(depth, at, 0).x - z;
            let w = exp(-dz * dz * shadow.sigma);
            lit += w * f32((word >> (y * 8u + x)) & 1u);
            weights += w;
        }
    }
    textureStore(mask_out, gid.xy, vec4<f32>(lit / weights));
}
