// Everything that a rewritten shader holds, the prelude included.
@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy, vec4(vec2<f32>(id.xy) / 64.0, 0.0, 1.0));
}

// ---- becomes ----

struct VrcsParams {
    extent: vec3<u32>,
    flags: u32,
    groups: vec3<u32>,
    tiles_per_row: u32,
    entries: u32,
    entries_per_tile: u32,
}

const VRCS_TILE_WIDTH: u32 = 16u;
const VRCS_ENABLED: u32 = 1u;
const VRCS_TILE_IDENTITY: u32 = 65536u;

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;
@group(1) @binding(0)
var<uniform> vrcs_params: VrcsParams;
var<private> vrcs_pixel: vec3<u32>;
var<private> vrcs_copies: u32;
@group(1) @binding(1)
var<storage> vrcs_coords: array<u32>;

fn vrcs_is_inside(pixel: vec3<u32>) -> bool {
    let _e3 = vrcs_params.extent;
    return all((pixel < _e3));
}

fn vrcs_members_in_extent(block: vec2<u32>, mask: u32) -> u32 {
    let _e4 = vrcs_params.extent;
    let _e8 = vrcs_params.extent;
    let room = min((_e4.xy - min(block, _e8.xy)), vec2(4u));
    let columns = (((1u << room.x) - 1u) * 4369u);
    let rows = ((1u << (room.y * 4u)) - 1u);
    return ((mask & columns) & rows);
}

fn vrcs_members(block_1: vec2<u32>, z: u32, mask_1: u32) -> u32 {
    return mask_1;
}

fn vrcs_relative(mask_2: u32, home: u32) -> u32 {
    var relative: u32;

    relative = mask_2;
    if ((home & 1u) != 0u) {
        let _e7 = relative;
        let _e12 = relative;
        relative = (((_e7 & 21845u) << 1u) | ((_e12 >> 1u) & 21845u));
    }
    if ((home & 2u) != 0u) {
        let _e22 = relative;
        let _e27 = relative;
        relative = (((_e22 & 13107u) << 2u) | ((_e27 >> 2u) & 13107u));
    }
    if ((home & 4u) != 0u) {
        let _e37 = relative;
        let _e42 = relative;
        relative = (((_e37 & 3855u) << 4u) | ((_e42 >> 4u) & 3855u));
    }
    if ((home & 8u) != 0u) {
        let _e52 = relative;
        let _e57 = relative;
        relative = (((_e52 & 255u) << 8u) | ((_e57 >> 8u) & 255u));
    }
    let _e63 = relative;
    return _e63;
}

fn vrcs_take(pixel_1: vec3<u32>, mask_3: u32) -> bool {
    var local: bool;
    var home_1: u32;

    let block_2 = (pixel_1.xy & vec2(4294967292u));
    let _e7 = vrcs_members_in_extent(block_2, mask_3);
    let _e8 = vrcs_members(block_2, pixel_1.z, _e7);
    if !((_e8 == 0u)) {
        let _e18 = vrcs_params.extent.z;
        local = (pixel_1.z >= _e18);
    } else {
        local = true;
    }
    let _e21 = local;
    if _e21 {
        return false;
    }
    home_1 = ((pixel_1.x & 3u) | ((pixel_1.y & 3u) << 2u));
    let _e33 = home_1;
    if (((_e8 >> _e33) & 1u) == 0u) {
        home_1 = firstTrailingBit(_e8);
    }
    let _e41 = home_1;
    let _e44 = home_1;
    vrcs_pixel = vec3<u32>((block_2 + vec2<u32>((_e41 & 3u), (_e44 >> 2u))), pixel_1.z);
    let _e52 = home_1;
    let _e53 = vrcs_relative(_e8, _e52);
    vrcs_copies = (_e53 & 4294967294u);
    return true;
}

fn vrcs_prefix(tile: vec3<u32>, lane: u32) -> bool {
    let origin = (tile.xy * vec2<u32>(16u, 16u));
    vrcs_pixel = vec3<u32>((origin + vec2<u32>((lane % VRCS_TILE_WIDTH), (lane / VRCS_TILE_WIDTH))), tile.z);
    vrcs_copies = 0u;
    let _e20 = vrcs_params.flags;
    if ((_e20 & VRCS_ENABLED) == 0u) {
        let _e26 = vrcs_pixel;
        let _e27 = vrcs_is_inside(_e26);
        return _e27;
    }
    let _e31 = vrcs_params.tiles_per_row;
    let slot = ((tile.y * _e31) + tile.x);
    let header = vrcs_coords[slot];
    if ((header & VRCS_TILE_IDENTITY) != 0u) {
        let _e43 = vrcs_pixel;
        let _e44 = vrcs_is_inside(_e43);
        return _e44;
    }
    if (lane >= (header & 65535u)) {
        return false;
    }
    let _e52 = vrcs_params.entries;
    let _e55 = vrcs_params.entries_per_tile;
    let entry = vrcs_coords[((_e52 + (slot * _e55)) + lane)];
    let position = vec2<u32>((entry & 255u), ((entry >> 8u) & 255u));
    let _e73 = vrcs_take(vec3<u32>((origin + position), tile.z), (entry >> 16u));
    return _e73;
}

fn vrcs_duplicate(k: u32) -> vec3<u32> {
    let _e2 = vrcs_pixel;
    let _e12 = vrcs_pixel.z;
    return vec3<u32>((_e2.xy ^ vec2<u32>((k & 3u), (k >> 2u))), _e12);
}

fn vrcs_delta(k_1: u32) -> vec2<i32> {
    let _e1 = vrcs_duplicate(k_1);
    let _e5 = vrcs_pixel;
    return (vec2<i32>(_e1.xy) - vec2<i32>(_e5.xy));
}

fn vrcs_copy_picture(at: vec2<u32>, value: vec4<f32>) {
    let _e4 = vrcs_copies;
    if (_e4 != 0u) {
        if ((_e4 & 2u) != 0u) {
            let _e10 = vrcs_delta(1u);
            textureStore(picture, (at + vec2<u32>(_e10)), value);
        }
        if ((_e4 & 16u) != 0u) {
            let _e18 = vrcs_delta(4u);
            textureStore(picture, (at + vec2<u32>(_e18)), value);
        }
        if ((_e4 & 32u) != 0u) {
            let _e26 = vrcs_delta(5u);
            textureStore(picture, (at + vec2<u32>(_e26)), value);
        }
    }
    return;
}

fn main_inner(id: vec3<u32>) {
    let _e2 = id.xy;
    let _e10 = vec4<f32>((vec2<f32>(id.xy) / vec2(64f)), 0f, 1f);
    textureStore(picture, _e2, _e10);
    vrcs_copy_picture(_e2, _e10);
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
