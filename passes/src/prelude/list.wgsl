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
    var index = group.x;
    // only below the first row of workgroups does the entry's place wait for what stands in the buffer
    if group.y != 0u {
        index += group.y * vrcs_coords[select(2u, 3u, VRCS_SHADES_SKY)];
    }
    if VRCS_SHADES_SKY {
        count += vrcs_coords[1];
    }
    let number = index * (VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT) + lane;
    let place = vrcs_place(number, covered, vrcs_params.capacity);
    let word = vrcs_params.entries + place * vrcs_params.stride;
    // read before it is known whether it counts, so that both are waited for at once
    let first = vrcs_coords[word];
    if number >= count {
        return false;
    }
    return vrcs_take_entry(first, word, group.z);
}
