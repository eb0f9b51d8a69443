// Random seeds: each primary goes on with its own, and duplicates keep theirs.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var<storage, read_write> seeds: array<u32>;

fn random(index: u32) -> f32 {
    let seed = seeds[index] * 747796405u + 2891336453u;
    seeds[index] = seed;
    return f32(seed >> 8u) / 16777216.0;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let noise = random(id.y * frame.width + id.x);
    textureStore(picture, id.xy, textureLoad(input, id.xy, 0) * noise);
}
