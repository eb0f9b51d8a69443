// What is read is the pixel's own place, but the pixel to the left stores there, too.
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = id.y * textureDimensions(picture).x + id.x;
    let before = state[at];
    state[at] = before * 0.5 + textureLoad(picture, id.xy, 0).x;
    state[at + 1u] = before;
}

// ---- is refused ----

error[VRCS013]: `state` is read at another place than this invocation's own, while others write it
  ┌─ beside_own.wgsl:8:18
  │
8 │     let before = state[at];
  │                  ^^^^^^^^^ reads another invocation's output
9 │     state[at] = before * 0.5 + textureLoad(picture, id.xy, 0).x;
  │     ----------------------------------------------------------- the invocation's own place
  │
  = help: read from a second resource that this dispatch does not write, as a ping-pong pair does
