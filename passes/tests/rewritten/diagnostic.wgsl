// `@diagnostic` on statements, which naga does not read, goes; nothing else changes.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@diagnostic(off, derivative_uniformity)
fn shade(x: u32) -> f32 {
    if x > 3u @diagnostic(warning, derivative_uniformity) {
        return 1.0;
    }
    return 0.0;
}

@compute @workgroup_size(8, 8) @diagnostic(off, derivative_uniformity)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(shade(id.x)));
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;

fn shade(x: u32) -> f32 {
    if (x > 3u) {
        return 1f;
    }
    return 0f;
}

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
    let _e2 = id.xy;
    let _e4 = shade(id.x);
    let _e5 = vec4(_e4);
    vrcs_copy_picture(_e2, _e5);
    textureStore(picture, _e2, _e5);
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
