// options: {"targets": {"half": "copy"}}
// A half-size target that one pixel of each quad writes.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var half: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(1.0));
    if (id.x & 1u) == 0u && (id.y & 1u) == 0u {
        textureStore(half, id.xy / 2u, vec4(0.5));
    }
}

// ---- is refused ----

error[VRCS012]: a store to `half` runs only for some ids and does not go to the pixel's own place
   ┌─ half_size.wgsl:10:9
   │
 9 │     if (id.x & 1u) == 0u && (id.y & 1u) == 0u {
   │        ----------------- the condition on the ids
10 │         textureStore(half, id.xy / 2u, vec4(0.5));
   │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ lost when the invocation that runs it is a duplicate
   │
   = help: `--target half=full` has every pixel store there what the original does; or move this store to an entry point of its own
