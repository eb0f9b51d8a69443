// Graded mode: every invocation runs for its own pixel. The buffer has a word for each quad and in it a byte for each pixel: in
// the low half how many others share with it, in the high half the rate of their block.

// The byte of the pixel at hand; zero, which is no sharing at 1x1, in entry points that were not rewritten.
var<private> vrcs_group: u32;

fn vrcs_grade(pixel: vec3<u32>) {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u || any(pixel.xy >= vrcs_params.extent.xy) {
        return;
    }
    let word = vrcs_coords[(pixel.y >> 1u) * vrcs_params.tiles_per_row + (pixel.x >> 1u)];
    vrcs_group = (word >> (((pixel.y & 1u) * 2u + (pixel.x & 1u)) * 8u)) & 0xffu;
}

fn vrcs_graded_copies() -> u32 {
    return vrcs_group & 15u;
}

fn vrcs_graded_rate() -> vec2<u32> {
    return vec2<u32>(1u) << vec2<u32>(vrcs_group >> 6u, (vrcs_group >> 4u) & 3u);
}

// The same where the user's own bits are asked for.
fn vrcs_grade_in_tile(pixel: vec3<u32>) {
    vrcs_pixel = pixel;
    vrcs_grade(pixel);
}

// The user's own bits of the tile that the pixel at hand lies in: four for each tile, behind the `capacity` words of the quads.
// `entries_per_tile` has the tile's width and height. With shading rates off, and outside the extent, nothing tells them.
fn vrcs_user_bits() -> u32 {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u || any(vrcs_pixel.xy >= vrcs_params.extent.xy) {
        return 0u;
    }
    let size = vec2<u32>(vrcs_params.entries_per_tile & 0xffffu, vrcs_params.entries_per_tile >> 16u);
    let tile = vrcs_pixel.xy / size;
    let tiles_per_row = (vrcs_params.tiles_per_row * 2u + size.x - 1u) / size.x;
    let slot = tile.y * tiles_per_row + tile.x;
    return (vrcs_coords[vrcs_params.capacity + slot / 8u] >> (slot % 8u * 4u)) & 15u;
}
