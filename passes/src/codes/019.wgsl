// options: {"targets": {"history": "refuse"}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var history: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    textureStore(history, id.xy, vec4(1.0)); // here
}
