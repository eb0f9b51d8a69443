// VRCSPrefix for classified tiles: the dispatch is cut into segments of whole workgroups, one for each rate, then one for mixed
// tiles. The class is uniform in a workgroup; only mixed tiles load entries.
//
// The buffer's first words are: for each of the seven rates the number of covered tiles, and of tiles of sky; the number of
// entries of mixed tiles, and of sky; the workgroups in a row of the dispatch without sky and with it; the phase.

const VRCS_CLASSIFIED_HEADER: u32 = 32u;

// Finds the pixel of invocation `lane` of a workgroup. False if there is none.
fn vrcs_prefix(group: vec3<u32>, lane: u32) -> bool {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_take_own(group, lane);
    }
    let area = VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT;
    let room = vrcs_params.entries_per_tile;
    // workgroups of the segments that are left
    var rest = group.y * vrcs_coords[select(16u, 17u, VRCS_SHADES_SKY)] + group.x;
    for (var rate = 0u; rate < 7u; rate++) {
        let covered = vrcs_coords[rate];
        var tiles = covered;
        if VRCS_SHADES_SKY {
            tiles += vrcs_coords[rate + 7u];
        }
        // 1x1, 1x2, 2x1, 2x2, 2x4, 4x2, 4x4: so many tiles share a workgroup
        let together = 1u << ((0x4332110u >> (rate * 4u)) & 15u);
        let groups = (tiles + together - 1u) / together;
        if rest < groups {
            let lanes = area / together;
            let number = rest * together + lane / lanes;
            if number >= tiles {
                return false;
            }
            let slot = vrcs_coords[VRCS_CLASSIFIED_HEADER + rate * room + vrcs_place(number, covered, room)];
            let tile = vec2<u32>(slot % vrcs_params.tiles_per_row, slot / vrcs_params.tiles_per_row);
            let origin = tile * vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
            // the codes of the rates, a nibble each
            let code = (0xa965410u >> (rate * 4u)) & 15u;
            return vrcs_take_block(origin, group.z, VRCS_TILE_WIDTH, lane % lanes, code, vrcs_coords[18]);
        }
        rest -= groups;
    }
    let covered = vrcs_coords[14];
    let number = rest * area + lane;
    if number >= covered + select(0u, vrcs_coords[15], VRCS_SHADES_SKY) {
        return false;
    }
    let place = vrcs_place(number, covered, vrcs_params.capacity);
    let word = vrcs_params.entries + place * vrcs_params.stride;
    return vrcs_take_entry(vrcs_coords[word], word, group.z);
}
