// Trees and grass: alpha-tested leaves, each a surface of its own, the known worst case for variable rates.

const STEPS: u32 = 180u;
const LIGHTS: u32 = 2u;
const SHADOWS: u32 = 1u;
const SHADOW_STEPS: u32 = 40u;
const REFLECTION_STEPS: u32 = 0u;
const OCCLUSION_RAYS: u32 = 4u;
const FOG: f32 = 0.012;
const GRAIN: f32 = 0.0;

const SOIL: u32 = 1u;
const TRUNK: u32 = 2u;
const GRASS: u32 = 3u;
const LEAF: u32 = 4u;

fn sway(time: f32, height: f32, phase: f32) -> f32 {
    return 0.05 * height * sin(time * 1.7 + phase);
}

// A leaf is a thin bent plate whose outline a texture cuts out.
fn leaf(q: vec3<f32>, size: f32) -> f32 {
    let bent = q.y - q.x * q.x * 0.6;
    let outline = abs(q.z) - size * 0.42 * max(1.0 - q.x * q.x / (size * size), 0.0) * (1.0 + 0.18 * cos(q.x * 90.0));
    let plate = max(max(abs(bent) - 0.006, outline), abs(q.x) - size);
    return plate * 0.55;
}

fn scene_distance(p: vec3<f32>, time: f32) -> Hit {
    var hit = Hit(p.y - 0.12 * noise(p.xz * 0.8), SOIL);
    // trunks
    let row = clamp(round((p.x) / 2.6), -3.0, 3.0);
    let trunk = vec2<f32>(p.x - row * 2.6, p.z - 6.4);
    hit = nearer(hit, Hit(max(length(trunk) - 0.16 + 0.02 * p.y, p.y - 3.2) * 0.9, TRUNK));
    // crowns: leaves in the cells of a grid, inside ellipsoids
    let crown = length((vec3<f32>(trunk.x, p.y - 2.7, trunk.y)) / vec3<f32>(1.35, 1.15, 1.2)) - 1.0;
    if crown < 0.3 {
        let cell = floor(p / 0.34);
        let number = vec3<i32>(cell);
        let key = bitcast<u32>(number.x) * 73856093u ^ bitcast<u32>(number.y) * 19349663u ^ bitcast<u32>(number.z) * 83492791u;
        let inside = length((vec3<f32>(cell.x * 0.34 + 0.17 - row * 2.6, cell.y * 0.34 - 2.53, cell.z * 0.34 - 6.23)) / vec3<f32>(1.35, 1.15, 1.2));
        if inside < 1.0 && chance(key) < 0.82 {
            var q = p - (cell + 0.5) * 0.34 - vec3<f32>(sway(time, p.y, chance(key + 5u) * 6.3) * 0.5, 0.0, 0.0);
            let a = turn(q.xz, chance(key + 1u) * 6.3);
            q = vec3<f32>(a.x, q.y, a.y);
            let b = turn(q.xy, chance(key + 2u) * 2.4 - 1.2);
            q = vec3<f32>(b.x, b.y, q.z);
            // no step may leave the cell unseen
            let wall = 0.19 - max(max(abs(p.x - (cell.x + 0.5) * 0.34), abs(p.y - (cell.y + 0.5) * 0.34)), abs(p.z - (cell.z + 0.5) * 0.34));
            hit = nearer(hit, Hit(min(leaf(q, 0.16), max(wall, 0.02)), LEAF + (key & 0x7ffu) * 8u));
        } else {
            hit = nearer(hit, Hit(0.05, SKY));
        }
    } else {
        hit = nearer(hit, Hit(crown * 0.9, SKY));
    }
    // blades of grass
    if p.y < 0.55 && p.z > 0.5 && p.z < 6.0 {
        let cell = floor(p.xz / 0.11);
        let key = bitcast<u32>(i32(cell.x)) * 0x85ebca6bu ^ bitcast<u32>(i32(cell.y)) * 0xc2b2ae35u;
        let tall = 0.22 + 0.26 * chance(key);
        let lean = (chance(key + 3u) - 0.5) * 0.12 + sway(time, p.y, chance(key + 4u) * 6.3);
        let q = vec2<f32>(p.x - (cell.x + 0.5) * 0.11 - lean * p.y / tall, p.z - (cell.y + 0.5) * 0.11);
        let facing = turn(q, chance(key + 6u) * 3.1);
        let width = 0.018 * max(1.0 - p.y / tall, 0.0);
        let blade = max(max(abs(facing.x) - width, abs(facing.y) - 0.004), p.y - tall) * 0.6;
        hit = nearer(hit, Hit(max(blade, 0.0) + 0.0, GRASS + (key & 0x7ffu) * 8u));
    }
    return hit;
}

fn moved(p: vec3<f32>, surface: u32) -> vec3<f32> {
    if (surface & 7u) >= GRASS {
        let phase = chance(surface >> 3u) * 6.3;
        return p - vec3<f32>(sway(frame.time, p.y, phase) - sway(frame.time_before, p.y, phase), 0.0, 0.0) * 0.5;
    }
    return p;
}

fn triangle_of(p: vec3<f32>, surface: u32) -> u32 {
    let cell = vec3<u32>(abs(p * 6.0));
    return hash_u32(cell.x + 128u * cell.y + 16384u * cell.z + surface * 7919u);
}

fn scene_material(p: vec3<f32>, n: vec3<f32>, surface: u32) -> Material {
    switch surface & 7u {
        case SOIL: {
            let shade = rough_noise(p.xz * 7.0, 5u);
            return Material(vec3<f32>(0.2, 0.15, 0.09) * (0.5 + shade), 0.0, 0.95, 0.0, 0.0);
        }
        case TRUNK: {
            let bark = rough_noise(vec2<f32>(atan2(n.z, n.x) * 6.0, p.y * 3.0), 5u);
            return Material(vec3<f32>(0.27, 0.2, 0.15) * (0.4 + 1.1 * bark), 0.0, 0.9, 0.0, 0.0);
        }
        case GRASS: {
            let tint = chance(surface >> 3u);
            return Material(mix(vec3<f32>(0.2, 0.34, 0.08), vec3<f32>(0.42, 0.45, 0.14), tint) * (0.5 + p.y), 0.0, 0.8, 0.0, 0.5);
        }
        default: {
            let tint = chance(surface >> 3u);
            let vein = 0.8 + 0.4 * rough_noise(p.xz * 30.0 + p.y * 17.0, 2u);
            return Material(mix(vec3<f32>(0.12, 0.3, 0.06), vec3<f32>(0.32, 0.4, 0.08), tint) * vein, 0.0, 0.6, 0.0, 0.7);
        }
    }
}

fn scene_light(i: u32) -> Light {
    if i == 0u {
        return Light(vec3<f32>(16.0, 22.0, -10.0), 80.0, vec3<f32>(1.0, 0.92, 0.75) * 3000.0);
    }
    return Light(vec3<f32>(-30.0, 18.0, 20.0), 90.0, vec3<f32>(0.35, 0.45, 0.6) * 700.0);
}

fn sky_colour(direction: vec3<f32>) -> vec3<f32> {
    return mix(vec3<f32>(0.75, 0.8, 0.85), vec3<f32>(0.22, 0.42, 0.8), sqrt(clamp(direction.y, 0.0, 1.0)));
}
