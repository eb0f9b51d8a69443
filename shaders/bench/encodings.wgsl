// Ways to write down which pixels of a tile are shaded, and for whom: each as a builder and as a pass that goes by it.
//
//   WORDS      32 bits an entry: the place in the tile, and the members of its quad
//   HALVES     DOOM's 11 bits in 16: 4 + 4 bits of place, 3 of copies
//   PARTITION  4 bits a quad: which of the 15 ways to part four pixels; a row of quads is a word, and how many primaries lie in the
//              rows above is kept beside it. A thread finds its quad by prefix sums (SEARCH), or the workgroup unpacks the tile
//              into its memory first
//
// Tiles are 16x16, the picture is made of whole tiles, and rates are 2x2 at most. All of them promote nearly full tiles.

struct Frame {
    size: vec2<u32>,
    lights: u32,
    sri_pitch: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var surface: texture_2d<f32>;
@group(0) @binding(2) var<storage, read> lights: array<vec4<f32>>;
@group(0) @binding(3) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(4) var<storage, read_write> built: array<u32>;
@group(0) @binding(4) var<storage, read> coords: array<u32>;
@group(0) @binding(5) var<storage, read> sri: array<u32>;
// For each way to part a quad, a nibble for each place: the members of the group that it leads.
@group(0) @binding(6) var<storage, read> partings: array<u32, 16>;

const FULL: u32 = 224u;
#ifdef WORDS
const ROOM: u32 = 224u;
#endif
#ifdef HALVES
const ROOM: u32 = 112u;
#endif
#ifdef PARTITION
// two words of prefix bytes, and the codes
const ROOM: u32 = 10u;
#endif

fn entries_of(slot: u32) -> u32 {
    let tiles = (frame.size.x / 16u) * (frame.size.y / 16u);
    return tiles + slot * ROOM;
}

// The sum of the 4-bit fields of a word.
fn sum_of(fields: u32) -> u32 {
    let pairs = (fields & 0x0f0f0f0fu) + ((fields >> 4u) & 0x0f0f0f0fu);
    return (pairs * 0x01010101u) >> 24u;
}

// ---- The builders ----

#ifdef PARTITION
// Ways to part a quad are in the order of how many groups they make: 0 makes four, 1 to 6 three, 7 to 13 two, 14 one.
const APART: u32 = 0u;
const ROWS: u32 = 7u;
const COLUMNS: u32 = 8u;
const TOGETHER: u32 = 14u;

// For each nibble, how many groups its way to part a quad makes.
fn groups_of(codes: u32) -> u32 {
    let low = codes & 0x0f0f0f0fu;
    let high = (codes >> 4u) & 0x0f0f0f0fu;
    return groups_of_bytes(low) | (groups_of_bytes(high) << 4u);
}

fn groups_of_bytes(codes: u32) -> u32 {
    let ones = 0x01010101u;
    let less = (((codes + 15u * ones) >> 4u) & ones) + (((codes + 9u * ones) >> 4u) & ones)
        + (((codes + 2u * ones) >> 4u) & ones);
    return 4u * ones - less;
}

fn code_of(rate: u32) -> u32 {
    return select(select(select(APART, COLUMNS, rate == 1u), ROWS, rate == 4u), TOGETHER, rate == 5u);
}

var<workgroup> row_counts: array<u32, 64>;

// Eight tiles to a workgroup, an invocation for each row of quads.
@compute @workgroup_size(64)
fn build(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = vec2<u32>(group.x * 8u + lane / 8u, group.y);
    let row = lane % 8u;
    let is_inside = tile.x * 16u < frame.size.x;
    var codes = 0u;
    if is_inside {
        let at = (tile.y * 8u + row) * frame.sri_pitch + tile.x * 2u;
        for (var i = 0u; i < 2u; i++) {
            let rates = sri[at + i];
            for (var j = 0u; j < 4u; j++) {
                codes |= code_of((rates >> (j * 8u)) & 255u) << ((i * 4u + j) * 4u);
            }
        }
    }
    row_counts[lane] = sum_of(groups_of(codes));
    workgroupBarrier();
    if !is_inside {
        return;
    }
    let slot = tile.y * (frame.size.x / 16u) + tile.x;
    let start = entries_of(slot);
    built[start + 2u + row] = codes;
    if row < 3u {
        var sum = 0u;
        var words = vec2<u32>(0u);
        for (var i = 0u; i < 8u; i++) {
            words[i / 4u] |= min(sum, 255u) << ((i % 4u) * 8u);
            sum += row_counts[lane - row + i];
        }
        if row < 2u {
            built[start + row] = words[row];
        } else {
            built[slot] = select(sum, 256u, sum > FULL);
        }
    }
}
#else

var<workgroup> counts: array<atomic<u32>, 32>;
var<workgroup> staged: array<u32, 1024>;

// A nibble for each place of the quad: the members of the group that it leads.
fn leads_of(rate: u32) -> u32 {
    return select(select(select(0x8421u, 0x00a5u, rate == 1u), 0x0c03u, rate == 4u), 0x000fu, rate == 5u);
}

// Four tiles to a workgroup, an invocation for each quad.
@compute @workgroup_size(256)
fn build(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let sub = lane / 64u;
    let number = lane % 64u;
    let tile = vec2<u32>(group.x * 4u + sub, group.y);
    let quad = vec2<u32>(number % 8u, number / 8u);
    let is_inside = tile.x * 16u < frame.size.x;
    if lane < 32u {
        atomicStore(&counts[lane], 0u);
    }
    workgroupBarrier();
    var leads = 0u;
    if is_inside {
        let word = sri[(tile.y * 8u + quad.y) * frame.sri_pitch + tile.x * 2u + quad.x / 4u];
        leads = leads_of((word >> ((quad.x & 3u) * 8u)) & 255u);
    }
    let led = (leads | (leads >> 1u) | (leads >> 2u) | (leads >> 3u)) & 0x1111u;
    let shift = (number & 7u) * 4u;
    atomicOr(&counts[sub * 8u + (number >> 3u)], countOneBits(led) << shift);
    workgroupBarrier();
    var before = 0u;
    var total = 0u;
    let own_word = number >> 3u;
    for (var word = 0u; word < 8u; word++) {
        let fields = atomicLoad(&counts[sub * 8u + word]);
        let mask = select(select(0u, (1u << shift) - 1u, word == own_word), 0xffffffffu, word < own_word);
        before += sum_of(fields & mask);
        total += sum_of(fields);
    }
    for (var i = 0u; i < 4u; i++) {
        let members = (leads >> (i * 4u)) & 15u;
        if members != 0u {
            let place = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
#ifdef WORDS
            staged[sub * 256u + before] = place.x | (place.y << 8u) | (members << 16u);
#else
            // relative to the primary: beside, below, across
            var copies = members;
            copies = select(copies, ((copies & 5u) << 1u) | ((copies >> 1u) & 5u), (i & 1u) != 0u);
            copies = select(copies, ((copies & 3u) << 2u) | (copies >> 2u), (i & 2u) != 0u);
            staged[sub * 256u + before] = place.x | (place.y << 4u) | ((copies >> 1u) << 8u);
#endif
            before++;
        }
    }
    workgroupBarrier();
    if !is_inside {
        return;
    }
    let slot = tile.y * (frame.size.x / 16u) + tile.x;
    if number == 0u {
        built[slot] = select(total, 256u, total > FULL);
    }
    if total > FULL {
        return;
    }
#ifdef WORDS
    for (var i = number; i < total; i += 64u) {
        built[entries_of(slot) + i] = staged[sub * 256u + i];
    }
#else
    for (var i = number; i * 2u < total; i += 64u) {
        let two = staged[sub * 256u + i * 2u] | (staged[sub * 256u + i * 2u + 1u] << 16u);
        built[entries_of(slot) + i] = two;
    }
#endif
}
#endif

// ---- The pass ----

// A primary: its place in the tile, and the other members of its quad's group, by how they lie: beside, below, across.
struct Primary {
    place: vec2<u32>,
    copies: u32,
}

fn relative(members: u32, home: u32) -> u32 {
    var copies = members;
    copies = select(copies, ((copies & 5u) << 1u) | ((copies >> 1u) & 5u), (home & 1u) != 0u);
    copies = select(copies, ((copies & 3u) << 2u) | (copies >> 2u), (home & 2u) != 0u);
    return copies >> 1u;
}

#ifdef WORDS
fn fetch(slot: u32, lane: u32) -> Primary {
    let entry = coords[entries_of(slot) + lane];
    let place = vec2<u32>(entry & 255u, (entry >> 8u) & 255u);
    return Primary(place, relative(entry >> 16u, (place.x & 1u) | ((place.y & 1u) << 1u)));
}
#endif

#ifdef HALVES
fn fetch(slot: u32, lane: u32) -> Primary {
    let entry = (coords[entries_of(slot) + lane / 2u] >> ((lane & 1u) * 16u)) & 0xffffu;
    return Primary(vec2<u32>(entry & 15u, (entry >> 4u) & 15u), (entry >> 8u) & 7u);
}
#endif

#ifdef PARTITION
#ifdef SEARCH
fn fetch(slot: u32, lane: u32) -> Primary {
    let start = entries_of(slot);
    let above = vec2<u32>(coords[start], coords[start + 1u]);
    var row = 0u;
    var rest = lane;
    for (var i = 1u; i < 8u; i++) {
        let sum = (above[i / 4u] >> ((i % 4u) * 8u)) & 255u;
        if lane >= sum {
            row = i;
            rest = lane - sum;
        }
    }
    let codes = coords[start + 2u + row];
    let counts = groups_of(codes);
    var quad = 0u;
    for (var i = 0u; i < 7u; i++) {
        let here = (counts >> (i * 4u)) & 15u;
        let is_past = quad == i && rest >= here;
        rest -= select(0u, here, is_past);
        quad += select(0u, 1u, is_past);
    }
    let leads = partings[(codes >> (quad * 4u)) & 15u];
    var led = (leads | (leads >> 1u) | (leads >> 2u) | (leads >> 3u)) & 0x1111u;
    for (var i = 0u; i < rest; i++) {
        led &= led - 1u;
    }
    let bit = firstTrailingBit(led);
    let home = bit / 4u;
    return Primary(vec2<u32>(quad, row) * 2u + vec2<u32>(home & 1u, home >> 1u), relative((leads >> bit) & 15u, home));
}
#else
var<workgroup> unpacked: array<u32, 256>;

// An invocation for each quad leaves what its primaries are.
fn unpack(slot: u32, lane: u32) {
    let start = entries_of(slot);
    let row = lane / 8u;
    let quad = lane % 8u;
    let codes = coords[start + 2u + row];
    let counts = groups_of(codes);
    var at = (coords[start + row / 4u] >> ((row % 4u) * 8u)) & 255u;
    at += sum_of(counts & ((1u << (quad * 4u)) - 1u));
    let leads = partings[(codes >> (quad * 4u)) & 15u];
    for (var home = 0u; home < 4u; home++) {
        let members = (leads >> (home * 4u)) & 15u;
        if members != 0u {
            let place = vec2<u32>(quad, row) * 2u + vec2<u32>(home & 1u, home >> 1u);
            unpacked[at] = place.x | (place.y << 4u) | (relative(members, home) << 8u);
            at++;
        }
    }
}

fn fetch(slot: u32, lane: u32) -> Primary {
    let entry = unpacked[lane];
    return Primary(vec2<u32>(entry & 15u, (entry >> 4u) & 15u), entry >> 8u);
}
#endif
#endif

@compute @workgroup_size(256)
fn shade(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = tile.y * (frame.size.x / 16u) + tile.x;
    let count = coords[slot];
#ifdef PARTITION
#ifndef SEARCH
    if count <= FULL {
        if lane < 64u {
            unpack(slot, lane);
        }
        workgroupBarrier();
    }
#endif
#endif
    var primary = Primary(vec2<u32>(lane % 16u, lane / 16u), 0u);
    if count <= FULL {
        if lane >= count {
            return;
        }
        primary = fetch(slot, lane);
    }
    let id = tile.xy * 16u + primary.place;
    let seen = textureLoad(surface, id, 0);
    let normal = normalize(seen.xyz * 2.0 - 1.0);
    let at = vec3(vec2<f32>(id) * 0.001, seen.w);
    var sum = vec3(0.02);
    for (var i = 0u; i < frame.lights; i++) {
        let light = lights[i];
        let to = light.xyz - at;
        sum += max(dot(normal, to) * inverseSqrt(dot(to, to) + 0.01), 0.0) * light.w / (1.0 + dot(to, to));
    }
    let color = vec4(sum, 1.0);
    textureStore(picture, id, color);
    if (primary.copies & 1u) != 0u {
        textureStore(picture, id ^ vec2(1u, 0u), color);
    }
    if (primary.copies & 2u) != 0u {
        textureStore(picture, id ^ vec2(0u, 1u), color);
    }
    if (primary.copies & 4u) != 0u {
        textureStore(picture, id ^ vec2(1u, 1u), color);
    }
}
