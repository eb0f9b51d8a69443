// options: {"targets": {"frames": "copy"}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var<storage, read_write> frames: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    if all(id == vec3(0u)) {
        frames[0] = 1u; // here
    }
}
