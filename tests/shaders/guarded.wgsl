// A border is skipped: the domain does not start at the origin.
struct Frame { size: vec2<u32>, border: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy < vec2(frame.border)) || any(id.xy >= frame.size - vec2(frame.border)) {
        return;
    }
    let left = textureLoad(input, id.xy - vec2(1u, 0u), 0);
    let right = textureLoad(input, id.xy + vec2(1u, 0u), 0);
    textureStore(picture, id.xy, left - right);
}
