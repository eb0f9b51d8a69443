// Any pixel of a tile may raise the tile's flag; all raise it to the same value, so it matters to nobody who does.
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var bright: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var<storage, read_write> flags: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let color = textureLoad(picture, id.xy, 0);
    textureStore(bright, id.xy, color);
    if color.y > 0.5 {
        flags[(id.y / 8u) * 64u + id.x / 8u] = 1u;
    }
}

// ---- becomes ----

@group(0) @binding(0)
var picture: texture_2d<f32>;
@group(0) @binding(1)
var bright: texture_storage_2d<r32float,write>;
@group(0) @binding(2)
var<storage, read_write> flags: array<u32>;

fn vrcs_copy_bright(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if ((_e4 & 2u) != 0u) {
        let _e9 = vrcs_delta(1u);
        textureStore(bright, (at + vec2<u32>(_e9)), value);
    }
    if ((_e4 & 16u) != 0u) {
        let _e17 = vrcs_delta(4u);
        textureStore(bright, (at + vec2<u32>(_e17)), value);
    }
    if ((_e4 & 32u) != 0u) {
        let _e25 = vrcs_delta(5u);
        textureStore(bright, (at + vec2<u32>(_e25)), value);
    }
    return;
}

fn vrcs_address_flags(pixel_5: vec3<u32>) -> u32 {
    return (((pixel_5.y / 8u) * 64u) + (pixel_5.x / 8u));
}

fn vrcs_copy_flags(value_1: u32) {
    let _e3 = vrcs_copies;
    if (_e3 != 0u) {
        if ((_e3 & 2u) != 0u) {
            let _e9 = vrcs_duplicate(1u);
            let _e10 = vrcs_address_flags(_e9);
            flags[_e10] = value_1;
        }
        if ((_e3 & 16u) != 0u) {
            let _e17 = vrcs_duplicate(4u);
            let _e18 = vrcs_address_flags(_e17);
            flags[_e18] = value_1;
        }
        if ((_e3 & 32u) != 0u) {
            let _e25 = vrcs_duplicate(5u);
            let _e26 = vrcs_address_flags(_e25);
            flags[_e26] = value_1;
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let color = textureLoad(picture, id.xy, 0i);
    let _e6 = id.xy;
    vrcs_copy_bright(_e6, color);
    textureStore(bright, _e6, color);
    if (color.y > 0.5f) {
        vrcs_copy_flags(1u);
        flags[(((id.y / 8u) * 64u) + (id.x / 8u))] = 1u;
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
