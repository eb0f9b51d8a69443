// Limits between neighbouring quads, or tiles: an invocation makes one word, four quads. Its CPU twin is src/analyse/smoothing.rs.
#import vrcs::analyse::because

struct Params {
    // Quads across and down.
    size: vec2<u32>,
    // Words in a row.
    pitch: u32,
    // Whether reasons are those of these rates.
    has_reasons: u32,
    // Log2 of the quads on a side of what has one rate: 0, or that of tiles, whose neighbours are tiles.
    step: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> raw: array<u32>;
@group(0) @binding(2) var<storage, read_write> smooth_rates: array<u32>;
#ifdef REASONS
@group(0) @binding(3) var<storage, read_write> reasons: array<u32>;
#endif

fn logs_at(quad: vec2<u32>) -> vec2<u32> {
    let word = raw[quad.y * params.pitch + (quad.x >> 2u)];
    let code = extractBits(word, (quad.x & 3u) * 8u, 8u);
    return vec2<u32>((code >> 2u) & 3u, code & 3u);
}

fn smoothed(quad: vec2<u32>) -> u32 {
    let own = logs_at(quad);
    var least = own;
    var sum = vec2<u32>(0u);
    var count = 0u;
    let step = vec2<u32>(params.step);
    let tile = quad >> step;
    for (var i = 0u; i < 9u; i++) {
        // beyond the left or upper border the difference wraps, and is outside as well
        let near = tile + vec2<u32>(i % 3u, i / 3u) - 1u;
        let at = near << step;
        if all(near < params.size) && all(at < params.size) {
            let logs = logs_at(at);
            least = min(least, logs);
            sum += min(logs, own);
            count++;
        }
    }
#ifdef CONSERVATIVE
    var logs = sum / count;
#else
    var logs = select(own, min(own, vec2<u32>(1u)), least == vec2<u32>(0u));
#endif
    // no 4 beside a 1
    logs = select(logs, min(logs, vec2<u32>(1u)), logs.yx == vec2<u32>(0u));
    return (logs.x << 2u) | logs.y;
}

@compute @workgroup_size(16, 8)
fn smooth_words(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x * 4u >= params.size.x || id.y >= params.size.y {
        return;
    }
    var word = 0u;
    for (var i = 0u; i < 4u; i++) {
        let quad = vec2<u32>(id.x * 4u + i, id.y);
        if quad.x < params.size.x {
            word |= smoothed(quad) << (i * 8u);
        }
    }
    let at = id.y * params.pitch + id.x;
    smooth_rates[at] = word;
#ifdef REASONS
    if params.has_reasons != 0u {
        let changed = raw[at] ^ word;
        var why = reasons[at];
        for (var i = 0u; i < 4u; i++) {
            if id.x * 4u + i < params.size.x && extractBits(changed, i * 8u, 8u) != 0u {
                why = insertBits(why, because::NEIGHBOUR, i * 8u, 8u);
            }
        }
        reasons[at] = why;
    }
#endif
}
