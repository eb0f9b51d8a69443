// Sums, minima and bit sets: of all pixels, in bins that data chooses, and at places that the ids choose.
struct Totals { count: atomic<u32>, least: atomic<u32>, most: atomic<i32>, seen: atomic<u32>, kept: atomic<u32>, debt: atomic<i32> }
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<storage, read_write> bins: array<atomic<u32>, 64>;
@group(0) @binding(3) var<storage, read_write> totals: Totals;
@group(0) @binding(4) var<storage, read_write> columns: array<atomic<u32>>;

fn count(bin: u32, weight: u32) {
    atomicAdd(&bins[bin], weight);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    let color = textureLoad(input, id.xy, 0);
    let bin = u32(color.x * 63.0);
    count(bin, 1u);
    count(u32(color.y * 63.0), 3u);
    atomicAdd(&totals.count, 1u);
    atomicSub(&totals.debt, i32(bin));
    atomicMin(&totals.least, bin + 7u);
    atomicMax(&totals.most, -i32(bin));
    atomicOr(&totals.seen, 1u << (bin % 32u));
    atomicAnd(&totals.kept, ~(1u << (bin / 4u)));
    atomicAdd(&columns[id.x], 1u + bin);
    atomicMax(&columns[128u + id.y], bin);
    textureStore(picture, id.xy, color);
}
