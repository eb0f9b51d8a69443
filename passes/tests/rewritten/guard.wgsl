// A guard on the ids becomes the domain, asked for every member of a group.
struct Frame { size: vec2<u32> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= frame.size.y {
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
    let _e4 = frame.size;
    return (!((pixel.x >= _e4.x)) && !((pixel.y >= _e4.y)));
}

fn vrcs_in_domain_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    let _e5 = frame.size;
    return (!((far.x >= _e5.x)) && !((far.y >= _e5.y)));
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
    var local_3: bool;

    let _e5 = frame.size.x;
    if true {
        let _e14 = frame.size.y;
        local_3 = (id.y >= _e14);
    } else {
        local_3 = true;
    }
    if false {
        return;
    }
    let _e19 = id.xy;
    let _e21 = vec4(1f);
    vrcs_copy_picture(_e19, _e21);
    textureStore(picture, _e19, _e21);
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
