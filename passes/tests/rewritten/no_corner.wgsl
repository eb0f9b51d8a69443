// What may wrap around between two pixels of a group, no corner tells: the domain is asked for each member.
struct Frame { size: vec2<u32> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy - vec2(1u) >= frame.size) {
        return;
    }
    textureStore(picture, id.xy, vec4(1.0));
}

// ---- becomes ----

struct Frame {
    size: vec2<u32>,
}

@group(0) @binding(0)
var<uniform> frame: Frame;
@group(0) @binding(1)
var picture: texture_storage_2d<rgba8unorm,write>;

fn vrcs_in_domain(pixel: vec3<u32>) -> bool {
    let _e6 = frame.size;
    return (!(((pixel.x - 1u) >= _e6.x)) && !(((pixel.y - 1u) >= _e6.y)));
}

fn vrcs_in_domain_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    return false;
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
    let _e7 = frame.size;
    if any(((id.xy - vec2(1u)) >= _e7)) {
        return;
    }
    let _e11 = id.xy;
    let _e13 = vec4(1f);
    vrcs_copy_picture(_e11, _e13);
    textureStore(picture, _e11, _e13);
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
