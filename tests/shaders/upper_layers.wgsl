// All layers but the first one store a second time, at places that masks do not tell apart for the analysis.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d_array<rgba8unorm, write>;
@group(0) @binding(2) var below: texture_storage_2d_array<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(input, id.xy, 0) * (1.0 / f32(id.z + 1u));
    textureStore(picture, id.xy, id.z, color);
    if id.z > 0u {
        textureStore(below, id.xy & vec2(1023u), id.z - 1u, color.wzyx);
    }
}
