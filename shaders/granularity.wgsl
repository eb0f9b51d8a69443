// One rate for each square area of several quads, as hardware attachments have: on each axis the finest of the area's rates. In place.
// An invocation makes 16×16 pixels: two words across, eight rows of quads. Its CPU twin is src/tradeoff/granularity.rs.

struct Params {
    // Quads across and down.
    size: vec2<u32>,
    // Words in a row.
    pitch: u32,
    // Quads across an area: 2, 4 or 8.
    side: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read_write> rates: array<u32>;

fn code_at(quad: vec2<u32>) -> u32 {
    return extractBits(rates[quad.y * params.pitch + (quad.x >> 2u)], (quad.x & 3u) * 8u, 8u);
}

// The finest rate of an area, axis by axis.
fn finest(corner: vec2<u32>) -> u32 {
    var logs = vec2<u32>(2u);
    for (var i = 0u; i < params.side * params.side; i++) {
        let quad = corner + vec2<u32>(i % params.side, i / params.side);
        if all(quad < params.size) {
            let code = code_at(quad);
            logs = min(logs, vec2<u32>((code >> 2u) & 3u, code & 3u));
        }
    }
    return (logs.x << 2u) | logs.y;
}

@compute @workgroup_size(8, 8)
fn share(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = id.xy * 8u;
    if any(first >= params.size) {
        return;
    }
    let areas = 8u / params.side;
    for (var area = 0u; area < areas * areas; area++) {
        let corner = first + vec2<u32>(area % areas, area / areas) * params.side;
        if any(corner >= params.size) {
            continue;
        }
        let code = finest(corner);
        for (var i = 0u; i < params.side * params.side; i++) {
            let quad = corner + vec2<u32>(i % params.side, i / params.side);
            if all(quad < params.size) {
                let word = quad.y * params.pitch + (quad.x >> 2u);
                rates[word] = insertBits(rates[word], code, (quad.x & 3u) * 8u, 8u);
            }
        }
    }
}
