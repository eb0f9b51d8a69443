// Errors and luma of windows: 4x4 pixels around each of a block's four quads, upper left, upper right, lower left, lower right.
#define_import_path vrcs::analyse::sums

#ifdef DIRECT
#import vrcs::analyse::params::params
#endif
#ifndef LINES
#ifndef SHARED_SUMS
#import vrcs::analyse::pairs::joined
#ifdef PAIRWISE
#import vrcs::analyse::params::ONE
#import vrcs::analyse::pairs::sensitivity_under
#endif
#endif
#endif
#ifndef LINES
#ifdef DIRECT
#import vrcs::analyse::pictures
#import vrcs::analyse::source
#else
#import vrcs::analyse::cells::{cells, slot_of, ROW, PLANE, PICTURE, ODD}
#endif
#endif

struct Sums {
    across: vec4<u32>,
    down: vec4<u32>,
    // the sum of lumas
    brightness: vec4<u32>,
}

#ifndef LINES
#ifdef SHARED_SUMS
// The four windows overlap: 6x6 pixels in all, of which each pair is looked at once.

// Six pixels: the left one of each word, and the right one.
struct Line {
    left: vec3<u32>,
    right: vec3<u32>,
}

#ifdef DIRECT
// Where the six pixels of each line are, in the previous picture; and whether they lie in three words side by side.
struct Columns {
    left: vec3<u32>,
    right: vec3<u32>,
    is_plain: bool,
}

fn columns_of(quad: vec2<u32>) -> Columns {
    let first = i32(quad.x * 2u);
    let last = vec3<i32>(i32(params.size.x) - 1);
    let left = vec3<u32>(clamp(vec3<i32>(first - 1, first + 1, first + 3), vec3<i32>(0), last));
    let right = vec3<u32>(min(vec3<i32>(first, first + 2, first + 4), last));
    let is_same = params.ratio.x == (1u << 24u);
    var columns = Columns(left, right, is_same && first > 0 && first + 4 <= last.x);
    if !columns.is_plain {
        columns.left = source::still_columns(left);
        columns.right = source::still_columns(right);
    }
    return columns;
}

// Straight from the picture: eight bits a pixel are read faster than they are shared.
fn line_at(columns: Columns, y: i32, picture: u32) -> Line {
    let row = source::still_row(u32(clamp(y, 0, i32(params.size.y) - 1))) * params.luma_pitch;
    var left: vec3<u32>;
    var right: vec3<u32>;
    if columns.is_plain {
        let at = row + (columns.right.x >> 2u);
        let before = pictures::word_at(at - 1u, picture);
        let here = pictures::word_at(at, picture);
        let behind = pictures::word_at(at + 1u, picture);
        left = vec3<u32>(before >> 24u, (here >> 8u) & 255u, here >> 24u);
        right = vec3<u32>(here & 255u, (here >> 16u) & 255u, behind & 255u);
    } else {
        let l = columns.left;
        let r = columns.right;
        left = vec3<u32>(
            pictures::code_in(pictures::word_at(row + (l.x >> 2u), picture), l.x),
            pictures::code_in(pictures::word_at(row + (l.y >> 2u), picture), l.y),
            pictures::code_in(pictures::word_at(row + (l.z >> 2u), picture), l.z),
        );
        right = vec3<u32>(
            pictures::code_in(pictures::word_at(row + (r.x >> 2u), picture), r.x),
            pictures::code_in(pictures::word_at(row + (r.y >> 2u), picture), r.y),
            pictures::code_in(pictures::word_at(row + (r.z >> 2u), picture), r.z),
        );
    }
    return Line(pictures::luma_of_codes(left), pictures::luma_of_codes(right));
}
#else
fn line_at(at: u32) -> Line {
    let words = vec3<u32>(cells[at], cells[at + ODD], cells[at + 1u]);
    return Line(words & vec3<u32>(0xffffu), words >> vec3<u32>(16u));
}
#endif

// A difference as it is summed. What is squared needs no sign.
fn strength(a: vec3<u32>, b: vec3<u32>) -> vec3<u32> {
#ifdef MEAN
    return max(a, b) - min(a, b);
#else
    let d = a - b;
    return d * d;
#endif
}

// The pairs of two lines each: their sums in the left window and in the right one.
fn across(a: Line, b: Line) -> vec2<u32> {
    let inside = strength(a.left, a.right) + strength(b.left, b.right);
    let between = strength(a.right, a.left.yzz) + strength(b.right, b.left.yzz);
    return inside.xy + inside.yz + between.xy;
}

// The pairs of one line and the next, by words.
fn down(a: Line, b: Line) -> vec3<u32> {
    return strength(a.left, b.left) + strength(a.right, b.right);
}

fn light(a: Line, b: Line) -> vec3<u32> {
    return (a.left + a.right) + (b.left + b.right);
}

// By words to by windows.
fn by_window(upper: vec3<u32>, lower: vec3<u32>) -> vec4<u32> {
    return vec4<u32>(upper.xy + upper.yz, lower.xy + lower.yz);
}

// The sums of four quads, of which the first is given, and the block's place in the tile.
fn sums_of(quad: vec2<u32>, block: vec2<u32>, picture: u32) -> Sums {
#ifdef DIRECT
    let columns = columns_of(quad);
    let y = i32(quad.y * 2u) - 1;
    let a = line_at(columns, y, picture);
    let b = line_at(columns, y + 1, picture);
    let c = line_at(columns, y + 2, picture);
    let d = line_at(columns, y + 3, picture);
    let e = line_at(columns, y + 4, picture);
    let f = line_at(columns, y + 5, picture);
#else
    let at = picture * PICTURE + block.y * 4u * ROW + block.x;
    let a = line_at(at);
    let b = line_at(at + ROW);
    let c = line_at(at + 2u * ROW);
    let d = line_at(at + 3u * ROW);
    let e = line_at(at + 4u * ROW);
    let f = line_at(at + 5u * ROW);
#endif
    let across_middle = across(c, d);
    let down_middle = down(c, d);
    let light_middle = light(c, d);
    return Sums(
        vec4<u32>(across(a, b) + across_middle, across_middle + across(e, f)),
        by_window(down(a, b) + down(b, c) + down_middle, down_middle + down(d, e) + down(e, f)),
        by_window(light(a, b) + light_middle, light_middle + light(e, f)),
    );
}
#else
// Any pairs, channels and norm: one window after the other.

// Channels and luma of a pixel, of the picture before (0) or after (1) transparents.
fn cell_at(p: vec2<u32>, picture: u32) -> vec4<u32> {
    let at = picture * PICTURE + p.y * ROW + slot_of(p.x >> 1u);
    let shift = (p.x & 1u) * 16u;
#ifdef CHANNELS
    let words = vec4<u32>(cells[at], cells[at + PLANE], cells[at + 2u * PLANE], cells[at + 3u * PLANE]);
    return (words >> vec4<u32>(shift)) & vec4<u32>(0xffffu);
#else
    return vec4<u32>((cells[at] >> shift) & 0xffffu);
#endif
}

// Whether the pair that starts at x, y is looked at, across and down.
fn is_taken(x: u32, y: u32) -> vec2<bool> {
#ifdef INTERLEAVED
    return vec2<bool>(((x + y) & 1u) == 0u, ((x + y) & 1u) == 1u);
#else
#ifdef SUB_SAMPLED
    return vec2<bool>(((x | y) & 1u) == 0u);
#else
#ifdef QUAD
    return vec2<bool>(x == 2u && (y == 2u || y == 3u), y == 2u && (x == 2u || x == 3u));
#else
    return vec2<bool>(true);
#endif
#endif
#endif
}

#ifdef SOBEL
// Three pixels in a line, the middle one twice.
fn side_of(middle: vec2<u32>, step: vec2<u32>, picture: u32) -> vec4<u32> {
    return cell_at(middle - step, picture) + 2u * cell_at(middle, picture) + cell_at(middle + step, picture);
}
#endif

// The sums of the window whose upper left cell is given: across, down, luma. Windows start at odd pixels.
fn window(corner: vec2<u32>, picture: u32) -> vec3<u32> {
    let right = vec2<u32>(1u, 0u);
    let under = vec2<u32>(0u, 1u);
    var sums = vec3<u32>(0u);
    var sensitivity = 0u;
#ifdef PAIRWISE
    var darkest = ONE;
    for (var i = 0u; i < 16u; i++) {
        darkest = min(darkest, cell_at(corner + vec2<u32>(i & 3u, i >> 2u), picture).w);
    }
    sensitivity = sensitivity_under(darkest);
#endif
    for (var i = 0u; i < 16u; i++) {
        let x = i & 3u;
        let y = i >> 2u;
        let cell = corner + vec2<u32>(x, y);
        let here = cell_at(cell, picture);
        let taken = is_taken(x + 1u, y + 1u);
        sums.z += here.w;
#ifdef SOBEL
        if (x == 1u || x == 2u) && (y == 1u || y == 2u) {
            sums.x = joined(
                sums.x, side_of(cell - right, under, picture), side_of(cell + right, under, picture), sensitivity);
            sums.y = joined(
                sums.y, side_of(cell - under, right, picture), side_of(cell + under, right, picture), sensitivity);
        }
#else
        if x < 3u && taken.x {
            sums.x = joined(sums.x, here, cell_at(cell + right, picture), sensitivity);
        }
        if y < 3u && taken.y {
            sums.y = joined(sums.y, here, cell_at(cell + under, picture), sensitivity);
        }
#endif
    }
    return sums;
}

fn sums_of(quad: vec2<u32>, block: vec2<u32>, picture: u32) -> Sums {
    let corner = block * 4u;
    let a = window(corner, picture);
    let b = window(corner + vec2<u32>(2u, 0u), picture);
    let c = window(corner + vec2<u32>(0u, 2u), picture);
    let d = window(corner + vec2<u32>(2u, 2u), picture);
    return Sums(vec4<u32>(a.x, b.x, c.x, d.x), vec4<u32>(a.y, b.y, c.y, d.y), vec4<u32>(a.z, b.z, c.z, d.z));
}
#endif
#endif
