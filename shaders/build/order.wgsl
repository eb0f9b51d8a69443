// Which pixel of a group comes first, and how a group is graded.

// A mask over the block as one relative to place `home`.
fn relative(mask: u32, home: u32) -> u32 {
    var moved = mask;
    if (home & 1u) != 0u {
        moved = ((moved & 0x5555u) << 1u) | ((moved >> 1u) & 0x5555u);
    }
    if (home & 2u) != 0u {
        moved = ((moved & 0x3333u) << 2u) | ((moved >> 2u) & 0x3333u);
    }
    if (home & 4u) != 0u {
        moved = ((moved & 0x0f0fu) << 4u) | ((moved >> 4u) & 0x0f0fu);
    }
    if (home & 8u) != 0u {
        moved = ((moved & 0x00ffu) << 8u) | ((moved >> 8u) & 0x00ffu);
    }
    return moved;
}

// Which pixel comes first: places are visited by ascending `place ^ flip`. See src/build/primary.rs.
fn flip_of(rate: vec2<u32>, corner: vec2<u32>, covered: u32) -> u32 {
    if params.phase == 0u {
        return 0u;
    }
    let frame = params.phase - 1u;
    let odd = frame & 1u;
    if all(rate == vec2<u32>(1u, 0u)) {
        return (corner.y + odd) & 1u;
    }
    if all(rate == vec2<u32>(0u, 1u)) {
        return ((corner.x + odd) & 1u) << 2u;
    }
    if all(rate == vec2<u32>(1u)) && countOneBits(covered) == 3u {
        var left = covered;
        if frame != 0u {
            left &= left - 1u;
        }
        if frame == 2u {
            left &= left - 1u;
        }
        return firstTrailingBit(left) & 5u;
    }
    return odd * (((1u << rate.x) - 1u) | (((1u << rate.y) - 1u) << 2u));
}

#ifdef GRADED
// A member's byte in the graded buffer.
fn grade(mask: u32) -> u32 {
    let columns = (mask | (mask >> 4u) | (mask >> 8u) | (mask >> 12u)) & 15u;
    let rows = select(0u, 1u, (mask & 0xfu) != 0u) | select(0u, 2u, (mask & 0xf0u) != 0u)
        | select(0u, 4u, (mask & 0xf00u) != 0u) | select(0u, 8u, (mask & 0xf000u) != 0u);
    // the smallest aligned block that holds all of them: the highest bit in which they differ
    let spans = firstLeadingBit(vec2<u32>(columns, rows)) ^ firstTrailingBit(vec2<u32>(columns, rows));
    let logs = min(spans, vec2<u32>(2u));
    return (countOneBits(mask) - 1u) | (((logs.x << 2u) | logs.y) << 4u);
}
#endif
