// The window is wider than the torus, and the pixels that share a place are told apart by a condition.
struct Window { size: vec2<u32> }
@group(0) @binding(0) var<uniform> window: Window;
@group(0) @binding(1) var<storage, read_write> cells: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= window.size * 2u) {
        return;
    }
    let place = id.xy % window.size;
    if id.x < window.size.x && id.y < window.size.y {
        cells[place.y * window.size.x + place.x] = 1.0;
    } else if id.x == 0u {
        cells[place.y * window.size.x + place.x] = 0.0;
    }
}

// ---- is refused ----

error[VRCS012]: a store to `cells` runs only for some ids and does not go to the pixel's own place
   ┌─ narrow_torus.wgsl:15:9
   │
12 │     if id.x < window.size.x && id.y < window.size.y {
   │        -------------------------------------------- the condition on the ids
   ·
15 │         cells[place.y * window.size.x + place.x] = 0.0;
   │         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ lost when the invocation that runs it is a duplicate
   │
   = help: `--target cells=full` has every pixel store there what the original does; or move this store to an entry point of its own
