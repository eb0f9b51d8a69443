// Bars that sweep past a patterned wall: what they uncover was not seen the frame before.

const STEPS: u32 = 60u;
const LIGHTS: u32 = 4u;
const SHADOWS: u32 = 1u;
const SHADOW_STEPS: u32 = 24u;
const REFLECTION_STEPS: u32 = 0u;
const OCCLUSION_RAYS: u32 = 3u;
const FOG: f32 = 0.0;
const GRAIN: f32 = 0.0;

const WALL: u32 = 1u;
const BAR: u32 = 2u;

fn place_of(bar: f32, time: f32) -> f32 {
    return bar * 1.7 + 0.9 * sin(time * (1.5 + bar * 0.4));
}

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    var hit = Hit(9.0 - p.z, WALL);
    for (var i = -1; i <= 1; i++) {
        let bar = f32(i);
        let q = p - vec3<f32>(place_of(bar, time), 0.0, 4.0 + 0.6 * bar);
        hit = nearer(hit, Hit(box_distance(q, vec3<f32>(0.28, 4.0, 0.1)) - 0.02, BAR + 8u * u32(i + 1)));
    }
    return hit;
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    if (surface & 7u) == BAR {
        let bar = f32(surface >> 3u) - 1.0;
        return p - vec3<f32>(place_of(bar, frame.time) - place_of(bar, frame.time_before), 0.0, 0.0);
    }
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    return 0u;
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    if (surface & 7u) == BAR {
        let stripe = 0.5 + 0.1 * sin(p.y * 3.0);
        return Material(vec3<f32>(0.7, 0.45, 0.2) * stripe, 0.0, 0.5, 0.0, 0.0);
    }
    let panel = floor(p.xy * 0.5);
    let fine = rough_noise(p.xy * 14.0, 4u);
    let check = f32((i32(floor(p.x * 9.0)) + i32(floor(p.y * 9.0))) & 1);
    let plain = chance_at(vec2<i32>(panel));
    let shade = select(select(0.45, 0.25 + 0.5 * fine, plain > 0.35), 0.2 + 0.6 * check, plain > 0.7);
    return Material(vec3<f32>(shade, shade * 0.9, shade * 0.8), 0.0, 0.9, 0.0, 0.0);
}

fn scene_light(i: u32) -> Light {
    return Light(vec3<f32>(-4.5 + 3.0 * f32(i), 3.0, 1.0), 16.0, vec3<f32>(14.0));
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.35, 0.4, 0.45);
}
