// A store that runs for some ids and goes to the pixel's own place follows its primary: there is nothing to do for every pixel.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(1) var edges: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4<f32>(id.xyxy) / 64.0);
    if (id.x & 3u) == 0u {
        textureStore(edges, id.xy, vec4<f32>(1.0));
    }
}

// ---- becomes ----

// warning[VRCS100]: a store to `edges` runs only for some ids; its copies follow the primary
//   ┌─ unasked_of_none.wgsl:8:8
//   │
// 8 │     if (id.x & 3u) == 0u {
//   │        ^^^^^^^^^^^^^^^^^ the condition on the ids
// 9 │         textureStore(edges, id.xy, vec4<f32>(1.0));
//   │         ----------------------------------------- copied wherever the primary stores
//   │
//   = help: keep both sides of the condition in blocks of their own, or at full rate, where that shows
//

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;
@group(0) @binding(1)
var edges: texture_storage_2d<rgba8unorm,write>;

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

fn vrcs_copy_edges(at_1: vec2<u32>, value_1: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(edges, (at_1 + vec2<u32>(_e9)), value_1);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(edges, (at_1 + vec2<u32>(_e17)), value_1);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(edges, (at_1 + vec2<u32>(_e25)), value_1);
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let _e2 = id.xy;
    let _e7 = (vec4<f32>(id.xyxy) / vec4(64f));
    vrcs_copy_picture(_e2, _e7);
    textureStore(picture, _e2, _e7);
    if ((id.x & 3u) == 0u) {
        let _e14 = id.xy;
        let _e16 = vec4(1f);
        vrcs_copy_edges(_e14, _e16);
        textureStore(edges, _e14, _e16);
        return;
    } else {
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
