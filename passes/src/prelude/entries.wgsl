// Entries of a list: where in the picture a primary lies, and the members of its group.
//
// One word where no group is larger than a quad: x | y << 14 | duplicates << 28, of which bit 0 stands for the horizontal neighbour in the
// quad, bit 1 for the vertical one and bit 2 for the diagonal one; else two words: x | y << 16, and the members over the aligned 4x4 block.

// Workgroups in a row of a dispatch by a list: a number, so that where an entry stands hangs on nothing that is read. On an H200 a
// row that the buffer told, and a branch that asked for it below the first row only, cost a pass of 0.2 ms 1 and 6 %.
const VRCS_ROW: u32 = 32u;

// The user's own bits of the tile that the pixel at hand lies in: four for each tile, behind the entries. With shading rates off
// nothing tells them.
fn vrcs_user_bits() -> u32 {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u {
        return 0u;
    }
    let tile = vrcs_pixel.xy / vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    let slot = tile.y * vrcs_params.tiles_per_row + tile.x;
    let first = vrcs_params.entries + vrcs_params.capacity * vrcs_params.stride;
    return (vrcs_coords[first + slot / 8u] >> (slot % 8u * 4u)) & 15u;
}

// Takes over the entry at a word, of which `first` is what stands there.
fn vrcs_take_entry(first: u32, word: u32, z: u32) -> bool {
    if vrcs_params.stride == 1u {
        return vrcs_take_quad(vec3<u32>(first & 0x3fffu, (first >> 14u) & 0x3fffu, z), first >> 28u);
    }
    return vrcs_take_listed(first, vrcs_coords[word + 1u], z);
}

// The word at which entry `number` stands.
fn vrcs_word_of(number: u32, covered: u32) -> u32 {
    return vrcs_params.entries + vrcs_place(number, covered, vrcs_params.capacity) * vrcs_params.stride;
}

// The place of entry `number`, where those of sky lie at the end, the last one first.
fn vrcs_place(number: u32, covered: u32, capacity: u32) -> u32 {
    if VRCS_SHADES_SKY {
        return select(capacity - 1u - (number - covered), number, number < covered);
    }
    return number;
}

// With shading rates off: every pixel of a tile.
fn vrcs_take_own(group: vec3<u32>, lane: u32) -> bool {
    let origin = group.xy * vec2<u32>(VRCS_TILE_WIDTH, VRCS_TILE_HEIGHT);
    return vrcs_take_alone(vec3<u32>(origin + vec2<u32>(lane % VRCS_TILE_WIDTH, lane / VRCS_TILE_WIDTH), group.z));
}
