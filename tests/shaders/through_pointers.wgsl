// A swizzled buffer of structs that is written member by member through a pointer, with a return half way.
struct View { size: vec2<u32>, pad: vec2<u32> }
struct Texel { color: vec3<f32>, depth: f32, seed: u32 }

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read_write> texels: array<Texel>;
@group(0) @binding(2) var<storage, read> noise: array<f32>;

fn swizzled(at: vec2<u32>) -> u32 {
    let tile = at / 8u;
    let inner = at % 8u;
    let per_row = (view.size.x + 7u) / 8u;
    return (tile.y * per_row + tile.x) * 64u + inner.y * 8u + inner.x;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size) { return; }
    let texel = &texels[swizzled(id.xy)];
    let n = noise[(id.x * 7u + id.y * 13u) % arrayLength(&noise)];
    (*texel).color.y = n;
    (*texel).color.x = n * 2.0;
    (*texel).depth = n + f32(id.x);
    if n > 0.0 {
        (*texel).seed = id.x * 31u + id.y;
        return;
    }
    (*texel).seed = 9u;
}
