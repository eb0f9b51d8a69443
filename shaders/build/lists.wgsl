// Counts, the numbers of rates, and entries as the lists have them.

// The sum of the fields of a word.
fn sum_of(fields: u32) -> u32 {
#ifdef WORDWISE
    return (fields * 0x01010101u) >> 24u;
#else
    let pairs = (fields & 0x0f0f0f0fu) + ((fields >> 4u) & 0x0f0f0f0fu);
    return (pairs * 0x01010101u) >> 24u;
#endif
}

// The order number of a rate among all.
fn rate_index(code: u32) -> u32 {
    // a nibble for each of the codes 0 to 7; 9 and 10 stand apart
    return select((0x04320010u >> (code * 4u)) & 15u, code - 4u, code > 7u);
}

// The entry of a primary as the lists have it: one word where no group is larger than a quad.
fn listed(pixel: vec2<u32>, mask: u32) -> u32 {
    let quad = mask >> ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
    return pixel.x | (pixel.y << 14u) | ((quad & 3u) << 28u) | (((quad >> 4u) & 3u) << 30u);
}

#ifdef LIST
fn put_list(at: u32, pixel: vec2<u32>, mask: u32) {
    if params.list_stride == 1u {
        list[LIST_HEADER + at] = listed(pixel, mask);
        return;
    }
    list[LIST_HEADER + at * 2u] = pixel.x | (pixel.y << 16u);
    list[LIST_HEADER + at * 2u + 1u] = mask;
}
#endif

#ifdef CLASSIFIED
fn put_mixed(at: u32, pixel: vec2<u32>, mask: u32) {
    if params.list_stride == 1u {
        classified[params.mixed + at] = listed(pixel, mask);
        return;
    }
    classified[params.mixed + at * 2u] = pixel.x | (pixel.y << 16u);
    classified[params.mixed + at * 2u + 1u] = mask;
}
#endif
