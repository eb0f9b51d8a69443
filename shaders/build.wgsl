// The coordinate builder: one workgroup for each tile, one invocation for each quad.
//
// Its CPU twin is src/build/cpu.rs, with src/coverage/cpu.rs; both make the same words. Each invocation finds the groups of the
// blocks that start in its quad and notes each at its primary's place; then counts the primaries in its quad, learns from a
// shared table of 4-bit counts how many the quads before it have, and writes its own. What nobody asked for is not compiled.

struct Params {
    extent: vec2<u32>,
    // Which texel of the coverage textures stands for a pixel, and texels a pixel.
    sample_at: vec2<u32>,
    // Pixels of the picture plane at distance 1, for rebuilt normals.
    plane: vec2<f32>,
    sample_scale: u32,
    tiles_per_row: u32,
    tile_count: u32,
    // Where the tiled entries start, in words.
    entries: u32,
    entries_per_tile: u32,
    // More primaries than this make a tile full: 0xffffffff if full tiles are kept.
    full: u32,
    // The largest rate, as its code.
    largest: u32,
    // Words in a row of the shading-rate image, and of the effective rates.
    sri_pitch: u32,
    // 0, or 1 + the frame's number modulo 4.
    phase: u32,
    list_capacity: u32,
    // Words of an entry of the lists.
    list_stride: u32,
    // Where the entries of mixed tiles start among the classified lists, in words.
    mixed: u32,
    graded_pitch: u32,
    wave: u32,
    depth_scale: f32,
    depth_bias: f32,
    depth_tolerance: f32,
    normal_tolerance: u32,
    sky: u32,
    layers: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> sri: array<u32>;
#ifdef TILED
@group(0) @binding(2) var<storage, read_write> coords: array<u32>;
#endif
#ifdef COUNTERS
// See shaders/finish.wgsl.
@group(0) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;
#endif
#ifdef LIST
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
#endif
#ifdef CLASSIFIED
@group(0) @binding(5) var<storage, read_write> classified: array<u32>;
#endif
#ifdef EFFECTIVE
@group(0) @binding(6) var<storage, read_write> effective: array<atomic<u32>>;
#endif
#ifdef GRADED
@group(0) @binding(7) var<storage, read_write> graded: array<u32>;
#endif
#ifdef TRIANGLES
@group(0) @binding(8) var triangle_texture: texture_2d<u32>;
#endif
#ifdef SURFACES
@group(0) @binding(9) var surface_texture: texture_2d<u32>;
#endif
#ifdef DEPTH
@group(0) @binding(10) var depth_texture: texture_2d<f32>;
#endif
#ifdef OCTAHEDRAL
@group(0) @binding(11) var normal_texture: texture_2d<f32>;
#endif

const TILE: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
const AREA: u32 = TILE.x * TILE.y;
// a side that is odd, as of a workgroup of 64 by 1, ends in half a quad
const QUADS: vec2<u32> = (TILE + 1u) / 2u;
const QUAD_COUNT: u32 = QUADS.x * QUADS.y;
const COUNT_WORDS: u32 = (QUAD_COUNT + 7u) / 8u;
const TILE_IDENTITY: u32 = 0x40000u;
const TILE_UNIFORM: u32 = 0x80000u;
const TILE_SKY: u32 = 0x100000u;
const IS_SKY: u32 = 0x10000u;
const LIST_HEADER: u32 = 4u;
const CLASSIFIED_HEADER: u32 = 32u;
// The numbers of the counters.
const C_LIST: u32 = 0u;
const C_TILES: u32 = 2u;
const C_MIXED: u32 = 16u;
const C_STATISTICS: u32 = 18u;

// For each pixel of the tile, the members of the group that it leads over its aligned 4x4 block, and IS_SKY.
var<workgroup> leads: array<u32, AREA>;
// The number of primaries in each quad, eight to a word; of sky apart.
var<workgroup> counts: array<atomic<u32>, COUNT_WORDS>;
var<workgroup> sky_counts: array<atomic<u32>, COUNT_WORDS>;
// Bit n: there is a quad with rate n.
var<workgroup> rates_seen: atomic<u32>;
#ifdef EFFECTIVE
// Bit n: coverage has split the block of quad n.
var<workgroup> splits: array<atomic<u32>, 2>;
var<workgroup> effective_words: array<atomic<u32>, QUAD_COUNT>;
#endif
#ifdef GRADED
var<workgroup> grades: array<u32, AREA>;
#endif
#ifdef COUNTERS
// Where the tile's entries start in the list, and of sky; the same for the entries of mixed tiles.
var<workgroup> starts: vec4<u32>;
#endif
#ifdef STATISTICS
var<workgroup> pixels_at: array<atomic<u32>, 7>;
var<workgroup> sky_pixels: atomic<u32>;
#endif

// ---- Coverage ----

#ifdef COVERAGE
const HALO: vec2<u32> = TILE + 2u;
#ifdef TRIANGLES
var<workgroup> triangles: array<u32, HALO.x * HALO.y>;
#endif
#ifdef SURFACES
var<workgroup> surfaces: array<u32, AREA>;
#endif
#ifdef DEPTH
var<workgroup> inverse: array<f32, HALO.x * HALO.y>;
#endif
#ifdef NORMALS
// Three signed bytes, each plus 128.
var<workgroup> normals: array<u32, AREA>;
#endif
#ifdef SKY
var<workgroup> is_sky: array<u32, AREA>;
#endif

fn texel_of(pixel: vec2<i32>) -> vec2<i32> {
    let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(params.extent) - 1);
    return inside * (i32(params.sample_scale) + 1) + vec2<i32>(params.sample_at);
}

fn in_halo(pixel: vec2<i32>) -> u32 {
    return u32(pixel.y + 1) * HALO.x + u32(pixel.x + 1);
}

#ifdef DEPTH
// Cuts to 16 significant bits; what is not finite, or negative, becomes -1, which is close to nothing.
fn quantise(value: f32) -> f32 {
    let bits = bitcast<u32>(value);
    if (bits & 0x7f800000u) == 0x7f800000u || ((bits & 0x80000000u) != 0u && value != 0.0) {
        return -1.0;
    }
    return bitcast<f32>(bits & 0x7fffff00u);
}
#endif

fn load_samples(origin: vec2<u32>, index: u32) {
    for (var i = index; i < HALO.x * HALO.y; i += QUAD_COUNT) {
        let at = vec2<i32>(i32(i % HALO.x), i32(i / HALO.x)) - 1;
        let texel = texel_of(vec2<i32>(origin) + at);
#ifdef TRIANGLES
        let triangle = textureLoad(triangle_texture, texel, 0).x;
        triangles[i] = triangle;
#endif
#ifdef DEPTH
        let depth = textureLoad(depth_texture, texel, 0).x;
#ifdef LINEAR
        inverse[i] = quantise(1.0 / depth);
#else
        inverse[i] = quantise(depth * params.depth_scale + params.depth_bias);
#endif
#endif
        if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(TILE)) {
            continue;
        }
        let own = u32(at.y) * TILE.x + u32(at.x);
#ifdef SURFACES
        let surface = textureLoad(surface_texture, texel, 0).x;
        surfaces[own] = surface;
#endif
#ifdef OCTAHEDRAL
        normals[own] = octahedral(textureLoad(normal_texture, texel, 0).xy);
#endif
#ifdef SKY_TRIANGLE
        is_sky[own] = select(0u, 1u, triangle == params.sky);
#endif
#ifdef SKY_SURFACE
        is_sky[own] = select(0u, 1u, surface == params.sky);
#endif
#ifdef SKY_DEPTH
#ifdef STANDARD
        is_sky[own] = select(0u, 1u, depth >= 1.0);
#else
#ifdef LINEAR
        // what is not finite fails every comparison of its bits
        let positive = bitcast<i32>(depth) > 0 && bitcast<i32>(depth) < 0x7f800000;
        is_sky[own] = select(1u, 0u, positive);
#else
        is_sky[own] = select(0u, 1u, depth <= 0.0);
#endif
#endif
#endif
    }
}

#ifdef NORMALS
fn pack_normal(normal: vec3<i32>) -> u32 {
    let bytes = vec3<u32>(normal + 128);
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u);
}

fn normal_of(at: u32) -> vec3<i32> {
    let packed = normals[at];
    return vec3<i32>(vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(255u)) - 128;
}

fn is_normal_close(a: u32, b: u32) -> bool {
    let n = normal_of(a);
    let m = normal_of(b);
    let along = dot(n, m);
    let lengths = dot(n, n) * dot(m, m);
    return along > 0 && along * along >= lengths - (lengths >> params.normal_tolerance);
}
#endif

#ifdef OCTAHEDRAL
// An octahedral normal on a grid where the components' absolute values sum up to 127.
fn octahedral(encoded: vec2<f32>) -> u32 {
    let xy = clamp(vec2<i32>(floor(encoded * 254.0 + 0.5)) - 127, vec2<i32>(-127), vec2<i32>(127));
    let z = 127 - abs(xy.x) - abs(xy.y);
    if z < 0 {
        let signs = select(vec2<i32>(1), vec2<i32>(-1), xy < vec2<i32>(0));
        return pack_normal(vec3<i32>((127 - abs(xy.yx)) * signs, z));
    }
    return pack_normal(vec3<i32>(xy, z));
}
#endif

#ifdef REBUILT
// The neighbours of a pixel, in the order in which three pixels of one plane are sought.
fn around(i: u32) -> vec2<i32> {
    switch i {
        case 0u { return vec2<i32>(1, 0); }
        case 1u { return vec2<i32>(0, 1); }
        case 2u { return vec2<i32>(-1, 0); }
        case 3u { return vec2<i32>(0, -1); }
        case 4u { return vec2<i32>(1, 1); }
        case 5u { return vec2<i32>(-1, 1); }
        case 6u { return vec2<i32>(-1, -1); }
        default { return vec2<i32>(1, -1); }
    }
}

// The normal of the plane through three pixels of one triangle; none if there are no three.
fn rebuild(origin: vec2<u32>, at: vec2<u32>) -> u32 {
    let none = pack_normal(vec3<i32>(0));
    let place = vec2<i32>(at);
    let here = inverse[in_halo(place)];
    let id = triangles[in_halo(place)];
    if here < 0.0 {
        return none;
    }
    var usable = 0u;
    for (var i = 0u; i < 8u; i++) {
        let there = place + around(i);
        let pixel = vec2<i32>(origin) + there;
        let inside = all(pixel >= vec2<i32>(0)) && all(pixel < vec2<i32>(params.extent));
        if inside && triangles[in_halo(there)] == id && inverse[in_halo(there)] >= 0.0 {
            usable |= 1u << i;
        }
    }
    for (var i = 0u; i < 8u; i++) {
        for (var j = i + 1u; j < 8u; j++) {
            let a = around(i);
            let b = around(j);
            let area = a.x * b.y - a.y * b.x;
            if area == 0 || ((usable >> i) & (usable >> j) & 1u) == 0u {
                continue;
            }
            let along_a = inverse[in_halo(place + a)] - here;
            let along_b = inverse[in_halo(place + b)] - here;
            let slope = vec2<f32>(
                along_a * f32(b.y) - along_b * f32(a.y),
                along_b * f32(a.x) - along_a * f32(b.x),
            ) / f32(area);
            return plane_normal(vec2<f32>(origin + at), here, slope);
        }
    }
    return none;
}

// A plane n.P = d seen through P = z (u, v, 1) is 1/z = (n/d).(u, v, 1).
fn plane_normal(at: vec2<f32>, here: f32, slope: vec2<f32>) -> u32 {
    let seen = (at + 0.5 - vec2<f32>(params.extent) * 0.5) / params.plane;
    let xy = slope * params.plane;
    var z = here;
    z -= seen.x * xy.x;
    z -= seen.y * xy.y;
    let normal = vec3<f32>(xy, z);
    let sum = abs(normal.x) + abs(normal.y) + abs(normal.z);
    if !(sum > 0.0) {
        return pack_normal(vec3<i32>(0));
    }
    return pack_normal(vec3<i32>(floor(normal * 127.0 / sum + 0.5)));
}
#endif

#ifdef DEPTH
// The slope of inverse depth along an axis: the smaller difference to either side.
fn slope_at(at: vec2<i32>, axis: vec2<i32>) -> f32 {
    let here = inverse[in_halo(at)];
    let back = here - inverse[in_halo(at - axis)];
    let ahead = inverse[in_halo(at + axis)] - here;
    return select(ahead, back, abs(back) < abs(ahead));
}

// Whether a pixel lies in the plane through another.
fn is_in_plane(origin: vec2<i32>, goal: vec2<i32>) -> bool {
    let here = inverse[in_halo(origin)];
    let there = inverse[in_halo(goal)];
    if here < 0.0 || there < 0.0 {
        return false;
    }
    let delta = vec2<f32>(goal - origin);
    let expected = slope_at(origin, vec2<i32>(1, 0)) * delta.x + slope_at(origin, vec2<i32>(0, 1)) * delta.y;
    return abs((there - here) - expected) <= here * params.depth_tolerance;
}
#endif

// Whether a pixel may take another's result.
fn share(a: vec2<u32>, b: vec2<u32>) -> bool {
    let at_a = a.y * TILE.x + a.x;
    let at_b = b.y * TILE.x + b.x;
#ifdef SKY
    if (is_sky[at_a] | is_sky[at_b]) != 0u {
        return (is_sky[at_a] & is_sky[at_b]) != 0u;
    }
#endif
#ifdef SURFACES
    if surfaces[at_a] != surfaces[at_b] {
        return false;
    }
#endif
#ifdef TRIANGLES
    if triangles[in_halo(vec2<i32>(a))] == triangles[in_halo(vec2<i32>(b))] {
        return true;
    }
    // other triangles share only where they are one surface, or where normals and depth say that they lie in one plane
#ifndef ONE_PLANE
#ifndef SURFACES
    return false;
#endif
#endif
#endif
    var close = true;
#ifdef NORMALS
    close = is_normal_close(at_a, at_b);
#endif
#ifdef DEPTH
    close = close && is_in_plane(vec2<i32>(a), vec2<i32>(b)) && is_in_plane(vec2<i32>(b), vec2<i32>(a));
#endif
    return close;
}
#endif

// ---- Rates ----

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

// ---- Groups ----

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

// Finds the groups of the block with this first corner.
fn cluster(origin: vec2<u32>, corner: vec2<u32>, rate: vec2<u32>) {
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
        leads[at.y * TILE.x + at.x] = members | (((sky >> home) & 1u) << 16u);
#ifdef GRADED
        let byte = grade(members);
        for (var rest = members; rest != 0u; rest &= rest - 1u) {
            let place = firstTrailingBit(rest);
            let member = base + vec2<u32>(place & 3u, place >> 2u);
            grades[member.y * TILE.x + member.x] = byte;
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
                atomicOr(&splits[quad >> 5u], 1u << (quad & 31u));
            }
        }
    }
#endif
}

// ---- The tile ----

// The sum of the 4-bit fields of a word.
fn sum_of(fields: u32) -> u32 {
    let pairs = (fields & 0x0f0f0f0fu) + ((fields >> 4u) & 0x0f0f0f0fu);
    return (pairs * 0x01010101u) >> 24u;
}

// The order number of a rate among all.
fn rate_index(code: u32) -> u32 {
    // a nibble for each of the codes 0 to 7; 9 and 10 stand apart
    return select((0x04320010u >> (code * 4u)) & 15u, code - 4u, code > 7u);
}

#ifdef LIST
fn put_list(at: u32, pixel: vec2<u32>, mask: u32) {
    if params.list_stride == 1u {
        let quad = mask >> ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
        list[LIST_HEADER + at] = pixel.x | (pixel.y << 14u) | ((quad & 3u) << 28u) | (((quad >> 4u) & 3u) << 30u);
        return;
    }
    list[LIST_HEADER + at * 2u] = pixel.x | (pixel.y << 16u);
    list[LIST_HEADER + at * 2u + 1u] = mask;
}
#endif

#ifdef CLASSIFIED
fn put_mixed(at: u32, pixel: vec2<u32>, mask: u32) {
    if params.list_stride == 1u {
        let quad = mask >> ((pixel.x & 2u) + (pixel.y & 2u) * 4u);
        classified[params.mixed + at] = pixel.x | (pixel.y << 14u) | ((quad & 3u) << 28u) | (((quad >> 4u) & 3u) << 30u);
        return;
    }
    classified[params.mixed + at * 2u] = pixel.x | (pixel.y << 16u);
    classified[params.mixed + at * 2u + 1u] = mask;
}
#endif

@compute @workgroup_size(QUADS.x, QUADS.y)
fn build(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let origin = tile.xy * TILE;
    let quad = local.xy;
    let slot = tile.y * params.tiles_per_row + tile.x;
#ifdef COVERAGE
    load_samples(origin, index);
    workgroupBarrier();
#ifdef REBUILT
    for (var i = 0u; i < 4u; i++) {
        let at = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
        normals[at.y * TILE.x + at.x] = rebuild(origin, at);
    }
    workgroupBarrier();
#endif
#endif

    let rate = rate_of(origin / 2u + quad);
    for (var i = 0u; i < 4u; i++) {
        let corner = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
#ifdef ODD
        if any(corner >= TILE) {
            continue;
        }
        let rate = rate_of((origin + corner) / 2u);
#endif
        if all((corner & ((vec2<u32>(1u) << rate) - 1u)) == vec2<u32>(0u)) {
            cluster(origin, corner, rate);
        }
    }
    workgroupBarrier();

    var own_count = 0u;
    var own_sky = 0u;
    for (var i = 0u; i < 4u; i++) {
        let at = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
#ifdef ODD
        if any(at >= TILE) {
            continue;
        }
#endif
        let lead = leads[at.y * TILE.x + at.x];
        if lead != 0u {
            let of_sky = (lead & IS_SKY) != 0u;
            own_sky += select(0u, 1u, of_sky);
            own_count += select(1u, 0u, of_sky);
        }
    }
    let room = min(room_at(origin, quad * 2u), TILE - quad * 2u);
    let is_inside = all(room > vec2<u32>(0u));
    atomicOr(&counts[index >> 3u], own_count << ((index & 7u) * 4u));
#ifdef SKY
    atomicOr(&sky_counts[index >> 3u], own_sky << ((index & 7u) * 4u));
#endif
    if is_inside {
        atomicOr(&rates_seen, 1u << ((rate.x << 2u) | rate.y));
    }
    workgroupBarrier();

    var before = 0u;
    var total = 0u;
    var sky_before = 0u;
    var sky_total = 0u;
    for (var word = 0u; word < COUNT_WORDS; word++) {
        let own = word == index >> 3u;
        let below = (1u << ((index & 7u) * 4u)) - 1u;
        let fields = atomicLoad(&counts[word]);
        if own {
            before = total + sum_of(fields & below);
        }
        total += sum_of(fields);
#ifdef SKY
        let sky_fields = atomicLoad(&sky_counts[word]);
        if own {
            sky_before = sky_total + sum_of(sky_fields & below);
        }
        sky_total += sum_of(sky_fields);
#endif
    }

    let is_whole = all(origin + TILE <= params.extent);
    let is_alone = total == 0u || sky_total == 0u;
    let is_all_sky = total == 0u;
    let sum = total + sky_total;
    let is_identity = is_alone && (sum > params.full || (sum == AREA && is_whole));
    let seen = atomicLoad(&rates_seen);
    // the rate of the tile, if it has one
    let tile_code = firstTrailingBit(seen);
#ifdef ODD
    // quads of the tile are not quads of the picture
    let is_uniform = false;
#else
    let is_uniform = !is_identity && is_whole && is_alone && countOneBits(seen) == 1u
        && sum == AREA >> ((tile_code >> 2u) + (tile_code & 3u));
#endif
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
        let above = min(tile_room.y, quad.y * 2u) * tile_room.x;
        let beside = min(tile_room.x, quad.x * 2u) * here.y;
        let all_pixels = tile_room.x * tile_room.y;
        if is_all_sky {
            sky_before = above + beside;
            sky_total = all_pixels;
        } else {
            before = above + beside;
            total = all_pixels;
        }
    }

#ifdef COUNTERS
    if index == 0u {
        var places = vec4<u32>(0u);
#ifdef LIST
        if total > 0u {
            places.x = atomicAdd(&counters[C_LIST], total);
        }
        if sky_total > 0u {
            places.y = atomicAdd(&counters[C_LIST + 1u], sky_total);
        }
#endif
#ifdef CLASSIFIED
        if is_identity || is_uniform {
            let number = rate_index(select(tile_code, 0u, is_identity));
            let region = CLASSIFIED_HEADER + number * params.tile_count;
            if is_all_sky {
                let place = atomicAdd(&counters[C_TILES + 7u + number], 1u);
                classified[region + params.tile_count - 1u - place] = slot;
            } else {
                classified[region + atomicAdd(&counters[C_TILES + number], 1u)] = slot;
            }
        } else {
            if total > 0u {
                places.z = atomicAdd(&counters[C_MIXED], total);
            }
            if sky_total > 0u {
                places.w = atomicAdd(&counters[C_MIXED + 1u], sky_total);
            }
        }
#endif
        starts = places;
    }
#endif

#ifdef STATISTICS
    if is_inside {
        let pixels = min(room, vec2<u32>(2u));
#ifdef ODD
        for (var i = 0u; i < 4u; i++) {
            let at = vec2<u32>(i & 1u, i >> 1u);
            if all(at < pixels) {
                let pixel = quad * 2u + at;
                let code = cut(origin, pixel, rate_of((origin + pixel) / 2u));
                atomicAdd(&pixels_at[select(rate_index((code.x << 2u) | code.y), 0u, is_identity)], 1u);
            }
        }
#else
        let code = cut(origin, quad * 2u, rate);
        let number = select(rate_index((code.x << 2u) | code.y), 0u, is_identity);
        atomicAdd(&pixels_at[number], pixels.x * pixels.y);
#endif
#ifdef SKY
        for (var i = 0u; i < 4u; i++) {
            let at = vec2<u32>(i & 1u, i >> 1u);
            if all(at < pixels) {
                let pixel = quad * 2u + at;
                atomicAdd(&sky_pixels, is_sky[pixel.y * TILE.x + pixel.x]);
            }
        }
#endif
    }
#endif

#ifdef EFFECTIVE
    if is_inside {
        let code = cut(origin, quad * 2u, rate);
        let number = quad.y * QUADS.x + quad.x;
        let split = (atomicLoad(&splits[number >> 5u]) >> (number & 31u)) & 1u;
        let byte = select((code.x << 2u) | code.y | (split << 7u), 0u, is_identity);
        let at = origin / 2u + quad;
#ifdef WHOLE_WORDS
        atomicOr(&effective_words[quad.y * QUADS.x + (quad.x & ~3u)], byte << ((quad.x & 3u) * 8u));
#else
        // a word that two tiles share
        let word = at.y * params.sri_pitch + (at.x >> 2u);
        let shift = (at.x & 3u) * 8u;
        atomicAnd(&effective[word], ~(255u << shift));
        atomicOr(&effective[word], byte << shift);
#endif
    }
#endif
    workgroupBarrier();

#ifdef EFFECTIVE
#ifdef WHOLE_WORDS
    if is_inside && (quad.x & 3u) == 0u {
        let at = origin / 2u + quad;
        let word = atomicLoad(&effective_words[quad.y * QUADS.x + quad.x]);
        atomicStore(&effective[at.y * params.sri_pitch + (at.x >> 2u)], word);
    }
#endif
#endif

#ifdef STATISTICS
    if index < 7u {
        let pixels = atomicLoad(&pixels_at[index]);
        if pixels > 0u {
            atomicAdd(&counters[C_STATISTICS + 13u + index], pixels);
        }
    }
    if index == 0u {
        let waves = (AREA + params.wave - 1u) / params.wave;
        var busy = (total + params.wave - 1u) / params.wave;
        if is_identity && !is_all_sky {
            busy = waves;
        }
        let at = C_STATISTICS;
        atomicAdd(&counters[at], tile_room.x * tile_room.y);
        atomicAdd(&counters[at + 1u], total);
#ifdef SKY
        atomicAdd(&counters[at + 2u], atomicLoad(&sky_pixels));
        atomicAdd(&counters[at + 3u], sky_total);
#endif
        atomicAdd(&counters[at + 4u], 1u);
        atomicAdd(&counters[at + 5u], select(0u, 1u, busy == 0u));
        atomicAdd(&counters[at + 6u], waves);
        atomicAdd(&counters[at + 7u], waves - busy);
        atomicAdd(&counters[at + 8u], select(0u, 1u, !is_identity && total % params.wave != 0u));
        atomicAdd(&counters[at + 9u], select(0u, 1u, is_identity));
        atomicAdd(&counters[at + 10u], select(0u, 1u, is_uniform));
        atomicAdd(&counters[at + 11u], select(0u, 1u, !is_identity && !is_uniform));
        atomicAdd(&counters[at + 12u], select(0u, 1u, is_all_sky));
    }
#endif

#ifdef GRADED
    if is_inside {
        var word = 0u;
        for (var i = 0u; i < 4u; i++) {
            let at = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
            word |= grades[at.y * TILE.x + at.x] << (i * 8u);
        }
        let at = origin / 2u + quad;
        graded[at.y * params.graded_pitch + at.x] = select(word, 0u, is_identity);
    }
#endif

#ifdef TILED
    if index == 0u {
        coords[slot] = header;
    }
#endif
    // what is written for each primary
    let first = params.entries + slot * params.entries_per_tile;
    for (var i = 0u; i < 4u; i++) {
        let at = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
#ifdef ODD
        if any(at >= TILE) {
            continue;
        }
#endif
        var lead = leads[at.y * TILE.x + at.x];
        if is_identity {
            let in_block = (origin + at) & vec2<u32>(3u);
            let own = 1u << (in_block.y * 4u + in_block.x);
            lead = select(0u, own | select(0u, IS_SKY, is_all_sky), all(origin + at < params.extent));
        }
        if lead == 0u {
            continue;
        }
        let mask = lead & 0xffffu;
        let of_sky = (lead & IS_SKY) != 0u;
        let number = select(before, sky_before, of_sky);
        before += select(1u, 0u, of_sky);
        sky_before += select(0u, 1u, of_sky);
#ifdef TILED
        if !is_identity && !is_uniform {
            coords[first + number + select(0u, total, of_sky)] = at.x | (at.y << 8u) | (mask << 16u);
        }
#endif
#ifdef LIST
        let in_list = select(starts.x + number, params.list_capacity - 1u - starts.y - number, of_sky);
        put_list(in_list, origin + at, mask);
#endif
#ifdef CLASSIFIED
        if !is_identity && !is_uniform {
            let in_mixed = select(starts.z + number, params.list_capacity - 1u - starts.w - number, of_sky);
            put_mixed(in_mixed, origin + at, mask);
        }
#endif
    }
}
