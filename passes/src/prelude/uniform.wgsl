// Tiles of one rate throughout: where their primaries lie is computed, not loaded.

// Takes over block `number` of a tile that starts at `origin`, is `width` pixels wide and whose rate has this code.
fn vrcs_take_block(origin: vec2<u32>, z: u32, width: u32, number: u32, code: u32, phase: u32) -> bool {
    let rate = vec2<u32>(code >> 2u, code & 3u);
    let across = width >> rate.x;
    let corner = origin + (vec2<u32>(number % across, number / across) << rate);
    let size = vec2<u32>(1u) << rate;
    let row = ((1u << size.x) - 1u) << (corner.x & 3u);
    let rows = (0x1111u & ((1u << (size.y * 4u)) - 1u)) << ((corner.y & 3u) * 4u);
    let flip = vrcs_flip(rate, corner, phase);
    return vrcs_take(vec3<u32>(corner ^ vec2<u32>(flip & 3u, flip >> 2u), z), row * rows);
}

// From a block's first corner to the pixel that is its primary in this phase: 0, or 1 + the frame's number modulo 4.
fn vrcs_flip(rate: vec2<u32>, corner: vec2<u32>, phase: u32) -> u32 {
    if phase == 0u {
        return 0u;
    }
    let odd = (phase - 1u) & 1u;
    // half rates flip as a checkerboard
    if rate.x + rate.y == 1u {
        return select((corner.x + odd) & 1u, (corner.y + odd) & 1u, rate.x == 1u) << (rate.y * 2u);
    }
    // the others from one corner to the opposite one
    return odd * (((1u << rate.x) - 1u) | (((1u << rate.y) - 1u) << 2u));
}
