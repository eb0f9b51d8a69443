// Counts, the numbers of rates, and entries as the lists have them.

// The sum of the fields of a word.
fn sum_of(fields: u32) -> u32 {
    let pairs = (fields & 0x0f0f0f0fu) + ((fields >> 4u) & 0x0f0f0f0fu);
    return (pairs * 0x01010101u) >> 24u;
}

// The order number of a rate among all.
fn rate_index(code: u32) -> u32 {
    // a nibble for each of the codes 0 to 7; 9 and 10 stand apart
    return select((0x04320010u >> (code * 4u)) & 15u, code - 4u, code > 7u);
}

// The entry of a primary as the lists have it: one word where no group is larger than a quad. Twin: ListEntry::quad in src/build/mod.rs.
fn listed(pixel: vec2<u32>, mask: u32) -> u32 {
    let block = mask >> ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
    // the members as the primary sees them: columns, then rows, exchanged
    var quad = (block & 3u) | ((block >> 2u) & 12u);
    quad = select(quad, ((quad & 5u) << 1u) | ((quad >> 1u) & 5u), (pixel.x & 1u) != 0u);
    quad = select(quad, ((quad & 3u) << 2u) | (quad >> 2u), (pixel.y & 1u) != 0u);
    return pixel.x | (pixel.y << 14u) | ((quad >> 1u) << 28u);
}

#ifdef LINEAR_DEPTH
// The linear depth of a pixel, 0 at the near plane and 1 at the far one. Twin: LinearDepth::share in src/build/mod.rs.
fn linear_depth(pixel: vec2<u32>) -> f32 {
    let texel = textureLoad(depth_texture, texel_of(vec2<i32>(pixel)), 0).x;
#ifdef LINEAR
    let distance = texel;
#else
    let distance = params.linear_factor / (texel * params.depth_scale + params.depth_bias);
#endif
    // what lies behind the viewer, or is no number, is far: such bits are no positive finite ones
    let is_ahead = bitcast<i32>(distance) > 0 && bitcast<i32>(distance) < 0x7f800000;
    return select(1.0, clamp((distance - params.linear_near) * params.linear_share, 0.0, 1.0), is_ahead);
}

// An entry of a tile that carries linear depth: x | y << 4 | members of the quad << 8 | depth << 12.
fn deep_entry(entry: u32, pixel: vec2<u32>, depth: u32) -> u32 {
    let quad = (entry >> 16u) >> ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
    let members = (quad & 3u) | (((quad >> 4u) & 3u) << 2u);
    return (entry & 15u) | (((entry >> 8u) & 15u) << 4u) | (members << 8u) | (depth << 12u);
}
#endif

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
