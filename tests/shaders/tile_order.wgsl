// The local place from the local index, in another order than the hardware's: the address has no tangent.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let x = (index & 1u) | ((index >> 1u) & 2u) | ((index >> 2u) & 4u);
    let y = ((index >> 1u) & 1u) | ((index >> 2u) & 2u) | ((index >> 3u) & 4u);
    let at = vec2(group.x * 8u + x, group.y * 8u + y);
    textureStore(picture, at, textureLoad(input, at, 0));
}
