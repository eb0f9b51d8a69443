@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;

var<workgroup> stack: array<u32, 64>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    stack[lane] = id.x * id.y;
    textureStore(picture, id.xy, vec4<u32>(stack[lane]));
}

// ---- becomes ----

// warning[VRCS103]: a region works for the whole workgroup and stores what it finds out: no wave retires there
//   ┌─ scratch.wgsl:8:5
//   │
// 8 │     textureStore(picture, id.xy, vec4<u32>(stack[lane]));
//   │     ^^^^^^^^^^^^ every invocation gets here, and only primaries store
//   │
//   = help: put a barrier between the work on workgroup memory and the work on the pixel
//

@group(0) @binding(0)
var picture: texture_storage_2d<r32uint,write>;
var<workgroup> stack: array<u32, 64>;
var<private> vrcs_slot: u32;
var<workgroup> vrcs_masks: array<u32, 64>;
var<private> vrcs_is_primary: bool;
var<private> vrcs_other_pixel: vec3<u32>;
var<private> vrcs_other_copies: u32;

fn vrcs_copy_picture(at: vec2<u32>, value: vec4<u32>) {
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

fn main_inner(id: vec3<u32>, lane_2: u32, vrcs_own_id: vec3<u32>, vrcs_own_lane: u32) {
    vrcs_change_pixel();
    stack[lane_2] = (id.x * id.y);
    let _e8 = id.xy;
    let _e11 = stack[lane_2];
    let _e12 = vec4(_e11);
    let _e16 = vrcs_is_primary;
    if _e16 {
        vrcs_copy_picture(_e8, _e12);
    }
    let _e18 = vrcs_is_primary;
    if _e18 {
        textureStore(picture, _e8, _e12);
    }
    return;
}

@compute @workgroup_size(8, 8, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane_index: u32, @builtin(global_invocation_id) vrcs_id: vec3<u32>, @builtin(local_invocation_id) vrcs_local: vec3<u32>) {
    let _e4 = vrcs_tile_is_empty(vrcs_group);
    if _e4 {
        return;
    }
    vrcs_group_begin(vrcs_group, vrcs_id, vrcs_lane_index, vec2<u32>(8u, 8u));
    vrcs_group_masks(vrcs_id);
    let _e8 = vrcs_pixel;
    main_inner(vrcs_id, vrcs_lane_index, _e8, (((((_e8.z % 1u) * 8u) + (_e8.y % 8u)) * 8u) + (_e8.x % 8u)));
    return;
}
