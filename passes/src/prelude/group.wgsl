// VRCSPrefix for shaders with barriers: the tile is the workgroup, and nobody leaves. Lane l is itself, and does besides
// what the tile's l-th primary has to do.

// Whether this invocation has a primary. `vrcs_pixel` and `vrcs_copies` are the primary's.
var<private> vrcs_on: bool;
// This invocation's own place in the workgroup, and its primary's.
var<private> vrcs_lane: u32;
var<private> vrcs_slot: u32;

// Whether no pixel of a tile is shaded: the same for the whole workgroup.
fn vrcs_tile_is_empty(tile: vec3<u32>) -> bool {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return false;
    }
    let header = vrcs_header(tile);
    return !vrcs_is_identity(header) && vrcs_primaries(header) == 0u;
}

// Finds the primary of invocation `lane` of the workgroup that has the tile; `pixel` is its own place in the grid.
fn vrcs_group_begin(tile: vec3<u32>, pixel: vec3<u32>, lane: u32, size: vec2<u32>) {
    vrcs_lane = lane;
    vrcs_on = vrcs_tile_prefix(tile, pixel, lane, size);
    let place = vrcs_pixel.xy - tile.xy * size;
    vrcs_slot = place.y * size.x + place.x;
}

// For masked regions: whether this invocation's own pixel is a primary, with its duplicates. Between regions, what a copy
// goes by is kept here.
var<private> vrcs_is_primary: bool;
var<private> vrcs_other_pixel: vec3<u32>;
var<private> vrcs_other_copies: u32;
var<workgroup> vrcs_masks: array<u32, VRCS_GROUP_ROOM>;

// Tells each primary's own invocation of its duplicates. Every invocation has to come here.
fn vrcs_group_masks(pixel: vec3<u32>) {
    vrcs_masks[vrcs_lane] = 0u;
    workgroupBarrier();
    if vrcs_on {
        vrcs_masks[vrcs_slot] = vrcs_copies | 1u;
    }
    workgroupBarrier();
    let mask = vrcs_masks[vrcs_lane];
    vrcs_is_primary = (mask & 1u) != 0u;
    vrcs_other_pixel = pixel;
    vrcs_other_copies = mask & ~1u;
}

// Changes between the two meanings of "this pixel": the lane's primary, and the invocation's own.
fn vrcs_change_pixel() {
    let pixel = vrcs_pixel;
    vrcs_pixel = vrcs_other_pixel;
    vrcs_other_pixel = pixel;
    let copies = vrcs_copies;
    vrcs_copies = vrcs_other_copies;
    vrcs_other_copies = copies;
}
