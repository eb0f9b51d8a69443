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
    capacity: u32,
    stride: u32,
}

const VRCS_TILE_WIDTH: u32 = 16u;
const VRCS_SHADES_SKY: bool = false;
const VRCS_TILE_IDENTITY: u32 = 262144u;
const VRCS_TILE_SKY: u32 = 1048576u;
const VRCS_ENABLED: u32 = 1u;
const VRCS_TILE_UNIFORM: u32 = 524288u;

@group(0) @binding(0)
var picture: texture_storage_2d<rgba8unorm,write>;
@group(1) @binding(0)
var<uniform> vrcs_params: VrcsParams;
var<private> vrcs_pixel: vec3<u32>;
var<private> vrcs_copies: u32;
var<private> vrcs_tile: u32;
@group(1) @binding(1)
var<storage> vrcs_coords: array<u32>;

fn vrcs_place(tile: vec3<u32>, lane: u32) -> vec3<u32> {
    let size_1 = vec2<u32>(16u, 16u);
    let own = ((tile.xy * size_1) + vec2<u32>((lane % VRCS_TILE_WIDTH), (lane / VRCS_TILE_WIDTH)));
    return vec3<u32>(own, tile.z);
}

fn vrcs_is_inside(pixel: vec3<u32>) -> bool {
    let _e3 = vrcs_params.extent;
    return all((pixel < _e3));
}

fn vrcs_is_shaded(pixel_1: vec3<u32>) -> bool {
    let _e1 = vrcs_is_inside(pixel_1);
    return _e1;
}

fn vrcs_header(tile_1: vec3<u32>) -> u32 {
    let _e4 = vrcs_params.tiles_per_row;
    let slot = ((tile_1.y * _e4) + tile_1.x);
    vrcs_tile = slot;
    let _e11 = vrcs_coords[slot];
    return _e11;
}

fn vrcs_is_identity(header: u32) -> bool {
    if VRCS_SHADES_SKY {
        return ((header & VRCS_TILE_IDENTITY) != 0u);
    }
    return ((header & 1310720u) == VRCS_TILE_IDENTITY);
}

fn vrcs_primaries(header_1: u32) -> u32 {
    if VRCS_SHADES_SKY {
        return ((header_1 & 511u) + ((header_1 >> 9u) & 511u));
    }
    return select((header_1 & 511u), 0u, ((header_1 & VRCS_TILE_SKY) != 0u));
}

fn vrcs_divided(number: u32, by: u32) -> vec2<u32> {
    if ((by & (by - 1u)) == 0u) {
        return vec2<u32>((number & (by - 1u)), (number >> firstTrailingBit(by)));
    }
    return vec2<u32>((number % by), (number / by));
}

fn vrcs_flip(rate: vec2<u32>, corner: vec2<u32>, phase: u32) -> u32 {
    if (phase == 0u) {
        return 0u;
    }
    let odd = ((phase - 1u) & 1u);
    if ((rate.x + rate.y) == 1u) {
        return (select(((corner.x + odd) & 1u), ((corner.y + odd) & 1u), (rate.x == 1u)) << (rate.y * 2u));
    }
    return (odd * (((1u << rate.x) - 1u) | (((1u << rate.y) - 1u) << 2u)));
}

fn vrcs_holds_throughout(near: vec3<u32>, far: vec3<u32>) -> bool {
    return true;
}

fn vrcs_is_whole(near_1: vec3<u32>, far_1: vec3<u32>) -> bool {
    var local: bool;

    let _e4 = vrcs_params.extent;
    if all((far_1 < _e4)) {
        let _e9 = vrcs_holds_throughout(near_1, far_1);
        local = _e9;
    } else {
        local = false;
    }
    let _e11 = local;
    return _e11;
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

fn vrcs_take_inside(pixel_2: vec3<u32>, nominal: u32, mask_3: u32) -> bool {
    var local_1: bool;
    var home_1: u32;

    let block_2 = (pixel_2.xy & vec2(4294967292u));
    let _e8 = vrcs_members_in_extent(block_2, mask_3);
    let _e9 = vrcs_members(block_2, pixel_2.z, _e8);
    if !((_e9 == 0u)) {
        let _e19 = vrcs_params.extent.z;
        local_1 = (pixel_2.z >= _e19);
    } else {
        local_1 = true;
    }
    let _e22 = local_1;
    if _e22 {
        return false;
    }
    home_1 = nominal;
    let _e25 = home_1;
    if (((_e9 >> _e25) & 1u) == 0u) {
        home_1 = firstTrailingBit(_e9);
    }
    let _e33 = home_1;
    let _e36 = home_1;
    vrcs_pixel = vec3<u32>((block_2 + vec2<u32>((_e33 & 3u), (_e36 >> 2u))), pixel_2.z);
    let _e44 = home_1;
    let _e45 = vrcs_relative(_e9, _e44);
    vrcs_copies = (_e45 & 4294967294u);
    return true;
}

fn vrcs_take_block(origin: vec2<u32>, z_1: u32, width: u32, number_1: u32, code: u32, phase_1: u32) -> bool {
    let rate_1 = vec2<u32>((code >> 2u), (code & 3u));
    let size_2 = (vec2(1u) << rate_1);
    let _e16 = vrcs_divided(number_1, (width >> rate_1.x));
    let corner_1 = (origin + (_e16 << rate_1));
    let _e19 = vrcs_flip(rate_1, corner_1, phase_1);
    let pixel_5 = vec3<u32>((corner_1 ^ vec2<u32>((_e19 & 3u), (_e19 >> 2u))), z_1);
    let row = ((1u << size_2.x) - 1u);
    let rows_1 = (4369u & ((1u << (size_2.y * 4u)) - 1u));
    let _e47 = vrcs_is_whole(vec3<u32>(corner_1, z_1), vec3<u32>(((corner_1 + size_2) - vec2(1u)), z_1));
    if _e47 {
        vrcs_pixel = pixel_5;
        vrcs_copies = ((row * rows_1) & 4294967294u);
        return true;
    }
    let mask_5 = ((row << (corner_1.x & 3u)) * (rows_1 << ((corner_1.y & 3u) * 4u)));
    let _e74 = vrcs_take_inside(pixel_5, ((pixel_5.x & 3u) | ((pixel_5.y & 3u) << 2u)), mask_5);
    return _e74;
}

fn vrcs_take(pixel_3: vec3<u32>, mask_4: u32) -> bool {
    var local_2: bool;

    let home_2 = ((pixel_3.x & 3u) | ((pixel_3.y & 3u) << 2u));
    let near_2 = vec3<u32>((pixel_3.xy & vec2(4294967292u)), pixel_3.z);
    if (((mask_4 >> home_2) & 1u) != 0u) {
        let _e30 = vrcs_is_whole(near_2, vec3<u32>((pixel_3.xy | vec2(3u)), pixel_3.z));
        local_2 = _e30;
    } else {
        local_2 = false;
    }
    let _e32 = local_2;
    if _e32 {
        vrcs_pixel = pixel_3;
        let _e35 = vrcs_relative(mask_4, home_2);
        vrcs_copies = (_e35 & 4294967294u);
        return true;
    }
    let _e39 = vrcs_take_inside(pixel_3, home_2, mask_4);
    return _e39;
}

fn vrcs_take_tiled(origin_1: vec2<u32>, z_2: u32, entry: u32) -> bool {
    let position = vec2<u32>((entry & 255u), ((entry >> 8u) & 255u));
    let _e14 = vrcs_take(vec3<u32>((origin_1 + position), z_2), (entry >> 16u));
    return _e14;
}

fn vrcs_tile_prefix(tile_2: vec3<u32>, pixel_4: vec3<u32>, lane_1: u32, size: vec2<u32>) -> bool {
    vrcs_pixel = pixel_4;
    vrcs_copies = 0u;
    let _e9 = vrcs_params.flags;
    if ((_e9 & VRCS_ENABLED) == 0u) {
        let _e14 = vrcs_is_shaded(pixel_4);
        return _e14;
    }
    let _e15 = vrcs_header(tile_2);
    let _e16 = vrcs_is_identity(_e15);
    if _e16 {
        let _e17 = vrcs_is_shaded(pixel_4);
        return _e17;
    }
    let _e18 = vrcs_primaries(_e15);
    if (lane_1 >= _e18) {
        return false;
    }
    let origin_2 = (tile_2.xy * size);
    if ((_e15 & VRCS_TILE_UNIFORM) != 0u) {
        let _e37 = vrcs_take_block(origin_2, tile_2.z, size.x, lane_1, ((_e15 >> 24u) & 15u), ((_e15 >> 21u) & 7u));
        return _e37;
    }
    let _e41 = vrcs_params.tiles_per_row;
    let slot_1 = ((tile_2.y * _e41) + tile_2.x);
    let _e48 = vrcs_params.entries;
    let _e51 = vrcs_params.entries_per_tile;
    let entry_1 = vrcs_coords[((_e48 + (slot_1 * _e51)) + lane_1)];
    let _e58 = vrcs_take_tiled(origin_2, tile_2.z, entry_1);
    return _e58;
}

fn vrcs_prefix(tile_3: vec3<u32>, lane_2: u32) -> bool {
    let size_3 = vec2<u32>(16u, 16u);
    let _e5 = vrcs_place(tile_3, lane_2);
    let _e6 = vrcs_tile_prefix(tile_3, _e5, lane_2, size_3);
    return _e6;
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
    let _e2 = id.xy;
    let _e10 = vec4<f32>((vec2<f32>(id.xy) / vec2(64f)), 0f, 1f);
    vrcs_copy_picture(_e2, _e10);
    textureStore(picture, _e2, _e10);
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
