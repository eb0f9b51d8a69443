// Every other pixel of a row: which one, depends on the row. A duplicate's place is computed anew, and its bounds asked for it.
struct Frame { number: u32 }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(picture);
    let first = vec2(id.x * 2u + ((id.y + frame.number) & 1u), id.y);
    textureStore(picture, first, vec4(1.0));
    let second = vec2(id.x * 2u + ((id.y + frame.number + 1u) & 1u), id.y);
    if second.x < size.x {
        textureStore(picture, second, vec4(0.5));
    }
}

// ---- becomes ----

struct Frame {
    number: u32,
}

@group(0) @binding(0)
var<uniform> frame: Frame;
@group(0) @binding(1)
var picture: texture_storage_2d<rgba8unorm,write>;

fn vrcs_address_picture(pixel_5: vec3<u32>, captured_a: u32) -> vec2<u32> {
    return vec2<u32>(((pixel_5.x * 2u) + (1u & (pixel_5.y + captured_a))), pixel_5.y);
}

fn vrcs_copy_picture(captured_a_1: u32, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if (_e4 != 0u) {
        if ((_e4 & 2u) != 0u) {
            let _e10 = vrcs_duplicate(1u);
            let _e11 = vrcs_address_picture(_e10, captured_a_1);
            textureStore(picture, _e11, value);
        }
        if ((_e4 & 16u) != 0u) {
            let _e17 = vrcs_duplicate(4u);
            let _e18 = vrcs_address_picture(_e17, captured_a_1);
            textureStore(picture, _e18, value);
        }
        if ((_e4 & 32u) != 0u) {
            let _e24 = vrcs_duplicate(5u);
            let _e25 = vrcs_address_picture(_e24, captured_a_1);
            textureStore(picture, _e25, value);
        }
    }
    return;
}

fn vrcs_guard_picture(pixel_6: vec3<u32>, captured_a_2: u32, captured_b: u32) -> bool {
    return (((pixel_6.x * 2u) + (1u & (1u + (pixel_6.y + captured_a_2)))) < captured_b);
}

fn vrcs_address_picture_1(pixel_7: vec3<u32>, captured_a_3: u32, captured_b_1: u32) -> vec2<u32> {
    return vec2<u32>(((pixel_7.x * 2u) + (1u & (1u + (pixel_7.y + captured_a_3)))), pixel_7.y);
}

fn vrcs_copy_picture_1(captured_a_4: u32, captured_b_2: u32, value_1: vec4<f32>) {
    let _e5 = vrcs_copies;
    if (_e5 != 0u) {
        if ((_e5 & 2u) != 0u) {
            let _e11 = vrcs_duplicate(1u);
            let _e12 = vrcs_guard_picture(_e11, captured_a_4, captured_b_2);
            if _e12 {
                let _e13 = vrcs_address_picture_1(_e11, captured_a_4, captured_b_2);
                textureStore(picture, _e13, value_1);
            }
        }
        if ((_e5 & 16u) != 0u) {
            let _e19 = vrcs_duplicate(4u);
            let _e20 = vrcs_guard_picture(_e19, captured_a_4, captured_b_2);
            if _e20 {
                let _e21 = vrcs_address_picture_1(_e19, captured_a_4, captured_b_2);
                textureStore(picture, _e21, value_1);
            }
        }
        if ((_e5 & 32u) != 0u) {
            let _e27 = vrcs_duplicate(5u);
            let _e28 = vrcs_guard_picture(_e27, captured_a_4, captured_b_2);
            if _e28 {
                let _e29 = vrcs_address_picture_1(_e27, captured_a_4, captured_b_2);
                textureStore(picture, _e29, value_1);
            }
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let size_4 = textureDimensions(picture);
    let _e9 = frame.number;
    let first = vec2<u32>(((id.x * 2u) + ((id.y + _e9) & 1u)), id.y);
    let _e18 = vec4(1f);
    vrcs_copy_picture(_e9, _e18);
    textureStore(picture, first, _e18);
    let _e25 = frame.number;
    let second = vec2<u32>(((id.x * 2u) + (((id.y + _e25) + 1u) & 1u)), id.y);
    if (second.x < size_4.x) {
        let _e39 = vec4(0.5f);
        vrcs_copy_picture_1(_e9, size_4.x, _e39);
        textureStore(picture, second, _e39);
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
