// An address without a tangent is computed anew for each duplicate; the loop's counter is the primary's.
@group(0) @binding(0) var<storage, read_write> texels: array<f32>;

fn swizzled(at: vec2<u32>) -> u32 {
    return (at.y / 8u) * 64u + (at.x & 7u) + (at.y & 7u) * 8u;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var i = 0u; i < 2u; i++) {
        texels[swizzled(id.xy) * 2u + i] = f32(i);
    }
}

// ---- becomes ----

@group(0) @binding(0)
var<storage, read_write> texels: array<f32>;

fn swizzled(at: vec2<u32>) -> u32 {
    return ((((at.y / 8u) * 64u) + (at.x & 7u)) + ((at.y & 7u) * 8u));
}

fn vrcs_address_texels(pixel_5: vec3<u32>, captured_a: u32) -> u32 {
    let _e6 = swizzled(vec2<u32>(pixel_5.x, pixel_5.y));
    return (captured_a + (2u * _e6));
}

fn vrcs_copy_texels(captured_a_1: u32, value: f32) {
    let _e4 = vrcs_copies;
    if (_e4 != 0u) {
        if ((_e4 & 2u) != 0u) {
            let _e10 = vrcs_duplicate(1u);
            let _e11 = vrcs_address_texels(_e10, captured_a_1);
            texels[_e11] = value;
        }
        if ((_e4 & 16u) != 0u) {
            let _e18 = vrcs_duplicate(4u);
            let _e19 = vrcs_address_texels(_e18, captured_a_1);
            texels[_e19] = value;
        }
        if ((_e4 & 32u) != 0u) {
            let _e26 = vrcs_duplicate(5u);
            let _e27 = vrcs_address_texels(_e26, captured_a_1);
            texels[_e27] = value;
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    var i: u32 = 0u;

    loop {
        let _e3 = i;
        if (_e3 < 2u) {
        } else {
            break;
        }
        {
            let _e8 = swizzled(id.xy);
            let _e11 = i;
            let _e14 = i;
            let _e15 = f32(_e14);
            vrcs_copy_texels(_e3, _e15);
            texels[((_e8 * 2u) + _e11)] = _e15;
        }
        continuing {
            let _e17 = i;
            i = (_e17 + 1u);
        }
    }
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
