// The coordinate builder where rates alone decide and no group is larger than a quad: an invocation for the four quads whose rates are one
// word, a workgroup for a few tiles beside one another.
//
// Its CPU twin is src/build/cpu.rs, which it agrees with word for word, as shaders/build.wgsl does, the builder for everything else. It
// needs tiles whose width is a multiple of 8 and whose height is even. Four quads are worked on as the bytes of a word: in each, bit 0
// stands for the upper left pixel, 1 for the upper right, 2 for the lower left, 3 for the lower right. The entries of all tiles of a
// workgroup are gathered in workgroup memory, one tile behind the other as the lists have them, and written out by neighbours side by
// side. What nobody asked for is not compiled.

const LANES: u32 = QUAD_COUNT / 4u;
const INVOCATIONS: u32 = TILES * LANES;
const WORDS_ACROSS: u32 = TILE.x / 8u;
// The lowest bit of each byte.
const EACH: u32 = 0x01010101u;
// Of an invocation: its primaries (12 bits), its pixels (12 bits), and which of the four rates its quads have (4 bits).
var<workgroup> found: array<u32, INVOCATIONS>;
// Of a tile: its entries in the list (16 bits), and those that the tile itself stores (16 bits); see `entries_of`.
var<workgroup> tile_entries: array<u32, TILES>;
// Where a tile's entries start among all of the workgroup's, in the same halves.
var<workgroup> tile_starts: array<u32, TILES>;
// The entries that are stored: the place in the workgroup's tiles, x (10 bits) and y (6 bits), and whether the quad is coarse
// across (bit 16) and down (bit 17).
var<workgroup> staged: array<u32, TILES * AREA>;
#ifdef LIST
var<workgroup> list_start: u32;
#endif
#ifdef CLASSIFIED
var<workgroup> mixed_start: u32;
// How many tiles of each rate are here, and where they start.
var<workgroup> class_counts: array<atomic<u32>, 4>;
var<workgroup> class_starts: array<u32, 4>;
#endif
#ifdef STATISTICS
var<workgroup> tally: array<atomic<u32>, STATISTICS_WORDS>;
#endif

// Four quads: which of their pixels lie in the extent, and, in bit 0 of each byte, whether a quad is coarse across and down.
struct Quads {
    inside: u32,
    across: u32,
    down: u32,
}

// The pixels of four quads that lie in the extent, which reaches so far from the first of them.
fn inside_of(room: vec2<u32>) -> u32 {
    let whole = min(room.x / 2u, 4u);
    let columns = select((1u << (whole * 8u)) - 1u, 0xffffffffu, whole == 4u) & 0x0f0f0f0fu;
    let odd = select(0u, 5u << (whole * 8u), whole < 4u && (room.x & 1u) != 0u);
    return (columns | odd) & select(select(0u, 0x03030303u, room.y == 1u), 0x0f0f0f0fu, room.y >= 2u);
}

// Four quads by the word of their rates. A byte that is no rate means full rate; larger rates are 2x2 here, and at most the largest; what
// the extent cuts off a quad makes it finer.
fn quads_of(word: u32, inside: u32) -> Quads {
    let y0 = word & EACH;
    let y1 = (word >> 1u) & EACH;
    let x0 = (word >> 2u) & EACH;
    let x1 = (word >> 3u) & EACH;
    let high = ((word >> 4u) | (word >> 5u) | (word >> 6u) | (word >> 7u)) & EACH;
    // 1x1, 1x2, 2x1, 2x2, 2x4, 4x2 and 4x4: no 3, and no 4 beside a 1
    let is_none = high | (x0 & x1) | (y0 & y1) | (x1 & ~(y0 | y1)) | (y1 & ~(x0 | x1));
    let most = vec2<u32>(select(0u, EACH, params.largest >= 4u), select(0u, EACH, (params.largest & 3u) != 0u));
    return Quads(
        inside,
        (x0 | x1) & ~is_none & most.x & (inside >> 1u),
        (y0 | y1) & ~is_none & most.y & (inside >> 2u),
    );
}

// The pixels that come first in their groups: `place ^ flip` in shaders/build/order.wgsl, for all groups of a quad at once.
fn leads_of(quads: Quads) -> u32 {
    let both = quads.across & quads.down;
    let one = quads.across ^ quads.down;
    let no_coarse = EACH & ~(both | one);
    let not_both = EACH & ~both;
    var leads = EACH | ((EACH & ~quads.across) << 1u) | ((EACH & ~quads.down) << 2u) | (no_coarse << 3u);
    if params.phase != 0u {
        let is_odd = ((params.phase - 1u) & 1u) != 0u;
        // half rates flip as a checkerboard, whole ones from corner to corner
        let even = EACH | (no_coarse * 6u) | (not_both << 3u);
        let odd = no_coarse | (not_both * 6u) | ((EACH & ~one) << 3u);
        leads = select(even, odd, is_odd);
    }
    return leads & quads.inside;
}

// The members of a quad's group, as bits of the quad: `place` is a pixel's own bit number, `coarse` bit 0 across and bit 1 down.
fn members_of(place: u32, coarse: u32) -> u32 {
    let row = select(1u << (place & 1u), 3u, (coarse & 1u) != 0u);
    return select(row << (place & 2u), row * 5u, (coarse & 2u) != 0u);
}

// Members of a quad as a mask over the aligned 4x4 block around a pixel.
fn over_block(members: u32, pixel: vec2<u32>) -> u32 {
    return ((members & 3u) | ((members & 12u) << 2u)) << ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
}

// A primary and its duplicates in the quad: across, down, and across and down.
fn listed(pixel: vec2<u32>, coarse: u32) -> u32 {
    return pixel.x | (pixel.y << 14u) | (coarse << 28u) | ((coarse & (coarse >> 1u)) << 30u);
}

#ifdef LIST
fn put_list(at: u32, pixel: vec2<u32>, coarse: u32, members: u32) {
    if params.list_stride == 1u {
        list[LIST_HEADER + at] = listed(pixel, coarse);
        return;
    }
    list[LIST_HEADER + at * 2u] = pixel.x | (pixel.y << 16u);
    list[LIST_HEADER + at * 2u + 1u] = over_block(members, pixel);
}
#endif

#ifdef CLASSIFIED
fn put_mixed(at: u32, pixel: vec2<u32>, coarse: u32, members: u32) {
    if params.list_stride == 1u {
        classified[params.mixed + at] = listed(pixel, coarse);
        return;
    }
    classified[params.mixed + at * 2u] = pixel.x | (pixel.y << 16u);
    classified[params.mixed + at * 2u + 1u] = over_block(members, pixel);
}
#endif

@compute @workgroup_size(INVOCATIONS)
fn build(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let sub = index / LANES;
    let number = index % LANES;
    let first = vec2<u32>(number % WORDS_ACROSS * 8u, number / WORDS_ACROSS * 2u);
    let tile = vec2<u32>(group.x * TILES + sub, group.y);
    let has_tile = tile.x < params.tiles_per_row;
    let origin = tile * TILE;
    let at = origin + first;
    let slot = tile.y * params.tiles_per_row + tile.x;
    let room = select(vec2<u32>(0u), params.extent - min(params.extent, at), has_tile);

    // ---- The four quads ----

    let word_at = (at.y / 2u) * params.sri_pitch + at.x / 8u;
    let inside = inside_of(room);
    var word = 0u;
    if inside != 0u {
        word = sri[word_at];
    }
    let quads = quads_of(word, inside);
    let both = quads.across & quads.down;
    var leads = leads_of(quads);
    let here = inside & EACH;
    let seen = select(0u, 1u, (here & ~(quads.across | quads.down)) != 0u)
        | select(0u, 2u, (quads.down & ~both) != 0u)
        | select(0u, 4u, (quads.across & ~both) != 0u)
        | select(0u, 8u, both != 0u);
    found[index] = countOneBits(leads) | (countOneBits(inside) << 12u) | (seen << 24u);
#ifdef CLASSIFIED
    for (var i = index; i < 4u; i += INVOCATIONS) {
        atomicStore(&class_counts[i], 0u);
    }
#endif
#ifdef STATISTICS
    for (var i = index; i < STATISTICS_WORDS; i += INVOCATIONS) {
        atomicStore(&tally[i], 0u);
    }
#endif
    workgroupBarrier();

    // ---- The tile as a whole, the same for all of its invocations ----

    var before = 0u;
    var sum = 0u;
    var rates = 0u;
    for (var i = 0u; i < LANES; i++) {
        let other = found[sub * LANES + i];
        before += select(0u, other, i < number);
        sum += other & 0xffffffu;
        rates |= other >> 24u;
    }
    let primaries = sum & 0xfffu;
    let pixels = (sum >> 12u) & 0xfffu;
    let is_whole = pixels == AREA;
    let is_identity = primaries > params.full || primaries == AREA;
    let is_uniform = !is_identity && is_whole && countOneBits(rates) == 1u;
    let is_mixed = has_tile && !is_identity && !is_uniform;
    // bit 0 of its number says down, bit 1 across
    let rate = firstTrailingBit(rates);
    let code = ((rate >> 1u) << 2u) | (rate & 1u);
    var entries = primaries;
    before = select(before, before >> 12u, is_identity) & 0xfffu;
    if is_identity {
        entries = pixels;
        leads = inside;
    }
#ifdef TILED
    if number == 0u && has_tile {
        var header = params.phase << 21u;
        if is_identity {
            header |= TILE_IDENTITY;
        } else {
            header |= primaries;
            if is_uniform {
                header |= TILE_UNIFORM | (code << 24u);
            }
        }
#ifdef USER
        header |= (user_bits[slot / 8u] >> ((slot % 8u) * 4u)) << 28u;
#endif
        coords[slot] = header;
    }
#endif
#ifdef USER
    if number == 0u && has_tile {
        hand_on_user_bits(slot);
    }
#endif
#ifdef CLASSIFIED
    let class_number = select(rate, 0u, is_identity);
    var class_place = 0u;
    if number == 0u && has_tile && !is_mixed {
        class_place = atomicAdd(&class_counts[class_number], 1u);
    }
#endif
#ifdef STORED
    if number == 0u {
        let mixed = select(0u, entries, is_mixed);
#ifdef LIST
        tile_entries[sub] = entries | (mixed << 16u);
#else
        tile_entries[sub] = mixed | (mixed << 16u);
#endif
    }
#endif
#ifdef STATISTICS
    // rates that are no rate of the tile count as 1x1
    if inside != 0u {
        let fine = select(15u * (EACH & ~(quads.across | quads.down)), 0xffffffffu, is_identity);
        let coarse = select(0xffffffffu, 0u, is_identity);
        atomicAdd(&tally[13], countOneBits(inside & fine));
        atomicAdd(&tally[14], countOneBits(inside & (15u * (quads.down & ~both)) & coarse));
        atomicAdd(&tally[15], countOneBits(inside & (15u * (quads.across & ~both)) & coarse));
        atomicAdd(&tally[16], countOneBits(inside & (15u * both) & coarse));
    }
    if number == 0u && has_tile {
        let waves = (AREA + params.wave - 1u) / params.wave;
        let busy = select((entries + params.wave - 1u) / params.wave, waves, is_identity);
        atomicAdd(&tally[0], pixels);
        atomicAdd(&tally[1], entries);
        atomicAdd(&tally[4], 1u);
        atomicAdd(&tally[6], waves);
        atomicAdd(&tally[7], waves - busy);
        atomicAdd(&tally[8], select(0u, 1u, !is_identity && entries % params.wave != 0u));
        atomicAdd(&tally[9], select(0u, 1u, is_identity));
        atomicAdd(&tally[10], select(0u, 1u, is_uniform));
        atomicAdd(&tally[11], select(0u, 1u, is_mixed));
    }
#endif
    let is_coarse = !is_identity && inside != 0u;
#ifdef EFFECTIVE
    if inside != 0u {
        atomicStore(&effective[word_at], select(0u, (quads.across << 2u) | quads.down, is_coarse));
    }
#endif
#ifdef GRADED
    for (var j = 0u; j < 4u; j++) {
        let bits = (inside >> (j * 8u)) & 15u;
        if bits != 0u {
            let across = (quads.across >> (j * 8u)) & 1u;
            let down = (quads.down >> (j * 8u)) & 1u;
            // members but one in the low half, the rate in the high one
            let byte = (across + down + (across & down)) | (across << 6u) | (down << 4u);
            let bytes = (bits & 1u) | ((bits & 2u) << 7u) | ((bits & 4u) << 14u) | ((bits & 8u) << 21u);
            graded[(at.y / 2u) * params.graded_pitch + at.x / 2u + j] = select(0u, bytes * byte, is_coarse);
        }
    }
#endif

#ifdef STORED
    workgroupBarrier();

    // ---- Entries, gathered; room in the lists ----

    var starts = 0u;
    var all_entries = 0u;
    for (var i = 0u; i < TILES; i++) {
        let other = tile_entries[i];
        starts += select(0u, other, i < sub);
        all_entries += other;
    }
    if number == 0u {
        // whether the tile stores its own is told by the last bit
        tile_starts[sub] = ((starts & 0xffffu) << 1u) | ((starts >> 16u) << 17u) | select(0u, 1u, is_mixed);
    }
#ifdef LIST
    let is_stored = true;
    if index == 0u {
        list_start = atomicAdd(&counters[C_LIST], all_entries & 0xffffu);
    }
#else
    let is_stored = is_mixed;
#endif
#ifdef CLASSIFIED
    if index == INVOCATIONS - 1u && all_entries > 0xffffu {
        mixed_start = atomicAdd(&counters[C_MIXED], all_entries >> 16u);
    }
    for (var i = index; i < 4u; i += INVOCATIONS) {
        let tiles = atomicLoad(&class_counts[i]);
        if tiles > 0u {
            class_starts[i] = atomicAdd(&counters[C_TILES + i], tiles);
        }
    }
#endif
    if is_stored {
        var next = (starts & 0xffffu) + before;
        let corner = (sub * TILE.x + first.x) | (first.y << 10u);
        // 1 across, 2 down
        let coarse = select(0u, quads.across | (quads.down << 1u), is_coarse);
        for (var i = 0u; i < 16u; i++) {
            let bit = (i >> 2u) * 8u + (i & 3u);
            if ((leads >> bit) & 1u) != 0u {
                let place = ((i >> 2u) * 2u + (i & 1u)) + (((i >> 1u) & 1u) << 10u);
                staged[next] = (corner + place) | (((coarse >> ((i >> 2u) * 8u)) & 3u) << 16u);
                next++;
            }
        }
    }
    workgroupBarrier();

    // ---- Written out ----

#ifdef CLASSIFIED
    if number == 0u && has_tile && !is_mixed {
        let place = class_starts[class_number] + class_place;
        classified[CLASSIFIED_HEADER + class_number * params.tile_count + place] = tile.x | (tile.y << 16u);
    }
#endif
    let group_origin = vec2<u32>(group.x * TILES, group.y) * TILE;
    let group_slot = group.y * params.tiles_per_row + group.x * TILES;
    for (var n = index; n < (all_entries & 0xffffu); n += INVOCATIONS) {
        let entry = staged[n];
        let place = vec2<u32>(entry & 0x3ffu, (entry >> 10u) & 63u);
        let pixel = group_origin + place;
        let coarse = entry >> 16u;
        let members = members_of((place.x & 1u) | ((place.y & 1u) << 1u), coarse);
#ifdef LIST
        put_list(list_start + n, pixel, coarse, members);
#endif
#ifdef BY_TILE
        let of_tile = place.x / TILE.x;
        let start = tile_starts[of_tile];
        if (start & 1u) != 0u {
            let nth = n - ((start >> 1u) & 0xffffu);
#ifdef TILED
            let in_tile = (place.x % TILE.x) | (place.y << 8u) | (over_block(members, pixel) << 16u);
            coords[params.entries + (group_slot + of_tile) * params.entries_per_tile + nth] = in_tile;
#endif
#ifdef CLASSIFIED
            put_mixed(mixed_start + (start >> 17u) + nth, pixel, coarse, members);
#endif
        }
#endif
    }
#endif
#ifdef STATISTICS
#ifndef STORED
    workgroupBarrier();
#endif
    for (var i = index; i < STATISTICS_WORDS; i += INVOCATIONS) {
        let more = atomicLoad(&tally[i]);
        if more > 0u {
            atomicAdd(&counters[C_STATISTICS + i], more);
        }
    }
#endif
}
