// options: {"place": {"group": 0, "binding": 1}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<uniform> tint: vec4<f32>; // here

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, tint);
}
