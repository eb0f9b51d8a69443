// All five ids in one struct; the place is the workgroup's number times its size plus the invocation's own, in groups of odd sides with
// a depth.
struct Ids {
    @builtin(global_invocation_id) pixel: vec3<u32>,
    @builtin(local_invocation_id) lane: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
}

@group(0) @binding(0) var<storage, read_write> result: array<u32>;

@compute @workgroup_size(5, 3, 2)
fn main(ids: Ids) {
    let group = (ids.group.z * ids.groups.y + ids.group.y) * ids.groups.x + ids.group.x;
    result[group * 30u + ids.index] = ids.pixel.x * 100u + ids.pixel.y * 10000u + ids.lane.x + ids.pixel.z;
}
