// options: {"targets": {"normal": "full"}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var normals: texture_storage_2d<rgba8snorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    textureStore(normals, id.xy, vec4(0.0, 0.0, 1.0, 0.0));
}
