@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var<storage, read_write> histogram: array<atomic<u32>, 16>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    atomicAdd(&histogram[id.x % 16u], 1u); // here
    textureStore(picture, id.xy, vec4(1.0));
}
