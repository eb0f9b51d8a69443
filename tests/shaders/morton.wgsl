// A buffer in Morton order, computed by a helper with a loop in it.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>, 4096>;

fn morton(at: vec2<u32>) -> u32 {
    var code = 0u;
    for (var bit = 0u; bit < 6u; bit++) {
        code |= ((at.x >> bit) & 1u) << (2u * bit);
        code |= ((at.y >> bit) & 1u) << (2u * bit + 1u);
    }
    return code;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    texels[morton(id.xy)] = textureLoad(input, id.xy, 0);
}
