@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

fn share(lane: u32, value: u32) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    return sums[63u - lane];
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    textureStore(picture, id.xy, vec4<u32>(share(lane, id.x)));
}

// ---- is refused ----

error[VRCS015]: the helper function `share` has a barrier inside
  ┌─ barrier_in_helper.wgsl:4:1
  │  
4 │ ╭ fn share(lane: u32, value: u32) -> u32 {
5 │ │     sums[lane] = value;
6 │ │     workgroupBarrier();
7 │ │     return sums[63u - lane];
8 │ │ }
  │ ╰─^ every invocation of the workgroup has to get through here
  │  
  = help: move the barrier into the entry point, and what stands before and behind it into functions of their own
