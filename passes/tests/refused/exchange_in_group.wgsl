// What is taken may be taken twice where the parts between barriers run apart.
@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
@group(0) @binding(1) var<storage, read_write> drawn: array<atomic<u32>>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    sums[lane] = id.x;
    workgroupBarrier();
    let taken = atomicExchange(&drawn[id.y * 64u + id.x], 0u);
    textureStore(picture, id.xy, vec4<u32>(taken + sums[63u - lane]));
}

// ---- is refused ----

error[VRCS014]: `atomicExchange` on `drawn` cannot stand for the pixels that do not run: the invocations of a workgroup work together
   ┌─ exchange_in_group.wgsl:10:17
   │
10 │     let taken = atomicExchange(&drawn[id.y * 64u + id.x], 0u);
   │                 ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ runs once for each primary
   │
   = help: exchange at the invocation's own place alone, or move it to an entry point of its own
