// Each invocation writes a block of 2x3 texels in a loop.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(4, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(picture);
    for (var y = 0u; y < 3u; y++) {
        for (var x = 0u; x < 2u; x++) {
            let at = id.xy * vec2(2u, 3u) + vec2(x, y);
            if all(at < size) {
                textureStore(picture, at, textureLoad(input, at, 0) + f32(x + 2u * y));
            }
        }
    }
}
