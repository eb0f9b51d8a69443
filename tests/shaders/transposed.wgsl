// Rotated by a quarter: x and y change places, and one runs backwards.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(picture));
    let at = vec2<i32>(id.xy);
    let to = vec2(size.x - 1 - at.y, at.x);
    if all(to >= vec2(0)) && all(to < size) {
        textureStore(picture, to, textureLoad(input, at, 0));
    }
}
