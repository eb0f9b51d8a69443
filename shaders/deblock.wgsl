// The deblocker: one invocation for 4×2 pixels, which is two quads, and one word of luma for each row.
//
// src/deblock/mod.rs argues where the taps lie and why no two invocations race; src/deblock/cpu.rs is the twin. What nobody asked for
// is not compiled. `filter_quads` writes the picture, or the scratch texture where the picture cannot be read and written at
// once; `return_quads` then takes what was filtered back from there.

struct Params {
    extent: vec2<u32>,
    // Words in a row of the effective rates, and of the luma.
    rates_pitch: u32,
    luma_pitch: u32,
    // 0 if the first pixel of a group is always its primary, else 1 + the frame's number modulo 4.
    phase: u32,
    // Pixels in a row of a picture in a buffer.
    picture_pitch: u32,
    // Inverse depth is this factor times what the texture holds, plus this.
    inverse_depth: vec2<f32>,
    // How far from a plane is still in it, relative to inverse depth.
    tolerance: f32,
    // White of the luma, as a power of two.
    white_log: i32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> rates: array<u32>;

#ifdef SCRATCH
@group(0) @binding(2) var picture: texture_2d<f32>;
#ifdef RGBA8
@group(0) @binding(3) var result: texture_storage_2d<rgba8unorm, write>;
#endif
#ifdef RGBA16
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;
#endif
#ifdef RGBA32
@group(0) @binding(3) var result: texture_storage_2d<rgba32float, write>;
#endif
#ifdef RG11B10
@group(0) @binding(3) var result: texture_storage_2d<rg11b10ufloat, write>;
#endif
#endif

#ifdef IN_PLACE
#ifdef RGBA8
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, read_write>;
#endif
#ifdef RGBA16
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, read_write>;
#endif
#ifdef RGBA32
@group(0) @binding(2) var picture: texture_storage_2d<rgba32float, read_write>;
#endif
#ifdef RG11B10
@group(0) @binding(2) var picture: texture_storage_2d<rg11b10ufloat, read_write>;
#endif
#endif

#ifdef R32UINT
@group(0) @binding(2) var picture: texture_storage_2d<r32uint, read_write>;
#endif

#ifdef BUFFER
@group(0) @binding(2) var<storage, read_write> picture: array<u32>;
#endif

#ifdef DEPTH
@group(0) @binding(4) var depth: texture_2d<f32>;
#endif
#ifdef SURFACES
@group(0) @binding(5) var surfaces: texture_2d<u32>;
#endif
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

// ---- The picture ----

#ifdef PACKED_RGBA8
fn unpack(word: u32) -> vec4<f32> {
    return unpack4x8unorm(word);
}

fn pack(color: vec4<f32>) -> u32 {
    return pack4x8unorm(color);
}
#endif

#ifdef PACKED_RG11B10
// Small floats are halves without a sign and with fewer bits of mantissa.
fn unpack(word: u32) -> vec4<f32> {
    let rg = unpack2x16float(((word & 0x7ffu) << 4u) | ((word & 0x3ff800u) << 9u));
    let b = unpack2x16float((word >> 22u) << 5u);
    return vec4<f32>(rg, b.x, 1.0);
}

// A half without its sign to one with `drop` fewer bits, to the nearest, ties to even; what is too large becomes the
// largest, and infinity and NaN stay what they are.
fn shorten(bits: u32, drop: u32) -> u32 {
    if bits > 0x7fffu {
        // negative: there is no such thing
        return select(0u, 0x7fffu >> drop, (bits & 0x7fffu) > 0x7c00u);
    }
    if bits >= 0x7c00u {
        return select(0x7c00u, 0x7fffu, bits > 0x7c00u) >> drop;
    }
    let rounded = (bits + (1u << (drop - 1u)) - 1u + ((bits >> drop) & 1u)) >> drop;
    return min(rounded, (0x7c00u >> drop) - 1u);
}

fn pack(color: vec4<f32>) -> u32 {
    let rg = pack2x16float(color.rg);
    let b = pack2x16float(vec2<f32>(color.b, 0.0));
    return shorten(rg & 0xffffu, 4u) | (shorten(rg >> 16u, 4u) << 11u) | (shorten(b & 0xffffu, 5u) << 22u);
}
#endif

fn load(at: vec2<u32>) -> vec4<f32> {
#ifdef SCRATCH
    return textureLoad(picture, at, 0);
#endif
#ifdef IN_PLACE
    return textureLoad(picture, at);
#endif
#ifdef R32UINT
    return unpack(textureLoad(picture, at).r);
#endif
#ifdef BUFFER
    let index = at.y * params.picture_pitch + at.x;
#ifdef ONE_WORD
    return unpack(picture[index]);
#endif
#ifdef TWO_WORDS
    return vec4<f32>(unpack2x16float(picture[index * 2u]), unpack2x16float(picture[index * 2u + 1u]));
#endif
#ifdef FOUR_WORDS
    return vec4<f32>(
        bitcast<f32>(picture[index * 4u]),
        bitcast<f32>(picture[index * 4u + 1u]),
        bitcast<f32>(picture[index * 4u + 2u]),
        bitcast<f32>(picture[index * 4u + 3u]),
    );
#endif
#endif
}

fn store(at: vec2<u32>, color: vec4<f32>) {
#ifdef SCRATCH
    textureStore(result, at, color);
#endif
#ifdef IN_PLACE
    textureStore(picture, at, color);
#endif
#ifdef R32UINT
    textureStore(picture, at, vec4<u32>(pack(color), 0u, 0u, 0u));
#endif
#ifdef BUFFER
    let index = at.y * params.picture_pitch + at.x;
#ifdef ONE_WORD
    picture[index] = pack(color);
#endif
#ifdef TWO_WORDS
    picture[index * 2u] = pack2x16float(color.rg);
    picture[index * 2u + 1u] = pack2x16float(color.ba);
#endif
#ifdef FOUR_WORDS
    // alpha keeps its place
    picture[index * 4u] = bitcast<u32>(color.r);
    picture[index * 4u + 1u] = bitcast<u32>(color.g);
    picture[index * 4u + 2u] = bitcast<u32>(color.b);
#endif
#endif
}

// ---- Rates ----

// The byte of a quad, full rate outside the picture or if it is no code; bit 7 if coverage split its block.
fn byte_of(quad: vec2<u32>) -> u32 {
    if any(quad * 2u >= params.extent) {
        return 0u;
    }
    let word = rates[quad.y * params.rates_pitch + (quad.x >> 2u)];
    let byte = extractBits(word, (quad.x & 3u) * 8u, 8u);
    let code = byte & 15u;
    // 1x1, 1x2, 2x1, 2x2, 2x4, 4x2 and 4x4
    let is_rate = code <= 10u && ((0x673u >> code) & 1u) != 0u && (byte & 0x70u) == 0u;
    return select(0u, byte, is_rate && code != 0u);
}

// The width and height of a quad's groups, as powers of two, and whether coverage split its block.
fn rate_of(quad: vec2<u32>) -> vec3<u32> {
    let byte = byte_of(quad);
    var rate = vec2<u32>((byte >> 2u) & 3u, byte & 3u);
    let split = byte >> 7u;
    if any(rate > vec2<u32>(1u)) {
        let block = quad & vec2<u32>(~1u);
        let agreed = split == 0u
            && byte_of(block) == byte
            && byte_of(block + vec2<u32>(1u, 0u)) == byte
            && byte_of(block + vec2<u32>(0u, 1u)) == byte
            && byte_of(block + vec2<u32>(1u, 1u)) == byte;
        if !agreed {
            rate = min(rate, vec2<u32>(1u));
        }
    }
    return vec3<u32>(rate, split);
}

// Where the value of a pixel's group was computed. No invocation ever writes there.
fn sample_of(pixel: vec2<u32>, rate: vec2<u32>) -> vec2<u32> {
    let corner = (pixel >> rate) << rate;
    var offset = vec2<u32>(0u);
    if params.phase != 0u {
        let odd = (params.phase - 1u) & 1u;
        if all(rate == vec2<u32>(1u, 0u)) {
            offset.x = (pixel.y + odd) & 1u;
        } else if all(rate == vec2<u32>(0u, 1u)) {
            offset.y = (pixel.x + odd) & 1u;
        } else {
            offset = odd * ((vec2<u32>(1u) << rate) - 1u);
        }
    }
    return min(corner + offset, params.extent - 1u);
}

// ---- What may blend ----

fn is_finite(color: vec4<f32>) -> bool {
    return all((bitcast<vec3<u32>>(color.rgb) & vec3<u32>(0x7f800000u)) != vec3<u32>(0x7f800000u));
}

// Whether differences of it cannot overflow: finite, and below 2^126.
fn is_usable(color: vec4<f32>) -> bool {
    return all((bitcast<vec3<u32>>(color.rgb) & vec3<u32>(0x7f800000u)) < vec3<u32>(0x7e800000u));
}

fn is_same(a: vec4<f32>, b: vec4<f32>) -> bool {
    return all(bitcast<vec4<u32>>(a) == bitcast<vec4<u32>>(b));
}

#ifdef DEPTH
fn inverse_at(at: vec2<i32>) -> f32 {
    let inside = clamp(at, vec2<i32>(0), vec2<i32>(params.extent) - 1);
    let value = textureLoad(depth, inside, 0).r;
#ifdef LINEAR
    return select(0.0, 1.0 / value, value > 0.0);
#else
    return params.inverse_depth.x * value + params.inverse_depth.y;
#endif
}

// The slope of inverse depth along an axis: the smaller difference to either side, at the border the only one.
fn slope_at(at: vec2<i32>, here: f32, axis: vec2<i32>) -> f32 {
    let back = here - inverse_at(at - axis);
    let ahead = inverse_at(at + axis) - here;
    let has_back = all((at - axis) >= vec2<i32>(0));
    let has_ahead = all((at + axis) < vec2<i32>(params.extent));
    return select(ahead, back, has_back && (!has_ahead || abs(back) < abs(ahead)));
}

// Whether a pixel lies in the plane through another.
fn is_in_plane(origin: vec2<i32>, goal: vec2<i32>) -> bool {
    let here = inverse_at(origin);
    let there = inverse_at(goal);
    let delta = vec2<f32>(goal - origin);
    var expected = 0.0;
    if delta.x != 0.0 {
        expected += slope_at(origin, here, vec2<i32>(1, 0)) * delta.x;
    }
    if delta.y != 0.0 {
        expected += slope_at(origin, here, vec2<i32>(0, 1)) * delta.y;
    }
    return abs((there - here) - expected) <= here * params.tolerance;
}
#endif

// Whether a pixel and a tap show one surface.
fn is_one_surface(pixel: vec2<u32>, tap: vec2<u32>) -> bool {
    var is_one = true;
#ifdef SURFACES
    is_one = textureLoad(surfaces, pixel, 0).r == textureLoad(surfaces, tap, 0).r;
#endif
#ifdef DEPTH
    let a = vec2<i32>(pixel);
    let b = vec2<i32>(tap);
    is_one = is_one && is_in_plane(a, b) && is_in_plane(b, a);
#endif
    return is_one;
}

// ---- The filter ----

struct Tap {
    at: vec2<u32>,
    is_inside: bool,
}

// The sample of the group that a pixel lies in; none outside the picture.
fn tap_at(pixel: vec2<i32>) -> Tap {
    if any(pixel < vec2<i32>(0)) || any(pixel >= vec2<i32>(params.extent)) {
        return Tap(vec2<u32>(0u), false);
    }
    let at = vec2<u32>(pixel);
    return Tap(sample_of(at, rate_of(at / 2u).xy), true);
}

// The value of a tap as seen from a pixel: the pixel's own where the tap shows another surface, or is not to be used.
fn tapped(pixel: vec2<u32>, own: vec4<f32>, tap: Tap) -> vec4<f32> {
    if !tap.is_inside {
        return own;
    }
    let value = load(tap.at);
    if !is_usable(value) || !is_one_surface(pixel, tap.at) {
#ifdef COUNTERS
        atomicAdd(&counters[C_REFUSED], 1u);
#endif
        return own;
    }
    return value;
}

// How much of the way from the own sample to a tap's lies behind a pixel.
fn weight(pixel: u32, own: u32, tap: u32) -> f32 {
    return abs(f32(i32(pixel) - i32(own))) / max(abs(f32(i32(tap) - i32(own))), 1.0);
}

// The value of a pixel of a coarse group. `is_active` tells along which axes it holds a copy.
fn filtered(
    pixel: vec2<u32>,
    rate: vec2<u32>,
    origin: vec2<u32>,
    own: vec4<f32>,
    is_active: vec2<bool>,
) -> vec4<f32> {
    let corner = vec2<i32>((pixel >> rate) << rate);
    let end = corner + vec2<i32>(vec2<u32>(1u) << rate);
    // the nearest pixel beyond the group, on the side on which this pixel lies from its sample
    let beyond = select(corner - 1, end, pixel > origin);
    let base = vec2<i32>(select(pixel, origin, is_active));

    var across = own;
    var down = own;
    var part = vec2<f32>(0.0);
    if is_active.x {
        let tap = tap_at(vec2<i32>(beyond.x, base.y));
        if tap.is_inside {
            part.x = weight(pixel.x, origin.x, tap.at.x);
        }
        across = tapped(pixel, own, tap);
    }
    if is_active.y {
        let tap = tap_at(vec2<i32>(base.x, beyond.y));
        if tap.is_inside {
            part.y = weight(pixel.y, origin.y, tap.at.y);
        }
        down = tapped(pixel, own, tap);
    }
    var diagonal = own;
    if all(is_active) {
        diagonal = tapped(pixel, own, tap_at(beyond));
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

// The square root of the luma (Eq. 25), 8 bits; see fixed::sqrt_code. What is not finite differs from all its neighbours, so
// that it asks for full rate.
fn luma_code(color: vec4<f32>, at: vec2<u32>) -> u32 {
    if !is_finite(color) {
        return ((at.x + at.y) & 1u) * 255u;
    }
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
#endif

// Whether a filter may write a pixel.
fn is_written(pixel: vec2<u32>, rate: vec2<u32>) -> bool {
    return all(pixel < params.extent) && any(pixel != sample_of(pixel, rate));
}

@compute @workgroup_size(8, 8)
fn filter_quads(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = id.xy * vec2<u32>(4u, 2u);
    if any(first >= params.extent) {
        return;
    }
#ifdef LUMA
    var words = vec2<u32>(0u);
#endif
    for (var side = 0u; side < 2u; side++) {
        let quad = first / 2u + vec2<u32>(side, 0u);
        let rate = rate_of(quad);
        let is_coarse = any(rate.xy != vec2<u32>(0u));
#ifndef LUMA
        if !is_coarse {
            continue;
        }
#endif
        var values: array<vec4<f32>, 4>;
        for (var i = 0u; i < 4u; i++) {
            let pixel = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
            // a pixel outside repeats one inside; it is never written
            values[i] = load(min(pixel, params.extent - 1u));
        }
        for (var i = 0u; i < 4u; i++) {
            let pixel = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
            var value = values[i];
            if is_coarse && all(pixel < params.extent) {
#ifdef COUNTERS
                if !is_finite(value) {
                    atomicAdd(&counters[C_NOT_FINITE], 1u);
                }
#endif
                let origin = sample_of(pixel, rate.xy);
                var is_active = pixel != origin;
                if rate.z != 0u {
                    // coverage split the block: who shares is told by who is equal
                    is_active = is_active & vec2<bool>(is_same(value, values[i ^ 1u]), is_same(value, values[i ^ 2u]));
                }
                if any(is_active) && is_usable(value) {
                    value = filtered(pixel, rate.xy, origin, value, is_active);
#ifdef COUNTERS
                    atomicAdd(&counters[C_FILTERED], 1u);
#endif
                    store(pixel, value);
                }
#ifdef SCRATCH
                else if any(pixel != origin) {
                    store(pixel, value);
                }
#endif
            }
#ifdef LUMA
            if all(pixel < params.extent) {
                words[i >> 1u] |= luma_code(value, pixel) << ((side * 2u + (i & 1u)) * 8u);
            }
#endif
        }
    }
#ifdef LUMA
    luma[first.y * params.luma_pitch + id.x] = words.x;
    if first.y + 1u < params.extent.y {
        luma[(first.y + 1u) * params.luma_pitch + id.x] = words.y;
    }
#endif
}

#ifdef SCRATCH
// The way back: what `filter_quads` wrote goes from the scratch texture, which is bound as the picture here, to the picture.
@compute @workgroup_size(8, 8)
fn return_quads(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var side = 0u; side < 2u; side++) {
        let quad = id.xy * vec2<u32>(2u, 1u) + vec2<u32>(side, 0u);
        let rate = rate_of(quad).xy;
        if all(rate == vec2<u32>(0u)) {
            continue;
        }
        for (var i = 0u; i < 4u; i++) {
            let pixel = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
            if is_written(pixel, rate) {
                store(pixel, load(pixel));
            }
        }
    }
}
#endif
