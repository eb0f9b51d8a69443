// One pixel of each quad stores to a buffer half as wide and half as high, and nobody stores anything else: the domain is every
// second pixel of every second row.
struct Frame { width: u32, height: u32 }

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> half: array<vec4<f32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height { return; }
    if all(id.xy % vec2(2u) == vec2(0u)) {
        half[(id.y / 2u) * frame.width + id.x / 2u] = textureLoad(source, id.xy, 0);
    }
}
