// VRCSPrefix for tiled dispatch: one workgroup a tile, the tile's primaries in its first invocations.
//
// The coordinate buffer holds a header for each tile and, from word `entries` on, `entries_per_tile` words for each tile. A
// header has the number of entries of covered pixels (9 bits) and of sky (9 bits), three flags, the phase (3 bits), the rate of a
// uniform tile (4 bits). An entry is x | y << 8 | mask << 16: the primary's position in the tile, and the members of its group
// as a mask over its aligned 4x4 block.

// Every pixel of the tile is its own primary; no entries are stored.
const VRCS_TILE_IDENTITY: u32 = 0x40000u;
// The whole tile has one rate; no entries are stored.
const VRCS_TILE_UNIFORM: u32 = 0x80000u;
// The whole tile is sky.
const VRCS_TILE_SKY: u32 = 0x100000u;

fn vrcs_header(tile: vec3<u32>) -> u32 {
    return vrcs_coords[tile.y * vrcs_params.tiles_per_row + tile.x];
}

// Whether every pixel of a tile is shaded for itself.
fn vrcs_is_identity(header: u32) -> bool {
    if VRCS_SHADES_SKY {
        return (header & VRCS_TILE_IDENTITY) != 0u;
    }
    return (header & (VRCS_TILE_IDENTITY | VRCS_TILE_SKY)) == VRCS_TILE_IDENTITY;
}

// The number of a tile's primaries, where it is not an identity.
fn vrcs_primaries(header: u32) -> u32 {
    if VRCS_SHADES_SKY {
        return (header & 0x1ffu) + ((header >> 9u) & 0x1ffu);
    }
    return select(header & 0x1ffu, 0u, (header & VRCS_TILE_SKY) != 0u);
}

// Finds the pixel of invocation `lane` of the workgroup that has the tile. False if there is none. `pixel` is the invocation's
// own place, `size` the tile's.
fn vrcs_tile_prefix(tile: vec3<u32>, pixel: vec3<u32>, lane: u32, size: vec2<u32>) -> bool {
    vrcs_pixel = pixel;
    vrcs_copies = 0u;
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_is_inside(pixel);
    }
    let header = vrcs_header(tile);
    if vrcs_is_identity(header) {
        return vrcs_is_inside(pixel);
    }
    if lane >= vrcs_primaries(header) {
        return false;
    }
    let origin = tile.xy * size;
    if (header & VRCS_TILE_UNIFORM) != 0u {
        return vrcs_take_block(origin, tile.z, size.x, lane, (header >> 24u) & 15u, (header >> 21u) & 7u);
    }
    let slot = tile.y * vrcs_params.tiles_per_row + tile.x;
    let entry = vrcs_coords[vrcs_params.entries + slot * vrcs_params.entries_per_tile + lane];
    let position = vec2<u32>(entry & 0xffu, (entry >> 8u) & 0xffu);
    return vrcs_take(vec3<u32>(origin + position, tile.z), entry >> 16u);
}

// An invocation's own place in a workgroup whose invocations lie in the tile row by row.
fn vrcs_place(tile: vec3<u32>, lane: u32) -> vec3<u32> {
    let size = vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    let own = tile.xy * size + vec2<u32>(lane % VRCS_TILE_WIDTH, lane / VRCS_TILE_WIDTH);
    return vec3<u32>(own, tile.z);
}

// Finds the pixel of an invocation of such a workgroup.
fn vrcs_prefix(tile: vec3<u32>, lane: u32) -> bool {
    let size = vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    return vrcs_tile_prefix(tile, vrcs_place(tile, lane), lane, size);
}
