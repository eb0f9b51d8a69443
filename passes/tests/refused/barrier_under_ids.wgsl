@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = id.x;
    if id.x < 100u {
        workgroupBarrier();
        textureStore(picture, id.xy, vec4<u32>(sums[63u - lane]));
    }
}

// ---- is refused ----

error[VRCS015]: a barrier stands under a condition that may differ within a workgroup
  ┌─ barrier_under_ids.wgsl:7:8
  │
7 │     if id.x < 100u {
  │        ^^^^^^^^^^^ comes from an invocation's id, or from memory that is written
8 │         workgroupBarrier();
  │         ---------------- not every invocation gets here
  │
  = help: take the condition from a uniform, from `workgroup_id`, or from `workgroupUniformLoad`; wrap the work between the barriers in it, not the barriers
