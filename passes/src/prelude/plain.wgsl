// Entries as they are without linear depth.

// Takes over an entry of a tile that starts at `origin`: x | y << 8 | mask << 16.
fn vrcs_take_tiled(origin: vec2<u32>, z: u32, entry: u32) -> bool {
    let position = vec2<u32>(entry & 0xffu, (entry >> 8u) & 0xffu);
    return vrcs_take(vec3<u32>(origin + position, z), entry >> 16u);
}

// Takes over an entry of a list that has two words: x | y << 16, and the members over the aligned 4x4 block.
fn vrcs_take_listed(first: u32, second: u32, z: u32) -> bool {
    return vrcs_take(vec3<u32>(first & 0xffffu, first >> 16u, z), second);
}
