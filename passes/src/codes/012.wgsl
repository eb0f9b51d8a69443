// options: {"targets": {"half": "copy"}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var half: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    if (id.x & 1u) == 0u && (id.y & 1u) == 0u {
        textureStore(half, id.xy / 2u, vec4(0.5)); // here
    }
}
