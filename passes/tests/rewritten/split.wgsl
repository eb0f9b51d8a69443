// A store on one side of a line: its copies follow the primary, with a warning.
struct Frame { middle: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < frame.middle {
        textureStore(picture, id.xy, vec4(1.0));
    } else {
        textureStore(picture, id.xy, vec4(0.0));
    }
}

// ---- becomes ----

// warning[VRCS100]: a store to `picture` runs only for some ids; its copies follow the primary
//   ┌─ split.wgsl:8:8
//   │
// 8 │     if id.x < frame.middle {
//   │        ^^^^^^^^^^^^^^^^^^^ the condition on the ids
// 9 │         textureStore(picture, id.xy, vec4(1.0));
//   │         -------------------------------------- copied wherever the primary stores
//   │
//   = help: keep both sides of the condition in blocks of their own, or at full rate, where that shows
//
// warning[VRCS100]: a store to `picture` runs only for some ids; its copies follow the primary
//    ┌─ split.wgsl:8:8
//    │
//  8 │     if id.x < frame.middle {
//    │        ^^^^^^^^^^^^^^^^^^^ the condition on the ids
//    ·
// 11 │         textureStore(picture, id.xy, vec4(0.0));
//    │         -------------------------------------- copied wherever the primary stores
//    │
//    = help: keep both sides of the condition in blocks of their own, or at full rate, where that shows
//

struct Frame {
    middle: u32,
}

@group(0) @binding(0)
var<uniform> frame: Frame;
@group(0) @binding(1)
var picture: texture_storage_2d<rgba8unorm,write>;

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

fn main_inner(id: vec3<u32>) {
    let _e4 = frame.middle;
    if (id.x < _e4) {
        let _e7 = id.xy;
        let _e9 = vec4(1f);
        vrcs_copy_picture(_e7, _e9);
        textureStore(picture, _e7, _e9);
        return;
    } else {
        let _e11 = id.xy;
        let _e13 = vec4(0f);
        vrcs_copy_picture(_e11, _e13);
        textureStore(picture, _e11, _e13);
        return;
    }
}

@compute @workgroup_size(16, 16, 1)
fn main(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    main_inner(_e5);
    return;
}
