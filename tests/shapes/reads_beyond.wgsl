// Fills one half of a checkerboard from the other half, in place. At the border it reads beyond the picture, where WGSL may give any texel,
// also one that another pixel stores to.
@group(0) @binding(0) var picture: texture_storage_2d<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 2 * vec2<i32>(id.xy);
    let known = textureLoad(picture, at) + textureLoad(picture, at + 1)
        + textureLoad(picture, at + vec2(2, 0)) + textureLoad(picture, at + vec2(1, -1));
    textureStore(picture, at + vec2(0, 1), known * 0.5);
    textureStore(picture, at + vec2(1, 0), known * 0.25);
}
