// A hall with many lamps: shiny metal, a polished floor, painted walls. What costs is light and reflections.

const STEPS: u32 = 120u;
const LIGHTS: u32 = 64u;
const SHADOWS: u32 = 3u;
const SHADOW_STEPS: u32 = 32u;
const REFLECTION_STEPS: u32 = 40u;
const OCCLUSION_RAYS: u32 = 5u;
const FOG: f32 = 0.0;
const GRAIN: f32 = 0.0;

const FLOOR: u32 = 1u;
const WALL: u32 = 2u;
const CEILING: u32 = 3u;
const PILLAR: u32 = 4u;
const BALL: u32 = 5u;
const PIPE: u32 = 6u;
const CRATE: u32 = 7u;

fn orbit(time: f32, number: f32) -> vec3<f32> {
    let angle = time * 0.7 + number * 2.1;
    return vec3<f32>(sin(angle) * 2.2, 1.1 + 0.3 * sin(time * 1.3 + number), 6.0 + number * 3.0 + cos(angle) * 0.8);
}

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    var hit = Hit(p.y, FLOOR);
    hit = nearer(hit, Hit(4.2 - p.y, CEILING));
    hit = nearer(hit, Hit(5.0 - abs(p.x), WALL));
    hit = nearer(hit, Hit(26.0 - p.z, WALL));
    let bay = clamp(round((p.z - 4.0) / 4.0), 0.0, 5.0) * 4.0 + 4.0;
    let q = vec3<f32>(abs(p.x) - 3.9, p.y, p.z - bay);
    hit = nearer(hit, Hit(max(length(q.xz) - 0.32, abs(q.y - 2.1) - 2.1), PILLAR));
    hit = nearer(hit, Hit(length(vec2<f32>(p.x + 4.4, p.y - 3.6)) - 0.18, PIPE));
    hit = nearer(hit, Hit(length(vec2<f32>(p.x - 4.4, p.y - 3.3)) - 0.12, PIPE));
    for (var i = 0u; i < 3u; i++) {
        hit = nearer(hit, Hit(length(p - orbit(time, f32(i))) - 0.75, BALL + 16u * i));
    }
    let box = p - vec3<f32>(-2.4, 0.6, 8.5);
    let turned = turn(box.xz, 0.5);
    hit = nearer(hit, Hit(box_distance(vec3<f32>(turned.x, box.y, turned.y), vec3<f32>(0.6)) - 0.03, CRATE));
    return hit;
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    if (surface & 15u) == BALL {
        let number = f32(surface >> 4u);
        return p - orbit(frame.time, number) + orbit(frame.time_before, number);
    }
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    // facets of a few hand-widths, as a mesh would have
    let cell = vec3<u32>(abs(p * 2.5));
    return hash_u32(cell.x + 64u * cell.y + 4096u * cell.z + 0x10000u * surface);
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    switch surface & 15u {
        case FLOOR: {
            let slab = floor(p.xz / 1.2);
            let joint = min(abs(fract(p.x / 1.2) - 0.5), abs(fract(p.z / 1.2) - 0.5));
            let shade = 0.22 + 0.12 * chance_at(vec2<i32>(slab)) + 0.08 * rough_noise(p.xz * 9.0, 4u);
            let colour = select(vec3<f32>(shade, shade * 0.95, shade * 0.88), vec3<f32>(0.05), joint > 0.49);
            return Material(colour, 0.0, 0.12 + 0.25 * rough_noise(p.xz * 2.0, 3u), 0.0, 0.0);
        }
        case WALL: {
            let dado = step(p.y, 1.2);
            let stain = rough_noise(vec2<f32>(p.z + p.x, p.y) * 1.7, 5u);
            let paint = mix(vec3<f32>(0.62, 0.58, 0.48), vec3<f32>(0.12, 0.25, 0.24), dado);
            return Material(paint * (0.75 + 0.4 * stain), 0.0, 0.8, 0.0, 0.0);
        }
        case CEILING: {
            let panel = max(abs(fract(p.x * 0.5) - 0.5), abs(fract(p.z * 0.25) - 0.5));
            let lamp = f32(panel < 0.16);
            return Material(vec3<f32>(0.5 + 0.4 * lamp), 0.0, 0.9, lamp * 0.5, 0.0);
        }
        case PILLAR: {
            let brushed = rough_noise(vec2<f32>(p.y * 60.0, atan2(n.z, n.x) * 3.0), 3u);
            return Material(vec3<f32>(0.72, 0.7, 0.66) * (0.8 + 0.3 * brushed), 1.0, 0.22 + 0.1 * brushed, 0.0, 0.0);
        }
        case BALL: {
            let tint = vec3<f32>(0.95, 0.72 + 0.1 * f32(surface >> 4u), 0.4 + 0.25 * f32(surface >> 4u));
            return Material(tint, 1.0, 0.06, 0.0, 0.0);
        }
        case PIPE: {
            let rust = smoothstep(0.45, 0.65, rough_noise(p.zy * 3.0, 5u));
            return Material(mix(vec3<f32>(0.6), vec3<f32>(0.35, 0.16, 0.08), rust), 1.0 - rust, 0.25 + 0.6 * rust, 0.0, 0.0);
        }
        default: {
            let plank = fract(p.y * 3.3);
            let grain = rough_noise(vec2<f32>(p.y * 40.0, (p.x + p.z) * 4.0), 4u);
            return Material(vec3<f32>(0.42, 0.28, 0.15) * (0.6 + 0.6 * grain) * step(0.05, plank), 0.0, 0.7, 0.0, 0.0);
        }
    }
}

fn scene_light(i: u32) -> Light {
    let side = f32(i & 3u) - 1.5;
    let place = vec3<f32>(side * 2.6, 3.7 - 0.5 * chance(i * 7u), 2.0 + f32(i >> 2u) * 1.5);
    let hue = chance(i + 400u);
    let colour = mix(vec3<f32>(1.0, 0.75, 0.45), vec3<f32>(0.5, 0.7, 1.0), hue) * (0.5 + chance(i + 800u));
    return Light(place, 6.5, colour * 1.4);
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.08, 0.085, 0.1) * (0.6 + 0.4 * direction.y);
}
