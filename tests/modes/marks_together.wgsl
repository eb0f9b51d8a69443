// A workgroup whose tile lies in fog leaves as a whole, before its barrier; the others blur by what they have in common.
fn vrcs_user() -> u32 { return 0u; }

@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba32float, write>;

var<workgroup> values: array<f32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if (vrcs_user() & 1u) != 0u {
        return;
    }
    values[lane] = textureLoad(input, min(id.xy, textureDimensions(input) - 1u), 0).x;
    workgroupBarrier();
    var sum = 0.0;
    for (var i = 0u; i < 64u; i++) {
        sum += values[i] * f32(i + vrcs_user());
    }
    textureStore(picture, id.xy, vec4(sum, f32(vrcs_user()), vec2<f32>(id.xy)));
}
