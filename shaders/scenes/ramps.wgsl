// A test chart: smooth ramps at many slopes, across, down and aslant, and edges between colours of one luma. The first is where an estimator that watches
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
    let at = p.xy + frame.time * vec2<f32>(0.05, 0.03);
    let row = floor(p.y * 2.0);
    // a third of the chart for each direction
    var place = (at.x + at.y) * 0.70710678;
    if p.x < -1.2 {
        place = at.x;
    } else if p.x < 1.2 {
        place = at.y;
    }
    let along = fract(place * exp2(clamp(row + 3.0, 0.0, 6.0)) * 0.12);
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
