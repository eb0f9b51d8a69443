@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var full: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var half: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let depth = textureLoad(source, id.xy, 0);
    textureStore(full, id.xy, depth);
    if all(local.xy % 2u == vec2<u32>(0u)) {
        textureStore(half, id.xy / 2u, depth);
    }
}

// ---- is refused ----

error[VRCS012]: a store to `half` runs only for some ids and does not go to the pixel's own place; `full` could do that, but 1 of the 2 statements that other stores need would run twice, so that nothing would be saved
   ┌─ half_by_vector.wgsl:10:9
   │
 9 │     if all(local.xy % 2u == vec2<u32>(0u)) {
   │        --- the condition on the ids
10 │         textureStore(half, id.xy / 2u, depth);
   │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ lost when the invocation that runs it is a duplicate
   │
   = help: `--target half=full` has every pixel store there what the original does; or move this store to an entry point of its own
