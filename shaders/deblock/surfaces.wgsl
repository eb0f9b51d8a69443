// What may blend: values that can be subtracted, and pixels of one surface.
#define_import_path vrcs::deblock::surfaces

#import vrcs::deblock::params::params

#ifdef DEPTH
@group(0) @binding(4) var depth: texture_2d<f32>;
#endif
#ifdef SURFACES
@group(0) @binding(5) var surfaces: texture_2d<u32>;
#endif
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
    let value = textureLoad(depth, inside + vec2<i32>(params.origin), 0).r;
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
    is_one = textureLoad(surfaces, pixel + params.origin, 0).r == textureLoad(surfaces, tap + params.origin, 0).r;
#endif
#ifdef DEPTH
    let a = vec2<i32>(pixel);
    let b = vec2<i32>(tap);
    is_one = is_one && is_in_plane(a, b) && is_in_plane(b, a);
#endif
    return is_one;
}
