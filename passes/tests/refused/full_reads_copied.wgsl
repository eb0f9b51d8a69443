// options: {"targets": {"mask": "full"}}
@group(0) @binding(0) var<storage, read_write> color: array<vec4<f32>>;
@group(0) @binding(1) var mask: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * 64u + id.x;
    color[at] = color[at] * 0.5;
    textureStore(mask, id.xy, color[at]);
}

// ---- is refused ----

error[VRCS026]: what is stored to `mask` cannot be separated from the rest: one side reads `color`, which the other stores
  ┌─ full_reads_copied.wgsl:9:31
  │
9 │     textureStore(mask, id.xy, color[at]);
  │                               ^^^^^^^^^ here
  │
  = help: let these targets be copied, or store to them in an entry point of their own, in a dispatch before or behind this one
