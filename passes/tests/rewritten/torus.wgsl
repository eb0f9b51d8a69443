// A window on a torus: where a cell stands tells the pixels apart, since the window is no wider than the torus.
struct Window { origin: vec2<i32>, size: vec2<i32>, moved: i32 }
@group(0) @binding(0) var<uniform> window: Window;
@group(0) @binding(1) var<storage, read_write> cells: array<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = vec2<i32>(id.xy);
    if any(at >= window.size) {
        return;
    }
    let cell = window.origin + at;
    let place = ((cell % window.size) + window.size) % window.size;
    textureStore(picture, at, vec4(1.0));
    if at.x < window.moved {
        cells[place.y * window.size.x + place.x] = 0.0;
    }
}

// ---- becomes ----

struct Window {
    origin: vec2<i32>,
    size: vec2<i32>,
    moved: i32,
}

@group(0) @binding(0)
var<uniform> window: Window;
@group(0) @binding(1)
var<storage, read_write> cells: array<f32>;
@group(0) @binding(2)
var picture: texture_storage_2d<r32float,write>;

fn vrcs_in_domain(pixel: vec3<u32>) -> bool {
    let _e5 = window.size;
    return (!((i32(pixel.x) >= _e5.x)) && !((i32(pixel.y) >= _e5.y)));
}

fn vrcs_in_domain_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    let _e6 = window.size;
    return (!((i32(far.x) >= _e6.x)) && !((i32(far.y) >= _e6.y)));
}

fn vrcs_copy_picture(at: vec2<i32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(picture, (at + _e9), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e16 = vrcs_delta(4u);
        textureStore(picture, (at + _e16), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e23 = vrcs_delta(5u);
        textureStore(picture, (at + _e23), value);
    }
    return;
}

fn vrcs_guard_cells(pixel_6: vec3<u32>, captured_a: i32, captured_b: i32, captured_c: vec2<i32>, captured_d: vec2<i32>) -> bool {
    return (i32(pixel_6.x) < captured_a);
}

fn vrcs_address_cells(pixel_7: vec3<u32>, captured_a_1: i32, captured_b_1: i32, captured_c_1: vec2<i32>, captured_d_1: vec2<i32>) -> i32 {
    return (((captured_b_1 + ((i32(pixel_7.x) + captured_c_1.x) % captured_b_1)) % captured_b_1) + (captured_b_1 * ((captured_d_1.y + ((i32(pixel_7.y) + captured_c_1.y) % captured_d_1.y)) % captured_d_1.y)));
}

fn vrcs_copy_cells(captured_a_2: i32, captured_b_2: i32, captured_c_2: vec2<i32>, captured_d_2: vec2<i32>, value_1: f32) {
    let _e7 = vrcs_copies;
    if (_e7 != 0u) {
        if ((_e7 & 2u) != 0u) {
            let _e13 = vrcs_duplicate(1u);
            let _e14 = vrcs_guard_cells(_e13, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
            if _e14 {
                let _e15 = vrcs_address_cells(_e13, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
                cells[_e15] = value_1;
            }
        }
        if ((_e7 & 16u) != 0u) {
            let _e22 = vrcs_duplicate(4u);
            let _e23 = vrcs_guard_cells(_e22, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
            if _e23 {
                let _e24 = vrcs_address_cells(_e22, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
                cells[_e24] = value_1;
            }
        }
        if ((_e7 & 32u) != 0u) {
            let _e31 = vrcs_duplicate(5u);
            let _e32 = vrcs_guard_cells(_e31, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
            if _e32 {
                let _e33 = vrcs_address_cells(_e31, captured_a_2, captured_b_2, captured_c_2, captured_d_2);
                cells[_e33] = value_1;
            }
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let at_1 = vec2<i32>(id.xy);
    let _e5 = window.size;
    if false {
        return;
    }
    let _e10 = window.origin;
    let cell = (_e10 + at_1);
    let _e14 = window.size;
    let _e18 = window.size;
    let _e22 = window.size;
    let place = (((cell % _e14) + _e18) % _e22);
    let _e26 = vec4(1f);
    vrcs_copy_picture(at_1, _e26);
    textureStore(picture, at_1, _e26);
    let _e30 = window.moved;
    if (at_1.x < _e30) {
        let _e37 = window.size.x;
        vrcs_copy_cells(_e30, _e37, _e10, _e5, 0f);
        cells[((place.y * _e37) + place.x)] = 0f;
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
