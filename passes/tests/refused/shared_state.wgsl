// The state that a pixel reads is that of four pixels, so others write it.
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;

fn place(id: vec2<u32>) -> u32 {
    return (id.y >> 1u) * textureDimensions(picture).x + (id.x >> 1u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = place(id.xy);
    state[at] = state[at] * 0.5 + textureLoad(picture, id.xy, 0).x;
}

// ---- is refused ----

error[VRCS013]: `state` is read at a place that several pixels write
   ┌─ shared_state.wgsl:12:17
   │
12 │     state[at] = state[at] * 0.5 + textureLoad(picture, id.xy, 0).x;
   │     ------------^^^^^^^^^-----------------------------------------
   │     │           │
   │     │           reads another invocation's output
   │     stores there
   │
   = help: read from a second resource that this dispatch does not write, as a ping-pong pair does

error[VRCS011]: several pixels store to one place of `state`, and they may have different primaries, so what it holds would be chance
   ┌─ shared_state.wgsl:12:5
   │
12 │     state[at] = state[at] * 0.5 + textureLoad(picture, id.xy, 0).x;
   │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ pixels (0, 0) and (1, 0) store to the same place
   │
   = help: dispatch one invocation for each place, in an entry point of its own; or `--target state=full`: every pixel stores there what the original does
