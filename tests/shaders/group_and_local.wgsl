// The pixel from the workgroup's place and the local place, in a struct; and a look-up by the local index.
struct Ids {
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
    @builtin(num_workgroups) count: vec3<u32>,
}
@group(0) @binding(0) var input: texture_2d<f32>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var ids: texture_storage_2d<rgba32uint, write>;

@compute @workgroup_size(8, 4)
fn main(in: Ids) {
    let at = in.group.xy * vec2(8u, 4u) + in.local.xy;
    textureStore(picture, at, textureLoad(input, at, 0));
    textureStore(ids, at, vec4(in.index, in.group.x + in.count.x * in.group.y, in.local.x, in.local.y));
}
