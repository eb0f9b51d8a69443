@group(0) @binding(0) var mask: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 4)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let at = group.xy * vec2<u32>(8u, 4u) + vec2<u32>(lane & 7u, lane / 8u);
    textureStore(mask, at, vec4<f32>(f32(lane)));
}

// ---- becomes ----

@group(0) @binding(0)
var mask: texture_storage_2d<r32float,write>;

fn vrcs_copy_mask(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(mask, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(mask, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(mask, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn main_inner(group: vec3<u32>, lane_3: u32) {
    let at_1 = ((group.xy * vec2<u32>(8u, 4u)) + vec2<u32>((lane_3 & 7u), (lane_3 / 8u)));
    let _e15 = vec4(f32(lane_3));
    vrcs_copy_mask(at_1, _e15);
    textureStore(mask, at_1, _e15);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    main_inner((_e5 / vec3<u32>(8u, 4u, 1u)), (((((_e5.z % 1u) * 4u) + (_e5.y % 4u)) * 8u) + (_e5.x % 8u)));
    return;
}
