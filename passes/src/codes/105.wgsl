@group(0) @binding(0) var samples: texture_2d<f32>;
@group(0) @binding(1) var mean: texture_storage_2d<rgba16float, write>;

var<workgroup> parts: array<vec4<f32>, 64>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    parts[lane] = textureLoad(samples, group.xy * 8u + vec2(lane % 8u, lane / 8u), 0);
    workgroupBarrier();
    for (var step = 32u; step > 0u; step >>= 1u) {
        if lane < step {
            parts[lane] += parts[lane + step];
        }
        workgroupBarrier();
    }
    if lane == 0u {
        textureStore(mean, group.xy, parts[0] / 64.0); // here
    }
}
