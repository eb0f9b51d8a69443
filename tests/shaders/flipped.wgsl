// Flipped, if a uniform says so: one of two addresses, by select and by branch.
struct Frame { flip: u32, size: vec2<i32> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var other: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var at = vec2<i32>(id.xy);
    if frame.flip > 3u {
        at.y = frame.size.y - 1 - at.y;
    }
    let color = textureLoad(input, id.xy, 0);
    textureStore(picture, at, color);
    textureStore(other, select(vec2<i32>(id.xy), vec2(frame.size.x - 1 - at.x, at.y), frame.flip > 5u), color.yxwz);
}
