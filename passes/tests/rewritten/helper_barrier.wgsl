@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
var<workgroup> sums: array<u32, 64>;

fn share(lane: u32, value: u32, twice: bool) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    if twice {
        return 2u * sums[63u - lane];
    }
    return sums[63u - lane];
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let found = share(lane, id.x, id.z > 0u);
    textureStore(picture, id.xy, vec4<u32>(found));
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_storage_2d<r32uint,write>;
var<workgroup> sums: array<u32, 64>;
var<private> vrcs_slot: u32;

fn share(lane: u32, value: u32, twice: bool) -> u32 {
    sums[lane] = value;
    workgroupBarrier();
    if twice {
        let _e10 = sums[(63u - lane)];
        return (2u * _e10);
    }
    let _e16 = sums[(63u - lane)];
    return _e16;
}

fn vrcs_copy_picture(at: vec2<u32>, value_1: vec4<u32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at + vec2<u32>(_e9)), value_1);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(picture, (at + vec2<u32>(_e17)), value_1);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(picture, (at + vec2<u32>(_e25)), value_1);
    }
    return;
}

fn main_inner(id: vec3<u32>, lane_3: u32, vrcs_own_id: vec3<u32>, vrcs_own_lane: u32) {
    var vrcs_share_result: u32;
    var vrcs_own_kept: bool;

    sums[lane_3] = id.x;
    let _e29 = vrcs_on;
    if _e29 {
        vrcs_own_kept = (vrcs_own_id.z > 0u);
    }
    workgroupBarrier();
    let _e33 = vrcs_on;
    if _e33 {
        let _e34 = vrcs_own_kept;
        if _e34 {
            let _e37 = sums[(63u - vrcs_own_lane)];
            vrcs_share_result = (2u * _e37);
        } else {
            let _e42 = sums[(63u - vrcs_own_lane)];
            vrcs_share_result = _e42;
        }
        let found = vrcs_share_result;
        let _e46 = vrcs_own_id.xy;
        let _e47 = vec4(found);
        vrcs_copy_picture(_e46, _e47);
        textureStore(picture, _e46, _e47);
        return;
    }
}

@compute @workgroup_size(8, 8, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane_index: u32, @builtin(global_invocation_id) vrcs_id: vec3<u32>, @builtin(local_invocation_id) vrcs_local: vec3<u32>) {
    let _e4 = vrcs_tile_is_empty(vrcs_group);
    if _e4 {
        return;
    }
    vrcs_group_begin(vrcs_group, vrcs_id, vrcs_lane_index, vec2<u32>(8u, 8u));
    let _e8 = vrcs_pixel;
    main_inner(vrcs_id, vrcs_lane_index, _e8, (((((_e8.z % 1u) * 8u) + (_e8.y % 8u)) * 8u) + (_e8.x % 8u)));
    return;
}
