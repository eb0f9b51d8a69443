// Shows what its pixel is told that it shares.
fn vrcs_copies() -> u32 { return 0u; }
fn vrcs_rate() -> vec2<u32> { return vec2<u32>(1u); }

struct Frame { size: vec2<u32>, number: u32, rays: u32 }

@group(0) @binding(0) var<storage, read_write> result: array<u32>;
@group(0) @binding(1) var<uniform> frame: Frame;

@compute @workgroup_size(8, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let rate = vrcs_rate();
    result[id.y * frame.size.x + id.x] = vrcs_copies() | (rate.x << 8u) | (rate.y << 16u);
}
