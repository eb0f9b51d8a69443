// Guards that only grow, or only shrink, with the ids are asked at a group's nearest or farthest corner: once, not for each member.
struct Frame { first: vec2<i32>, last: vec2<f32>, groups: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let at = vec2<i32>(id.xy) - vec2(2);
    if any(at < frame.first) || f32(id.x) > frame.last.x || group.y >= frame.groups {
        return;
    }
    if id.y + 1u < 64u || id.x < 32u {
        textureStore(picture, id.xy, vec4(1.0));
    }
}

// ---- becomes ----

struct Frame {
    first: vec2<i32>,
    last: vec2<f32>,
    groups: u32,
}

@group(0) @binding(0)
var<uniform> frame: Frame;
@group(0) @binding(1)
var picture: texture_storage_2d<rgba8unorm,write>;

fn vrcs_in_domain(pixel: vec3<u32>) -> bool {
    let _e7 = frame.first;
    let _e21 = frame.last;
    let _e31 = frame.groups;
    return ((((!(((i32(pixel.x) - 2i) < _e7.x)) && !(((i32(pixel.y) - 2i) < _e7.y))) && !((f32(pixel.x) > _e21.x))) && !(((pixel.y / 8u) >= _e31))) && (((1u + pixel.y) < 64u) || (pixel.x < 32u)));
}

fn vrcs_in_domain_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    let _e8 = frame.first;
    let _e23 = frame.last;
    let _e33 = frame.groups;
    return ((((!(((i32(near.x) - 2i) < _e8.x)) && !(((i32(near.y) - 2i) < _e8.y))) && !((f32(far.x) > _e23.x))) && !(((far.y / 8u) >= _e33))) && (((1u + far.y) < 64u) || (far.x < 32u)));
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

fn main_inner(id: vec3<u32>, group: vec3<u32>) {
    var local_3: bool;
    var local_4: bool;
    var local_5: bool;

    let at_1 = (vec2<i32>(id.xy) - vec2(2i));
    let _e9 = frame.first;
    if true {
        let _e20 = frame.last.x;
        local_3 = (f32(id.x) > _e20);
    } else {
        local_3 = true;
    }
    let _e23 = local_3;
    if true {
        let _e30 = frame.groups;
        local_4 = (group.y >= _e30);
    } else {
        local_4 = true;
    }
    if false {
        return;
    }
    if !(((id.y + 1u) < 64u)) {
        local_5 = (id.x < 32u);
    } else {
        local_5 = true;
    }
    if true {
        let _e48 = id.xy;
        let _e50 = vec4(1f);
        vrcs_copy_picture(_e48, _e50);
        textureStore(picture, _e48, _e50);
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
    main_inner(_e5, (_e5 / vec3<u32>(8u, 8u, 1u)));
    return;
}
