// The previous picture, before and after transparents: channels and luma of its pixels.
#define_import_path vrcs::analyse::pictures

#import vrcs::analyse::params::{params, tables, before}
#import vrcs::analyse::fixed::{luma, quantise, BAD}

#ifdef SQRT_LUMA
#ifdef LINES
@group(0) @binding(3) var<storage, read> colour: array<vec2<u32>>;
#else
@group(0) @binding(3) var<storage, read> colour: array<u32>;
#endif
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

#ifdef CODES
// Linear light of codes. In workgroup memory, since neighbours look up different codes, and a cache answers them one after another.
var<workgroup> codes: array<u32, 256>;

// To be called by all `count` invocations of a workgroup, and followed by a barrier.
fn share_codes(index: u32, count: u32) {
    for (var code = index; code < 256u; code += count) {
        codes[code] = tables[code];
    }
}
#endif

#ifdef SQRT_LUMA
// fixed::sqrt_luma: code^2 * 16384 / 65025, rounded. The factor is 2^17 / 3.96887; exact for all 256 codes.
fn luma_of_codes(codes: vec3<u32>) -> vec3<u32> {
    let square = codes * codes;
    return (square * 33025u + (square >> vec3<u32>(1u)) + vec3<u32>(65536u)) >> vec3<u32>(17u);
}

#ifdef LINES
// The same, exact for all 256 codes as well, in two multiplications.
fn lumas_of(codes: vec4<u32>) -> vec4<u32> {
    return (codes * (codes * 33025u + 98u) + 64900u) >> vec4<u32>(17u);
}
#endif

fn code_in(word: u32, x: u32) -> u32 {
    return extractBits(word, (x & 3u) * 8u, 8u);
}

#ifndef LINES
// A word of a picture, before (0) or after (1) transparents.
fn word_at(at: u32, picture: u32) -> u32 {
#ifdef TRANSPARENTS
    if picture == 1u {
        return after[at];
    }
#endif
    return colour[at];
}

fn before_at(p: vec2<u32>) -> vec4<u32> {
    return luma_of_codes(vec3<u32>(code_in(colour[p.y * params.luma_pitch + (p.x >> 2u)], p.x))).xxxx;
}
#ifdef TRANSPARENTS
fn after_at(p: vec2<u32>) -> vec4<u32> {
    return luma_of_codes(vec3<u32>(code_in(after[p.y * params.luma_pitch + (p.x >> 2u)], p.x))).xxxx;
}
#endif
#endif
#else
// Channels and luma; BAD in the last for what is in doubt.
fn pixel_of(value: vec3<f32>) -> vec4<u32> {
#ifdef CODES
    // beside 2^21 a float has quarters left: a code's bits are the ten low ones but for two, to whichever side it is rounded
    let code = (bitcast<vec3<u32>>(value * 255.0 + vec3<f32>(2097152.25)) >> vec3<u32>(2u)) & vec3<u32>(255u);
    let c = vec3<u32>(codes[code.x], codes[code.y], codes[code.z]);
    return vec4<u32>(c, luma(c));
#else
    let c = vec3<u32>(
        quantise(value.x, params.white_log),
        quantise(value.y, params.white_log),
        quantise(value.z, params.white_log),
    );
    if any(c == vec3<u32>(BAD)) {
        return vec4<u32>(0u, 0u, 0u, BAD);
    }
    return vec4<u32>(c, luma(c));
#endif
}

fn before_at(p: vec2<u32>) -> vec4<u32> {
    return pixel_of(textureLoad(colour, before(p), 0).xyz);
}
#ifdef TRANSPARENTS
fn after_at(p: vec2<u32>) -> vec4<u32> {
    return pixel_of(textureLoad(after, before(p), 0).xyz);
}
#endif
#endif
