// A duplicate lies in its primary's layer: a condition on the layer alone loses no store.
@group(0) @binding(0) var<storage, read_write> cells: array<u32>;
@group(0) @binding(1) var picture: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, id.z, vec4(1u));
    if id.z > 0u {
        cells[((id.z << 20u) | ((id.y & 1023u) << 10u)) + (id.x & 1023u)] = 1u;
    }
}

// ---- becomes ----

@group(0) @binding(0)
var<storage, read_write> cells: array<u32>;
@group(0) @binding(1)
var picture: texture_storage_2d_array<r32uint,write>;

fn vrcs_copy_picture(at: vec2<u32>, layer: u32, value: vec4<u32>) {
    let _e5 = vrcs_copies;
    if ((_e5 & 2u) != 0u) {
        let _e10 = vrcs_delta(1u);
        textureStore(picture, (at + vec2<u32>(_e10)), layer, value);
    }
    if ((_e5 & 16u) != 0u) {
        let _e18 = vrcs_delta(4u);
        textureStore(picture, (at + vec2<u32>(_e18)), layer, value);
    }
    if ((_e5 & 32u) != 0u) {
        let _e26 = vrcs_delta(5u);
        textureStore(picture, (at + vec2<u32>(_e26)), layer, value);
    }
    return;
}

fn vrcs_address_cells(pixel_5: vec3<u32>) -> u32 {
    return (((pixel_5.z << 20u) | ((pixel_5.y & 1023u) << 10u)) + (pixel_5.x & 1023u));
}

fn vrcs_copy_cells(value_1: u32) {
    let _e3 = vrcs_copies;
    if (_e3 != 0u) {
        if ((_e3 & 2u) != 0u) {
            let _e9 = vrcs_duplicate(1u);
            let _e10 = vrcs_address_cells(_e9);
            cells[_e10] = value_1;
        }
        if ((_e3 & 16u) != 0u) {
            let _e17 = vrcs_duplicate(4u);
            let _e18 = vrcs_address_cells(_e17);
            cells[_e18] = value_1;
        }
        if ((_e3 & 32u) != 0u) {
            let _e25 = vrcs_duplicate(5u);
            let _e26 = vrcs_address_cells(_e25);
            cells[_e26] = value_1;
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let _e2 = id.xy;
    let _e5 = vec4(1u);
    vrcs_copy_picture(_e2, id.z, _e5);
    textureStore(picture, _e2, id.z, _e5);
    if (id.z > 0u) {
        vrcs_copy_cells(1u);
        cells[(((id.z << 20u) | ((id.y & 1023u) << 10u)) + (id.x & 1023u))] = 1u;
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
