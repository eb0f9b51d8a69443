@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
var<workgroup> shared_sum: array<f32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    shared_sum[i] = f32(id.x);
    workgroupBarrier();
    textureStore(picture, id.xy, vec4(shared_sum[63u - i]));
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;
var<workgroup> shared_sum: array<f32, 64>;
var<private> vrcs_slot: u32;

fn vrcs_copy_picture(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(picture, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(picture, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn main_inner(id: vec3<u32>, i: u32, vrcs_own_id: vec3<u32>, vrcs_own_i: u32) {
    shared_sum[i] = f32(id.x);
    workgroupBarrier();
    let _e17 = vrcs_on;
    if _e17 {
        let _e18 = vrcs_own_id.xy;
        let _e21 = shared_sum[(63u - vrcs_own_i)];
        let _e22 = vec4(_e21);
        vrcs_copy_picture(_e18, _e22);
        textureStore(picture, _e18, _e22);
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
