// A test chart: smooth ramps at many slopes, and edges between colours of one luma. The first is where an estimator that watches
// its own output oscillates, the second what luma cannot see.

const STEPS: u32 = 24u;
const LIGHTS: u32 = 1u;
const SHADOWS: u32 = 0u;
const SHADOW_STEPS: u32 = 1u;
const FOG: f32 = 0.0;
const GRAIN: f32 = 0.0;

const CHART: u32 = 1u;

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    return Hit(4.0 - p.z, CHART);
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    return 0u;
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    let at = p.xy + vec2<f32>(frame.time * 0.05, 0.0);
    let row = floor(at.y * 2.0);
    let along = fract(at.x * exp2(clamp(row + 3.0, 0.0, 6.0)) * 0.12);
    let ramp = abs(along * 2.0 - 1.0);
    if row < 1.0 {
        return Material(vec3<f32>(ramp * ramp), 0.0, 1.0, 0.0, 0.0);
    }
    // red and green, or blue and grey, of one luma (Eq. 25)
    let square = (i32(floor(at.x * 4.0)) + i32(floor(at.y * 4.0))) & 1;
    var a = vec3<f32>(0.587, 0.0, 0.0);
    var b = vec3<f32>(0.0, 0.299, 0.0);
    if at.x > 0.0 {
        a = vec3<f32>(0.0, 0.0, 0.9);
        b = vec3<f32>(0.1026);
    }
    return Material(select(a, b, square == 0), 0.0, 1.0, 0.0, 0.0);
}

fn scene_light(i: u32) -> Light {
    return Light(vec3<f32>(0.0, 0.0, -60.0), 1e4, vec3<f32>(12500.0));
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.2);
}
