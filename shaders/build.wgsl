// The coordinate builder: one workgroup for each tile, one invocation for each quad.
//
// Its CPU twin is src/build/cpu.rs; both make the same words. Each invocation finds the groups that start in its quad,
// counts them, learns from a shared table of 4-bit counts how many the quads before it have, and writes its own.

struct Params {
    extent: vec2<u32>,
    tiles_per_row: u32,
    // Where the entries start, in words.
    entries: u32,
    entries_per_tile: u32,
    // More primaries than this make a tile full: 0xffffffff if full tiles are kept.
    full: u32,
    // The largest rate, as its code.
    largest: u32,
    // Words in a row of the shading-rate image.
    sri_pitch: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> sri: array<u32>;
@group(0) @binding(2) var<storage, read_write> coords: array<u32>;

const TILE: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
const QUADS: vec2<u32> = TILE / 2u;
const QUAD_COUNT: u32 = QUADS.x * QUADS.y;
const COUNT_WORDS: u32 = (QUAD_COUNT + 7u) / 8u;
const TILE_IDENTITY: u32 = 0x10000u;

// The number of groups that start in each quad, eight to a word.
var<workgroup> counts: array<atomic<u32>, COUNT_WORDS>;

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

// Whether pixel i of a quad is the first of a group.
fn starts_group(origin: vec2<u32>, quad: vec2<u32>, rate: vec2<u32>, i: u32) -> bool {
    let pixel = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
    let corner = all((pixel & ((vec2<u32>(1u) << rate) - 1u)) == vec2<u32>(0u));
    return corner && all(origin + pixel < params.extent);
}

// The entry of the group that starts at a pixel.
fn entry_of(origin: vec2<u32>, pixel: vec2<u32>, rate: vec2<u32>) -> u32 {
    let room = min(params.extent - (origin + pixel), vec2<u32>(1u) << rate);
    let row = ((1u << room.x) - 1u) << (pixel.x & 3u);
    let rows = (0x1111u & ((1u << (room.y * 4u)) - 1u)) << ((pixel.y & 3u) * 4u);
    return pixel.x | (pixel.y << 8u) | ((row * rows) << 16u);
}

// The sum of the 4-bit fields of a word.
fn sum_of(counts: u32) -> u32 {
    let pairs = (counts & 0x0f0f0f0fu) + ((counts >> 4u) & 0x0f0f0f0fu);
    return (pairs * 0x01010101u) >> 24u;
}

@compute @workgroup_size(QUADS.x, QUADS.y)
fn build(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) quad: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let origin = tile.xy * TILE;
    let rate = rate_of(origin / 2u + quad.xy);
    var count = 0u;
    for (var i = 0u; i < 4u; i++) {
        count += select(0u, 1u, starts_group(origin, quad.xy, rate, i));
    }
    atomicOr(&counts[index >> 3u], count << ((index & 7u) * 4u));
    workgroupBarrier();

    var before = 0u;
    var total = 0u;
    for (var word = 0u; word < COUNT_WORDS; word++) {
        let fields = atomicLoad(&counts[word]);
        if word == index >> 3u {
            before = total + sum_of(fields & ((1u << ((index & 7u) * 4u)) - 1u));
        }
        total += sum_of(fields);
    }

    let slot = tile.y * params.tiles_per_row + tile.x;
    let is_whole = all(origin + TILE <= params.extent);
    let is_identity = total > params.full || (total == TILE.x * TILE.y && is_whole);
    if index == 0u {
        coords[slot] = select(total, TILE_IDENTITY, is_identity);
    }
    if is_identity {
        return;
    }
    var at = params.entries + slot * params.entries_per_tile + before;
    for (var i = 0u; i < 4u; i++) {
        if starts_group(origin, quad.xy, rate, i) {
            let pixel = quad.xy * 2u + vec2<u32>(i & 1u, i >> 1u);
            coords[at] = entry_of(origin, pixel, rate);
            at++;
        }
    }
}
