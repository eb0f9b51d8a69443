// Parts of elements: a member, a component, an element of a small array, through pointers.
struct Texel { color: vec3<f32>, weight: f32, ids: array<u32, 4> }
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var input: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> texels: array<Texel>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.width || id.y >= frame.height {
        return;
    }
    let color = textureLoad(input, id.xy, 0);
    let texel = &texels[id.x + frame.width * id.y];
    (*texel).color.y = color.x;
    (*texel).weight = color.y;
    (*texel).ids[u32(color.z * 3.0)] = 7u;
    for (var i = 0u; i < 2u; i++) {
        texel.ids[i * 3u] = i + u32(color.w * 100.0);
    }
}
