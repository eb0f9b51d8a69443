// VRCSPrefix for classified tiles: the dispatch is cut into segments of whole workgroups, one for mixed tiles, then one for each rate.
// The class is uniform in a workgroup; only mixed tiles load entries.
//
// The buffer's first words are: for each of the seven rates the number of covered tiles, and of tiles of sky; the number of
// entries of mixed tiles, and of sky; the workgroup behind each rate's segment of covered tiles, and behind each where sky is shaded; the
// phase. What hangs on one another is read in few steps: an H200 takes 2 % longer for a pass of 0.2 ms with each more.

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
    let number = group.y * VRCS_ROW + group.x;
    // mixed tiles first: what they take, a list takes, and no more is to be asked. Read before it is known whether it counts, as there
    let entry = number * area + lane;
    let word = vrcs_word_of(entry, mixed);
    let first = vrcs_coords[word];
    if number * area < entries {
        if entry >= entries {
            return false;
        }
        return vrcs_take_entry(first, word, group.z);
    }
    let ends = vec4<u32>(vrcs_class_end(0u), vrcs_class_end(1u), vrcs_class_end(2u), vrcs_class_end(3u));
    if number < ends.x {
        return vrcs_take_class(0u, number - (entries + area - 1u) / area, group.z, lane);
    }
    if number < ends.y {
        return vrcs_take_class(1u, number - ends.x, group.z, lane);
    }
    if number < ends.z {
        return vrcs_take_class(2u, number - ends.y, group.z, lane);
    }
    if number < ends.w {
        return vrcs_take_class(3u, number - ends.z, group.z, lane);
    }
    var start = ends.w;
    for (var rate = 4u; rate < 7u; rate++) {
        let end = vrcs_class_end(rate);
        if number < end {
            return vrcs_take_class(rate, number - start, group.z, lane);
        }
        start = end;
    }
    return false;
}

// The workgroup behind a rate's segment.
fn vrcs_class_end(rate: u32) -> u32 {
    if VRCS_SHADES_SKY {
        return vrcs_coords[rate + 23u];
    }
    return vrcs_coords[rate + 16u];
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

// Takes over what an invocation of workgroup `group` of a rate's segment has.
fn vrcs_take_class(rate: u32, group: u32, z: u32, lane: u32) -> bool {
    let together = vrcs_together(rate);
    let share = vrcs_divided(lane, (VRCS_TILE_WIDTH * VRCS_TILE_HEIGHT) >> together);
    let number = (group << together) + share.y;
    let room = vrcs_params.entries_per_tile;
    let place = vrcs_place(number, vrcs_coords[rate], room);
    let tiles = vrcs_class_tiles(rate);
    let tile = vrcs_coords[VRCS_CLASSIFIED_HEADER + rate * room + place];
    let phase = vrcs_coords[30];
    // a workgroup has one tile of the first rate, and several of the others, of which the last ones may lack
    if rate != 0u && number >= tiles {
        return false;
    }
    let origin = vec2<u32>(tile & 0xffffu, tile >> 16u) * vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    if rate == 0u {
        let own = vrcs_divided(share.x, VRCS_TILE_WIDTH);
        return vrcs_take_alone(vec3<u32>(origin + own, z));
    }
    if rate == 3u {
        let corner = origin + vrcs_divided(share.x, VRCS_TILE_WIDTH / 2u) * 2u;
        let flip = vrcs_flip(vec2<u32>(1u), corner, phase) & 1u;
        return vrcs_take_quad(vec3<u32>(corner ^ vec2<u32>(flip), z), 7u);
    }
    // the codes of the rates, a nibble each
    let code = (0xa965410u >> (rate * 4u)) & 15u;
    return vrcs_take_block(origin, z, VRCS_TILE_WIDTH, share.x, code, phase);
}
