// VRCSPrefix for a list: invocation n of the dispatch has the list's n-th entry.
//
// The buffer's first words are the number of entries of covered pixels, and that of sky.

// Finds the pixel of invocation `lane` of a workgroup. False if there is none.
fn vrcs_prefix(group: vec3<u32>, lane: u32) -> bool {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_take_own(group, lane);
    }
    let covered = vrcs_coords[0];
    var count = covered;
    if VRCS_SHADES_SKY {
        count += vrcs_coords[1];
    }
    let number = (group.y * VRCS_ROW + group.x) * (VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT) + lane;
    let word = vrcs_word_of(number, covered);
    // read before it is known whether it counts, so that both are waited for at once
    let first = vrcs_coords[word];
    if number >= count {
        return false;
    }
    return vrcs_take_entry(first, word, group.z);
}
