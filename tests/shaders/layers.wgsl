// A layer for each z, and a 3-D target beside it.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d_array<rgba8unorm, write>;
@group(0) @binding(2) var volume: texture_storage_3d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(input, id.xy, 0) * (1.0 / f32(id.z + 1u));
    textureStore(picture, id.xy, id.z, color);
    textureStore(volume, vec3<i32>(id), color.wzyx);
}
