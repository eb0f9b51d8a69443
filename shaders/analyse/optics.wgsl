// What a camera and its lens tell of a pixel by its depth: how it moved, and how wide a depth of field will blur it. Its CPU twin is
// src/analyse/optics.rs.
#define_import_path vrcs::analyse::optics

#import vrcs::analyse::params::{params, SPEEDS}
#ifdef LENS
#import vrcs::depth::{inverse_distance, high_product, NO_DEPTH}
#endif

struct Optics {
    // From this frame's clip space to the previous frame's.
    reprojection: mat4x4<f32>,
    // The sign of w in the world, from this frame's clip space.
    world_w: vec4<f32>,
    // The inverse distance that is in focus, in 1/2^30.
    focus: u32,
    // Speed steps for one of these, in 1/2^30.
    blur_scale: u32,
    most_blur: u32,
    depth_offset: u32,
    reversed_z: u32,
}

@group(0) @binding(18) var<uniform> optics: Optics;

#ifdef CAMERA
// The bits of no number: what has no motion is in doubt, and stands still.
const NO_MOTION: u32 = 0x7fc00000u;

// The bits of the vector from where a surface was to where it is, in pixels. Both ways of depth: the matrices say which. This divides,
// so that drivers may differ by a step of the table of speeds.
fn camera_motion_at(centre: vec2<f32>, depth: f32) -> vec2<u32> {
    let bits = bitcast<u32>(depth);
    if bits != 0x80000000u && bits > 0x3f800000u {
        return vec2<u32>(NO_MOTION);
    }
    let size = vec2<f32>(params.size);
    // clip space has y up, pixels have y down
    let flat = centre / size * 2.0 - 1.0;
    let clip = vec4<f32>(flat.x, -flat.y, depth, 1.0);
    let before = optics.reprojection * clip;
    // the plane at infinity has w = 0 and still a place in the picture; only the sign of w before counts
    let w = before.w * select(1.0, -1.0, dot(optics.world_w, clip) < 0.0);
    // not above 0, infinite, or no number
    let sign_and_size = bitcast<u32>(w);
    if sign_and_size == 0u || sign_and_size >= 0x7f800000u {
        return vec2<u32>(NO_MOTION);
    }
    let place = before.xy / before.w;
    let was = (vec2<f32>(place.x, -place.y) + 1.0) / 2.0 * size;
    return bitcast<vec2<u32>>(centre - was);
}

// The same of a pixel.
fn camera_motion(p: vec2<u32>, depth: f32) -> vec2<u32> {
    return camera_motion_at(vec2<f32>(p) + 0.5, depth);
}
#endif

#ifdef LENS
// The width of the circle of confusion, as a speed that would blur as wide; what is no depth is sharp.
fn lens_blur(depth: f32) -> u32 {
    let inverse = inverse_distance(depth, optics.depth_offset, optics.reversed_z != 0u);
    let apart = min(max(inverse, optics.focus) - min(inverse, optics.focus), (1u << 30u) - 1u);
    let width = min(high_product(apart << 2u, optics.blur_scale), optics.most_blur);
    return select(width, 0u, inverse == NO_DEPTH);
}
#endif
