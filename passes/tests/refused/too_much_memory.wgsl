@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> large: array<vec4<u32>, 1000>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    large[lane] = vec4<u32>(id, lane);
    let mine = large[lane] * 3u;
    workgroupBarrier();
    textureStore(picture, id.xy, mine + large[63u - lane]);
}

// ---- is refused ----

error[VRCS020]: `main` needs 17024 bytes of workgroup memory, and the device has 16384: 16000 of the author's and 1024 for exchanges (`large` 16000, `vrcs_exchange_mine` 1024)
  ┌─ too_much_memory.wgsl:2:1
  │
2 │ var<workgroup> large: array<vec4<u32>, 1000>;
  │ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `large` 16000 bytes
  │
  = help: make what is exchanged smaller, or compute it from the ids, or raise `max_workgroup_memory` to what the device has
