// options: {"place": {"group": 0, "binding": 1}}
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<uniform> tint: vec4<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, tint);
}

// ---- is refused ----

error[VRCS024]: the coordinate buffer cannot be binding 2 of group 0: that is `tint`
  ┌─ place_taken.wgsl:3:23
  │
3 │ @group(0) @binding(2) var<uniform> tint: vec4<f32>;
  │                       ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `tint` has this place
  │
  = help: the added bindings take two numbers in a row, 1 and 2: name others, or leave `--place` out
