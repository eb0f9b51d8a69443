@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(1) @binding(1) var<storage> vrcs_coords: array<u32>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(f32(vrcs_coords[id.x])));
}
