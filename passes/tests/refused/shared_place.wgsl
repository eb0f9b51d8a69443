// Four pixels store to each texel of the half-size target. Blocks of four may have one primary, or several where surfaces end.
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var half: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(picture, id.xy, 0);
    textureStore(half, id.xy / 2u, color);
}

// ---- is refused ----

error[VRCS011]: several pixels store to one place of `half`, and they may have different primaries, so what it holds would be chance
  ┌─ shared_place.wgsl:8:5
  │
8 │     textureStore(half, id.xy / 2u, color);
  │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ pixels (0, 0) and (1, 0) store to the same place
  │
  = help: dispatch one invocation for each place, in an entry point of its own; or `--target half=full`: every pixel stores there what the original does
