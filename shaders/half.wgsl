// The rates of passes of half the resolution: an invocation makes one word, four of their quads, from eight by two of the picture's. Its
// CPU twin is src/analyse/half.rs.
#import vrcs::rate::{axes, meet, or_full}

struct Params {
    // Quads of the picture, across and down.
    quads: vec2<u32>,
    // Words in a row of the picture's rates.
    pitch: u32,
    // Words in a row of what is made.
    half_pitch: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> rates: array<u32>;
@group(0) @binding(2) var<storage, read_write> half_rates: array<u32>;

const COARSEST: u32 = 10u;

fn rate_at(quad: vec2<u32>) -> u32 {
    // beyond the picture there is nothing that could be seen
    if any(quad >= params.quads) {
        return COARSEST;
    }
    let word = rates[quad.y * params.pitch + (quad.x >> 2u)];
    return or_full(extractBits(word, (quad.x & 3u) * 8u, 8u));
}

@compute @workgroup_size(16, 8)
fn half_resolution(@builtin(global_invocation_id) id: vec3<u32>) {
    let halves = (params.quads + 1u) / 2u;
    if id.x * 4u >= halves.x || id.y >= halves.y {
        return;
    }
    var word = 0u;
    for (var i = 0u; i < min(halves.x - id.x * 4u, 4u); i++) {
        let first = vec2<u32>(id.x * 4u + i, id.y) * 2u;
        var code = COARSEST;
        for (var j = 0u; j < 4u; j++) {
            code = meet(code, rate_at(first + vec2<u32>(j & 1u, j >> 1u)));
        }
#ifdef FOOTPRINT
        // as wide on the screen: one step finer on each axis
        let logs = axes(code);
        let finer = max(logs, vec2<u32>(1u)) - 1u;
        code = (finer.x << 2u) | finer.y;
#endif
        word |= code << (i * 8u);
    }
    half_rates[id.y * params.half_pitch + id.x] = word;
}
