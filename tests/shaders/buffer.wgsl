// A picture in a storage buffer, row by row, in a struct behind a header; and one of packed words.
struct Frame { size: vec2<u32> }
struct Picture { frames: u32, texels: array<vec4<f32>> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> picture: Picture;
@group(0) @binding(3) var<storage, read_write> packed: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.size.y {
        return;
    }
    let index = id.y * frame.size.x + id.x;
    let color = textureLoad(input, id.xy, 0);
    picture.texels[index] = color;
    packed[index] = pack4x8unorm(color);
}
