// Tiles of one rate throughout: where their primaries lie is computed, not loaded.

// A number's remainder and its quotient. What divides is a power of two but for a few shaders with barriers, and no GPU has a fast
// division; where it is a constant, the compiler knows which it is.
fn vrcs_divided(number: u32, by: u32) -> vec2<u32> {
    if (by & (by - 1u)) == 0u {
        return vec2<u32>(number & (by - 1u), number >> firstTrailingBit(by));
    }
    return vec2<u32>(number % by, number / by);
}

// Takes over block `number` of a tile that starts at `origin`, is `width` pixels wide and whose rate has this code.
fn vrcs_take_block(origin: vec2<u32>, z: u32, width: u32, number: u32, code: u32, phase: u32) -> bool {
    let rate = vec2<u32>(code >> 2u, code & 3u);
    let size = vec2<u32>(1u) << rate;
    let corner = origin + (vrcs_divided(number, width >> rate.x) << rate);
    let flip = vrcs_flip(rate, corner, phase);
    let pixel = vec3<u32>(corner ^ vec2<u32>(flip & 3u, flip >> 2u), z);
    // a whole block looks the same from each of its pixels
    let row = (1u << size.x) - 1u;
    let rows = 0x1111u & ((1u << (size.y * 4u)) - 1u);
    if vrcs_is_whole(vec3<u32>(corner, z), vec3<u32>(corner + size - 1u, z)) {
        vrcs_pixel = pixel;
        vrcs_copies = (row * rows) & ~1u;
        return true;
    }
    let mask = (row << (corner.x & 3u)) * (rows << ((corner.y & 3u) * 4u));
    return vrcs_take_inside(pixel, (pixel.x & 3u) | ((pixel.y & 3u) << 2u), mask);
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
