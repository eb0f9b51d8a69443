// The groups of any block: they may reach over quads, so that they are noted in workgroup memory, each at its primary's place.

#ifndef LOCAL
// Finds the groups of the block with this first corner. The tile's pixels start at `base_pixel`, its quads at `base_quad`.
fn cluster(base_pixel: u32, base_quad: u32, origin: vec2<u32>, corner: vec2<u32>, rate: vec2<u32>) {
    let in_block = (origin + corner) & vec2<u32>(3u);
    // may lie before the tile, where places that no mask has would wrap
    let base = corner - in_block;
    let size = min(room_at(origin, corner), vec2<u32>(1u) << rate);
    let row = ((1u << size.x) - 1u) << in_block.x;
    let rows = (0x1111u & ((1u << (size.y * 4u)) - 1u)) << (in_block.y * 4u);
    var left = row * rows;
    var sky = 0u;
#ifdef SKY
    for (var rest = left; rest != 0u; rest &= rest - 1u) {
        let place = firstTrailingBit(rest);
        let at = base + vec2<u32>(place & 3u, place >> 2u);
        sky |= is_sky[at.y * TILE.x + at.x] << place;
    }
#endif
    let flip = flip_of(rate, origin + corner, left & ~sky);
    var groups = 0u;
    while left != 0u {
        let home = firstTrailingBit(relative(left, flip)) ^ flip;
        let at = base + vec2<u32>(home & 3u, home >> 2u);
        var members = left;
#ifdef COVERAGE
        members = 1u << home;
        for (var rest = left & ~members; rest != 0u; rest &= rest - 1u) {
            let place = firstTrailingBit(rest);
            if share(at, base + vec2<u32>(place & 3u, place >> 2u)) {
                members |= 1u << place;
            }
        }
#endif
        leads[base_pixel + at.y * TILE.x + at.x] = members | (((sky >> home) & 1u) << 16u);
#ifdef GRADED
        let byte = grade(members);
        for (var rest = members; rest != 0u; rest &= rest - 1u) {
            let place = firstTrailingBit(rest);
            let member = base + vec2<u32>(place & 3u, place >> 2u);
            grades[base_pixel + member.y * TILE.x + member.x] = byte;
        }
#endif
        left &= ~members;
        groups++;
    }
#ifdef EFFECTIVE
    if groups > 1u {
        for (var y = 0u; y < (1u << rate.y); y += 2u) {
            for (var x = 0u; x < (1u << rate.x); x += 2u) {
                let quad = (corner.y + y) / 2u * QUADS.x + (corner.x + x) / 2u;
                atomicStore(&splits[base_quad + quad], 1u);
            }
        }
    }
#endif
}
#endif
