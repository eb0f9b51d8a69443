@group(0) @binding(0) var volume: texture_storage_3d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(4, 4, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = id.x;
    workgroupBarrier();
    textureStore(volume, id, vec4<u32>(sums[63u - lane]));
}

// ---- is refused ----

error[VRCS015]: the workgroup has a depth, and its invocations work together
  ┌─ deep_group.wgsl:7:5
  │
7 │     workgroupBarrier();
  │     ^^^^^^^^^^^^^^^^ they meet here
  │
  = help: a tile is flat: dispatch one layer of workgroups for each layer instead
