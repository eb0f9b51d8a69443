// VRCSPrefix for a list: invocation n of the dispatch has the list's n-th entry.
//
// The buffer's first words are the number of entries of covered pixels, that of sky, and the workgroups in a row of the dispatch
// without sky and with it.

// Finds the pixel of invocation `lane` of a workgroup. False if there is none.
fn vrcs_prefix(group: vec3<u32>, lane: u32) -> bool {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_take_own(group, lane);
    }
    let covered = vrcs_coords[0];
    var count = covered;
    var row = vrcs_coords[2];
    if VRCS_SHADES_SKY {
        count += vrcs_coords[1];
        row = vrcs_coords[3];
    }
    let number = (group.y * row + group.x) * (VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT) + lane;
    if number >= count {
        return false;
    }
    let place = vrcs_place(number, covered, vrcs_params.capacity);
    return vrcs_take_entry(vrcs_params.entries + place * vrcs_params.stride, group.z);
}
