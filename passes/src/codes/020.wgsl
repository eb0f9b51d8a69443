@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> large: array<vec4<u32>, 1000>; // here

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    large[lane] = vec4<u32>(id, lane);
    let mine = large[lane] * 3u;
    workgroupBarrier();
    textureStore(picture, id.xy, mine + large[63u - lane]);
}
