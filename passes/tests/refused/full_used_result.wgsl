// options: {"targets": {"count": "full"}}
@group(0) @binding(0) var<storage, read_write> count: atomic<u32>;
@group(0) @binding(1) var picture: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = atomicAdd(&count, 1u);
    textureStore(picture, id.xy, vec4<u32>(slot));
}

// ---- is refused ----

error[VRCS026]: what is stored to `count` cannot be separated from the rest: the result of an atomic on one side is used on the other
  ┌─ full_used_result.wgsl:7:16
  │
7 │     let slot = atomicAdd(&count, 1u);
  │                ^^^^^^^^^ here
  │
  = help: let these targets be copied, or store to them in an entry point of their own, in a dispatch before or behind this one
