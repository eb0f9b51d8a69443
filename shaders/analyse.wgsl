// The analysis: a workgroup takes 64 pixels by 32, 16 or 8, an invocation 8x4 of them, which are two words of the shading-rate image
// and whole blocks of 4x4 pixels.
//
// Its CPU twin is src/analyse/integer.rs; both make the same words. Only integers decide: see src/analyse/fixed.rs. What the
// scene does not declare is not here: no binding, no code.

struct Params {
    size: vec2<u32>,
    previous: vec2<u32>,
    ratio: vec2<u32>,
    sri_pitch: u32,
    luma_pitch: u32,
    speed_scale: vec2<f32>,
    offset_scale: vec2<f32>,
    half: vec4<u32>,
    quarter: vec4<u32>,
    threshold: u32,
    ambient: u32,
    sensitivity: u32,
    white_log2: i32,
    tolerance: u32,
    safe_width: u32,
    safe_tolerance: u32,
    largest: u32,
    material_least: u32,
    material_slow: u32,
    material_mirror: u32,
    half_tolerance: u32,
    half_fast: u32,
    has_history: u32,
    centre: vec2<i32>,
    falloff_scale: u32,
    depth_tolerance: u32,
    depth_offset: u32,
    reversed_z: u32,
    previous_pitch: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// 256 lumas of codes, b_H | b_Q << 16 over speed, tolerance over squared distance
@group(0) @binding(1) var<storage, read> tables: array<u32>;
@group(0) @binding(2) var<storage, read_write> rates: array<u32>;
#ifdef SQRT_LUMA
@group(0) @binding(3) var<storage, read> colour: array<u32>;
#else
@group(0) @binding(3) var colour: texture_2d<f32>;
#endif
#ifdef TRANSPARENTS
#ifdef SQRT_LUMA
@group(0) @binding(4) var<storage, read> after: array<u32>;
#else
@group(0) @binding(4) var after: texture_2d<f32>;
#endif
#endif
#ifdef ATTACHMENT
@group(0) @binding(5) var<storage, read_write> attachment: array<u32>;
#endif
#ifdef REASONS
@group(0) @binding(6) var<storage, read_write> reasons: array<u32>;
#endif
#ifdef MOTION
@group(0) @binding(7) var motion: texture_2d<f32>;
#endif
#ifdef DEPTH
@group(0) @binding(8) var depth: texture_2d<f32>;
@group(0) @binding(9) var depth_before: texture_2d<f32>;
#endif
#ifdef PREVIOUS_RATES
@group(0) @binding(10) var<storage, read> rates_before: array<u32>;
#endif
#ifdef MATERIALS
@group(0) @binding(11) var materials: texture_2d<f32>;
#endif
#ifdef NOISE
@group(0) @binding(12) var noise: texture_2d<f32>;
#endif
#ifdef FLAGS
@group(0) @binding(13) var marks: texture_2d<u32>;
#endif

#ifdef BLUR
// how wide a later blur is, in pixels
@group(0) @binding(15) var blur: texture_2d<f32>;
#endif
#ifdef WRITE_LUMA
@group(0) @binding(14) var<storage, read_write> sqrt_luma: array<u32>;
#endif

const ONE: u32 = 16384u;
const FACTOR_ONE: u32 = 4096u;
const TABLE_SPEEDS: u32 = 256u;
const SPEEDS: u32 = 1024u;
const TABLE_FALLOFF: u32 = 1280u;
const FALLOFF: u32 = 256u;

const TILE_ROWS: u32 = #{TILE_HEIGHT}u / 4u;
const WIDTH: u32 = 66u;
const HEIGHT: u32 = #{TILE_HEIGHT}u + 2u;
const CELLS: u32 = WIDTH * HEIGHT;

// The workgroup's pixels and a border of one. Luma before in bits 0 to 14, after in 15 to 29, doubt in 30 and 31; where
// channels are told apart, red and green, and blue and luma, of each picture.
var<workgroup> cells: array<u32, CELLS>;
#ifdef CHANNELS
var<workgroup> blues: array<u32, CELLS>;
#ifdef TRANSPARENTS
var<workgroup> cells_after: array<u32, CELLS>;
var<workgroup> blues_after: array<u32, CELLS>;
#endif
#endif
#ifdef MOTION
// across in bits 0 to 9, down in 10 to 19
var<workgroup> speeds: array<u32, CELLS>;
#endif

// Doubt, as it is kept in a cell.
const SURE: u32 = 0u;
const INVALID: u32 = 1u;
const OFF_SCREEN: u32 = 2u;
const DISOCCLUDED: u32 = 3u;

// The reasons of src/analyse/reasons.rs.
const REASON_CONTENT: u32 = 1u;
const REASON_NO_HISTORY: u32 = 2u;
const REASON_OF_DOUBT: u32 = 2u;
const REASON_MATERIAL: u32 = 6u;
const REASON_MASK: u32 = 7u;
const REASON_HALF_RATE: u32 = 8u;
const REASON_MOTION: u32 = 10u;

// A magnitude m * 2^e, m at most 2^15.
struct Mag {
    m: u32,
    e: i32,
}

fn above(x: u32) -> Mag {
    let shift = u32(max(17 - i32(countLeadingZeros(x)), 0));
    let rest = x & ((1u << shift) - 1u);
    return Mag((x >> shift) + select(0u, 1u, rest != 0u), i32(shift));
}

fn below(x: u32) -> Mag {
    let shift = u32(max(17 - i32(countLeadingZeros(x)), 0));
    return Mag(x >> shift, i32(shift));
}

fn times_above(a: Mag, b: Mag) -> Mag {
    let product = above(a.m * b.m);
    return Mag(product.m, product.e + a.e + b.e);
}

fn times_below(a: Mag, b: Mag) -> Mag {
    let product = below(a.m * b.m);
    return Mag(product.m, product.e + a.e + b.e);
}

fn is_less(a: Mag, b: Mag) -> bool {
    let apart = a.e - b.e;
    if apart >= 0 {
        return (apart <= 16 && (a.m << u32(min(apart, 16))) < b.m) || (a.m == 0u && b.m > 0u);
    }
    return (b.m << u32(min(-apart, 16))) > a.m;
}

fn mul_high(a: u32, b: u32) -> u32 {
    let al = a & 0xffffu;
    let ah = a >> 16u;
    let bl = b & 0xffffu;
    let bh = b >> 16u;
    let middle = ah * bl + ((al * bl) >> 16u);
    let low = al * bh + (middle & 0xffffu);
    return ah * bh + (middle >> 16u) + (low >> 16u);
}

fn exponent(n: i32) -> u32 {
    return u32(clamp(n, -126, 127) + 127) << 23u;
}

const BAD: u32 = 0xffffffffu;

// Units of luma of a linear value; BAD for what is none. Bits are looked at, since drivers may take compares of NaN apart.
fn quantise(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    if bits >= 0x80000000u {
        return select(BAD, 0u, (bits & 0x7fffffffu) < exponent(params.white_log2 - 15));
    }
    if bits > exponent(params.white_log2) {
        return BAD;
    }
    return u32(floor(value * bitcast<f32>(exponent(14 - params.white_log2)) + 0.5));
}

fn luma(c: vec3<u32>) -> u32 {
#ifdef REC709
    return (c.x * 3483u + c.y * 11718u + c.z * 1183u + 8192u) >> 14u;
#else
    return (c.x * 4899u + c.y * 9617u + c.z * 1868u + 8192u) >> 14u;
#endif
}

// Channels and luma; BAD in the last for what is in doubt.
#ifdef SQRT_LUMA
fn before_at(p: vec2<u32>) -> vec4<u32> {
    let word = colour[p.y * params.luma_pitch + (p.x >> 2u)];
    return vec4<u32>(tables[extractBits(word, (p.x & 3u) * 8u, 8u)]);
}
#ifdef TRANSPARENTS
fn after_at(p: vec2<u32>) -> vec4<u32> {
    let word = after[p.y * params.luma_pitch + (p.x >> 2u)];
    return vec4<u32>(tables[extractBits(word, (p.x & 3u) * 8u, 8u)]);
}
#endif
#else
fn pixel_of(value: vec3<f32>) -> vec4<u32> {
#ifdef CODES
    let code = vec3<u32>(value * 255.0 + 0.5);
    let c = vec3<u32>(tables[code.x & 255u], tables[code.y & 255u], tables[code.z & 255u]);
    return vec4<u32>(c, luma(c));
#else
    let c = vec3<u32>(quantise(value.x), quantise(value.y), quantise(value.z));
    if any(c == vec3<u32>(BAD)) {
        return vec4<u32>(0u, 0u, 0u, BAD);
    }
    return vec4<u32>(c, luma(c));
#endif
}
fn before_at(p: vec2<u32>) -> vec4<u32> {
    return pixel_of(textureLoad(colour, vec2<i32>(p), 0).xyz);
}
#ifdef TRANSPARENTS
fn after_at(p: vec2<u32>) -> vec4<u32> {
    return pixel_of(textureLoad(after, vec2<i32>(p), 0).xyz);
}
#endif
#endif

#ifdef DEPTH
fn inverse_depth(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    if bits != 0x80000000u && bits > 0x3f800000u {
        return BAD;
    }
    let scaled = u32(value * 1073741824.0);
    let toward = select((1u << 30u) - scaled, scaled, params.reversed_z != 0u);
    return toward + params.depth_offset - mul_high(toward << 2u, params.depth_offset);
}

fn is_hidden(now: u32, then: u32) -> bool {
    if now == BAD || then == BAD {
        return true;
    }
    return max(now, then) - min(now, then) > mul_high(min(now, then), params.depth_tolerance << 16u);
}
#endif

// The pixel of the previous picture that a pixel shows, and doubt.
fn source(p: vec2<u32>) -> vec3<u32> {
    let centre = p * 256u + 128u;
    var position = vec2<i32>(
        i32(mul_high(centre.x << 8u, params.ratio.x)),
        i32(mul_high(centre.y << 8u, params.ratio.y)),
    );
    var doubt = SURE;
#ifdef REPROJECTION
    let offset = textureLoad(motion, vec2<i32>(p), 0).xy * params.offset_scale;
    // a magnitude below 2^23 surely is a number that fits
    if any((bitcast<vec2<u32>>(offset) & vec2<u32>(0x7fffffffu)) >= vec2<u32>(0x4b000000u)) {
        doubt = OFF_SCREEN;
    } else {
        position += (vec2<i32>(floor(offset)) + 1) >> vec2<u32>(1u);
        if any(position < vec2<i32>(0)) || any((position >> vec2<u32>(8u)) >= vec2<i32>(params.previous)) {
            doubt = OFF_SCREEN;
        }
    }
#endif
    let past = min(vec2<u32>(max(position >> vec2<u32>(8u), vec2<i32>(0))), params.previous - 1u);
#ifdef DEPTH
    if doubt == SURE {
        let now = inverse_depth(textureLoad(depth, vec2<i32>(p), 0).x);
        let then = inverse_depth(textureLoad(depth_before, vec2<i32>(past), 0).x);
        if is_hidden(now, then) {
            doubt = DISOCCLUDED;
        }
    }
#endif
    return vec3<u32>(past, doubt);
}

#ifdef MOTION
fn speed_index(vector: f32, scale: f32) -> u32 {
    let bits = bitcast<u32>(vector) & 0x7fffffffu;
    if bits > 0x7f800000u {
        return 0u;
    }
    let steps = bitcast<f32>(bits) * scale;
    if bits == 0x7f800000u || steps >= f32(SPEEDS - 1u) {
        return SPEEDS - 1u;
    }
    return u32(steps);
}
#endif

fn fill(cell: u32, corner: vec2<i32>) {
    let at = vec2<i32>(i32(cell % WIDTH), i32(cell / WIDTH));
    let p = vec2<u32>(clamp(corner + at, vec2<i32>(0), vec2<i32>(params.size) - 1));
    let past = source(p);
    let b = before_at(past.xy);
    var doubt = past.z;
    if doubt == SURE && b.w == BAD {
        doubt = INVALID;
    }
#ifdef TRANSPARENTS
    let a = after_at(past.xy);
    if doubt == SURE && a.w == BAD {
        doubt = INVALID;
    }
#endif
#ifdef CHANNELS
    cells[cell] = (b.x & 0x7fffu) | ((b.y & 0x7fffu) << 15u) | (doubt << 30u);
    blues[cell] = (b.z & 0x7fffu) | ((b.w & 0x7fffu) << 15u);
#ifdef TRANSPARENTS
    cells_after[cell] = (a.x & 0x7fffu) | ((a.y & 0x7fffu) << 15u);
    blues_after[cell] = (a.z & 0x7fffu) | ((a.w & 0x7fffu) << 15u);
#endif
#else
    var word = (b.w & 0x7fffu) | (doubt << 30u);
#ifdef TRANSPARENTS
    word |= (a.w & 0x7fffu) << 15u;
#endif
    cells[cell] = word;
#endif
#ifdef MOTION
    let vector = textureLoad(motion, vec2<i32>(p), 0).xy;
    var speed = speed_index(vector.x, params.speed_scale.x) | (speed_index(vector.y, params.speed_scale.y) << 10u);
#ifdef FLAGS
    if (textureLoad(marks, vec2<i32>(p), 0).x & 1u) != 0u {
        speed = 0u;
    }
#endif
#ifdef BLUR
    let width = speed_index(textureLoad(blur, vec2<i32>(p), 0).x, 16.0);
    speed = max(speed & 1023u, width) | (max(speed >> 10u, width) << 10u);
#endif
    speeds[cell] = speed;
#endif
}

// Channels and luma of a cell, of the picture before (0) or after (1) transparents.
fn cell_at(cell: u32, picture: u32) -> vec4<u32> {
#ifdef CHANNELS
    var rg = cells[cell];
    var bl = blues[cell];
#ifdef TRANSPARENTS
    if picture == 1u {
        rg = cells_after[cell];
        bl = blues_after[cell];
    }
#endif
    return vec4<u32>(rg & 0x7fffu, (rg >> 15u) & 0x7fffu, bl & 0x7fffu, (bl >> 15u) & 0x7fffu);
#else
    return vec4<u32>((cells[cell] >> (picture * 15u)) & 0x7fffu);
#endif
}

fn apart(a: vec4<u32>, b: vec4<u32>) -> u32 {
    let d = max(a, b) - min(a, b);
#ifdef LARGEST_CHANNEL
    return max(d.x, max(d.y, d.z));
#else
#ifdef RGB
    return luma(d.xyz);
#else
    return d.w;
#endif
#endif
}

struct Sums {
    errors: vec2<u32>,
    luma: u32,
}

fn joined(sum: u32, a: vec4<u32>, b: vec4<u32>, sensitivity: u32) -> u32 {
#ifdef SOBEL
    // sums of four pixels each, two apart: eight steps from pixel to pixel
    var d = (apart(a, b) + 7u) >> 3u;
    let least = min(a.w, b.w) >> 2u;
#else
    var d = apart(a, b);
    let least = min(a.w, b.w);
#endif
#ifdef PAIRWISE
    let base = least + sensitivity;
    if d != 0u {
        d = select(min(((d << 10u) + max(base, 1u) - 1u) / max(base, 1u), 16383u), 16383u, base == 0u);
    }
#endif
#ifdef MEAN
    return sum + d;
#else
#ifdef NORM_LINF
    return max(sum, d);
#else
    return sum + d * d;
#endif
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
// Three cells in a line, the middle one twice.
fn side_of(middle: u32, apart: u32, picture: u32) -> vec4<u32> {
    return cell_at(middle - apart, picture) + 2u * cell_at(middle, picture) + cell_at(middle + apart, picture);
}
#endif

// Sums over the window whose upper left cell is given. Windows start at odd pixels.
fn sums_of(corner: u32, picture: u32) -> Sums {
    var sums = Sums(vec2<u32>(0u), 0u);
    var sensitivity = 0u;
#ifdef PAIRWISE
    var darkest = ONE;
    for (var i = 0u; i < 16u; i++) {
        darkest = min(darkest, cell_at(corner + (i >> 2u) * WIDTH + (i & 3u), picture).w);
    }
    let ramp = min(max(50u * darkest, 5u * ONE / 2u) - 5u * ONE / 2u, ONE);
    sensitivity = (params.sensitivity * (ONE - ramp)) >> 14u;
#endif
    for (var i = 0u; i < 16u; i++) {
        let x = i & 3u;
        let y = i >> 2u;
        let cell = corner + y * WIDTH + x;
        let here = cell_at(cell, picture);
        let taken = is_taken(x + 1u, y + 1u);
        sums.luma += here.w;
#ifdef SOBEL
        if (x == 1u || x == 2u) && (y == 1u || y == 2u) {
            sums.errors.x = joined(
                sums.errors.x, side_of(cell - 1u, WIDTH, picture), side_of(cell + 1u, WIDTH, picture), sensitivity);
            sums.errors.y = joined(
                sums.errors.y, side_of(cell - WIDTH, 1u, picture), side_of(cell + WIDTH, 1u, picture), sensitivity);
        }
#else
        if x < 3u && taken.x {
            sums.errors.x = joined(sums.errors.x, here, cell_at(cell + 1u, picture), sensitivity);
        }
        if y < 3u && taken.y {
            sums.errors.y = joined(sums.errors.y, here, cell_at(cell + WIDTH, picture), sensitivity);
        }
#endif
    }
    return sums;
}

struct Place {
    speed: vec2<u32>,
    // log2 of the previous rate
    previous: vec2<u32>,
    quad: vec2<u32>,
    shine: u32,
    noise: u32,
}

fn scaled(tolerance: u32, by: u32) -> u32 {
    return min((tolerance * by) >> 12u, 0xffffu);
}

fn tolerance_of(place: Place) -> u32 {
    var tolerance = params.tolerance;
#ifdef SAFE_AREA
    let at = place.quad * 2u;
    if any(at < vec2<u32>(params.safe_width)) || any(at + params.safe_width >= params.size) {
        tolerance = scaled(tolerance, params.safe_tolerance);
    }
#endif
#ifdef FOVEATION
    let d = abs(vec2<i32>(place.quad) * 2 - params.centre);
    let index = mul_high(u32(d.x * d.x + d.y * d.y), params.falloff_scale);
    tolerance = scaled(tolerance, tables[TABLE_FALLOFF + min(index, FALLOFF - 1u)]);
#endif
#ifdef MATERIALS
    let speed = max(place.speed.x, place.speed.y);
    if speed < params.material_slow {
        let most = (FACTOR_ONE - params.material_least) * (place.shine >> 4u) / 4064u;
        let slow = most * (params.material_slow - speed) / params.material_slow;
        tolerance = scaled(tolerance, FACTOR_ONE - min(slow, FACTOR_ONE));
    }
#endif
    return tolerance;
}

fn factor_of(factors: vec4<u32>, previous: u32) -> u32 {
    return factors[min(previous, 2u)];
}

fn is_below(error: u32, b: u32, base: u32, tolerance: u32, factor: u32) -> bool {
    let t = times_below(times_below(times_below(below(base), below(params.threshold)), below(tolerance)), below(factor));
    let be = times_above(above(b), above(error));
#ifdef NORM_L1
    return is_less(Mag(be.m, be.e + 27), times_below(t, below(#{PAIRS}u)));
#else
#ifdef NORM_LINF
    return is_less(Mag(be.m, be.e + 27), t);
#else
    let square = times_above(times_above(above(b), above(b)), above(error));
    return is_less(Mag(square.m, square.e + i32(#{SQUARE_SHIFT}u)), times_below(times_below(t, t), below(#{PAIRS}u)));
#endif
#endif
}

fn log_on(error: u32, speed: u32, base: u32, tolerance: u32, previous: u32, largest: u32) -> u32 {
    let entry = tables[TABLE_SPEEDS + speed];
    if !is_below(error, entry & 0xffffu, base, tolerance, factor_of(params.half, previous)) {
        return 0u;
    }
    let is_quarter = is_below(error, entry >> 16u, base, tolerance, factor_of(params.quarter, previous));
    return min(select(1u, 2u, is_quarter), largest);
}

fn legal(logs: vec2<u32>) -> vec2<u32> {
    return select(logs, min(logs, vec2<u32>(1u)), logs.yx == vec2<u32>(0u));
}

fn logs_of(sums: Sums, place: Place, tolerance: u32) -> vec2<u32> {
    let largest = vec2<u32>(params.largest >> 2u, params.largest & 3u);
#ifdef STANDALONE
    let across = tables[TABLE_SPEEDS + place.speed.x];
    let down = tables[TABLE_SPEEDS + place.speed.y];
    let h = vec2<u32>(across, down) & vec2<u32>(1u);
    return min(h + (h & (vec2<u32>(across, down) >> vec2<u32>(16u))), largest);
#else
#ifdef LADDER
    let step = max(tables[TABLE_SPEEDS + place.speed.x], tables[TABLE_SPEEDS + place.speed.y]) & 0xffffu;
    // 1x1, 2x1, 2x2, 4x2, 4x4
    let code = (0xa9540u >> (min(step, 4u) * 4u)) & 15u;
    return min(vec2<u32>(code >> 2u, code & 3u), largest);
#else
#ifdef PAIRWISE
    let base = ONE;
#else
#ifdef ABSOLUTE
    let base = 16u * ONE;
#else
    let base = sums.luma + 16u * params.ambient;
#endif
#endif
    return vec2<u32>(
        log_on(sums.errors.x, place.speed.x, base, tolerance, place.previous.x, largest.x),
        log_on(sums.errors.y, place.speed.y, base, tolerance, place.previous.y, largest.y),
    );
#endif
#endif
}

struct Quad {
    rate: vec2<u32>,
    attachment: vec2<u32>,
    reason: u32,
    error: vec2<u32>,
}

fn full(reason: u32) -> Quad {
    return Quad(vec2<u32>(0u), vec2<u32>(0u), reason, vec2<u32>(0u));
}

// A byte of 0 to 1.
fn byte_of(value: f32) -> u32 {
    return min(u32(value * 255.0 + 0.5), 255u);
}

// The pixel i of a quad; at the border, pixels repeat.
fn own(quad: vec2<u32>, i: u32) -> vec2<i32> {
    return vec2<i32>(min(quad * 2u + vec2<u32>(i & 1u, i >> 1u), params.size - 1u));
}

fn decide(quad: vec2<u32>, corner: u32) -> Quad {
    if params.has_history == 0u {
        return full(REASON_NO_HISTORY);
    }
    var lost = 0u;
    var is_invalid = false;
    var speed = vec2<u32>(SPEEDS);
    for (var i = 0u; i < 16u; i++) {
        let cell = corner + (i >> 2u) * WIDTH + (i & 3u);
        let doubt = cells[cell] >> 30u;
        is_invalid = is_invalid || doubt == INVALID;
        if lost == 0u && doubt >= OFF_SCREEN {
            lost = doubt;
        }
#ifdef MOTION
        speed = min(speed, vec2<u32>(speeds[cell] & 1023u, speeds[cell] >> 10u));
#endif
    }
    if lost != 0u {
        return full(lost + REASON_OF_DOUBT);
    }
    if is_invalid {
        return full(INVALID + REASON_OF_DOUBT);
    }
#ifndef MOTION
    speed = vec2<u32>(0u);
#endif
    var flagged = 0u;
    var place = Place(speed, vec2<u32>(0u), quad, 0u, 255u);
#ifdef FLAGS
    for (var i = 0u; i < 4u; i++) {
        flagged |= textureLoad(marks, own(quad, i), 0).x;
    }
    if (flagged & 4u) != 0u {
        return full(REASON_MASK);
    }
#endif
#ifdef PREVIOUS_RATES
    let past = source(vec2<u32>(own(quad, 0u))).xy >> vec2<u32>(1u);
    let word = rates_before[past.y * params.previous_pitch + (past.x >> 2u)];
    let had = extractBits(word, (past.x & 3u) * 8u, 8u);
    if had <= 10u && ((0x673u >> had) & 1u) != 0u {
        place.previous = vec2<u32>(had >> 2u, had & 3u);
    }
#endif
#ifdef MATERIALS
    for (var i = 0u; i < 4u; i++) {
        let surface = textureLoad(materials, own(quad, i), 0).xy;
        place.shine = max(place.shine, byte_of(surface.x) * byte_of(surface.y));
    }
    if place.shine >= params.material_mirror {
        return full(REASON_MATERIAL);
    }
#endif
#ifdef NOISE
    place.noise = 0u;
    for (var i = 0u; i < 4u; i++) {
        place.noise = max(place.noise, byte_of(textureLoad(noise, own(quad, i), 0).x));
    }
#endif
    let tolerance = tolerance_of(place);
    let sums = sums_of(corner, 0u);
    let solid = legal(logs_of(sums, place, tolerance));
    var out = Quad(solid, solid, REASON_CONTENT, sums.errors);
#ifdef TRANSPARENTS
    out.attachment = legal(logs_of(sums_of(corner, 1u), place, tolerance));
    out.rate = max(solid, out.attachment);
#endif
#ifdef MOTION_ONLY
    out.reason = REASON_MOTION;
#endif
    if all(out.rate == vec2<u32>(params.largest >> 2u, params.largest & 3u)) {
        out.reason = 0u;
    }
#ifdef HALF_RATE
    let is_slow = any(speed < vec2<u32>(params.half_fast));
    if all(out.rate >= vec2<u32>(1u)) && is_slow && (flagged & 2u) == 0u && place.noise > 0u {
        let less = (FACTOR_ONE - params.half_tolerance) * place.noise / 255u;
        let second = logs_of(sums, place, scaled(tolerance, FACTOR_ONE - less));
        var met = legal(min(out.rate, second));
        if all(met == vec2<u32>(0u)) {
            met = select(vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), sums.errors.x >> 2u <= sums.errors.y >> 2u);
        }
        if any(met != out.rate) {
            out.reason = REASON_HALF_RATE;
        }
        out.rate = met;
    }
#endif
    return out;
}

// Whether a rate of 4 holds across and down for a block of four quads.
fn agreed(a: vec2<u32>, b: vec2<u32>, c: vec2<u32>, d: vec2<u32>, error: vec2<u32>) -> vec2<bool> {
    let least = min(min(a, b), min(c, d));
    var four = least == vec2<u32>(2u);
    four = four & (least.yx >= vec2<u32>(1u));
    if all(four) && params.largest != 10u {
        four.x = error.x <= error.y;
        four.y = !four.x;
    }
    return four;
}

fn code_of(logs: vec2<u32>, four: vec2<bool>) -> u32 {
    let held = select(min(logs, vec2<u32>(1u)), logs, four);
    return (held.x << 2u) | held.y;
}

@compute @workgroup_size(8, TILE_ROWS)
fn analyse(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let origin = group.xy * vec2<u32>(64u, TILE_ROWS * 4u);
    for (var cell = index; cell < CELLS; cell += 8u * TILE_ROWS) {
        fill(cell, vec2<i32>(origin) - 1);
    }
    workgroupBarrier();

    let quads = (params.size + 1u) / 2u;
    let first = (origin + local.xy * vec2<u32>(8u, 4u)) / 2u;
    if any(first >= quads) {
        return;
    }
    var words = vec2<u32>(0u);
    var words_after = vec2<u32>(0u);
    var words_why = vec2<u32>(0u);
    for (var block = 0u; block < 2u; block++) {
        var four: array<Quad, 4>;
        var error = vec2<u32>(0u);
        for (var i = 0u; i < 4u; i++) {
            let at = vec2<u32>(block * 2u + (i & 1u), i >> 1u);
            let quad = first + at;
            four[i] = full(0u);
            if all(quad < quads) {
                let cell = (local.xy * vec2<u32>(8u, 4u) + at * 2u);
                four[i] = decide(quad, cell.y * WIDTH + cell.x);
                error += four[i].error >> vec2<u32>(2u);
            }
        }
        let holds = agreed(four[0].rate, four[1].rate, four[2].rate, four[3].rate, error);
        let holds_after = agreed(
            four[0].attachment, four[1].attachment, four[2].attachment, four[3].attachment, error);
        for (var i = 0u; i < 4u; i++) {
            let shift = (block * 2u + (i & 1u)) * 8u;
            words[i >> 1u] |= code_of(four[i].rate, holds) << shift;
            words_after[i >> 1u] |= code_of(four[i].attachment, holds_after) << shift;
            words_why[i >> 1u] |= four[i].reason << shift;
        }
    }
    let to = first.y * params.sri_pitch + (first.x >> 2u);
    let has_second = first.y + 1u < quads.y;
    rates[to] = words.x;
    if has_second {
        rates[to + params.sri_pitch] = words.y;
    }
#ifdef ATTACHMENT
    attachment[to] = words_after.x;
    if has_second {
        attachment[to + params.sri_pitch] = words_after.y;
    }
#endif
#ifdef REASONS
    reasons[to] = words_why.x;
    if has_second {
        reasons[to + params.sri_pitch] = words_why.y;
    }
#endif
}

#ifdef WRITE_LUMA
// round(255 sqrt(luma / white)): the root is guessed in float, and made exact in integers.
fn sqrt_code(value: u32) -> u32 {
    let square = (min(value, ONE) * 260100u) >> 14u;
    let guess = u32(sqrt(f32(square)) * 0.5 + 0.5);
    let more = select(0u, 1u, (2u * guess + 1u) * (2u * guess + 1u) <= square);
    let odd = max(2u * guess, 1u) - 1u;
    let less = select(0u, 1u, guess > 0u && odd * odd > square);
    return guess + more - less;
}

// An invocation makes one word: four pixels of the previous picture, after transparents if they are told apart.
@compute @workgroup_size(16, 16)
fn write_luma(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x * 4u >= params.previous.x || id.y >= params.previous.y {
        return;
    }
    var word = 0u;
    for (var i = 0u; i < 4u; i++) {
        let p = vec2<u32>(id.x * 4u + i, id.y);
        if p.x < params.previous.x {
#ifdef TRANSPARENTS
            let value = after_at(p).w;
#else
            let value = before_at(p).w;
#endif
            // what has no luma is white, which does not hide
            word |= select(sqrt_code(value), 255u, value == BAD) << (i * 8u);
        }
    }
    sqrt_luma[id.y * params.luma_pitch + id.x] = word;
}
#endif
