// Hills under a wide sky with clouds and drifting fog, seen from a fast aircraft. On the ground nothing but the camera moves, so motion
// comes from depth and two matrices; large parts are sky; the haze is grainy.

const STEPS: u32 = 150u;
const LIGHTS: u32 = 1u;
const SHADOWS: u32 = 1u;
const SHADOW_STEPS: u32 = 28u;
const FOG: f32 = 0.010;
const GRAIN: f32 = 0.05;

const LAND: u32 = 1u;
const LAKE: u32 = 2u;
const TOWER: u32 = 3u;

fn height(p: vec2<f32>) -> f32 {
    let hills = rough_noise(p * 0.035, 5u);
    return 14.0 * hills * hills + 2.0 * noise(p * 0.11) - 3.0;
}

const SUN: vec3<f32> = vec3<f32>(0.5472, 0.4104, 0.7296);
const CLOUDS_FROM: f32 = 55.0;
const CLOUDS_TO: f32 = 105.0;

// Hills, lake, and the tower of this place's own cell.
fn solid(p: vec3<f32>) -> Hit {
    var hit = Hit((p.y - height(p.xz)) * 0.6, LAND);
    hit = nearer(hit, Hit(p.y - 0.4, LAKE));
    let cell = round(p.xz / 48.0);
    let q = p.xz - cell * 48.0;
    let top = 9.0 + 8.0 * chance_at(vec2<i32>(cell));
    return nearer(hit, Hit(max(max(abs(q.x), abs(q.y)) - 1.1, p.y - top) * 0.9, TOWER));
}

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    let hit = solid(p);
    let q = p.xz - round(p.xz / 48.0) * 48.0;
    // no step may pass a cell with a tower unseen
    let wall = 25.0 - max(abs(q.x), abs(q.y));
    return Hit(min(hit.distance, max(wall, 0.6)), hit.surface);
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    let cell = vec2<i32>(floor(p.xz / 1.5));
    let half = u32(fract(p.x / 1.5) + fract(p.z / 1.5) > 1.0);
    return hash_u32(bitcast<u32>(cell.x) * 31u + bitcast<u32>(cell.y) * 1009u + half);
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    if surface == LAKE {
        let ripple = rough_noise(p.xz * 1.3 + frame.time * 0.3, 4u);
        return Material(vec3<f32>(0.03, 0.07, 0.1) + 0.05 * ripple, 0.0, 0.3, 0.0, 0.0);
    }
    if surface == TOWER {
        let course = step(0.08, fract(p.y * 1.6)) * step(0.06, fract((p.x + p.z) * 0.9 + 0.5 * floor(p.y * 1.6)));
        let windows = f32(fract(p.y * 0.4) > 0.55 && fract((p.x + p.z) * 0.8) > 0.6);
        return Material(vec3<f32>(0.5, 0.45, 0.4) * (0.5 + 0.5 * course), 0.0, 0.8, windows * 0.25, 0.0);
    }
    let detail = rough_noise(p.xz * 2.1, 6u);
    let grass = mix(vec3<f32>(0.16, 0.24, 0.07), vec3<f32>(0.3, 0.3, 0.12), detail);
    let rock = vec3<f32>(0.32, 0.29, 0.27) * (0.5 + detail);
    let steep = smoothstep(0.75, 0.6, n.y + 0.15 * (detail - 0.5));
    let snow = smoothstep(7.5, 9.0, p.y + 2.0 * detail) * (1.0 - steep);
    let colour = mix(mix(grass, rock, steep), vec3<f32>(0.85, 0.88, 0.92), snow);
    return Material(colour, 0.0, 0.9 - 0.3 * snow, 0.0, 0.0);
}

fn scene_light(i: u32) -> Light {
    return Light(frame.camera.position + vec3<f32>(120.0, 90.0, 160.0), 1e4, vec3<f32>(1.0, 0.85, 0.65) * 130000.0);
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    let up = clamp(direction.y, 0.0, 1.0);
    var sky = mix(vec3<f32>(0.85, 0.72, 0.6), vec3<f32>(0.16, 0.32, 0.66), pow(up, 0.55));
    sky += vec3<f32>(1.0, 0.8, 0.5) * (0.5 * pow(max(dot(direction, SUN), 0.0), 60.0));
    return sky;
}
