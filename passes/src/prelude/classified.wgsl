// VRCSPrefix for classified tiles: the dispatch is cut into segments of whole workgroups, one for mixed tiles, then one for each rate.
// The class is uniform in a workgroup; only mixed tiles load entries.
//
// The buffer's first words are: for each of the seven rates the number of covered tiles, and of tiles of sky; the number of
// entries of mixed tiles, and of sky; two that are not used; the phase.

const VRCS_CLASSIFIED_HEADER: u32 = 32u;

// Finds the pixel of invocation `lane` of a workgroup. False if there is none.
fn vrcs_prefix(group: vec3<u32>, lane: u32) -> bool {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return vrcs_take_own(group, lane);
    }
    let area = VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT;
    let mixed = vrcs_coords[14];
    var entries = mixed;
    if VRCS_SHADES_SKY {
        entries += vrcs_coords[15];
    }
    // workgroups of the segments that are left
    var rest = group.y * VRCS_ROW + group.x;
    // mixed tiles first: what they take, a list takes, and no more is to be asked
    let mixed_groups = (entries + area - 1u) / area;
    if rest < mixed_groups {
        let number = rest * area + lane;
        if number >= entries {
            return false;
        }
        let word = vrcs_word_of(number, mixed);
        return vrcs_take_entry(vrcs_coords[word], word, group.z);
    }
    rest -= mixed_groups;
    // all that the ends of the commonest segments hang on is read at once
    let groups = vec4<u32>(vrcs_class_groups(0u), vrcs_class_groups(1u), vrcs_class_groups(2u), vrcs_class_groups(3u));
    if rest < groups.x {
        return vrcs_take_class(0u, rest, group.z, lane);
    }
    rest -= groups.x;
    if rest < groups.y {
        return vrcs_take_class(1u, rest, group.z, lane);
    }
    rest -= groups.y;
    if rest < groups.z {
        return vrcs_take_class(2u, rest, group.z, lane);
    }
    rest -= groups.z;
    if rest < groups.w {
        return vrcs_take_class(3u, rest, group.z, lane);
    }
    rest -= groups.w;
    for (var rate = 4u; rate < 7u; rate++) {
        let more = vrcs_class_groups(rate);
        if rest < more {
            return vrcs_take_class(rate, rest, group.z, lane);
        }
        rest -= more;
    }
    return false;
}

// How many tiles of a rate share a workgroup, as a power of two: 1x1, 1x2, 2x1, 2x2, 2x4, 4x2, 4x4.
fn vrcs_together(rate: u32) -> u32 {
    return (0x4332110u >> (rate * 4u)) & 15u;
}

fn vrcs_class_tiles(rate: u32) -> u32 {
    if VRCS_SHADES_SKY {
        return vrcs_coords[rate] + vrcs_coords[rate + 7u];
    }
    return vrcs_coords[rate];
}

fn vrcs_class_groups(rate: u32) -> u32 {
    let together = vrcs_together(rate);
    return (vrcs_class_tiles(rate) + (1u << together) - 1u) >> together;
}

// Takes over what an invocation of workgroup `group` of a rate's segment has.
fn vrcs_take_class(rate: u32, group: u32, z: u32, lane: u32) -> bool {
    let together = vrcs_together(rate);
    let share = vrcs_divided(lane, (VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT) >> together);
    let number = (group << together) + share.y;
    if number >= vrcs_class_tiles(rate) {
        return false;
    }
    let room = vrcs_params.entries_per_tile;
    let place = vrcs_place(number, vrcs_coords[rate], room);
    let tile = vrcs_coords[VRCS_CLASSIFIED_HEADER + rate * room + place];
    let origin = vec2<u32>(tile & 0xffffu, tile >> 16u) * vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    if rate == 0u {
        let own = vrcs_divided(share.x, VRCS_TILE_WIDTH);
        return vrcs_take_alone(vec3<u32>(origin + own, z));
    }
    // the codes of the rates, a nibble each
    let code = (0xa965410u >> (rate * 4u)) & 15u;
    return vrcs_take_block(origin, z, VRCS_TILE_WIDTH, share.x, code, vrcs_coords[18]);
}
