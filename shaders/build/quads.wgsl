// The groups of a quad, where no group is larger: all in registers.

#ifdef LOCAL
// The places of a quad are bits 0 to 3, row by row.
struct Quad {
    // A nibble for each place: the members of the group that it leads.
    leads: u32,
    // A bit for each place that is sky.
    sky: u32,
    // A bit for each place in the extent.
    inside: u32,
    is_split: bool,
}

// Members as a mask over the aligned 4x4 block; `at` is the quad's first pixel in the picture.
fn over_block(members: u32, at: vec2<u32>) -> u32 {
    return ((members & 3u) | ((members & 12u) << 2u)) << ((at.x & 2u) + (at.y & 2u) * 4u);
}

// The bits of four places, each at the start of its nibble.
fn spread(places: u32) -> u32 {
    return (places & 1u) | ((places & 2u) << 3u) | ((places & 4u) << 6u) | ((places & 8u) << 9u);
}

// Finds the groups of one block of the quad and adds them to it; how many.
fn add_block(quad: ptr<function, Quad>, first: vec2<u32>, at: vec2<u32>, rate: vec2<u32>, block: u32) -> u32 {
    var left = (*quad).inside & block;
    if left == 0u {
        return 0u;
    }
    let place = firstTrailingBit(block);
    let corner = at + vec2<u32>(place & 1u, place >> 1u);
    let turn = flip_of(rate, corner, over_block(left & ~(*quad).sky, at));
    let flip = (turn & 1u) | ((turn >> 1u) & 2u);
    var groups = 0u;
    loop {
        var turned = left;
        turned = select(turned, ((turned & 5u) << 1u) | ((turned >> 1u) & 5u), (flip & 1u) != 0u);
        turned = select(turned, ((turned & 3u) << 2u) | (turned >> 2u), (flip & 2u) != 0u);
        let home = firstTrailingBit(turned) ^ flip;
        var members = left;
#ifdef COVERAGE
        members = 1u << home;
        for (var rest = left & ~members; rest != 0u; rest &= rest - 1u) {
            let other = firstTrailingBit(rest);
            if share(first + vec2<u32>(home & 1u, home >> 1u), first + vec2<u32>(other & 1u, other >> 1u)) {
                members |= 1u << other;
            }
        }
#endif
        (*quad).leads |= members << (home * 4u);
        left &= ~members;
        groups++;
        if left == 0u {
            break;
        }
    }
    return groups;
}

// `first` is the quad's first pixel in its tile, `at` the same in the picture, `room` how far the extent reaches from there.
fn quad_groups(first: vec2<u32>, at: vec2<u32>, room: vec2<u32>, rate: vec2<u32>) -> Quad {
    var quad: Quad;
    let columns = select(select(0u, 5u, room.x > 0u), 15u, room.x > 1u);
    let rows = select(select(0u, 3u, room.y > 0u), 15u, room.y > 1u);
    quad.inside = columns & rows;
#ifdef SKY
    for (var rest = quad.inside; rest != 0u; rest &= rest - 1u) {
        let place = firstTrailingBit(rest);
        quad.sky |= is_sky[(first.y + (place >> 1u)) * TILE.x + first.x + (place & 1u)] << place;
    }
#endif
    if all(rate == vec2<u32>(0u)) {
        quad.leads = (spread(quad.inside) * 15u) & 0x8421u;
        return quad;
    }
    let block = select(select(3u, 5u, rate.x == 0u), 15u, rate.x == rate.y);
    let groups = add_block(&quad, first, at, rate, block);
    let others = add_block(&quad, first, at, rate, ~block & 15u);
    quad.is_split = max(groups, others) > 1u;
    return quad;
}

// The rate of a quad: no larger one has to agree with its block, since none is left.
fn quad_rate(quad: vec2<u32>) -> vec2<u32> {
    let code = code_of(quad, (params.extent + 1u) / 2u);
    return min(vec2<u32>(code >> 2u, code & 3u), vec2<u32>(params.largest >> 2u, params.largest & 3u));
}

#ifdef GRADED
// The bytes of the quad's pixels in the graded buffer.
fn quad_grades(quad: Quad, at: vec2<u32>) -> u32 {
    var word = 0u;
    for (var i = 0u; i < 4u; i++) {
        let members = (quad.leads >> (i * 4u)) & 15u;
        if members != 0u {
            // a byte for each member
            let bytes = (members & 1u) | ((members & 2u) << 7u) | ((members & 4u) << 14u) | ((members & 8u) << 21u);
            word |= bytes * grade(over_block(members, at));
        }
    }
    return word;
}
#endif
#endif
