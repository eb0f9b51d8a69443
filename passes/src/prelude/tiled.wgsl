// VRCSPrefix for tiled dispatch: one workgroup a tile, the tile's primaries in its first invocations.
//
// The coordinate buffer holds a header for each tile and, from word `entries` on, `entries_per_tile` words for each tile. A
// header has the number of entries of covered pixels (9 bits) and of sky (9 bits), three flags, the phase (3 bits), the rate of a
// uniform tile (4 bits). An entry has the primary's position in the tile, and the members of its group.

// Every pixel of the tile is its own primary; no entries are stored.
const VRCS_TILE_IDENTITY: u32 = 0x40000u;
// The whole tile has one rate; no entries are stored.
const VRCS_TILE_UNIFORM: u32 = 0x80000u;
// The whole tile is sky.
const VRCS_TILE_SKY: u32 = 0x100000u;

// The number of the tile at hand.
var<private> vrcs_tile: u32;

// The word is found by the tile itself: what is read from a private variable is not uniform to a browser, and an empty tile leaves by it
// before a barrier.
fn vrcs_header(tile: vec3<u32>) -> u32 {
    let slot = tile.y * vrcs_params.tiles_per_row + tile.x;
    vrcs_tile = slot;
    return vrcs_coords[slot];
}

// The user's own bits of the tile at hand; with shading rates off nothing tells them.
fn vrcs_user_bits() -> u32 {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return 0u;
    }
    return vrcs_coords[vrcs_tile] >> 28u;
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
        return vrcs_is_shaded(pixel);
    }
    let header = vrcs_header(tile);
    if vrcs_is_identity(header) {
        return vrcs_is_shaded(pixel);
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
    return vrcs_take_tiled(origin, tile.z, entry);
}

// An invocation's own place in a workgroup whose invocations lie in the tile row by row.
fn vrcs_place(tile: vec3<u32>, lane: u32) -> vec3<u32> {
    let size = vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    let own = tile.xy * size + vec2<u32>(lane % VRCS_TILE_WIDTH, lane / VRCS_TILE_WIDTH);
    return vec3<u32>(own, tile.z);
}

// The same for what runs before the pixel is found, where that asks for the user's own bits.
fn vrcs_place_in_tile(tile: vec3<u32>, lane: u32) -> vec3<u32> {
    vrcs_tile = tile.y * vrcs_params.tiles_per_row + tile.x;
    return vrcs_place(tile, lane);
}

// Finds the pixel of an invocation of such a workgroup.
fn vrcs_prefix(tile: vec3<u32>, lane: u32) -> bool {
    let size = vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    return vrcs_tile_prefix(tile, vrcs_place(tile, lane), lane, size);
}
