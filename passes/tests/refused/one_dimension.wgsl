@group(0) @binding(0) var<storage, read_write> values: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    values[id.x] = 2.0;
}

// ---- is refused ----

error[VRCS003]: the entry point stores nothing at an address that depends on both axes of its invocation grid
  ┌─ one_dimension.wgsl:5:5
  │
5 │     values[id.x] = 2.0;
  │     ^^^^^^^^^^^^^^^^^^ depends on x alone
  │
  = help: if the dispatch goes over a picture's pixels row by row, tell its width: `--linear WIDTH`; else name another entry point with --entry
