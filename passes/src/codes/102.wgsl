@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> found: atomic<u32>;

@compute @workgroup_size(8, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mine = atomicAdd(&found, id.x); // here
    workgroupBarrier();
    textureStore(picture, id.xy, vec4<u32>(mine + atomicLoad(&found)));
}
