// The last region uses workgroup memory as scratch of its own, so it works for itself and for the group: it is masked.

@group(0) @binding(0) var<storage, read> nodes: array<u32>;
@group(0) @binding(1) var result: texture_storage_2d<r32uint, write>;
@group(0) @binding(2) var extra: texture_storage_2d<rgba8unorm, write>;

var<workgroup> shared_seed: u32;
var<workgroup> stack: array<u32, 256>;

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) gid: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    if lane == 0u {
        shared_seed = group.x * 31u + group.y;
    }
    workgroupBarrier();
    textureStore(extra, gid.xy, vec4<f32>(f32(gid.x + gid.y) / 128.0));
    workgroupBarrier();
    let size = max(arrayLength(&nodes), 1u);
    var depth = 0u;
    stack[lane * 4u] = (shared_seed + gid.x * 5u + gid.y * 3u) % size;
    var sum = 0u;
    var left = 12u;
    loop {
        if left == 0u {
            break;
        }
        left -= 1u;
        let node = nodes[stack[lane * 4u + depth]];
        sum = sum * 3u + (node & 255u);
        if (node & 1u) != 0u && depth < 3u {
            depth += 1u;
        } else if (node & 2u) != 0u && depth > 0u {
            depth -= 1u;
        }
        stack[lane * 4u + depth] = (node ^ sum) % size;
    }
    textureStore(result, gid.xy, vec4<u32>(sum, 0u, 0u, 0u));
}
