struct Item { a: vec3<f32>, n: u32, t: array<f32, 3> }
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> items: array<Item>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= vec2(frame.width, frame.height)) { return; }
    let v = textureLoad(input, id.xy, 0);
    items[id.y * frame.width + id.x] = Item(v.xyz, u32(v.w * 20.0), array(v.x, v.y, v.z));
}
