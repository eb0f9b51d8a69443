// An invocation reads what its neighbour writes.
@group(0) @binding(0) var heights: texture_storage_2d<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let left = textureLoad(heights, vec2<i32>(id.xy) - vec2(1, 0)).x;
    textureStore(heights, id.xy, vec4(left * 0.5));
}

// ---- is refused ----

error[VRCS013]: `heights` is read at another place than this invocation's own, while others write it
  ┌─ neighbour.wgsl:6:16
  │
6 │     let left = textureLoad(heights, vec2<i32>(id.xy) - vec2(1, 0)).x;
  │                ^^^^^^^^^^^ reads another invocation's output
7 │     textureStore(heights, id.xy, vec4(left * 0.5));
  │     --------------------------------------------- the invocation's own place
  │
  = help: read from a second resource that this dispatch does not write, as a ping-pong pair does
