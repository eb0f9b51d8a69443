// Where to store is read from memory that the shader writes.
struct State { cursor: array<u32, 4096>, values: array<f32, 4096> }
@group(0) @binding(0) var<storage, read_write> state: State;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.y * 64u + id.x;
    let at = state.cursor[index];
    state.values[at + index] = 1.0;
    state.cursor[index] = at + 1u;
}

// ---- is refused ----

error[VRCS010]: where a duplicate would store in `state` cannot be computed: it is read from memory that the shader writes
  ┌─ written_address.wgsl:9:5
  │
8 │     let at = state.cursor[index];
  │              ------------------- it is read from memory that the shader writes
9 │     state.values[at + index] = 1.0;
  │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ the store
  │
  = help: compute the address from the invocation's ids, uniforms and read-only memory
