// Divisions by zero and shifts by too many bits, by values that are found out to be constant: WGSL says what comes of them at run time.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    var nothing = vec2(0u);
    var bits = 33u;
    let column = (id.xy / nothing).x ^ (id.y % nothing.y);
    let row = (id.y ^ 1u) >> bits;
    textureStore(picture, vec2(column, row), vec4(1.0));
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;

fn vrcs_address_picture(pixel_5: vec3<u32>) -> vec2<u32> {
    return vec2<u32>((pixel_5.x ^ 0u), ((1u ^ pixel_5.y) >> 1u));
}

fn vrcs_copy_picture(value: vec4<f32>) {
    let _e3 = vrcs_copies;
    if (_e3 != 0u) {
        if ((_e3 & 2u) != 0u) {
            let _e9 = vrcs_duplicate(1u);
            let _e10 = vrcs_address_picture(_e9);
            textureStore(picture, _e10, value);
        }
        if ((_e3 & 16u) != 0u) {
            let _e16 = vrcs_duplicate(4u);
            let _e17 = vrcs_address_picture(_e16);
            textureStore(picture, _e17, value);
        }
        if ((_e3 & 32u) != 0u) {
            let _e23 = vrcs_duplicate(5u);
            let _e24 = vrcs_address_picture(_e23);
            textureStore(picture, _e24, value);
        }
    }
    return;
}

fn shade_inner(id: vec3<u32>) {
    var nothing: vec2<u32> = vec2(0u);
    var bits: u32 = 33u;

    let _e7 = nothing;
    let _e12 = nothing.y;
    let column = ((id.xy / _e7).x ^ (id.y % _e12));
    let _e18 = bits;
    let row_1 = ((id.y ^ 1u) >> _e18);
    let _e23 = vec4(1f);
    vrcs_copy_picture(_e23);
    textureStore(picture, vec2<u32>(column, row_1), _e23);
    return;
}

@compute @workgroup_size(16, 16, 1)
fn shade(@builtin(workgroup_id) vrcs_group: vec3<u32>, @builtin(local_invocation_index) vrcs_lane: u32) {
    let _e2 = vrcs_prefix(vrcs_group, vrcs_lane);
    if !(_e2) {
        return;
    }
    let _e5 = vrcs_pixel;
    shade_inner(_e5);
    return;
}
