@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> bins: array<atomic<u32>, 64>;
var<workgroup> own: array<atomic<u32>, 64>;

@compute @workgroup_size(16, 16)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let luma = textureLoad(picture, id.xy, 0).g;
    atomicAdd(&own[u32(clamp(luma, 0.0, 1.0) * 63.0)], 1u);
    workgroupBarrier();
    if lane < 64u {
        atomicAdd(&bins[lane], atomicLoad(&own[lane]));
    }
}

// ---- is refused ----

error[VRCS003]: every workgroup stores to the same places, so the entry point works out no pixels
   ┌─ histogram.wgsl:11:9
   │
11 │         atomicAdd(&bins[lane], atomicLoad(&own[lane]));
   │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ does not move with the workgroup
   │
   = help: leave this entry point as it is, and name another with --entry
