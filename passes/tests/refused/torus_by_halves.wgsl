// Two pixels share a place of the torus, of which one stores.
struct Window { origin: vec2<u32>, size: vec2<u32> }
@group(0) @binding(0) var<uniform> window: Window;
@group(0) @binding(1) var<storage, read_write> cells: array<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let half = id.xy / 2u;
    if any(half >= window.size) {
        return;
    }
    textureStore(picture, id.xy, vec4(1.0));
    let place = (window.origin + half) % window.size;
    if (id.x & 1u) == 0u && (id.y & 1u) == 0u {
        cells[place.y * window.size.x + place.x] = 1.0;
    }
}

// ---- is refused ----

error[VRCS012]: a store to `cells` runs only for some ids and does not go to the pixel's own place; `full` could do that, but 3 of the 4 statements that other stores need would run twice, so that nothing would be saved
   ┌─ torus_by_halves.wgsl:16:9
   │
15 │     if (id.x & 1u) == 0u && (id.y & 1u) == 0u {
   │        ----------------- the condition on the ids
16 │         cells[place.y * window.size.x + place.x] = 1.0;
   │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ lost when the invocation that runs it is a duplicate
   │
   = help: `--target cells=full` has every pixel store there what the original does; or move this store to an entry point of its own
