@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sum = subgroupAdd(f32(id.x));
    textureStore(picture, id.xy, vec4(sum));
}

// ---- is refused ----

error[VRCS016]: the result of `subgroupAdd` depends on which invocations share a subgroup
  ┌─ subgroup.wgsl:5:15
  │
5 │     let sum = subgroupAdd(f32(id.x));
  │               ^^^^^^^^^^^ other pixels share a subgroup when only primaries run
  │
  = help: use workgroup memory, or leave this entry point as it is
