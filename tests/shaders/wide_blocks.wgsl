// Each invocation writes a block of 4x2 texels; the last block of a row has a single column inside the picture.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var y = 0u; y < 2u; y++) {
        for (var x = 0u; x < 4u; x++) {
            let at = vec2(id.x * 4u + x, id.y * 2u + y);
            if all(at < vec2(frame.width, frame.height)) {
                textureStore(picture, at, textureLoad(input, at, 0) + f32(x + 4u * y));
            }
        }
    }
}
