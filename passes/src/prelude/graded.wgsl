// Graded mode: every invocation runs for its own pixel; the buffer has a word for each quad and in it a byte for each pixel: how
// many others share with it, and the rate of their block.

fn vrcs_grade(pixel: vec3<u32>) -> u32 {
    if (vrcs_params.flags & VRCS_ENABLED) == 0u || any(pixel.xy >= vrcs_params.extent.xy) {
        return 0u;
    }
    let word = vrcs_coords[(pixel.y >> 1u) * vrcs_params.tiles_per_row + (pixel.x >> 1u)];
    return (word >> (((pixel.y & 1u) * 2u + (pixel.x & 1u)) * 8u)) & 0xffu;
}
