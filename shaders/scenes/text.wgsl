// A drawing board with lines of small print, rulings and fine patterns, seen at a slant. Print scrolls, a fan of lines turns and a
// pencil rolls over the sheet, as on a screen that a renderer knows nothing of: there are no motion vectors at all, and no
// materials worth telling apart.

const STEPS: u32 = 90u;
const LIGHTS: u32 = 3u;
const SHADOWS: u32 = 2u;
const SHADOW_STEPS: u32 = 24u;
const REFLECTION_STEPS: u32 = 0u;
const OCCLUSION_RAYS: u32 = 6u;
const FOG: f32 = 0.0;
const GRAIN: f32 = 0.0;

const DESK: u32 = 1u;
const SHEET: u32 = 2u;
const PENCIL: u32 = 3u;
const CUP: u32 = 4u;

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    var hit = Hit(p.y, DESK);
    hit = nearer(hit, Hit(box_distance(p - vec3<f32>(0.0, 0.02, 3.4), vec3<f32>(2.2, 0.02, 2.4)), SHEET));
    let q = p - vec3<f32>(2.0 + 0.55 * cos(time * 0.9), 0.1, 3.0);
    let along = turn(q.xz, 0.3);
    hit = nearer(hit, Hit(max(length(vec2<f32>(along.x, q.y)) - 0.07, abs(along.y) - 1.1), PENCIL));
    let c = p - vec3<f32>(-2.75, 0.5, 4.6);
    hit = nearer(hit, Hit(max(abs(length(c.xz) - 0.42) - 0.035, abs(c.y) - 0.5), CUP));
    return hit;
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    if surface == CUP {
        return u32((atan2(p.z - 4.6, p.x + 2.75) + PI) * 6.0);
    }
    return 0u;
}

// A letter: five rows of three dots.
fn letter(code: u32, at: vec2<f32>) -> f32 {
    if any(at < vec2<f32>(0.0)) || any(at >= vec2<f32>(1.0)) {
        return 0.0;
    }
    let dot = vec2<u32>(vec2<f32>(at.x * 3.0, at.y * 5.0));
    return f32((code >> (dot.x + 3u * dot.y)) & 1u);
}

fn print(p: vec2<f32>, size: f32) -> f32 {
    let cell = floor(p / size);
    let key = bitcast<u32>(i32(cell.x)) * 197u + bitcast<u32>(i32(cell.y)) * 5003u;
    if chance(key + 9u) < 0.17 {
        return 0.0;
    }
    let inside = (p / size - cell) * vec2<f32>(1.35, 1.6) - vec2<f32>(0.1, 0.2);
    return letter(hash_u32(key) & 0x7fffu | 0x12u, inside);
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    if surface == SHEET {
        var ink = 0.0;
        let at = vec2<f32>(p.x, 5.8 - p.z);
        if at.y < 0.6 {
            ink = print(at, 0.2);
        } else if at.y < 2.6 {
            ink = print(at + vec2<f32>(0.0, frame.time * 0.12), select(0.055, 0.085, at.x < 0.0));
        } else if at.x < -0.7 {
            // a fan of lines
            let fan = at - vec2<f32>(-2.1, 3.6);
            ink = f32(fract(atan2(fan.y, fan.x) * 24.0 + frame.time) < 0.35);
        } else if at.x < 0.7 {
            // rulings that grow finer
            ink = f32(fract(exp2(2.0 + 1.6 * (at.y - 2.6)) * at.x) < 0.4);
        } else {
            // a zone plate
            let r = at - vec2<f32>(1.45, 3.7);
            ink = f32(sin(dot(r, r) * 60.0) > 0.0);
        }
        let paper = 0.86 + 0.03 * rough_noise(p.xz * 40.0, 2u);
        return Material(vec3<f32>(paper, paper * 0.98, paper * 0.93) * (1.0 - 0.88 * ink), 0.0, 0.9, 0.0, 0.0);
    }
    if surface == PENCIL {
        return Material(vec3<f32>(0.75, 0.2, 0.1), 0.0, 0.4, 0.0, 0.0);
    }
    if surface == CUP {
        return Material(vec3<f32>(0.2, 0.34, 0.55), 0.0, 0.25, 0.0, 0.0);
    }
    let grain = rough_noise(vec2<f32>(p.x * 1.2, p.z * 14.0), 5u);
    return Material(mix(vec3<f32>(0.3, 0.18, 0.1), vec3<f32>(0.5, 0.34, 0.2), grain), 0.0, 0.55, 0.0, 0.0);
}

fn scene_light(i: u32) -> Light {
    let place = vec3<f32>(-3.0 + 3.2 * f32(i), 3.5, 1.0 + 2.0 * f32(i));
    return Light(place, 14.0, vec3<f32>(1.0, 0.93, 0.82) * (9.0 - 2.0 * f32(i)));
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.5, 0.52, 0.55) * (0.5 + 0.5 * max(direction.y, 0.0));
}
