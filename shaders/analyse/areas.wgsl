// Errors and luma of whole tiles: of a tile's own pixels, and of no others. Pixels beyond its border are never shaded together with
// its own, so that a step there is no error of a coarse rate here. A workgroup makes 32x32 pixels, an invocation a quad of them. Its CPU twin is
// `Integers::tile` in src/analyse/integer.rs.
#define_import_path vrcs::analyse::areas

#import vrcs::analyse::pairs::joined
#ifdef PAIRWISE
#import vrcs::analyse::params::ONE
#import vrcs::analyse::pairs::sensitivity_under
#endif

// The side of a tile: 4, 8, 16 or 32.
const SIDE: u32 = #{SIDE}u;
const REGION: u32 = 32u;
const INVOCATIONS: u32 = 256u;
const ACROSS: u32 = REGION / SIDE;
const COUNT: u32 = ACROSS * ACROSS;
const SETS: u32 = COUNT * #{PICTURES}u;

#ifdef CHANNELS
var<workgroup> kept: array<vec2<u32>, 1024>;
#else
var<workgroup> kept: array<u32, 1024>;
#endif

// Of each tile, across and then down: sums of what pairs tell, as two words, since squares of 992 pairs need 38 bits; or their maximum.
var<workgroup> lows: array<atomic<u32>, SETS * 2u>;
var<workgroup> highs: array<atomic<u32>, SETS * 2u>;
// How many pairs, across in the low half.
var<workgroup> counts: array<atomic<u32>, SETS>;
var<workgroup> lights: array<atomic<u32>, SETS>;

// What a tile tells, in the units of a quad's window: PAIRS pairs and sixteen pixels.
struct Area {
    error: vec2<u32>,
    light: u32,
    // whether an axis has pixels to be shaded together, and no pair that tells of them
    is_blind: vec2<bool>,
}

// To be called by all invocations, and followed by a barrier.
fn clear(index: u32) {
    for (var i = index; i < SETS * 2u; i += INVOCATIONS) {
        atomicStore(&lows[i], 0u);
        atomicStore(&highs[i], 0u);
    }
    for (var i = index; i < SETS; i += INVOCATIONS) {
        atomicStore(&counts[i], 0u);
        atomicStore(&lights[i], 0u);
    }
}

// The tile of a quad of the region.
fn tile_of(quad: vec2<u32>) -> u32 {
    let tile = quad * 2u / SIDE;
    return tile.y * ACROSS + tile.x;
}

// Keeps a pixel's channels and luma; what has none is kept as anything.
fn keep(p: vec2<u32>, value: vec4<u32>) {
    let word = value & vec4<u32>(0x7fffu);
#ifdef CHANNELS
    kept[p.y * REGION + p.x] = vec2<u32>(word.x | (word.y << 16u), word.z | (word.w << 16u));
#else
    kept[p.y * REGION + p.x] = word.w;
#endif
}

fn pixel(p: vec2<u32>) -> vec4<u32> {
    let word = kept[p.y * REGION + p.x];
#ifdef CHANNELS
    return vec4<u32>(word.x & 0xffffu, word.x >> 16u, word.y & 0xffffu, word.y >> 16u);
#else
    return vec4<u32>(word);
#endif
}

// Whether the pair that starts at a pixel is looked at, across and down.
fn is_taken(p: vec2<u32>) -> vec2<bool> {
#ifdef INTERLEAVED
    return vec2<bool>(((p.x + p.y) & 1u) == 0u, ((p.x + p.y) & 1u) == 1u);
#else
#ifdef SUB_SAMPLED
    return vec2<bool>(((p.x | p.y) & 1u) == 0u);
#else
#ifdef QUAD
    return (p & vec2<u32>(1u)) == vec2<u32>(0u);
#else
    return vec2<bool>(true);
#endif
#endif
#endif
}

#ifdef SOBEL
// Three pixels in a line, the middle one twice.
fn side_of(middle: vec2<u32>, step: vec2<u32>) -> vec4<u32> {
    return pixel(middle - step) + 2u * pixel(middle) + pixel(middle + step);
}
#endif

// Adds what a quad's pixels tell, and their pairs with the pixels to the right and below. `room` is how much of the region lies in the
// picture.
fn gather(quad: vec2<u32>, room: vec2<u32>, picture: u32) {
    let first = quad * 2u;
    if any(first >= room) {
        return;
    }
    let corner = first / SIDE * SIDE;
    let end = min(corner + SIDE, room);
    let right = vec2<u32>(1u, 0u);
    let under = vec2<u32>(0u, 1u);
    var sensitivity = 0u;
#ifdef PAIRWISE
    // the least luma of the pixels that these pairs are of
    var darkest = ONE;
    for (var i = 0u; i < 9u; i++) {
        let p = first + vec2<u32>(i % 3u, i / 3u);
        if all(p < end) {
            darkest = min(darkest, pixel(p).w);
        }
    }
    sensitivity = sensitivity_under(darkest);
#endif
    var sums = vec2<u32>(0u);
    var count = 0u;
    var light = 0u;
    for (var i = 0u; i < 4u; i++) {
        let p = first + vec2<u32>(i & 1u, i >> 1u);
        if all(p < end) {
            let own = pixel(p);
            light += own.w;
#ifdef SOBEL
            if all(p > corner) && all(p + 1u < end) {
                sums.x = joined(sums.x, side_of(p - right, under), side_of(p + right, under), sensitivity);
                sums.y = joined(sums.y, side_of(p - under, right), side_of(p + under, right), sensitivity);
                count += 0x10001u;
            }
#else
            let taken = is_taken(p);
            if taken.x && p.x + 1u < end.x {
                sums.x = joined(sums.x, own, pixel(p + right), sensitivity);
                count += 1u;
            }
            if taken.y && p.y + 1u < end.y {
                sums.y = joined(sums.y, own, pixel(p + under), sensitivity);
                count += 0x10000u;
            }
#endif
        }
    }
    let slot = picture * COUNT + tile_of(quad);
#ifdef NORM_LINF
    atomicMax(&lows[slot * 2u], sums.x);
    atomicMax(&lows[slot * 2u + 1u], sums.y);
#else
    atomicAdd(&lows[slot * 2u], sums.x & 0xffffu);
    atomicAdd(&lows[slot * 2u + 1u], sums.y & 0xffffu);
    atomicAdd(&highs[slot * 2u], sums.x >> 16u);
    atomicAdd(&highs[slot * 2u + 1u], sums.y >> 16u);
#endif
    atomicAdd(&counts[slot], count);
    atomicAdd(&lights[slot], light);
}

// What PAIRS pairs would have summed to, rounded up, so that tiles at the border, which have fewer, are judged alike.
fn error_of(at: u32, count: u32) -> u32 {
    let low = atomicLoad(&lows[at]);
#ifdef NORM_LINF
    return low;
#else
    let high = atomicLoad(&highs[at]) * #{PAIRS}u;
    let n = max(count, 1u);
    return (high / n << 16u) + (((high % n) << 16u) + low * #{PAIRS}u + n - 1u) / n;
#endif
}

// What a tile of so many pixels tells, after a barrier.
fn area_of(tile: u32, extent: vec2<u32>, picture: u32) -> Area {
    let slot = picture * COUNT + tile;
    let count = atomicLoad(&counts[slot]);
    let pairs = vec2<u32>(count & 0xffffu, count >> 16u);
    return Area(
        vec2<u32>(error_of(slot * 2u, pairs.x), error_of(slot * 2u + 1u, pairs.y)),
        // rounded down: to a lower threshold
        atomicLoad(&lights[slot]) * 16u / (extent.x * extent.y),
        (pairs == vec2<u32>(0u)) & (extent > vec2<u32>(1u)),
    );
}
