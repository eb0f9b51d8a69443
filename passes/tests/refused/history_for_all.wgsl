@group(0) @binding(0) var<storage, read_write> history: array<u32>;
var<workgroup> sums: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = id.y * 64u + id.x;
    sums[lane] = history[at];
    workgroupBarrier();
    history[at] = sums[63u - lane];
}

// ---- is refused ----

error[VRCS013]: `history` is stored to, and read for the whole workgroup
  ┌─ history_for_all.wgsl:7:18
  │
7 │     sums[lane] = history[at];
  │                  ^^^^^^^^^^^ goes into workgroup memory, or into an exchange
  │
  = help: read from a second resource that this dispatch does not write, as a ping-pong pair does
