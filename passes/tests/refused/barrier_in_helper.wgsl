@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

fn share(lane: u32, value: u32) -> u32 {
    for (var turn = 0u; turn < 4u; turn++) {
        sums[lane] = value + turn;
        workgroupBarrier();
        if turn == 2u {
            return sums[63u - lane];
        }
        workgroupBarrier();
    }
    return 0u;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    textureStore(picture, id.xy, vec4<u32>(share(lane, id.x)));
}

// ---- is refused ----

error[VRCS015]: the helper function `share` has a barrier inside, and cannot be put into its caller's place: it returns out of a loop, out of a `switch`, or in some ways through a branch but not in all
   ┌─ barrier_in_helper.wgsl:4:1
   │  
 4 │ ╭ fn share(lane: u32, value: u32) -> u32 {
 5 │ │     for (var turn = 0u; turn < 4u; turn++) {
 6 │ │         sums[lane] = value + turn;
 7 │ │         workgroupBarrier();
   · │
13 │ │     return 0u;
14 │ │ }
   │ ╰─^ every invocation of the workgroup has to get through here
   │  
   = help: let it return at its end alone, or move the barrier into the entry point, and what stands before and behind it into functions of their own
