@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var<storage, read_write> histogram: array<atomic<u32>, 16>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    atomicAdd(&histogram[id.x % 16u], 1u);
    textureStore(picture, id.xy, vec4(1.0));
}

// ---- is refused ----

error[VRCS014]: an atomic on `histogram` would count primaries instead of pixels
  ┌─ atomic.wgsl:6:5
  │
6 │     atomicAdd(&histogram[id.x % 16u], 1u);
  │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ runs once for each primary
  │
  = help: `--atomics weight` has each primary count for all its pixels
