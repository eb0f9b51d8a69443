// A workgroup that no tile is a multiple of.
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(5, 7)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    let at = group.xy * vec2(5u, 7u) + local.xy;
    textureStore(picture, vec2(at.x, id.y), textureLoad(input, at, 0) * f32(local.x + 1u) * 0.2);
}
