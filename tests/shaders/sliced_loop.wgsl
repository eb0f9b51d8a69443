// An address without a tangent, in a loop: the counter is captured, the rest computed anew. Through a helper, too, whose
// caller keeps the counter for it.
struct Frame { rows: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> texels: array<f32, 16384>;
@group(0) @binding(3) var<storage, read_write> others: array<f32, 12288>;

fn swizzled(at: vec2<u32>) -> u32 {
    return ((at.y / 8u) * 8u + at.x / 8u) * 64u + (at.y & 7u) * 8u + (at.x & 7u);
}

fn put(index: u32, value: f32) {
    others[index] = value;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= 64u || id.y >= 64u || frame.rows > 100u {
        return;
    }
    let color = textureLoad(input, id.xy, 0);
    for (var i = 0u; i < 3u; i++) {
        texels[swizzled(id.xy) * 4u + i] = color[i];
        put(swizzled(id.yx) * 3u + i, color[i] * 2.0);
    }
}
