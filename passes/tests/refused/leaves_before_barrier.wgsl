@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    sums[lane] = id.x;
    workgroupBarrier();
    textureStore(picture, id.xy, vec4<u32>(sums[63u - lane]));
}

// ---- is refused ----

error[VRCS015]: an invocation may leave before a barrier, under a condition that may differ within a workgroup
  ┌─ leaves_before_barrier.wgsl:6:8
  │
6 │     if any(id.xy >= textureDimensions(picture)) {
  │        ^^^ comes from an invocation's id, or from memory that is written
7 │         return;
  │         ------- the others wait for it at the next barrier
  │
  = help: take the condition from a uniform, from `workgroup_id`, or from `workgroupUniformLoad`; wrap the work between the barriers in it, not the barriers
