// The deblocker: one invocation for a quad, 16x16 of them to a workgroup.
//
// src/deblock/mod.rs argues where the taps lie and why no two invocations race; src/deblock/cpu.rs is the twin. What nobody asked for
// is not compiled. `filter_quads` writes the picture, or the scratch texture where the picture cannot be read and written at
// once; `return_quads` then takes what was filtered back from there. Where a quad lies in one group, its pixels share their three taps.

#import vrcs::deblock::params::params
#import vrcs::deblock::picture::{load, store}
#import vrcs::deblock::groups::{load_rates, rate_of, sample_of}
#import vrcs::deblock::surfaces::{is_finite, is_usable, is_same, is_one_surface}

#ifdef LUMA
@group(0) @binding(6) var<storage, read_write> luma: array<u32>;
#endif
#ifdef LUMA_CODES
// Linear light of 8-bit codes, white / 16384.
@group(0) @binding(8) var<storage, read> codes: array<u32, 256>;
#endif
#ifdef COUNTERS
@group(0) @binding(7) var<storage, read_write> counters: array<atomic<u32>, 3>;
const C_NOT_FINITE: u32 = 0u;
const C_FILTERED: u32 = 1u;
const C_REFUSED: u32 = 2u;
#endif

#ifdef LUMA
// Each quad's four codes, two to a line, for the word that two quads share.
var<workgroup> shared_codes: array<u32, 256>;
#endif

#ifndef LUMA
// The coarse quads of a workgroup, in any order: the first invocations take those that lie in one group each, the last ones the others,
// and those between are done. So few waves do both.
var<workgroup> coarse: array<u32, 256>;
var<workgroup> coarse_counts: array<atomic<u32>, 2>;
#endif

struct Tap {
    at: vec2<u32>,
    is_inside: bool,
    color: vec4<f32>,
}

// The taps of a pixel or of a whole quad.
struct Taps {
    across: Tap,
    down: Tap,
    diagonal: Tap,
}

fn no_tap() -> Tap {
    return Tap(vec2<u32>(0u), false, vec4<f32>(0.0));
}

// The sample of the group that a pixel lies in; none outside the picture.
fn tap_at(pixel: vec2<i32>) -> Tap {
    if any(pixel < vec2<i32>(0)) || any(pixel >= vec2<i32>(params.extent)) {
        return no_tap();
    }
    let at = sample_of(vec2<u32>(pixel), rate_of(vec2<u32>(pixel) / 2u).xy);
    return Tap(at, true, load(at));
}

// The value of a tap as seen from a pixel: the pixel's own where the tap shows another surface, or is not to be used.
fn tapped(pixel: vec2<u32>, own: vec4<f32>, tap: Tap) -> vec4<f32> {
    if !tap.is_inside {
        return own;
    }
    if !is_usable(tap.color) || !is_one_surface(pixel, tap.at) {
#ifdef COUNTERS
        atomicAdd(&counters[C_REFUSED], 1u);
#endif
        return own;
    }
    return tap.color;
}

// How much of the way from the own sample to a tap's lies behind a pixel.
fn weight(pixel: u32, own: u32, tap: u32) -> f32 {
    return abs(f32(i32(pixel) - i32(own))) / max(abs(f32(i32(tap) - i32(own))), 1.0);
}

// The taps beside a pixel of a group on the axes that are asked for, seen from its sample.
fn taps_of(pixel: vec2<u32>, rate: vec2<u32>, origin: vec2<u32>, is_active: vec2<bool>) -> Taps {
    let corner = vec2<i32>((pixel >> rate) << rate);
    let end = corner + vec2<i32>(vec2<u32>(1u) << rate);
    // the nearest pixel beyond the group, on the side on which this pixel lies from its sample
    let beyond = select(corner - 1, end, pixel > origin);
    let base = vec2<i32>(select(pixel, origin, is_active));
    var taps = Taps(no_tap(), no_tap(), no_tap());
    if is_active.x {
        taps.across = tap_at(vec2<i32>(beyond.x, base.y));
    }
    if is_active.y {
        taps.down = tap_at(vec2<i32>(base.x, beyond.y));
    }
    if all(is_active) {
        taps.diagonal = tap_at(beyond);
    }
    return taps;
}

// The value of a pixel of a coarse group. `is_active` tells along which axes it holds a copy.
fn blended(pixel: vec2<u32>, origin: vec2<u32>, own: vec4<f32>, is_active: vec2<bool>, taps: Taps) -> vec4<f32> {
    var across = own;
    var down = own;
    var diagonal = own;
    var part = vec2<f32>(0.0);
    if is_active.x {
        if taps.across.is_inside {
            part.x = weight(pixel.x, origin.x, taps.across.at.x);
        }
        across = tapped(pixel, own, taps.across);
    }
    if is_active.y {
        if taps.down.is_inside {
            part.y = weight(pixel.y, origin.y, taps.down.at.y);
        }
        down = tapped(pixel, own, taps.down);
    }
    if all(is_active) {
        diagonal = tapped(pixel, own, taps.diagonal);
    }
    // written so that equal values give that value, bit for bit
    let near = own.rgb + (across.rgb - own.rgb) * part.x;
    let far = down.rgb + (diagonal.rgb - down.rgb) * part.x;
    return vec4<f32>(near + (far - near) * part.y, own.a);
}

#ifdef LUMA
// Units of luma of a channel; BAD if it is negative or above white. The same as in shaders/analyse/fixed.wgsl.
const BAD: u32 = 0xffffffffu;
fn units(value: f32) -> u32 {
#ifdef LUMA_CODES
    return codes[min(u32(value * 255.0 + 0.5), 255u)];
#else
    let bits = bitcast<u32>(value);
    if bits >= 0x80000000u {
        return select(BAD, 0u, (bits & 0x7fffffffu) < (u32(params.white_log - 15 + 127) << 23u));
    }
    if bits > (u32(params.white_log + 127) << 23u) {
        return BAD;
    }
    return u32(floor(value * bitcast<f32>(u32(14 - params.white_log + 127) << 23u) + 0.5));
#endif
}

// The square root of the luma (Eq. 25) of a finite color, 8 bits; see fixed::sqrt_code.
fn luma_code(color: vec4<f32>) -> u32 {
    let c = vec3<u32>(units(color.r), units(color.g), units(color.b));
    if any(c == vec3<u32>(BAD)) {
        return 255u;
    }
#ifdef REC709
    let light = (c.x * 3483u + c.y * 11718u + c.z * 1183u + 8192u) >> 14u;
#else
    let light = (c.x * 4899u + c.y * 9617u + c.z * 1868u + 8192u) >> 14u;
#endif
    // the root is guessed in float, and made exact in integers
    let square = (min(light, 16384u) * 260100u) >> 14u;
    let guess = u32(sqrt(f32(square)) * 0.5 + 0.5);
    let more = select(0u, 1u, (2u * guess + 1u) * (2u * guess + 1u) <= square);
    let odd = max(2u * guess, 1u) - 1u;
    let less = select(0u, 1u, guess > 0u && odd * odd > square);
    return guess + more - less;
}

// The codes of a quad, whose pixels inside the picture are marked by a byte of ones each. If one of those is not finite, the quad is like
// a chessboard: whatever lies around it, it asks for full rate.
fn codes_of(codes: u32, is_finite: bool, inside: u32) -> u32 {
    return select(0x00ffff00u, codes, is_finite) & inside;
}
#endif

// Whether a filter may write a pixel.
fn is_written(pixel: vec2<u32>, rate: vec2<u32>) -> bool {
    return all(pixel < params.extent) && any(pixel != sample_of(pixel, rate));
}

struct Filtered {
    color: vec4<f32>,
    is_written: bool,
}

// A quad's colours, and a bit for each pixel that is still to be stored.
struct FilteredQuad {
    colors: array<vec4<f32>, 4>,
    written: u32,
}

// What a quad's pixels have in common: width and height of their groups, as powers of two, whether coverage split the block; and, where
// all four lie in one group, its sample and the taps.
struct Quad {
    rate: vec3<u32>,
    is_shared: bool,
    origin: vec2<u32>,
    taps: Taps,
}

// Whether all pixels of a quad lie in one group.
fn is_one_group(rate: vec3<u32>) -> bool {
    return rate.z == 0u && all(rate.xy != vec2<u32>(0u));
}

fn quad_of(at: vec2<u32>, rate: vec3<u32>) -> Quad {
    let is_shared = is_one_group(rate);
    var quad = Quad(rate, is_shared, vec2<u32>(0u), Taps(no_tap(), no_tap(), no_tap()));
    if is_shared {
        let first = at * 2u;
        quad.origin = sample_of(first, rate.xy);
        // a group's sample is its first pixel or its last, so that all others lie on one side of it
        let is_last = params.phase != 0u && ((params.phase - 1u) & 1u) != 0u;
        let corner = (first >> rate.xy) << rate.xy;
        let opposite = select(corner + (vec2<u32>(1u) << rate.xy) - 1u, corner, is_last);
        quad.taps = taps_of(opposite, rate.xy, quad.origin, vec2<bool>(true));
    }
    return quad;
}

// The pixel of a coarse quad, given its neighbours in the quad across and down.
fn filtered(pixel: vec2<u32>, quad: Quad, own: vec4<f32>, across: vec4<f32>, down: vec4<f32>) -> Filtered {
    if any(pixel >= params.extent) {
        return Filtered(own, false);
    }
#ifdef COUNTERS
    if !is_finite(own) {
        atomicAdd(&counters[C_NOT_FINITE], 1u);
    }
#endif
    let origin = sample_of(pixel, quad.rate.xy);
    var is_active = pixel != origin;
    var out = Filtered(own, false);
#ifdef SCRATCH
    out.is_written = any(is_active);
#endif
    if quad.rate.z != 0u {
        // coverage split the block: who shares is told by who is equal
        is_active = is_active & vec2<bool>(is_same(own, across), is_same(own, down));
    }
    if !any(is_active) || !is_usable(own) {
        return out;
    }
    var taps = quad.taps;
    if !quad.is_shared {
        taps = taps_of(pixel, quad.rate.xy, origin, is_active);
    }
#ifdef COUNTERS
    atomicAdd(&counters[C_FILTERED], 1u);
#endif
    return Filtered(blended(pixel, origin, own, is_active, taps), true);
}

#ifdef BY_QUADS
// Where nothing is asked of each pixel alone, a quad is filtered as a whole, so that all of its taps are on their way at once: the same
// values as by `filtered`.

// A tap's colour where it may be used, else the pixel's own.
fn usable_or(own: vec4<f32>, tap: Tap) -> vec3<f32> {
    return select(own.rgb, tap.color.rgb, tap.is_inside && is_usable(tap.color));
}

// A pixel of a group, given the parts of the taps that lie across and down.
fn blended_in_group(own: vec4<f32>, taps: Taps, part: vec2<f32>) -> vec4<f32> {
    let across = usable_or(own, taps.across);
    let down = usable_or(own, taps.down);
    let diagonal = usable_or(own, taps.diagonal);
    let near = own.rgb + (across - own.rgb) * part.x;
    let far = down + (diagonal - down) * part.x;
    return select(own, vec4<f32>(near + (far - near) * part.y, own.a), is_usable(own));
}

// Which of four pixels are no samples, given the bits of those that are, and lie in the extent.
fn written_of(first: vec2<u32>, samples: u32) -> u32 {
    let room = params.extent - first;
    return 15u & ~samples & select(5u, 15u, room.x > 1u) & select(3u, 15u, room.y > 1u);
}

// The parts of a tap in a quad's two columns, or in its two lines.
fn parts_of(first: u32, own: u32, tap: u32, is_inside: bool) -> vec2<f32> {
    return select(vec2<f32>(0.0), vec2<f32>(weight(first, own, tap), weight(first + 1u, own, tap)), is_inside);
}

// A quad that lies in one group.
fn filter_group(first: vec2<u32>, quad: Quad, colors: array<vec4<f32>, 4>) -> FilteredQuad {
    let taps = quad.taps;
    let columns = parts_of(first.x, quad.origin.x, taps.across.at.x, taps.across.is_inside);
    let lines = parts_of(first.y, quad.origin.y, taps.down.at.y, taps.down.is_inside);
    // the sample may lie in another quad of the group
    let place = quad.origin - first;
    let samples = select(0u, 1u << (place.x + place.y * 2u), all(place < vec2<u32>(2u)));
    return FilteredQuad(
        array<vec4<f32>, 4>(
            blended_in_group(colors[0], taps, vec2<f32>(columns.x, lines.x)),
            blended_in_group(colors[1], taps, vec2<f32>(columns.y, lines.x)),
            blended_in_group(colors[2], taps, vec2<f32>(columns.x, lines.y)),
            blended_in_group(colors[3], taps, vec2<f32>(columns.y, lines.y)),
        ),
        written_of(first, samples),
    );
}

// The one tap of a pair of pixels, of which the first is given: beyond the pixel that is no sample.
fn tap_of_pair(first: vec2<u32>, axis: vec2<u32>, sample: vec2<u32>) -> Tap {
    let is_first = all(sample == first);
    return tap_at(vec2<i32>(first) + vec2<i32>(axis) * select(-1, 2, is_first));
}

// The pixel of a pair that is no sample.
fn blended_in_pair(own: vec4<f32>, pixel: vec2<u32>, sample: vec2<u32>, tap: Tap) -> vec4<f32> {
    // the three lie on one line: along the other axis there is no distance
    let part = max(weight(pixel.x, sample.x, tap.at.x), weight(pixel.y, sample.y, tap.at.y));
    let other = usable_or(own, tap);
    return select(own, vec4<f32>(own.rgb + (other - own.rgb) * part, own.a), is_usable(own));
}

// A quad of two pairs, side by side or one above the other.
fn filter_pairs(first: vec2<u32>, rate: vec2<u32>, colors: array<vec4<f32>, 4>) -> FilteredQuad {
    let axis = rate;
    let other = axis.yx;
    let second = first + other;
    let sample = sample_of(first, rate);
    let second_sample = sample_of(second, rate);
    let tap = tap_of_pair(first, axis, sample);
    let second_tap = tap_of_pair(second, axis, second_sample);
    let is_first = all(sample == first);
    let second_is_first = all(second_sample == second);
    let is_row = axis.x != 0u;
    // the pixels that are no samples
    let pixel = first + select(vec2<u32>(0u), axis, is_first);
    let second_pixel = second + select(vec2<u32>(0u), axis, second_is_first);
    let right = select(colors[2], colors[1], is_row);
    let left_below = select(colors[1], colors[2], is_row);
    let done = blended_in_pair(select(colors[0], right, is_first), pixel, sample, tap);
    let second_done = blended_in_pair(select(left_below, colors[3], second_is_first), second_pixel, second_sample, second_tap);
    let step = select(2u, 1u, is_row);
    let across = 3u - step;
    let samples = (1u << select(step, 0u, is_first)) | (1u << (across + select(step, 0u, second_is_first)));
    var out = colors;
    out[0] = select(done, colors[0], is_first);
    out[3] = select(colors[3], second_done, second_is_first);
    let in_step = select(colors[1], done, is_row && is_first);
    out[1] = select(in_step, second_done, !is_row && !second_is_first);
    let in_across = select(colors[2], done, !is_row && is_first);
    out[2] = select(in_across, second_done, is_row && !second_is_first);
    return FilteredQuad(out, written_of(first, samples));
}
#endif

// One of four. An index that is not known would put them into memory.
fn chosen(colors: array<vec4<f32>, 4>, i: u32) -> vec4<f32> {
    let upper = select(colors[0], colors[1], (i & 1u) != 0u);
    let lower = select(colors[2], colors[3], (i & 1u) != 0u);
    return select(upper, lower, i >= 2u);
}

// The quad of an invocation.
fn quad_at(group: vec2<u32>, index: u32) -> vec2<u32> {
    return group * 16u + vec2<u32>(index & 15u, index >> 4u);
}

#ifdef BY_QUADS
#ifdef SPLITS
// A quad whose block coverage has split: who shares is told by who is equal. One pixel after the other, and each is loaded anew: what is
// kept meanwhile costs every quad registers, and there are few of these.
fn filter_split(first: vec2<u32>, rate: vec2<u32>, colors: array<vec4<f32>, 4>) -> FilteredQuad {
    // bits 0 and 1: the pixels of a line are equal; bits 2 and 3: those of a column are
    let same = select(0u, 1u, is_same(colors[0], colors[1])) | select(0u, 2u, is_same(colors[2], colors[3]))
        | select(0u, 4u, is_same(colors[0], colors[2])) | select(0u, 8u, is_same(colors[1], colors[3]));
    var out = FilteredQuad(colors, 0u);
    for (var i = 0u; i < 4u; i++) {
        let pixel = first + vec2<u32>(i & 1u, i >> 1u);
        let origin = sample_of(pixel, rate);
        let is_copy = pixel != origin;
        if any(pixel >= params.extent) || !any(is_copy) {
            continue;
        }
        let own = load(pixel);
        let is_active = is_copy & vec2<bool>(((same >> (i >> 1u)) & 1u) != 0u, ((same >> (2u + (i & 1u))) & 1u) != 0u);
        var color = own;
        if any(is_active) && is_usable(own) {
            color = blended(pixel, origin, own, is_active, taps_of(pixel, rate, origin, is_active));
        }
#ifdef LUMA
        // an index that is not known would put them into memory
        out.colors[0] = select(out.colors[0], color, i == 0u);
        out.colors[1] = select(out.colors[1], color, i == 1u);
        out.colors[2] = select(out.colors[2], color, i == 2u);
        out.colors[3] = select(out.colors[3], color, i == 3u);
#endif
        store(pixel, color);
    }
    return out;
}
#endif
#else
// A coarse quad, one pixel after the other. Not unrolled: with all that a pixel may need, four copies are slow to compile.
fn filter_pixels(at: vec2<u32>, rate: vec3<u32>, colors: array<vec4<f32>, 4>) -> FilteredQuad {
    let quad = quad_of(at, rate);
    var out = FilteredQuad(colors, 0u);
    for (var i = 0u; i < 4u; i++) {
        let pixel = at * 2u + vec2<u32>(i & 1u, i >> 1u);
        let done = filtered(pixel, quad, chosen(colors, i), chosen(colors, i ^ 1u), chosen(colors, i ^ 2u));
        if done.is_written {
            store(pixel, done.color);
        }
#ifdef LUMA
        out.colors[0] = select(out.colors[0], done.color, i == 0u);
        out.colors[1] = select(out.colors[1], done.color, i == 1u);
        out.colors[2] = select(out.colors[2], done.color, i == 2u);
        out.colors[3] = select(out.colors[3], done.color, i == 3u);
#endif
    }
    return out;
}
#endif

// Filters a coarse quad; its colours then, and a bit for each pixel that is still to be stored.
fn filter_quad(at: vec2<u32>, rate: vec3<u32>, colors: array<vec4<f32>, 4>) -> FilteredQuad {
#ifdef BY_QUADS
    if is_one_group(rate) {
        return filter_group(at * 2u, quad_of(at, rate), colors);
    }
#ifdef SPLITS
    if rate.z != 0u {
        return filter_split(at * 2u, rate.xy, colors);
    }
#endif
    return filter_pairs(at * 2u, rate.xy, colors);
#else
    return filter_pixels(at, rate, colors);
#endif
}

@compute @workgroup_size(256)
fn filter_quads(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    load_rates(group.xy, index);
#ifndef LUMA
    if index < 2u {
        atomicStore(&coarse_counts[index], 0u);
    }
#endif
    workgroupBarrier();
    var at = quad_at(group.xy, index);
    var rate = rate_of(at);
#ifndef LUMA
    if any(rate.xy != vec2<u32>(0u)) {
        let kind = select(1u, 0u, is_one_group(rate));
        let place = atomicAdd(&coarse_counts[kind], 1u);
        coarse[select(place, 255u - place, kind == 1u)] = index | (rate.x << 8u) | (rate.y << 10u) | (rate.z << 12u);
    }
    workgroupBarrier();
    if index >= atomicLoad(&coarse_counts[0]) && index < 256u - atomicLoad(&coarse_counts[1]) {
        return;
    }
    let taken = coarse[index];
    at = quad_at(group.xy, taken & 255u);
    rate = vec3<u32>((taken >> 8u) & 3u, (taken >> 10u) & 3u, taken >> 12u);
#endif
    let a = at * 2u;
    let b = a + vec2<u32>(1u, 0u);
    let c = a + vec2<u32>(0u, 1u);
    let d = a + vec2<u32>(1u, 1u);
    // a pixel outside repeats one inside; it is never written
    let last = params.extent - 1u;
    let colors = array<vec4<f32>, 4>(load(min(a, last)), load(min(b, last)), load(min(c, last)), load(min(d, last)));
    var done = FilteredQuad(colors, 0u);
    if any(rate.xy != vec2<u32>(0u)) {
        done = filter_quad(at, rate, colors);
        if (done.written & 1u) != 0u {
            store(a, done.colors[0]);
        }
        if (done.written & 2u) != 0u {
            store(b, done.colors[1]);
        }
        if (done.written & 4u) != 0u {
            store(c, done.colors[2]);
        }
        if (done.written & 8u) != 0u {
            store(d, done.colors[3]);
        }
    }
#ifdef LUMA
    let codes = luma_code(done.colors[0]) | (luma_code(done.colors[1]) << 8u) | (luma_code(done.colors[2]) << 16u)
        | (luma_code(done.colors[3]) << 24u);
    let inside = select(0u, 0xffu, all(a < params.extent)) | select(0u, 0xff00u, all(b < params.extent))
        | select(0u, 0xff0000u, all(c < params.extent)) | select(0u, 0xff000000u, all(d < params.extent));
    // a pixel outside repeats one inside
    let are_finite = is_finite(done.colors[0]) && is_finite(done.colors[1]) && is_finite(done.colors[2]) && is_finite(done.colors[3]);
    let mine = codes_of(codes, are_finite, inside);
    shared_codes[index] = mine;
    workgroupBarrier();
    // of two quads, the left one writes the upper line's word, the right one the lower line's
    let other = shared_codes[index ^ 1u];
    let is_right = (at.x & 1u) != 0u;
    let word = select((mine & 0xffffu) | (other << 16u), (mine & 0xffff0000u) | (other >> 16u), is_right);
    let column = at.x >> 1u;
    let row = a.y + (at.x & 1u);
    if column * 4u < params.extent.x && row < params.extent.y {
        luma[row * params.luma_pitch + column] = word;
    }
#endif
}

#ifdef SCRATCH
// The way back: what `filter_quads` wrote goes from the scratch texture, which is bound as the picture here, to the picture.
@compute @workgroup_size(256)
fn return_quads(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    load_rates(group.xy, index);
    workgroupBarrier();
    let at = quad_at(group.xy, index);
    let rate = rate_of(at).xy;
    if all(rate == vec2<u32>(0u)) {
        return;
    }
    for (var i = 0u; i < 4u; i++) {
        let pixel = at * 2u + vec2<u32>(i & 1u, i >> 1u);
        if is_written(pixel, rate) {
            store(pixel, load(pixel));
        }
    }
}
#endif
