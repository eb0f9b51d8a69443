// Several words for each pixel, and rows that are longer than the picture: an unrolled write of two pixels each.
struct Frame { width: u32, height: u32, row_stride: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> words: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = id.x * 2u;
    let row = id.y * (frame.width + 3u);
    if id.y >= frame.height {
        return;
    }
    let color = textureLoad(input, id.xy, 0);
    if x < frame.width {
        words[(row + x) * 2u] = color.x;
        words[(row + x) * 2u + 1u] = color.y;
    }
    if x + 1u < frame.width {
        words[(row + x + 1u) * 2u] = color.z;
        words[(row + x + 1u) * 2u + 1u] = color.w;
    }
}
