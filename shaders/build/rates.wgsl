// The rate of each quad: its byte, larger rates where their whole block agrees, at most the largest; and how the extent cuts it.

// The byte of a quad; full rate outside the image.
fn code_of(quad: vec2<u32>, size: vec2<u32>) -> u32 {
    if any(quad >= size) {
        return 0u;
    }
    let word = sri[quad.y * params.sri_pitch + (quad.x >> 2u)];
    let code = extractBits(word, (quad.x & 3u) * 8u, 8u);
    // 1x1, 1x2, 2x1, 2x2, 2x4, 4x2 and 4x4; any other byte means full rate
    let is_rate = code <= 10u && ((0x673u >> code) & 1u) != 0u;
    return select(0u, code, is_rate);
}

// The width and height of a quad's groups, as powers of two.
fn rate_of(quad: vec2<u32>) -> vec2<u32> {
    let size = (params.extent + 1u) / 2u;
    let code = code_of(quad, size);
    var rate = vec2<u32>(code >> 2u, code & 3u);
    if any(rate > vec2<u32>(1u)) {
        let block = quad & vec2<u32>(~1u);
        let agreed = code_of(block, size) == code
            && code_of(block + vec2<u32>(1u, 0u), size) == code
            && code_of(block + vec2<u32>(0u, 1u), size) == code
            && code_of(block + vec2<u32>(1u, 1u), size) == code;
        if !agreed {
            rate = min(rate, vec2<u32>(1u));
        }
    }
    return min(rate, vec2<u32>(params.largest >> 2u, params.largest & 3u));
}

// How far the extent reaches from a pixel of the tile.
fn room_at(origin: vec2<u32>, pixel: vec2<u32>) -> vec2<u32> {
    return params.extent - min(params.extent, origin + pixel);
}

// A rate where the extent cuts its block.
fn cut(origin: vec2<u32>, pixel: vec2<u32>, rate: vec2<u32>) -> vec2<u32> {
    let corner = (pixel >> rate) << rate;
    let room = room_at(origin, corner);
    // 1, 2, 3 or more pixels: as powers of two, rounded up
    let reach = min(room / 2u + select(vec2<u32>(0u), vec2<u32>(1u), room > vec2<u32>(2u)), vec2<u32>(2u));
    let result = min(rate, reach);
    // there is no 4x1 and no 1x4
    return select(result, rate, result.x + result.y == 2u && result.x != result.y);
}
