// A workgroup whose size is decided when the pipeline is made.
override SIDE: u32 = 8u;
override gain: f32 = 0.5;
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(SIDE, SIDE / 2u)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let at = group.xy * vec2(SIDE, SIDE / 2u) + local.xy;
    textureStore(picture, at, textureLoad(input, at, 0) * gain);
}
