// A workgroup's pixels and a border of one, in workgroup memory.
//
// Words of two neighbouring pixels, 16 bits each, a plane for each channel and picture; and an aside for each 2x2 pixels. A quad's window
// is four such squares, so that all words are read whole. The even words of a row come first and the odd ones behind them: neighbouring
// invocations read every second word, and so read neighbours, each from a bank of its own.
#define_import_path vrcs::analyse::cells

#import vrcs::analyse::params::params
#import vrcs::analyse::fixed::BAD
#import vrcs::analyse::pictures
#import vrcs::analyse::source

const SQUARES: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u / 2u + 1u, #{TILE_HEIGHT}u / 2u + 1u);
// Where odd words start.
const ODD: u32 = SQUARES.x / 2u + 1u;
// Words from row to row, and from plane to plane.
const ROW: u32 = SQUARES.x;
const PLANE: u32 = ROW * SQUARES.y * 2u;

#ifndef DIRECT
var<workgroup> cells: array<u32, PLANE * #{PLANES}u>;
#endif

#ifdef ASIDES
// Of each square: the least speed across in bits 0 to 9 and down in 10 to 19; the first lost pixel's doubt of its upper row in bits 20 and
// 21, of its lower row in 22 and 23; whether a pixel is invalid in bit 24; whether one has no known motion in bit 25, for the reasons.
var<workgroup> asides: array<u32, ROW * SQUARES.y>;
#endif

// The place of a square's word in a row.
fn slot_of(x: u32) -> u32 {
    return (x & 1u) * ODD + (x >> 1u);
}

#ifndef DIRECT
// Keeps two neighbouring pixels of a picture: channels and luma.
fn keep(at: u32, left: vec4<u32>, right: vec4<u32>) {
#ifdef DOUBT
    // what is in doubt has no luma, and is not looked at
    let words = (left & vec4<u32>(0x7fffu)) | ((right & vec4<u32>(0x7fffu)) << vec4<u32>(16u));
#else
    let words = left | (right << vec4<u32>(16u));
#endif
#ifdef CHANNELS
    cells[at] = words.x;
    cells[at + PLANE] = words.y;
    cells[at + 2u * PLANE] = words.z;
    cells[at + 3u * PLANE] = words.w;
#else
    cells[at] = words.w;
#endif
}

#ifdef CHANNELS
const PICTURE: u32 = 4u * PLANE;
#else
const PICTURE: u32 = PLANE;
#endif

// Looks up two neighbouring pixels, given their sources in the previous picture and the doubts about those, and keeps them; gives the
// first lost pixel's doubt in bits 0 and 1, and whether one is invalid in bit 4.
fn look(at: u32, left: vec3<u32>, right: vec3<u32>) -> u32 {
    let before_left = pictures::before_at(left.xy);
    let before_right = pictures::before_at(right.xy);
    keep(at, before_left, before_right);
#ifdef TRANSPARENTS
    let after_left = pictures::after_at(left.xy);
    let after_right = pictures::after_at(right.xy);
    keep(at + PICTURE, after_left, after_right);
#endif
    var doubt = 0u;
#ifdef DOUBT
    var is_invalid = vec2<bool>(before_left.w == BAD, before_right.w == BAD);
#ifdef TRANSPARENTS
    is_invalid = is_invalid | vec2<bool>(after_left.w == BAD, after_right.w == BAD);
#endif
    let doubts = vec2<u32>(left.z, right.z);
    if any(is_invalid & (doubts == vec2<u32>(source::SURE))) {
        doubt = 16u;
    }
    doubt |= select(doubts.y, doubts.x, doubts.x != source::SURE);
#endif
    return doubt;
}

#endif

// Fills a square's words. Its upper left pixel is at an odd place, and may lie outside the picture.
fn fill_square(at: vec2<u32>, origin: vec2<u32>) {
    let slot = slot_of(at.x);
    let word = at.y * 2u * ROW + slot;
    let corner = vec2<i32>(origin + at * 2u) - 1;
    let last = vec2<i32>(params.size) - 1;
    let low = vec2<u32>(clamp(corner, vec2<i32>(0), last));
    let high = vec2<u32>(clamp(corner + 1, vec2<i32>(0), last));
#ifndef DIRECT
#ifdef REPROJECTION
    let upper = look(word, source::moved_source(low), source::moved_source(vec2<u32>(high.x, low.y)));
    let lower = look(word + ROW, source::moved_source(vec2<u32>(low.x, high.y)), source::moved_source(high));
#else
    let first = source::still_source(low);
    let second = source::still_source(high);
    let upper = look(word, vec3<u32>(first, 0u), vec3<u32>(second.x, first.y, 0u));
    let lower = look(word + ROW, vec3<u32>(first.x, second.y, 0u), vec3<u32>(second, 0u));
#endif
#endif
#ifdef ASIDES
    var aside = 0u;
#ifdef DOUBT
    aside = ((upper & 3u) << 20u) | ((lower & 3u) << 22u) | (((upper | lower) & 16u) << 20u);
#endif
#ifdef MOTION
    let above = min(source::speed_key(low), source::speed_key(vec2<u32>(high.x, low.y)));
    let under = min(source::speed_key(vec2<u32>(low.x, high.y)), source::speed_key(high));
    let speeds = source::speeds_of_key(min(above, under));
    aside |= speeds.x | (speeds.y << 10u);
#ifdef REASONS
    let lost_above = source::is_lost_at(low) || source::is_lost_at(vec2<u32>(high.x, low.y));
    let lost_under = source::is_lost_at(vec2<u32>(low.x, high.y)) || source::is_lost_at(high);
    aside |= select(0u, 1u << 25u, lost_above || lost_under);
#endif
#endif
    asides[at.y * ROW + slot] = aside;
#endif
}

const INNER: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u / 2u, #{TILE_HEIGHT}u / 2u);
const EDGE: u32 = INNER.x + SQUARES.y;

// Fills all squares: four by each of the workgroup's invocations, without a condition, so that all their loads are under way at once;
// then the last row and column.
fn fill(index: u32, count: u32, origin: vec2<u32>) {
    for (var i = 0u; i < 4u; i++) {
        let square = i * count + index;
        fill_square(vec2<u32>(square % INNER.x, square / INNER.x), origin);
    }
    for (var edge = index; edge < EDGE; edge += count) {
        let is_below = edge < INNER.x;
        fill_square(select(vec2<u32>(INNER.x, edge - INNER.x), vec2<u32>(edge, INNER.y), is_below), origin);
    }
}
