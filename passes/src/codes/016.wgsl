@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sum = subgroupAdd(f32(id.x)); // here
    textureStore(picture, id.xy, vec4(sum));
}
