struct Params {
    width: u32,
    height: u32,
}
@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = vec2<u32>(id.x % params.width, id.x / params.width);
    textureStore(picture, at, vec4<f32>(vec2<f32>(at), 0.0, 1.0));
}

// ---- is refused ----

error[VRCS003]: the entry point stores nothing at an address that depends on both axes of its invocation grid
   ┌─ row_by_row.wgsl:11:5
   │
11 │     textureStore(picture, at, vec4<f32>(vec2<f32>(at), 0.0, 1.0));
   │     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ depends on x alone
   │
   = help: if the dispatch goes over a picture's pixels row by row, tell its width: `--linear params.width`; else name another entry point with --entry
