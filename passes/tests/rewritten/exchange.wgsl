@group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;

var<workgroup> found: atomic<u32>;

@compute @workgroup_size(8, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mine = atomicAdd(&found, id.x);
    workgroupBarrier();
    textureStore(picture, id.xy, vec4<u32>(mine + atomicLoad(&found)));
}

// ---- becomes ----

// warning[VRCS102]: `mine` is handed to the invocation that shades for it through workgroup memory
//   ┌─ exchange.wgsl:7:16
//   │
// 7 │     let mine = atomicAdd(&found, id.x);
//   │                ^^^^^^^^^ only the invocation itself can know it
//   │
//   = help: to save the memory, compute it from the ids behind the barrier
//

@group(0) @binding(0)
var picture: texture_storage_2d<r32uint,write>;
var<workgroup> found: atomic<u32>;
var<private> vrcs_slot: u32;
var<workgroup> vrcs_exchange_mine: array<u32, 32>;

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

fn main_inner(id: vec3<u32>, vrcs_own_id: vec3<u32>) {
    var vrcs_own_mine: u32;

    let _e3 = atomicAdd((&found), id.x);
    let _e14 = vrcs_lane;
    vrcs_exchange_mine[_e14] = _e3;
    workgroupBarrier();
    let _e17 = vrcs_on;
    if _e17 {
        let _e20 = vrcs_slot;
        let _e22 = vrcs_exchange_mine[_e20];
        vrcs_own_mine = _e22;
    }
    let _e24 = vrcs_on;
    if _e24 {
        let _e25 = vrcs_own_mine;
        let _e26 = vrcs_own_id.xy;
        let _e27 = atomicLoad((&found));
        let _e29 = vec4((_e25 + _e27));
        vrcs_copy_picture(_e26, _e29);
        textureStore(picture, _e26, _e29);
        return;
    }
}

@compute @workgroup_size(8, 4, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane_index: u32, @builtin(global_invocation_id) vrcs_id: vec3<u32>, @builtin(local_invocation_id) vrcs_local: vec3<u32>) {
    let _e4 = vrcs_tile_is_empty(vrcs_group);
    if _e4 {
        return;
    }
    vrcs_group_begin(vrcs_group, vrcs_id, vrcs_lane_index, vec2<u32>(8u, 4u));
    let _e9 = vrcs_pixel;
    main_inner(vrcs_id, _e9);
    return;
}
