// The coordinate builder: a workgroup for a few tiles beside one another, an invocation for a quad. Where rates alone decide and no group
// is larger than a quad, shaders/build/words.wgsl does the same for four quads at once.
//
// Its CPU twin is src/build/cpu.rs, with src/coverage/cpu.rs; both make the same words. Each invocation finds the groups of its
// quads (or of the blocks that start in its quad, where groups may be larger), counts the primaries in them, and learns from a
// shared table of counts how many come before it. The tile's entries are gathered in workgroup memory and written out side by
// side; a workgroup asks for room in a list once, for all of its tiles: one counter is all that the workgroups of the whole
// picture wait for. What nobody asked for is not compiled.
//
// The rooms of this kernel are in shaders/build/; src/build/gpu.rs puts them together.

@compute @workgroup_size(INVOCATIONS)
fn build(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let sub = index / QUAD_COUNT;
    let number = index % QUAD_COUNT;
    let quad = vec2<u32>(number % QUADS.x, number / QUADS.x);
    let tile = vec2<u32>(group.x * TILES + sub, group.y);
    let has_tile = tile.x < params.tiles_per_row;
    let origin = tile * TILE;
    let slot = tile.y * params.tiles_per_row + tile.x;
    let first = quad * 2u;
    let at = origin + first;
    let base_pixel = sub * AREA;

    // whatever is added to starts at zero
    for (var i = index; i < ALL_COUNT_WORDS; i += INVOCATIONS) {
        atomicStore(&counts[i], 0u);
#ifdef SKY
        atomicStore(&sky_counts[i], 0u);
#endif
    }
    if number == 0u {
        atomicStore(&rates_seen[sub], 0u);
    }
#ifndef LOCAL
    for (var i = index; i < ALL_PIXELS; i += INVOCATIONS) {
        leads[i] = 0u;
#ifdef GRADED
        grades[i] = 0u;
#endif
    }
#ifdef EFFECTIVE
    atomicStore(&splits[index], 0u);
#endif
#endif
#ifdef EFFECTIVE
#ifdef SHARED_WORDS
    atomicStore(&effective_words[index], 0u);
#endif
#endif
#ifdef CLASSIFIED
    for (var i = index; i < CLASSES; i += INVOCATIONS) {
        atomicStore(&class_counts[i], 0u);
    }
#endif
#ifdef STATISTICS
    for (var i = index; i < STATISTICS_WORDS; i += INVOCATIONS) {
        atomicStore(&tally[i], 0u);
    }
#endif
#ifdef COVERAGE
    load_samples(origin, index);
#endif
    workgroupBarrier();
#ifdef REBUILT
    for (var i = 0u; i < 4u; i++) {
        let place = first + vec2<u32>(i & 1u, i >> 1u);
        normals[place.y * TILE.x + place.x] = rebuild(origin, place);
    }
    workgroupBarrier();
#endif

    // ---- Groups, and how many of them start in each quad ----

    let room = min(room_at(origin, first), TILE - min(TILE, first));
    let is_inside = all(room > vec2<u32>(0u));
    var own_count = 0u;
    var own_sky = 0u;
#ifdef LOCAL
    let rate = quad_rate(at / 2u);
    let own = quad_groups(first, at, room, rate);
    let led = (own.leads | (own.leads >> 1u) | (own.leads >> 2u) | (own.leads >> 3u)) & 0x1111u;
    own_sky = countOneBits(led & spread(own.sky));
    own_count = countOneBits(led) - own_sky;
#else
    let rate = rate_of(at / 2u);
    for (var i = 0u; i < 4u; i++) {
        let corner = first + vec2<u32>(i & 1u, i >> 1u);
#ifdef ODD
        if any(corner >= TILE) {
            continue;
        }
        let rate = rate_of((origin + corner) / 2u);
#endif
        if all((corner & ((vec2<u32>(1u) << rate) - 1u)) == vec2<u32>(0u)) {
            cluster(base_pixel, sub * QUAD_COUNT, origin, corner, rate);
        }
    }
    workgroupBarrier();
    for (var i = 0u; i < 4u; i++) {
        let place = first + vec2<u32>(i & 1u, i >> 1u);
#ifdef ODD
        if any(place >= TILE) {
            continue;
        }
#endif
        let lead = leads[base_pixel + place.y * TILE.x + place.x];
        if lead != 0u {
            let of_sky = (lead & IS_SKY) != 0u;
            own_sky += select(0u, 1u, of_sky);
            own_count += select(1u, 0u, of_sky);
        }
    }
#endif
    let base_word = sub * COUNT_WORDS;
    let own_word = number / FIELDS;
    let shift = (number % FIELDS) * FIELD_BITS;
    atomicOr(&counts[base_word + own_word], own_count << shift);
#ifdef SKY
    atomicOr(&sky_counts[base_word + own_word], own_sky << shift);
#endif
    if is_inside {
        atomicOr(&rates_seen[sub], 1u << ((rate.x << 2u) | rate.y));
    }
    workgroupBarrier();

    // ---- The tile as a whole, the same for all of its invocations ----

    var before = 0u;
    var total = 0u;
    var sky_before = 0u;
    var sky_total = 0u;
    let below = (1u << shift) - 1u;
    for (var word = 0u; word < COUNT_WORDS; word++) {
        // fields before one's own: all of them, some of them, none of them
        let mask = select(select(0u, below, word == own_word), 0xffffffffu, word < own_word);
        let fields = atomicLoad(&counts[base_word + word]);
        before += sum_of(fields & mask);
        total += sum_of(fields);
#ifdef SKY
        let sky_fields = atomicLoad(&sky_counts[base_word + word]);
        sky_before += sum_of(sky_fields & mask);
        sky_total += sum_of(sky_fields);
#endif
    }

    let is_whole = has_tile && all(origin + TILE <= params.extent);
    let is_alone = total == 0u || sky_total == 0u;
    let is_all_sky = total == 0u;
    let sum = total + sky_total;
    let is_identity = is_alone && (sum > params.full || (sum == AREA && is_whole));
    let seen = atomicLoad(&rates_seen[sub]);
    // the rate of the tile, if it has one
    let tile_code = firstTrailingBit(seen);
#ifdef ODD
    // quads of the tile are not quads of the picture
    let is_uniform = false;
#else
    let is_uniform = !is_identity && is_whole && is_alone && countOneBits(seen) == 1u
        && sum == AREA >> ((tile_code >> 2u) + (tile_code & 3u));
#endif
    let is_mixed = !is_identity && !is_uniform;
    var header = select(0u, TILE_SKY, is_all_sky) | (params.phase << 21u);
    if is_identity {
        header |= TILE_IDENTITY;
    } else {
        header |= total | (sky_total << 9u);
        if is_uniform {
            header |= TILE_UNIFORM | (tile_code << 24u);
        }
    }

    // an identity tile's lists hold every pixel
    let tile_room = min(room_at(origin, vec2<u32>(0u)), TILE);
    if is_identity {
        let here = min(room, vec2<u32>(2u)) * select(0u, 1u, is_inside);
        let above = min(tile_room.y, first.y) * tile_room.x;
        let beside = min(tile_room.x, first.x) * here.y;
        let all_pixels = tile_room.x * tile_room.y;
        before = above + beside;
        total = select(all_pixels, 0u, is_all_sky);
        sky_before = before;
        sky_total = select(0u, all_pixels, is_all_sky);
    }

    // ---- What the whole workgroup adds to the lists ----

#ifdef COUNTERS
    if number == 0u {
#ifdef LIST
        places[sub * 4u] = total;
        places[sub * 4u + 1u] = sky_total;
#endif
#ifdef CLASSIFIED
        places[sub * 4u + 2u] = select(0u, total, is_mixed);
        places[sub * 4u + 3u] = select(0u, sky_total, is_mixed);
#endif
    }
#endif
#ifdef CLASSIFIED
    let rate_number = rate_index(select(tile_code, 0u, is_identity));
    let class_number = select(rate_number, rate_number + 7u, is_all_sky);
    var class_place = 0u;
    if number == 0u && has_tile && !is_mixed {
        class_place = atomicAdd(&class_counts[class_number], 1u);
    }
#endif
#ifdef TILED
    if number == 0u && has_tile {
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

#ifdef STATISTICS
    if is_inside {
        let pixels = min(room, vec2<u32>(2u));
#ifdef ODD
        for (var i = 0u; i < 4u; i++) {
            let place = vec2<u32>(i & 1u, i >> 1u);
            if all(place < pixels) {
                let pixel = first + place;
                let code = cut(origin, pixel, rate_of((origin + pixel) / 2u));
                atomicAdd(&tally[13u + select(rate_index((code.x << 2u) | code.y), 0u, is_identity)], 1u);
            }
        }
#else
        let code = cut(origin, first, rate);
        let rate_here = select(rate_index((code.x << 2u) | code.y), 0u, is_identity);
        atomicAdd(&tally[13u + rate_here], pixels.x * pixels.y);
#endif
#ifdef SKY
        for (var i = 0u; i < 4u; i++) {
            let place = vec2<u32>(i & 1u, i >> 1u);
            if all(place < pixels) {
                let pixel = first + place;
                atomicAdd(&tally[2], is_sky[pixel.y * TILE.x + pixel.x]);
            }
        }
#endif
    }
    if number == 0u && has_tile {
        let waves = (AREA + params.wave - 1u) / params.wave;
        var busy = (total + params.wave - 1u) / params.wave;
        if is_identity && !is_all_sky {
            busy = waves;
        }
        atomicAdd(&tally[0], tile_room.x * tile_room.y);
        atomicAdd(&tally[1], total);
        atomicAdd(&tally[3], sky_total);
        atomicAdd(&tally[4], 1u);
        atomicAdd(&tally[5], select(0u, 1u, busy == 0u));
        atomicAdd(&tally[6], waves);
        atomicAdd(&tally[7], waves - busy);
        atomicAdd(&tally[8], select(0u, 1u, !is_identity && total % params.wave != 0u));
        atomicAdd(&tally[9], select(0u, 1u, is_identity));
        atomicAdd(&tally[10], select(0u, 1u, is_uniform));
        atomicAdd(&tally[11], select(0u, 1u, is_mixed));
        atomicAdd(&tally[12], select(0u, 1u, is_all_sky));
    }
#endif

#ifdef EFFECTIVE
    if is_inside {
#ifdef LOCAL
        let split = select(0u, 0x80u, own.is_split);
#else
        let split = atomicLoad(&splits[index]) << 7u;
#endif
        let code = cut(origin, first, rate);
        let byte = select((code.x << 2u) | code.y | split, 0u, is_identity);
#ifdef SHARED_WORDS
        atomicOr(&effective_words[index & ~3u], byte << ((quad.x & 3u) * 8u));
#else
        // a word that two tiles share
        let word = (at.y / 2u) * params.sri_pitch + (at.x >> 3u);
        let byte_shift = ((at.x >> 1u) & 3u) * 8u;
        atomicAnd(&effective[word], ~(255u << byte_shift));
        atomicOr(&effective[word], byte << byte_shift);
#endif
    }
#endif

#ifdef GRADED
#ifdef LOCAL
    if is_inside {
        let word = quad_grades(own, at);
        graded[(at.y / 2u) * params.graded_pitch + at.x / 2u] = select(word, 0u, is_identity);
    }
#else
    if is_inside {
        var word = 0u;
        for (var i = 0u; i < 4u; i++) {
            let place = first + vec2<u32>(i & 1u, i >> 1u);
            word |= grades[base_pixel + place.y * TILE.x + place.x] << (i * 8u);
        }
        graded[(at.y / 2u) * params.graded_pitch + at.x / 2u] = select(word, 0u, is_identity);
    }
#endif
#endif

    // ---- Entries, gathered ----

    for (var i = 0u; i < 4u; i++) {
        let place = first + vec2<u32>(i & 1u, i >> 1u);
#ifdef LOCAL
        var members = (own.leads >> (i * 4u)) & 15u;
        var of_sky = ((own.sky >> i) & 1u) != 0u;
        if is_identity {
            members = own.inside & (1u << i);
            of_sky = is_all_sky;
        }
        let mask = over_block(members, origin + place);
#else
#ifdef ODD
        if any(place >= TILE) {
            continue;
        }
#endif
        let lead = leads[base_pixel + place.y * TILE.x + place.x];
        var mask = lead & 0xffffu;
        var of_sky = (lead & IS_SKY) != 0u;
        if is_identity {
            let in_block = (origin + place) & vec2<u32>(3u);
            let own = 1u << (in_block.y * 4u + in_block.x);
            mask = select(0u, own, all(origin + place < params.extent));
            of_sky = is_all_sky;
        }
#endif
        if mask == 0u {
            continue;
        }
        let nth = select(before, total + sky_before, of_sky);
        before += select(1u, 0u, of_sky);
        sky_before += select(0u, 1u, of_sky);
        staged[base_pixel + nth] = place.x | (place.y << 8u) | (mask << 16u);
    }
    workgroupBarrier();

    // ---- Room in the lists ----

#ifdef COUNTERS
    for (var which = index; which < 4u; which += INVOCATIONS) {
#ifndef LIST
        if which < 2u {
            continue;
        }
#endif
#ifndef CLASSIFIED
        if which >= 2u {
            continue;
        }
#endif
        var more = 0u;
        for (var i = 0u; i < TILES; i++) {
            let own = places[i * 4u + which];
            places[i * 4u + which] = more;
            more += own;
        }
        if more > 0u {
            let start = atomicAdd(&counters[select(C_MIXED - 2u, C_LIST, which < 2u) + which], more);
            for (var i = 0u; i < TILES; i++) {
                places[i * 4u + which] += start;
            }
        }
    }
#ifdef CLASSIFIED
    for (var i = index; i < CLASSES; i += INVOCATIONS) {
        let tiles = atomicLoad(&class_counts[i]);
        if tiles > 0u {
            class_starts[i] = atomicAdd(&counters[C_TILES + i], tiles);
        }
    }
#endif
#ifdef STATISTICS
    for (var i = index; i < STATISTICS_WORDS; i += INVOCATIONS) {
        let more = atomicLoad(&tally[i]);
        if more > 0u {
            atomicAdd(&counters[C_STATISTICS + i], more);
        }
    }
#endif
    workgroupBarrier();
#endif

    // ---- Written out ----

#ifdef EFFECTIVE
#ifdef SHARED_WORDS
    if is_inside && (quad.x & 3u) == 0u {
        let word = atomicLoad(&effective_words[index]);
        atomicStore(&effective[(at.y / 2u) * params.sri_pitch + (at.x >> 3u)], word);
    }
#endif
#endif
#ifdef CLASSIFIED
    if number == 0u && has_tile && !is_mixed {
        let place = class_starts[class_number] + class_place;
        let region = CLASSIFIED_HEADER + rate_number * params.tile_count;
        classified[region + select(place, params.tile_count - 1u - place, is_all_sky)] = tile.x | (tile.y << 16u);
    }
#endif
    let all_entries = total + sky_total;
    for (var nth = number; nth < all_entries; nth += QUAD_COUNT) {
#ifndef LIST
        if !is_mixed {
            break;
        }
#endif
        let entry = staged[base_pixel + nth];
#ifdef LINEAR_DEPTH
        let deep_pixel = origin + vec2<u32>(entry & 0xffu, (entry >> 8u) & 0xffu);
        let depth_share = linear_depth(deep_pixel);
        let in_list_mask = (entry >> 16u) | (u32(depth_share * 65535.0 + 0.5) << 16u);
#else
        let in_list_mask = entry >> 16u;
#endif
#ifdef TILED
        if is_mixed {
#ifdef LINEAR_DEPTH
            let word = deep_entry(entry, deep_pixel, u32(depth_share * 1048575.0 + 0.5));
#else
            let word = entry;
#endif
            coords[params.entries + slot * params.entries_per_tile + nth] = word;
        }
#endif
#ifdef COUNTERS
        let of_sky = nth >= total;
        let in_list = select(nth, nth - total, of_sky);
        let pixel = origin + vec2<u32>(entry & 0xffu, (entry >> 8u) & 0xffu);
#ifdef LIST
        let start = places[sub * 4u + select(0u, 1u, of_sky)] + in_list;
        put_list(select(start, params.list_capacity - 1u - start, of_sky), pixel, in_list_mask);
#endif
#ifdef CLASSIFIED
        if is_mixed {
            let mixed_start = places[sub * 4u + select(2u, 3u, of_sky)] + in_list;
            put_mixed(select(mixed_start, params.list_capacity - 1u - mixed_start, of_sky), pixel, in_list_mask);
        }
#endif
#endif
    }
}
