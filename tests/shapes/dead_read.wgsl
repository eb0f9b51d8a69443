// One helper for both passes of a blur: a constant says which buffer is read, and which is written. The other's read is dropped.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> a: array<f32>;
@group(0) @binding(2) var<storage, read_write> b: array<f32>;

fn blur(from_a: bool, at: vec2<u32>, step: vec2<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    var sum = 0.0;
    for (var k = 0u; k < 3u; k++) {
        let place = min(at + step * k, vec2(frame.width, frame.height) - 1u);
        let i = place.y * frame.width + place.x;
        sum += select(b[i], a[i], from_a);
    }
    let o = at.y * frame.width + at.x;
    if from_a { b[o] = sum; } else { a[o] = sum; }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    blur(true, id.xy, vec2(1u, 0u));
}

@compute @workgroup_size(8, 8)
fn down(@builtin(global_invocation_id) id: vec3<u32>) {
    blur(false, id.xy, vec2(0u, 1u));
}
