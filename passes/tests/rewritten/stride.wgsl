// A row's length is a uniform: the copy goes to index + dx + dy * width.
struct Frame { width: u32, height: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> texels: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < frame.width && id.y < frame.height {
        texels[id.y * frame.width + id.x] = f32(id.x);
    }
}

// ---- becomes ----

struct Frame {
    width: u32,
    height: u32,
}

@group(0) @binding(0)
var<uniform> frame: Frame;
@group(0) @binding(1)
var<storage, read_write> texels: array<f32>;

fn vrcs_in_domain(pixel: vec3<u32>) -> bool {
    let _e4 = frame.width;
    let _e9 = frame.height;
    return ((pixel.x < _e4) && (pixel.y < _e9));
}

fn vrcs_in_domain_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    let _e5 = frame.width;
    let _e10 = frame.height;
    return ((far.x < _e5) && (far.y < _e10));
}

fn vrcs_copy_texels(captured_a: u32, index_a: u32, value: f32) {
    let _e5 = i32(captured_a);
    let _e8 = vrcs_copies;
    if ((_e8 & 2u) != 0u) {
        let _e13 = vrcs_delta(1u);
        texels[(index_a + u32((_e13.x + (_e13.y * _e5))))] = value;
    }
    if ((_e8 & 16u) != 0u) {
        let _e26 = vrcs_delta(4u);
        texels[(index_a + u32((_e26.x + (_e26.y * _e5))))] = value;
    }
    if ((_e8 & 32u) != 0u) {
        let _e39 = vrcs_delta(5u);
        texels[(index_a + u32((_e39.x + (_e39.y * _e5))))] = value;
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    var local_3: bool;

    let _e4 = frame.width;
    if true {
        let _e11 = frame.height;
        local_3 = (id.y < _e11);
    } else {
        local_3 = false;
    }
    if true {
        let _e19 = frame.width;
        let _e22 = ((id.y * _e19) + id.x);
        let _e25 = f32(id.x);
        vrcs_copy_texels(_e4, _e22, _e25);
        texels[_e22] = _e25;
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
