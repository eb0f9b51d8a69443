// Barriers of storage and of textures order memory, too; they do not part workgroup memory.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> first: array<f32>;
@group(0) @binding(2) var result: texture_storage_2d<rgba32float, write>;

var<workgroup> shared_row: array<f32, 64>;

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let size = textureDimensions(image);
    let color = textureLoad(image, min(gid.xy, size - 1u), 0);
    shared_row[lane] = color.x;
    storageBarrier();
    workgroupBarrier();
    let across = shared_row[lane ^ 9u];
    if all(gid.xy < size) {
        first[gid.y * size.x + gid.x] = across;
    }
    storageBarrier();
    textureBarrier();
    if all(gid.xy < size) {
        textureStore(result, gid.xy, vec4<f32>(across, color.yzw));
    }
}
