// A plaza in the evening, ray-marched in one pass: the demo's scene.
//
// Smooth areas (sky, spheres, plain walls, water) and fine detail (paving, fluted columns, a lattice, small painted signs) stand
// in one picture, with soft shadows and ambient occlusion: the mix that variable-rate shading has to tell apart.

struct Frame {
    // Width and height of the picture, in pixels.
    size: vec2<u32>,
    // Seconds.
    time: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

const FAR: f32 = 60.0;
const SUN: vec3<f32> = vec3<f32>(0.62, 0.42, -0.66);

const GROUND: f32 = 0.0;
const STONE: f32 = 1.0;
const METAL: f32 = 2.0;
const GLAZE: f32 = 3.0;
const LATTICE: f32 = 4.0;
const WATER: f32 = 5.0;

// Distance and material.
struct Hit { distance: f32, material: f32 }

fn nearer(a: Hit, b: Hit) -> Hit {
    if a.distance < b.distance {
        return a;
    }
    return b;
}

fn hash(p: vec2<f32>) -> f32 {
    let q = fract(p * vec2<f32>(0.1031, 0.1030));
    let r = q + dot(q, q.yx + 33.33);
    return fract((r.x + r.y) * r.x);
}

fn noise(p: vec2<f32>) -> f32 {
    let cell = floor(p);
    let t = smoothstep(vec2<f32>(0.0), vec2<f32>(1.0), fract(p));
    let bottom = mix(hash(cell), hash(cell + vec2<f32>(1.0, 0.0)), t.x);
    let top = mix(hash(cell + vec2<f32>(0.0, 1.0)), hash(cell + vec2<f32>(1.0, 1.0)), t.x);
    return mix(bottom, top, t.y);
}

fn box(p: vec3<f32>, half_size: vec3<f32>) -> f32 {
    let d = abs(p) - half_size;
    return length(max(d, vec3<f32>(0.0))) + min(max(d.x, max(d.y, d.z)), 0.0);
}

fn rotate(p: vec2<f32>, angle: f32) -> vec2<f32> {
    let c = cos(angle);
    let s = sin(angle);
    return vec2<f32>(c * p.x - s * p.y, s * p.x + c * p.y);
}

// A colonnade on either side: fluted shafts on plinths, under a beam.
fn colonnade(p: vec3<f32>) -> f32 {
    let q = vec3<f32>(abs(p.x) - 5.2, p.y, p.z);
    let nearest = clamp(round(q.z / 3.2), -1.0, 6.0) * 3.2;
    let c = vec3<f32>(q.x, q.y, q.z - nearest);
    let radius = length(c.xz);
    let flute = 0.035 * cos(atan2(c.z, c.x) * 18.0);
    let taper = 0.52 - 0.045 * c.y / 2.0;
    let shaft = max(radius - taper - flute * smoothstep(0.2, 0.4, c.y), abs(c.y - 2.0) - 2.0);
    let plinth = box(c - vec3<f32>(0.0, 0.14, 0.0), vec3<f32>(0.78, 0.14, 0.78));
    let capital = box(c - vec3<f32>(0.0, 3.95, 0.0), vec3<f32>(0.72, 0.12, 0.72));
    let beam = box(q - vec3<f32>(0.0, 4.55, 8.0), vec3<f32>(0.66, 0.45, 12.5));
    return min(min(shaft, plinth), min(capital, beam)) * 0.82;
}

fn scene(p: vec3<f32>) -> Hit {
    var hit = Hit(p.y, GROUND);
    // a basin of still water in the middle
    let basin = length(p.xz - vec2<f32>(0.0, 7.5));
    if basin < 2.35 {
        hit = Hit(p.y + 0.12, WATER);
    }
    let rim = max(abs(basin - 2.45) - 0.16, abs(p.y - 0.1) - 0.22);
    hit = nearer(hit, Hit(rim * 0.9, STONE));
    hit = nearer(hit, Hit(colonnade(p), STONE));
    // a sphere over the water, and a smaller one beside the path
    let orb = length(p - vec3<f32>(0.0, 1.75 + 0.08 * sin(frame.time), 7.5)) - 1.05;
    hit = nearer(hit, Hit(orb, METAL));
    hit = nearer(hit, Hit(length(p - vec3<f32>(-2.6, 0.62, 3.6)) - 0.62, GLAZE));
    // an open lattice box
    var q = p - vec3<f32>(2.55, 1.0, 4.1);
    let turned = rotate(q.xz, 0.6);
    q = vec3<f32>(turned.x, q.y, turned.y);
    let shell = box(q, vec3<f32>(0.8, 1.0, 0.8));
    if shell < 0.4 {
        let cell = abs(fract(q * 5.0) - 0.5);
        let bars = max(max(min(cell.x, cell.y), min(cell.y, cell.z)), min(cell.x, cell.z));
        let hole = (0.4 - bars) / 5.0;
        hit = nearer(hit, Hit(max(max(shell, -shell - 0.07), hole) * 0.7, LATTICE));
    } else {
        hit = nearer(hit, Hit(shell, LATTICE));
    }
    return hit;
}

fn march(origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var travelled = 0.02;
    for (var i = 0; i < 140; i++) {
        let hit = scene(origin + direction * travelled);
        if hit.distance < 0.0006 * travelled {
            return Hit(travelled, hit.material);
        }
        travelled += hit.distance;
        if travelled > FAR {
            break;
        }
    }
    return Hit(FAR, -1.0);
}

fn normal_at(p: vec3<f32>) -> vec3<f32> {
    let e = vec2<f32>(0.0009, -0.0009);
    return normalize(
        e.xyy * scene(p + e.xyy).distance + e.yyx * scene(p + e.yyx).distance
            + e.yxy * scene(p + e.yxy).distance + e.xxx * scene(p + e.xxx).distance,
    );
}

fn soft_shadow(origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    var lit = 1.0;
    var travelled = 0.03;
    for (var i = 0; i < 40; i++) {
        let distance = scene(origin + direction * travelled).distance;
        lit = min(lit, 9.0 * distance / travelled);
        travelled += clamp(distance, 0.03, 0.6);
        if lit < 0.004 || travelled > 14.0 {
            break;
        }
    }
    return clamp(lit, 0.0, 1.0);
}

fn occlusion(p: vec3<f32>, n: vec3<f32>) -> f32 {
    var taken = 0.0;
    var weight = 1.0;
    for (var i = 1; i <= 5; i++) {
        let reach = 0.09 * f32(i);
        taken += (reach - scene(p + n * reach).distance) * weight;
        weight *= 0.72;
    }
    return clamp(1.0 - 1.35 * taken, 0.0, 1.0);
}

fn sky(direction: vec3<f32>) -> vec3<f32> {
    let sun = max(dot(direction, normalize(SUN)), 0.0);
    let height = max(direction.y, 0.0);
    let base = mix(vec3<f32>(0.98, 0.6, 0.36), vec3<f32>(0.1, 0.24, 0.58), pow(height, 0.5));
    return base + vec3<f32>(1.0, 0.6, 0.25) * (0.25 * pow(sun, 12.0) + 1.5 * pow(sun, 900.0));
}

// Colour, and how much it mirrors.
fn surface(p: vec3<f32>, material: f32) -> vec4<f32> {
    if material == GROUND {
        let paving = p.xz * 1.6;
        let row = floor(paving.y);
        let slab = vec2<f32>(paving.x + 0.5 * (row % 2.0), paving.y);
        let edge = abs(fract(slab) - 0.5);
        let joint = smoothstep(0.47, 0.485, max(edge.x, edge.y));
        let grain = 0.82 + 0.12 * noise(p.xz * 38.0) + 0.22 * hash(floor(slab));
        return vec4<f32>(mix(vec3<f32>(0.44, 0.40, 0.36) * grain, vec3<f32>(0.12, 0.11, 0.1), joint), 0.03);
    }
    if material == STONE {
        // signs painted on the beam, as small as text
        let sign = vec2<f32>(p.z * 6.0, p.y * 8.0);
        let is_sign = p.y > 4.2 && p.y < 4.9 && hash(floor(sign) + 3.0) > 0.4;
        if is_sign && all(fract(sign) > vec2<f32>(0.3, 0.25)) {
            return vec4<f32>(0.3, 0.12, 0.08, 0.02);
        }
        let veins = noise(p.xy * 3.0 + p.z) * 0.6 + noise(p.yz * 9.0) * 0.3;
        return vec4<f32>(vec3<f32>(0.74, 0.69, 0.6) * (0.78 + 0.24 * veins), 0.02);
    }
    if material == METAL {
        return vec4<f32>(0.72, 0.7, 0.66, 0.82);
    }
    if material == GLAZE {
        return vec4<f32>(0.12, 0.42, 0.4, 0.25);
    }
    if material == LATTICE {
        return vec4<f32>(0.5, 0.22, 0.12, 0.05);
    }
    return vec4<f32>(0.05, 0.1, 0.11, 0.6);
}

fn lit_surface(p: vec3<f32>, direction: vec3<f32>, material: f32) -> vec3<f32> {
    let n = normal_at(p);
    let sun = normalize(SUN);
    let color = surface(p, material).rgb;
    let direct = max(dot(n, sun), 0.0) * soft_shadow(p + n * 0.004, sun);
    let ambient = occlusion(p, n) * (0.35 + 0.35 * n.y);
    let half_way = normalize(sun - direction);
    let gloss = pow(max(dot(n, half_way), 0.0), 48.0) * direct * surface(p, material).a * 3.0;
    return color * (direct * vec3<f32>(1.9, 1.45, 1.05) + ambient * vec3<f32>(0.55, 0.66, 0.85)) + gloss;
}

fn shade(origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let hit = march(origin, direction);
    if hit.material < 0.0 {
        return sky(direction);
    }
    let p = origin + direction * hit.distance;
    var color = lit_surface(p, direction, hit.material);
    let mirror = surface(p, hit.material).a;
    if mirror > 0.1 {
        let n = normal_at(p);
        let away = reflect(direction, n);
        let fresnel = mirror * mix(0.35, 1.0, pow(1.0 - max(dot(n, -direction), 0.0), 3.0));
        let second = march(p + n * 0.01, away);
        var seen = sky(away);
        if second.material >= 0.0 {
            seen = lit_surface(p + n * 0.01 + away * second.distance, away, second.material);
        }
        color = mix(color, seen, fresnel);
    }
    let haze = 1.0 - exp(-0.0014 * hit.distance * hit.distance);
    return mix(color, sky(vec3<f32>(direction.x, max(direction.y, 0.02), direction.z)), haze);
}

@compute @workgroup_size(8, 8)
fn plaza(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let size = vec2<f32>(frame.size);
    let uv = (2.0 * (vec2<f32>(id.xy) + 0.5) - size) / size.y;
    let sway = 0.25 * sin(frame.time * 0.3);
    let eye = vec3<f32>(0.9 + sway, 1.75, -3.4);
    let forward = normalize(vec3<f32>(0.0, 1.7, 7.5) - eye);
    let right = normalize(cross(vec3<f32>(0.0, 1.0, 0.0), forward));
    let up = cross(forward, right);
    let direction = normalize(forward * 1.55 + right * uv.x - up * uv.y);
    let color = shade(eye, direction);
    // a filmic curve, then the display's encoding
    let mapped = clamp((color * (2.51 * color + 0.03)) / (color * (2.43 * color + 0.59) + 0.14), vec3<f32>(0.0), vec3<f32>(1.0));
    textureStore(picture, id.xy, vec4<f32>(pow(mapped, vec3<f32>(1.0 / 2.2)), 1.0));
}
