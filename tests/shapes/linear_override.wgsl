// The width is an override, the place a tile of 8x8, and invocations behind the picture are not stopped.
override WIDTH: u32 = 61u;
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>, 8192>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(128)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = vec2(id.x % WIDTH, id.x / WIDTH);
    let color = textureLoad(input, at, 0);
    let tile = at / 8u;
    texels[(tile.y * 8u + tile.x) * 64u + (at.y % 8u) * 8u + at.x % 8u] = color;
    textureStore(picture, vec2(id.x % 61u, id.x / 61u), color);
}
