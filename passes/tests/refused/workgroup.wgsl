@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
var<workgroup> shared_sum: array<f32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    shared_sum[i] = f32(id.x);
    workgroupBarrier();
    textureStore(picture, id.xy, vec4(shared_sum[63u - i]));
}

// ---- is refused ----

error[VRCS015]: the shader uses the workgroup variable `shared_sum`
  ┌─ workgroup.wgsl:6:5
  │
6 │     shared_sum[i] = f32(id.x);
  │     ^^^^^^^^^^^^^^^^^^^^^^^^^ shared by the invocations of a workgroup

error[VRCS015]: the shader has a barrier, so its invocations cannot leave early
  ┌─ workgroup.wgsl:7:5
  │
7 │     workgroupBarrier();
  │     ^^^^^^^^^^^^^^^^ every invocation of the workgroup has to get here

error[VRCS015]: the shader uses the workgroup variable `shared_sum`
  ┌─ workgroup.wgsl:8:39
  │
8 │     textureStore(picture, id.xy, vec4(shared_sum[63u - i]));
  │                                       ^^^^^^^^^^^^^^^^^^^ shared by the invocations of a workgroup
