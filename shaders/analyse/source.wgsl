// Where a pixel comes from, whether that is known, and how fast it moves.
#define_import_path vrcs::analyse::source

#import vrcs::analyse::params::{params, SPEEDS, here, before}
#import vrcs::depth::{high_product, inverse_distance, NO_DEPTH}
#ifdef OPTICS
#import vrcs::analyse::optics
#endif

#ifdef VECTORS
@group(0) @binding(7) var motion: texture_2d<f32>;
#endif
#ifdef DEPTH_NOW
@group(0) @binding(8) var depth: texture_2d<f32>;
#endif
#ifdef DEPTH
@group(0) @binding(9) var depth_before: texture_2d<f32>;
#endif
#ifdef FLAGS
@group(0) @binding(13) var marks: texture_2d<u32>;
#endif
#ifdef BLUR
// how wide a later blur is, in pixels
@group(0) @binding(15) var blur: texture_2d<f32>;
#endif

// Doubt.
const SURE: u32 = 0u;
const NO_MOTION: u32 = 1u;
const OFF_SCREEN: u32 = 2u;
const DISOCCLUDED: u32 = 3u;

// In 1/256 previous pixels, without motion.
fn position_of(p: vec2<u32>) -> vec2<u32> {
    let centre = p * 256u + 128u;
    if all(params.ratio == vec2<u32>(1u << 24u)) {
        return centre;
    }
    return vec2<u32>(high_product(centre.x << 8u, params.ratio.x), high_product(centre.y << 8u, params.ratio.y));
}

// The pixel of the previous picture that a pixel shows if nothing moves: each axis for itself.
fn still_source(p: vec2<u32>) -> vec2<u32> {
    return min(position_of(p) >> vec2<u32>(8u), params.previous - 1u);
}

// The same of three columns, and of a row.
fn still_columns(x: vec3<u32>) -> vec3<u32> {
    return vec3<u32>(
        still_source(vec2<u32>(x.x, 0u)).x,
        still_source(vec2<u32>(x.y, 0u)).x,
        still_source(vec2<u32>(x.z, 0u)).x,
    );
}

fn still_row(y: u32) -> u32 {
    return still_source(vec2<u32>(0u, y)).y;
}

#ifdef DEPTH
fn inverse_depth(value: f32) -> u32 {
    return inverse_distance(value, params.depth_offset, params.reversed_z != 0u);
}

fn is_hidden(now: u32, then: u32) -> bool {
    if now == NO_DEPTH || then == NO_DEPTH {
        return true;
    }
    return max(now, then) - min(now, then) > high_product(min(now, then), params.depth_tolerance << 16u);
}
#endif

#ifdef DEPTH
// Whether there was something nearer. What is no depth is in doubt.
fn was_covered(now: u32, then: u32) -> bool {
    if now == NO_DEPTH || then == NO_DEPTH {
        return true;
    }
    return then > now && is_hidden(now, then);
}
#endif

#ifdef CAMERA
// The bits of a pixel's motion; what does not move with the world stands still.
fn motion_at(p: vec2<u32>) -> vec2<u32> {
#ifdef FLAGS
    if (textureLoad(marks, here(p), 0).x & 1u) != 0u {
        return vec2<u32>(0u);
    }
#endif
    return optics::camera_motion(p, textureLoad(depth, here(p), 0).x);
}
#endif
#ifdef VECTORS
fn motion_at(p: vec2<u32>) -> vec2<u32> {
    return bitcast<vec2<u32>>(textureLoad(motion, here(p), 0).xy);
}
#endif

#ifdef MOTION
const INFINITE: u32 = 0x7f800000u;

// Whether a vector is no number.
fn is_lost_motion(vector: vec2<u32>) -> bool {
    return any((vector & vec2<u32>(0x7fffffffu)) > vec2<u32>(INFINITE));
}
#endif

#ifdef REPROJECTION
// The pixel of the previous picture that a pixel shows, and doubt.
fn moved_source(p: vec2<u32>) -> vec3<u32> {
    var position = vec2<i32>(position_of(p));
    var doubt = SURE;
    let vector = motion_at(p);
    let offset = bitcast<vec2<f32>>(vector) * params.offset_scale;
    // a magnitude below 2^23 surely is a number that fits
    if is_lost_motion(vector) {
        doubt = NO_MOTION;
    } else if any((bitcast<vec2<u32>>(offset) & vec2<u32>(0x7fffffffu)) >= vec2<u32>(0x4b000000u)) {
        doubt = OFF_SCREEN;
    } else {
        position += (vec2<i32>(floor(offset)) + 1) >> vec2<u32>(1u);
        if any(position < vec2<i32>(0)) || any((position >> vec2<u32>(8u)) >= vec2<i32>(params.previous)) {
            doubt = OFF_SCREEN;
        }
    }
    let past = min(vec2<u32>(max(position >> vec2<u32>(8u), vec2<i32>(0))), params.previous - 1u);
#ifdef DEPTH
    if doubt == SURE {
        let now = inverse_depth(textureLoad(depth, here(p), 0).x);
        let then = inverse_depth(textureLoad(depth_before, before(past), 0).x);
        if is_hidden(now, then) {
            doubt = DISOCCLUDED;
        }
    }
#endif
    return vec3<u32>(past, doubt);
}
#endif

#ifdef MOTION
// Whether a pixel has no known motion, and counts as standing still. What does not move with the world needs none.
fn is_lost_at(p: vec2<u32>) -> bool {
#ifdef FLAGS
    if (textureLoad(marks, here(p), 0).x & 1u) != 0u {
        return false;
    }
#endif
    return is_lost_motion(motion_at(p));
}

// The index of a speed whose magnitude has these bits. Without a branch: it is asked for every pixel of a window that is unrolled, and
// some compilers take gigabytes for so many ways.
fn speed_index(bits: u32, scale: f32) -> u32 {
    let steps = bitcast<f32>(bits) * scale;
    let is_fastest = (bits == INFINITE) | (steps >= f32(SPEEDS - 1u));
    return select(u32(steps), SPEEDS - 1u, is_fastest);
}

// The bits of magnitudes; no number stands still.
fn magnitudes(vector: vec2<u32>) -> vec2<u32> {
    let bits = vector & vec2<u32>(0x7fffffffu);
    return select(bits, vec2<u32>(0u), bits > vec2<u32>(INFINITE));
}

// What the least speed of pixels is found by: magnitudes of motion, which grow as speeds do, so that one speed of four need be worked
// out; or speeds, where the width of a blur has to be compared.
fn speed_key(p: vec2<u32>) -> vec2<u32> {
    var key = magnitudes(motion_at(p));
#ifdef FLAGS
    if (textureLoad(marks, here(p), 0).x & 1u) != 0u {
        key = vec2<u32>(0u);
    }
#endif
#ifdef BLURRED
    key = speeds_of(key);
#endif
#ifdef BLUR
    let width = speed_index(magnitudes(bitcast<vec2<u32>>(textureLoad(blur, here(p), 0).xx)).x, 16.0);
    key = max(key, vec2<u32>(width));
#endif
#ifdef LENS
    key = max(key, vec2<u32>(optics::lens_blur(textureLoad(depth, here(p), 0).x)));
#endif
    return key;
}

fn speeds_of(magnitude: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(
        speed_index(magnitude.x, params.speed_scale.x),
        speed_index(magnitude.y, params.speed_scale.y),
    );
}

// Speeds of a key.
fn speeds_of_key(key: vec2<u32>) -> vec2<u32> {
#ifdef BLURRED
    return key;
#else
    return speeds_of(key);
#endif
}
#endif
