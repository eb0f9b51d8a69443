// A helper that stores is cloned; another entry point keeps the original.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

fn put(at: vec2<u32>, color: vec4<f32>) {
    textureStore(picture, at, color);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    put(id.xy, vec4(0.5));
}

@compute @workgroup_size(1)
fn mark() {
    put(vec2(3u, 4u), vec4(1.0));
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;

fn put(at: vec2<u32>, color: vec4<f32>) {
    textureStore(picture, at, color);
    return;
}

fn vrcs_copy_picture(at_1: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at_1 + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(picture, (at_1 + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(picture, (at_1 + vec2<u32>(_e25)), value);
    }
    return;
}

fn vrcs_put(at_2: vec2<u32>, color_1: vec4<f32>) {
    vrcs_copy_picture(at_2, color_1);
    textureStore(picture, at_2, color_1);
    return;
}

fn main_inner(id: vec3<u32>) {
    vrcs_put(id.xy, vec4(0.5f));
    return;
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

@compute @workgroup_size(1, 1, 1)
fn mark() {
    put(vec2<u32>(3u, 4u), vec4(1f));
    return;
}
