// Each pixel shows the depth that its entry carried, as bits.
fn vrcs_depth() -> f32 { return -1.0; }

struct Frame { size: vec2<u32>, number: u32, rays: u32 }

@group(0) @binding(0) var<storage, read_write> result: array<u32>;
@group(0) @binding(1) var<uniform> frame: Frame;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    result[id.y * frame.size.x + id.x] = bitcast<u32>(vrcs_depth());
}
