// A workgroup of one, as teaching code has it.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(1)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let uv = vec2<f32>(id.xy) / vec2<f32>(size.xy);
    textureStore(picture, id.xy, vec4(uv, fract(uv.x * 7.0 + uv.y), 1.0));
}
