@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    var axis = 2;
    let place = id.xy;
    textureStore(picture, vec2(place[axis], place.y), vec4(1.0));
}

// ---- is refused ----

error[VRCS010]: where a duplicate would store in `picture` cannot be computed: an index lies beyond the end of what it indexes
  ┌─ beyond.wgsl:7:5
  │
7 │     textureStore(picture, vec2(place[axis], place.y), vec4(1.0));
  │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ the store
  │
  = help: compute the address from the invocation's ids, uniforms and read-only memory
