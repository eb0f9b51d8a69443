// The deblocker: one invocation for a quad, 16x16 of them to a workgroup.
//
// src/deblock/mod.rs argues where the taps lie and why no two invocations race; src/deblock/cpu.rs is the twin. What nobody asked for
// is not compiled. `filter_quads` writes the picture, or the scratch texture where the picture cannot be read and written at
// once; `return_quads` then takes what was filtered back from there. Where a quad lies in one group, its pixels share their three taps.

#import vrcs::deblock::params::params
#import vrcs::deblock::picture::{load, store}
#import vrcs::deblock::groups::{rate_of, sample_of}
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
// The coarse quads of a workgroup, in any order: the first invocations take one each, and the others are done.
var<workgroup> coarse: array<u32, 256>;
var<workgroup> coarse_count: atomic<u32>;
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

// What a quad's pixels have in common: width and height of their groups, as powers of two, whether coverage split the block; and, where
// all four lie in one group, its sample and the taps.
struct Quad {
    rate: vec3<u32>,
    is_shared: bool,
    origin: vec2<u32>,
    taps: Taps,
}

fn quad_of(at: vec2<u32>, rate: vec3<u32>) -> Quad {
    let is_shared = rate.z == 0u && all(rate.xy != vec2<u32>(0u));
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

@compute @workgroup_size(256)
fn filter_quads(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    var at = quad_at(group.xy, index);
    var rate = rate_of(at);
#ifndef LUMA
    let is_coarse = any(rate.xy != vec2<u32>(0u));
    if index == 0u {
        atomicStore(&coarse_count, 0u);
    }
    workgroupBarrier();
    if is_coarse {
        let place = atomicAdd(&coarse_count, 1u);
        coarse[place] = index | (rate.x << 8u) | (rate.y << 10u) | (rate.z << 12u);
    }
    workgroupBarrier();
    if index >= atomicLoad(&coarse_count) {
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
#ifdef LUMA
    var mine = 0u;
    var inside = 0u;
    var are_finite = true;
#endif
    let is_filtered = any(rate.xy != vec2<u32>(0u));
    var quad = Quad(rate, false, vec2<u32>(0u), Taps(no_tap(), no_tap(), no_tap()));
    if is_filtered {
        quad = quad_of(at, rate);
    }
    // not unrolled here: with all that a pixel may need, four copies are slow to compile
    for (var i = 0u; i < 4u; i++) {
        let pixel = a + vec2<u32>(i & 1u, i >> 1u);
        var done = Filtered(chosen(colors, i), false);
        if is_filtered {
            done = filtered(pixel, quad, done.color, chosen(colors, i ^ 1u), chosen(colors, i ^ 2u));
            if done.is_written {
                store(pixel, done.color);
            }
        }
#ifdef LUMA
        if all(pixel < params.extent) {
            mine |= luma_code(done.color) << (i * 8u);
            inside |= 0xffu << (i * 8u);
            are_finite = are_finite && is_finite(done.color);
        }
#endif
    }
#ifdef LUMA
    mine = codes_of(mine, are_finite, inside);
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
