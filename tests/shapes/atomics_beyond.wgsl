// Additions that go beyond the end of their array for most pixels: a driver may drop them, or send them to the last word, which is
// what naga's bounds checks do.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> cells: array<atomic<i32>>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(source, id.xy, 0);
    textureStore(picture, id.xy, color);
    atomicAdd(&cells[id.y * 1000u + id.x * 3u], 1 + i32(color.x * 4.0));
}
