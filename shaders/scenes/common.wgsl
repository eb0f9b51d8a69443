// What every scene shares: the frame, the camera, the G-buffer, noise and distances.
//
// A scene is this file, a file of its own that says what stands in it, and passes.wgsl, which shades it. A frame is made by
// compute passes alone: `geometry` stands for rasterisation and runs for every pixel; the passes after it are ordinary
// compute shaders, one invocation a pixel, and are made variable-rate by the rewriter.

struct Camera {
    // Where it stands.
    position: vec3<f32>,
    near: f32,
    // Unit vectors, and how far the picture reaches along them at distance 1.
    right: vec3<f32>,
    reach_x: f32,
    up: vec3<f32>,
    reach_y: f32,
    forward: vec3<f32>,
    far: f32,
}

struct Frame {
    // Width and height of the picture, in pixels.
    size: vec2<u32>,
    number: u32,
    seed: u32,
    // Seconds, of this frame and of the one before.
    time: f32,
    time_before: f32,
    camera: Camera,
    camera_before: Camera,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Surface id in the low half, 0 for the sky; triangle id in the high half.
@group(0) @binding(1) var ids_out: texture_storage_2d<r32uint, write>;
// near / distance along the view axis: 1 at the near plane, 0 at infinity, and affine on a plane.
@group(0) @binding(2) var depth_out: texture_storage_2d<r32float, write>;
// The surface's normal.
@group(0) @binding(3) var normal_out: texture_storage_2d<rgba16float, write>;
// Pixels that what is seen has moved since the frame before.
@group(0) @binding(4) var motion_out: texture_storage_2d<rg32float, write>;

@group(0) @binding(5) var ids: texture_2d<u32>;
@group(0) @binding(6) var depth: texture_2d<f32>;
@group(0) @binding(7) var normals: texture_2d<f32>;

// Colour, and how metallic.
@group(0) @binding(8) var albedo_out: texture_storage_2d<rgba8unorm, write>;
// Roughness, emission, translucency.
@group(0) @binding(9) var surface_out: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(10) var albedo: texture_2d<f32>;
@group(0) @binding(11) var surface: texture_2d<f32>;

@group(0) @binding(12) var light_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(13) var light: texture_2d<f32>;
// Ambient occlusion in alpha, reflected light in colour.
@group(0) @binding(14) var traced_out: texture_storage_2d<rgba16float, write>;
@group(0) @binding(15) var traced: texture_2d<f32>;
@group(0) @binding(16) var picture: texture_storage_2d<rgba8unorm, write>;

// Surface ids alone; smoothness and Rf0; see gbuffer.wgsl.
@group(0) @binding(17) var surfaces_out: texture_storage_2d<r32uint, write>;
@group(0) @binding(18) var materials_out: texture_storage_2d<rgba8unorm, write>;
// Where noise is.
@group(0) @binding(19) var noise_out: texture_storage_2d<r32float, write>;

const PI: f32 = 3.14159265;
const SKY: u32 = 0u;

// What a ray meets.
struct Hit {
    distance: f32,
    surface: u32,
}

// What a surface is made of, at a place.
struct Material {
    colour: vec3<f32>,
    metal: f32,
    roughness: f32,
    emission: f32,
    translucency: f32,
}

struct Light {
    position: vec3<f32>,
    radius: f32,
    colour: vec3<f32>,
}

fn hash_u32(value: u32) -> u32 {
    var v = value ^ (frame.seed * 0x9e3779b9u);
    v = (v ^ 61u) ^ (v >> 16u);
    v *= 9u;
    v ^= v >> 4u;
    v *= 0x27d4eb2du;
    return v ^ (v >> 15u);
}

// 0 to 1, from whole numbers.
fn chance(value: u32) -> f32 {
    return f32(hash_u32(value) >> 8u) / 16777216.0;
}

fn chance_at(cell: vec2<i32>) -> f32 {
    return chance(bitcast<u32>(cell.x) * 0x85ebca6bu ^ bitcast<u32>(cell.y) * 0xc2b2ae35u);
}

// Value noise, 0 to 1.
fn noise(p: vec2<f32>) -> f32 {
    let cell = vec2<i32>(floor(p));
    let t = smoothstep(vec2<f32>(0.0), vec2<f32>(1.0), fract(p));
    let low = mix(chance_at(cell), chance_at(cell + vec2<i32>(1, 0)), t.x);
    let high = mix(chance_at(cell + vec2<i32>(0, 1)), chance_at(cell + vec2<i32>(1, 1)), t.x);
    return mix(low, high, t.y);
}

// Noise over several octaves, 0 to 1.
fn rough_noise(p: vec2<f32>, octaves: u32) -> f32 {
    var sum = 0.0;
    var weight = 0.5;
    var at = p;
    for (var i = 0u; i < octaves; i++) {
        sum += weight * noise(at);
        at = mat2x2<f32>(1.6, 1.2, -1.2, 1.6) * at + 7.3;
        weight *= 0.5;
    }
    return sum;
}

fn nearer(a: Hit, b: Hit) -> Hit {
    if a.distance < b.distance {
        return a;
    }
    return b;
}

fn box_distance(p: vec3<f32>, half_size: vec3<f32>) -> f32 {
    let d = abs(p) - half_size;
    return length(max(d, vec3<f32>(0.0))) + min(max(d.x, max(d.y, d.z)), 0.0);
}

fn turn(p: vec2<f32>, angle: f32) -> vec2<f32> {
    let c = cos(angle);
    let s = sin(angle);
    return vec2<f32>(c * p.x - s * p.y, s * p.x + c * p.y);
}

// The direction of the ray through a place in the picture, in pixels; 1 long along the view axis.
fn ray(camera: Camera, at: vec2<f32>) -> vec3<f32> {
    let ndc = at / vec2<f32>(frame.size) * 2.0 - 1.0;
    return camera.forward + camera.right * (ndc.x * camera.reach_x) - camera.up * (ndc.y * camera.reach_y);
}

// Where a point is seen, in pixels; far outside if it is behind the camera.
fn seen_at(camera: Camera, point: vec3<f32>) -> vec2<f32> {
    let v = point - camera.position;
    let along = dot(v, camera.forward);
    if along < camera.near {
        return vec2<f32>(-1e6);
    }
    let ndc = vec2<f32>(
        dot(v, camera.right) / (along * camera.reach_x),
        -dot(v, camera.up) / (along * camera.reach_y),
    );
    return (ndc + 1.0) * 0.5 * vec2<f32>(frame.size);
}

// The place that a pixel shows.
fn point_of(pixel: vec2<u32>, inverse_depth: f32) -> vec3<f32> {
    let direction = ray(frame.camera, vec2<f32>(pixel) + 0.5);
    return frame.camera.position + direction * (frame.camera.near / max(inverse_depth, 1e-6));
}
