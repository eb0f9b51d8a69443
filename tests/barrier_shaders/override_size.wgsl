// The workgroup's size is an override; the tile follows it. Each group finds its brightest pixel.

override WIDTH: u32 = 8;
override HEIGHT: u32 = 8;

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba8unorm, write>;

var<workgroup> brightest: atomic<u32>;
var<workgroup> row: array<f32, 256>;

@compute @workgroup_size(WIDTH, HEIGHT)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_id) lid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let color = textureLoad(image, gid.xy, 0);
    atomicMax(&brightest, u32(color.x * 255.0));
    row[lane] = color.y;
    workgroupBarrier();
    let share = color.x * 255.0 / f32(max(atomicLoad(&brightest), 1u));
    let mirrored = row[lid.y * WIDTH + WIDTH - 1u - lid.x];
    if all(gid.xy < textureDimensions(image)) {
        textureStore(result, gid.xy, vec4<f32>(share, mirrored, color.z, 1.0));
    }
}
