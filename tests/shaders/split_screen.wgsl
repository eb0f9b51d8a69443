// Two ways to shade, left and right of a line: both store at the pixel's own place.
struct Frame { middle: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(input, id.xy, 0);
    if id.x < frame.middle * 4u {
        textureStore(picture, id.xy, color);
    } else {
        textureStore(picture, id.xy, vec4(dot(color.rgb, vec3(0.299, 0.587, 0.114))));
    }
}
