// VRCSPrefix for tiled dispatch: one workgroup a tile, the tile's primaries in its first invocations.
//
// The coordinate buffer holds a header for each tile (the number of its primaries in the low half, flags above) and, from
// word `entries` on, `entries_per_tile` words for each tile. An entry is x | y << 8 | mask << 16: the primary's position
// in the tile, and the members of its group as a mask over its aligned 4x4 block.

// Every pixel of the tile is its own primary; no entries are stored.
const VRCS_TILE_IDENTITY: u32 = 0x10000u;

// Finds the pixel of invocation `lane` of the workgroup that has the tile. False if there is none.
fn vrcs_prefix(tile: vec3<u32>, lane: u32) -> bool {
    let origin = tile.xy * vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    vrcs_pixel = vec3<u32>(origin + vec2<u32>(lane % VRCS_TILE_WIDTH, lane / VRCS_TILE_WIDTH), tile.z);
    vrcs_copies = 0u;
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_is_inside(vrcs_pixel);
    }
    let slot = tile.y * vrcs_params.tiles_per_row + tile.x;
    let header = vrcs_coords[slot];
    if (header & VRCS_TILE_IDENTITY) != 0u {
        return vrcs_is_inside(vrcs_pixel);
    }
    if lane >= (header & 0xffffu) {
        return false;
    }
    let entry = vrcs_coords[vrcs_params.entries + slot * vrcs_params.entries_per_tile + lane];
    let position = vec2<u32>(entry & 0xffu, (entry >> 8u) & 0xffu);
    return vrcs_take(vec3<u32>(origin + position, tile.z), entry >> 16u);
}
