// The application's own rates, combined with those that the analysis found: an invocation makes one word, four quads, in place. Its CPU
// twin is src/analyse/own.rs.
#import vrcs::rate::{combine, meet}
#import vrcs::analyse::because
#ifdef DISTANCE
#import vrcs::depth::{inverse_distance, NO_DEPTH}
#endif

struct Params {
    // Pixels across and down.
    size: vec2<u32>,
    // Words in a row.
    pitch: u32,
    // What the combiners clamp to.
    largest: u32,
    // The coarsest rate that is asked for.
    most: u32,
    ids_combiner: u32,
    distance_combiner: u32,
    particles_combiner: u32,
    particles: u32,
    // A code for each step, four bits each.
    steps: u32,
    // Near over far, in 1/2^30.
    depth_offset: u32,
    // Bit 0: depth 1 is near. Bit 1: the reasons are those of these rates.
    has: u32,
    // Where the steps start, as inverse distances.
    reach: vec4<u32>,
    // A code for each id, four bits each.
    ids: array<vec4<u32>, 8>,
    // Where the view lies in the pictures.
    origin: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read_write> rates: array<u32>;
#ifdef REASONS
@group(0) @binding(2) var<storage, read_write> reasons: array<u32>;
#endif
#ifdef IDS
@group(0) @binding(3) var ids: texture_2d<u32>;
#endif
#ifdef DISTANCE
@group(0) @binding(4) var depth: texture_2d<f32>;
#endif
#ifdef FLAGS
@group(0) @binding(5) var marks: texture_2d<u32>;
#endif

// No rate: what was found stays.
const NONE: u32 = 15u;
// Of src/analyse/inputs.rs.
const FLAG_FULL: u32 = 4u;
const FLAG_PARTICLE: u32 = 8u;

fn combined(combiner: u32, found: u32, own: u32) -> u32 {
    if own == NONE {
        return found;
    }
    return combine(combiner, found, own, params.largest);
}

fn of_pixel(found: u32, pixel: vec2<i32>) -> u32 {
    var rate = found;
    let at = pixel + vec2<i32>(params.origin);
#ifdef IDS
    let id = textureLoad(ids, at, 0).x;
    if id < 256u {
        rate = combined(params.ids_combiner, rate, extractBits(params.ids[id >> 5u][(id >> 3u) & 3u], (id & 7u) * 4u, 4u));
    }
#endif
#ifdef DISTANCE
    let inverse = inverse_distance(textureLoad(depth, at, 0).x, params.depth_offset, (params.has & 1u) != 0u);
    if inverse == NO_DEPTH {
        return 0u;
    }
    var step = NONE;
    for (var i = 0u; i < 4u; i++) {
        let code = extractBits(params.steps, i * 4u, 4u);
        if code != NONE && inverse <= params.reach[i] {
            step = code;
        }
    }
    rate = combined(params.distance_combiner, rate, step);
#endif
#ifdef FLAGS
    let mark = textureLoad(marks, at, 0).x;
#ifdef PARTICLES
    if (mark & FLAG_PARTICLE) != 0u {
        rate = combined(params.particles_combiner, rate, params.particles);
    }
#endif
    if (mark & FLAG_FULL) != 0u {
        return 0u;
    }
#endif
    return rate;
}

fn of_quad(found: u32, quad: vec2<u32>) -> u32 {
    var rate = params.most;
    for (var i = 0u; i < 4u; i++) {
        // at the border, pixels repeat
        let at = min(quad * 2u + vec2<u32>(i & 1u, i >> 1u), params.size - 1u);
        rate = meet(rate, of_pixel(found, vec2<i32>(at)));
    }
    return rate;
}

@compute @workgroup_size(16, 8)
fn own_rates(@builtin(global_invocation_id) id: vec3<u32>) {
    let quads = (params.size + 1u) / 2u;
    if id.x * 4u >= quads.x || id.y >= quads.y {
        return;
    }
    let at = id.y * params.pitch + id.x;
    let found = rates[at];
    var word = found;
    for (var i = 0u; i < min(quads.x - id.x * 4u, 4u); i++) {
        let code = of_quad(extractBits(found, i * 8u, 8u), vec2<u32>(id.x * 4u + i, id.y));
        word = insertBits(word, code, i * 8u, 8u);
    }
    rates[at] = word;
#ifdef REASONS
    let changed = found ^ word;
    var why = reasons[at];
    for (var i = 0u; i < 4u; i++) {
        if extractBits(changed, i * 8u, 8u) != 0u {
            why = insertBits(why, because::OWN, i * 8u, 8u);
        }
    }
    if (params.has & 2u) != 0u {
        reasons[at] = why;
    }
#endif
}
