// Each pixel reads what an earlier frame left at its own place, and adds to it.
struct Frame { width: u32, height: u32, index: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(3) var history: texture_storage_2d<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let index = id.y * frame.width + id.x;
    let sample = textureLoad(input, id.xy, 0);
    let sum = sums[index] + sample;
    sums[index] = sum;
    let before = textureLoad(history, id.xy).x;
    textureStore(history, id.xy, vec4(mix(before, sum.x, 0.1)));
}
