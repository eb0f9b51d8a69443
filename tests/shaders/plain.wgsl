// One store at the pixel itself, no guard: WebGPU ignores what lies outside.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, textureLoad(input, id.xy, 0) * 0.5);
}
