// options: {"targets": {"noise": "full"}}
@group(0) @binding(0) var noise: texture_storage_2d<r32uint, write>;
@group(0) @binding(1) var picture: texture_storage_2d<r32uint, write>;
var<private> seed: u32 = 7u;

fn random() -> u32 {
    seed = seed * 747796405u + 2891336453u;
    return seed;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(noise, id.xy, vec4<u32>(random() + id.x));
    textureStore(picture, id.xy, vec4<u32>(random()));
}

// ---- is refused ----

error[VRCS026]: what is stored to `noise` cannot be separated from the rest: both use the private variable `seed`
  ┌─ full_private.wgsl:4:1
  │
4 │ var<private> seed: u32 = 7u;
  │ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^ here
  │
  = help: let these targets be copied, or store to them in an entry point of their own, in a dispatch before or behind this one
