// Rates of tiles, one estimate and one rate each (Yang et al., I3D 2019, §3 and §4; GDC 2019, pass 1), in place of one for each quad: for
// the rates, or for the attachment alone. A tile's error and luma are those of its own pixels (analyse/areas.wgsl), its speed the least of
// theirs, its doubt that of any. A workgroup makes 32x32 pixels. Its CPU twin is `Stage::tile` in src/analyse/decide.rs; both
// make the same words.

#import vrcs::analyse::params::{params, largest, FACTOR_ONE, here, before}
#import vrcs::analyse::fixed::{byte_of, BAD}
#import vrcs::analyse::pictures
#import vrcs::analyse::source
#import vrcs::analyse::because
#import vrcs::analyse::areas
#import vrcs::analyse::sums::Sums
#import vrcs::analyse::rates::{Logs, Places, legal, logs_of, scaled, limits_everywhere, limits_under}
#ifdef LOCAL_TOLERANCE
#ifdef SAFE_AREA
#import vrcs::analyse::rates::safety_at
#endif
#ifdef FOVEATION
#import vrcs::analyse::rates::falloff_at
#endif
#ifdef MATERIALS
#import vrcs::analyse::rates::calmed
#endif
#endif

#ifndef ATTACHMENT_ALONE
@group(0) @binding(2) var<storage, read_write> rates: array<u32>;
#endif
#ifdef ATTACHMENT
@group(0) @binding(5) var<storage, read_write> attachment: array<u32>;
#endif
#ifdef REASONS
@group(0) @binding(6) var<storage, read_write> reasons: array<u32>;
#endif
#ifdef PLAIN
@group(0) @binding(20) var<storage, read_write> plain_rates: array<u32>;
#endif
#ifdef PREVIOUS_RATES
@group(0) @binding(10) var<storage, read> rates_before: array<u32>;
#endif
#ifdef MATERIALS
@group(0) @binding(11) var materials: texture_2d<f32>;
#endif
#ifdef NOISE
@group(0) @binding(12) var noise: texture_2d<f32>;
#endif

// Of each tile.
#ifdef DOUBT
// The first lost pixel's place and doubt; all ones for none. Whether a pixel has no luma.
var<workgroup> lost: array<atomic<u32>, areas::COUNT>;
var<workgroup> invalid: array<atomic<u32>, areas::COUNT>;
#endif
#ifdef MOTION
// The least speeds' keys, across and down; whether a pixel has no known motion.
var<workgroup> slowest: array<atomic<u32>, areas::COUNT * 2u>;
var<workgroup> unknown: array<atomic<u32>, areas::COUNT>;
#endif
#ifdef PREVIOUS_RATES
// Log2 of the finest previous rate, across and down.
var<workgroup> finest: array<atomic<u32>, areas::COUNT * 2u>;
#endif
#ifdef FLAGS
var<workgroup> marked: array<atomic<u32>, areas::COUNT>;
#endif
#ifdef MATERIALS
var<workgroup> shine: array<atomic<u32>, areas::COUNT>;
#endif
#ifdef NOISE
var<workgroup> noisiest: array<atomic<u32>, areas::COUNT>;
#endif
// Log2 of the rate in bits 0 to 3, of the attachment's in 4 to 7, of the one without the extra half rate in 8 to 11; the reason above 16.
var<workgroup> found: array<u32, areas::COUNT>;

fn clear(index: u32) {
    if index < areas::COUNT {
#ifdef DOUBT
        atomicStore(&lost[index], 0xffffffffu);
        atomicStore(&invalid[index], 0u);
#endif
#ifdef MOTION
        atomicStore(&slowest[index * 2u], 0xffffffffu);
        atomicStore(&slowest[index * 2u + 1u], 0xffffffffu);
        atomicStore(&unknown[index], 0u);
#endif
#ifdef PREVIOUS_RATES
        atomicStore(&finest[index * 2u], 2u);
        atomicStore(&finest[index * 2u + 1u], 2u);
#endif
#ifdef FLAGS
        atomicStore(&marked[index], 0u);
#endif
#ifdef MATERIALS
        atomicStore(&shine[index], 0u);
#endif
#ifdef NOISE
        atomicStore(&noisiest[index], 0u);
#endif
    }
}

// Looks at a pixel, of the region and of the picture; gives its source in the previous picture.
fn look(p: vec2<u32>, at: vec2<u32>, tile: u32) -> vec2<u32> {
#ifdef REPROJECTION
    let past = source::moved_source(at);
#else
    let past = vec3<u32>(source::still_source(at), source::SURE);
#endif
    let value = pictures::before_at(past.xy);
    areas::keep(p, value);
#ifdef DOUBT
    if past.z != source::SURE {
        atomicMin(&lost[tile], ((p.y * areas::REGION + p.x) << 2u) | past.z);
    } else if value.w == BAD {
        atomicOr(&invalid[tile], 1u);
    }
#endif
#ifdef MOTION
    let key = source::speed_key(at);
    atomicMin(&slowest[tile * 2u], key.x);
    atomicMin(&slowest[tile * 2u + 1u], key.y);
#ifdef REASONS
    if source::is_lost_at(at) {
        atomicOr(&unknown[tile], 1u);
    }
#endif
#endif
#ifdef FLAGS
    atomicOr(&marked[tile], textureLoad(source::marks, here(at), 0).x);
#endif
#ifdef MATERIALS
#ifdef MATERIALS_BEFORE
    let surface = textureLoad(materials, before(past.xy), 0).xy;
#else
    let surface = textureLoad(materials, here(at), 0).xy;
#endif
    atomicMax(&shine[tile], byte_of(surface.x) * byte_of(surface.y));
#endif
#ifdef NOISE
    atomicMax(&noisiest[tile], byte_of(textureLoad(noise, here(at), 0).x));
#endif
#ifdef PREVIOUS_RATES
    if all((p & vec2<u32>(1u)) == vec2<u32>(0u)) {
        let quad = past.xy >> vec2<u32>(1u);
        let word = rates_before[quad.y * params.previous_pitch + (quad.x >> 2u)];
        let had = extractBits(word, (quad.x & 3u) * 8u, 8u);
        let is_rate = had <= 10u && ((0x673u >> (had & 31u)) & 1u) != 0u;
        atomicMin(&finest[tile * 2u], select(0u, had >> 2u, is_rate));
        atomicMin(&finest[tile * 2u + 1u], select(0u, had & 3u, is_rate));
    }
#endif
    return past.xy;
}

#ifdef LOCAL_TOLERANCE
// The least tolerance of a tile's quads, of which the first and the one beyond the last are given: of the quad that is nearest to where one
// looks, in the safe area only if all of it is, and of the shiniest surface.
fn tolerance_of(low: vec2<u32>, high: vec2<u32>, places: Places) -> vec4<u32> {
    var tolerance = vec4<u32>(params.tolerance);
#ifdef SAFE_AREA
    tolerance = scaled(tolerance, vec4<u32>(safety_at(clamp(params.size / 4u, low, high - 1u))));
#endif
#ifdef FOVEATION
    let gaze = vec2<u32>(max(params.centre, vec2<i32>(0))) / 2u;
    tolerance = scaled(tolerance, vec4<u32>(falloff_at(clamp(gaze, low, high - 1u))));
#endif
#ifdef MATERIALS
    tolerance = calmed(tolerance, places);
#endif
    return tolerance;
}
#endif

fn packed(rate: vec2<u32>, attached: vec2<u32>, plain: vec2<u32>, reason: u32) -> u32 {
    return rate.x | (rate.y << 2u) | (attached.x << 4u) | (attached.y << 6u) | (plain.x << 8u) | (plain.y << 10u) | (reason << 16u);
}

fn full(reason: u32) -> u32 {
    return reason << 16u;
}

// 4x4 keeps 4 on the axis of the smaller error, unless it is allowed.
fn allowed(rate: vec2<u32>, error: vec2<u32>) -> vec2<u32> {
    if all(rate == vec2<u32>(2u)) && params.largest != 10u {
        return select(vec2<u32>(1u, 2u), vec2<u32>(2u, 1u), error.x >> 2u <= error.y >> 2u);
    }
    return rate;
}

#ifndef MOTION_ONLY
// Where nothing tells of an axis there is doubt.
fn seen(logs: Logs, area: areas::Area) -> Logs {
    let blind = area.is_blind;
    return Logs(select(logs.across, vec4<u32>(0u), blind.x), select(logs.down, vec4<u32>(0u), blind.y));
}
#endif

fn sums_of(area: areas::Area) -> Sums {
    return Sums(vec4<u32>(area.error.x), vec4<u32>(area.error.y), vec4<u32>(area.light));
}

fn decide(tile: u32, origin: vec2<u32>, room: vec2<u32>) -> u32 {
    let corner = vec2<u32>(tile % areas::ACROSS, tile / areas::ACROSS) * areas::SIDE;
    if any(corner >= room) {
        return 0u;
    }
    let extent = min(room - corner, vec2<u32>(areas::SIDE));
    if params.has_history == 0u {
        return full(because::NO_HISTORY);
    }
#ifdef DOUBT
    let doubt = atomicLoad(&lost[tile]);
    if doubt != 0xffffffffu {
        return full(because::of_doubt(doubt));
    }
    if atomicLoad(&invalid[tile]) != 0u {
        return full(because::INVALID);
    }
#endif
    var marks = 0u;
#ifdef FLAGS
    marks = atomicLoad(&marked[tile]);
    if (marks & 4u) != 0u {
        return full(because::MASK);
    }
#endif
    let zero = vec4<u32>(0u);
    let none = Logs(zero, zero);
    var places = Places(none, none, zero, vec4<u32>(255u));
#ifdef MATERIALS
    places.shine = vec4<u32>(atomicLoad(&shine[tile]));
    if places.shine.x >= params.material_mirror {
        return full(because::MATERIAL);
    }
#endif
#ifdef MOTION
    let speed = source::speeds_of_key(vec2<u32>(atomicLoad(&slowest[tile * 2u]), atomicLoad(&slowest[tile * 2u + 1u])));
    places.speed = Logs(vec4<u32>(speed.x), vec4<u32>(speed.y));
#endif
#ifdef PREVIOUS_RATES
    places.previous = Logs(vec4<u32>(atomicLoad(&finest[tile * 2u])), vec4<u32>(atomicLoad(&finest[tile * 2u + 1u])));
#endif
#ifdef NOISE
    places.noise = vec4<u32>(atomicLoad(&noisiest[tile]));
#endif
#ifdef LOCAL_TOLERANCE
    let low = (origin + corner) / 2u;
    let tolerance = tolerance_of(low, low + (extent + 1u) / 2u, places);
    let across = limits_under(tolerance, places.previous.across);
    let down = limits_under(tolerance, places.previous.down);
#else
    let tolerance = vec4<u32>(params.tolerance);
    let across = limits_everywhere(places.previous.across);
    let down = limits_everywhere(places.previous.down);
#endif
    let area = areas::area_of(tile, extent, 0u);
#ifdef MOTION_ONLY
    let solid = legal(logs_of(sums_of(area), places.speed, across, down));
#else
    let solid = legal(seen(logs_of(sums_of(area), places.speed, across, down), area));
#endif
    var rate = vec2<u32>(solid.across.x, solid.down.x);
    var attached = rate;
    var attached_error = area.error;
#ifdef TRANSPARENTS
    let after = areas::area_of(tile, extent, 1u);
    let behind = legal(seen(logs_of(sums_of(after), places.speed, across, down), after));
    attached = vec2<u32>(behind.across.x, behind.down.x);
    attached_error = after.error;
    // transparents can make a solid coarser, never finer
    rate = max(rate, attached);
#endif
    let plain = rate;
    var reason = because::CONTENT;
#ifdef MOTION_ONLY
    reason = because::MOTION;
#endif
#ifdef MOTION
#ifdef REASONS
    reason = select(reason, because::NO_MOTION, atomicLoad(&unknown[tile]) != 0u);
#endif
#endif
    reason = select(reason, 0u, all(rate == largest()));
#ifdef HALF_RATE
    let again = all(rate != vec2<u32>(0u))
        && (places.speed.across.x < params.half_fast || places.speed.down.x < params.half_fast)
        && (marks & 2u) == 0u
        && places.noise.x != 0u;
    if again {
        let less = (FACTOR_ONE - params.half_tolerance) * places.noise / 255u;
        let strict = scaled(tolerance, FACTOR_ONE - less);
        let again_across = limits_under(strict, places.previous.across);
        let again_down = limits_under(strict, places.previous.down);
        let second = seen(logs_of(sums_of(area), places.speed, again_across, again_down), area);
        let met = legal(Logs(min(vec4<u32>(rate.x), second.across), min(vec4<u32>(rate.y), second.down)));
        var stays = vec2<u32>(met.across.x, met.down.x);
        if all(stays == vec2<u32>(0u)) {
            stays = select(vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), area.error.x >> 2u <= area.error.y >> 2u);
        }
        reason = select(reason, because::HALF_RATE, any(stays != rate));
        rate = stays;
    }
#endif
    return packed(allowed(rate, area.error), allowed(attached, attached_error), allowed(plain, area.error), reason);
}

// A code, given its logs; a rate of 4 holds for whole blocks.
fn code_of(logs: u32, is_whole: bool) -> u32 {
    let most = select(1u, 2u, is_whole);
    return (min(logs & 3u, most) << 2u) | min((logs >> 2u) & 3u, most);
}

@compute @workgroup_size(256)
fn tiles(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let origin = group.xy * areas::REGION;
    let room = min(params.size - origin, vec2<u32>(areas::REGION));
    let quad = vec2<u32>(index & 15u, index >> 4u);
    let tile = areas::tile_of(quad);
#ifdef CODES
    pictures::share_codes(index, areas::INVOCATIONS);
#endif
    areas::clear(index);
    clear(index);
    workgroupBarrier();
    var pasts: array<vec2<u32>, 4>;
    for (var i = 0u; i < 4u; i++) {
        let p = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
        if all(p < room) {
            pasts[i] = look(p, origin + p, tile);
        }
    }
    workgroupBarrier();
    areas::gather(quad, room, 0u);
#ifdef TRANSPARENTS
    workgroupBarrier();
    for (var i = 0u; i < 4u; i++) {
        let p = quad * 2u + vec2<u32>(i & 1u, i >> 1u);
        if all(p < room) {
            let value = pictures::after_at(pasts[i]);
            areas::keep(p, value);
#ifdef DOUBT
            // what is lost comes first
            if value.w == BAD {
                atomicOr(&invalid[tile], 1u);
            }
#endif
        }
    }
    workgroupBarrier();
    areas::gather(quad, room, 1u);
#endif
    workgroupBarrier();
    if index < areas::COUNT {
        found[index] = decide(index, origin, room);
    }
    workgroupBarrier();

    let quads = (params.size + 1u) / 2u;
    let at = vec2<u32>((index & 3u) * 4u, index >> 2u);
    let first = origin / 2u + at;
    if index >= 64u || any(first >= quads) {
        return;
    }
    var word = 0u;
    var attached = 0u;
    var plain = 0u;
    var why = 0u;
    for (var i = 0u; i < min(quads.x - first.x, 4u); i++) {
        let of_tile = found[areas::tile_of(vec2<u32>(at.x + i, at.y))];
        let is_whole = all((vec2<u32>(first.x + i, first.y) | vec2<u32>(1u)) < quads);
        word |= code_of(of_tile, is_whole) << (i * 8u);
        attached |= code_of(of_tile >> 4u, is_whole) << (i * 8u);
        plain |= code_of(of_tile >> 8u, is_whole) << (i * 8u);
        why |= (of_tile >> 16u) << (i * 8u);
    }
    let to = first.y * params.sri_pitch + (first.x >> 2u);
#ifndef ATTACHMENT_ALONE
    rates[to] = word;
#endif
#ifdef ATTACHMENT
    attachment[to] = attached;
#endif
#ifdef PLAIN
    plain_rates[to] = plain;
#endif
#ifdef REASONS
    reasons[to] = why;
#endif
}
