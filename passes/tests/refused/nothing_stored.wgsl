@group(0) @binding(0) var<storage, read> input: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let unused = input[id.x];
}

// ---- is refused ----

error[VRCS003]: the entry point stores nothing at an address that depends on both axes of its invocation grid
 = help: name another entry point with --entry
