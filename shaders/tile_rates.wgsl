// The rate of a tile of 16x16 pixels (GDC 2019, pass 2): its furthest depth tells how it moved, the previous picture's tiles are fetched
// there between four of them, and motion and the shiniest of its surfaces scale what they say. A workgroup makes a tile. Its CPU twin is src/analyse/tiles.rs.

#import vrcs::analyse::params::{params, largest, SPEEDS, here, before}
#ifdef MATERIALS_NOW
#import vrcs::analyse::fixed::byte_of
#endif
#import vrcs::depth::high_product
#import vrcs::analyse::because
#import vrcs::analyse::optics::camera_motion_at
#import vrcs::analyse::source::{depth, is_lost_motion, magnitudes, position_of, speeds_of}
#ifdef DEPTH
#import vrcs::analyse::source::{depth_before, inverse_depth, was_covered}
#endif
#import vrcs::analyse::sums::Sums
#import vrcs::analyse::rates::{Logs, Places, legal, logs_of, limits_everywhere, limits_under, tolerances}

@group(0) @binding(2) var<storage, read_write> rates: array<u32>;
#ifdef ATTACHMENT
@group(0) @binding(5) var<storage, read_write> attachment: array<u32>;
#endif
#ifdef REASONS
@group(0) @binding(6) var<storage, read_write> reasons: array<u32>;
#endif
#ifdef MATERIALS_NOW
@group(0) @binding(11) var materials: texture_2d<f32>;
#endif
@group(0) @binding(19) var<storage, read_write> tile_data: array<vec4<u32>>;

// The bits of the furthest depth. Bits of what is not negative are in its order.
var<workgroup> furthest: atomic<u32>;
var<workgroup> is_lost: atomic<u32>;
// Whether a pixel was off the screen, or hidden.
var<workgroup> is_outside: atomic<u32>;
var<workgroup> is_hidden: atomic<u32>;
#ifdef MATERIALS_NOW
// The most smoothness * Rf0.
var<workgroup> shine: atomic<u32>;
#endif
// How the tile moved: the bits of its vector; then where it comes from, as an offset in 1/256 previous pixels.
var<workgroup> moved: vec2<u32>;
var<workgroup> shift: vec2<i32>;
// Log2 of the rate across and down, and the reason.
var<workgroup> found: vec3<u32>;

fn full(reason: u32) -> vec3<u32> {
    return vec3<u32>(0u, 0u, reason);
}

// A share of a value, in 1/65536, rounded up.
fn share_above(value: vec2<u32>, weight: u32) -> vec2<u32> {
    return (value >> vec2<u32>(16u)) * weight
        + (((value & vec2<u32>(0xffffu)) * weight + vec2<u32>(0xffffu)) >> vec2<u32>(16u));
}

// Finds how a tile moved, by its furthest depth; the reason if that is not known.
fn move_tile(low: vec2<u32>, high: vec2<u32>, far: f32) -> u32 {
    moved = camera_motion_at(vec2<f32>(low + high) * 0.5, far);
    shift = vec2<i32>(0);
    if is_lost_motion(moved) {
        return because::NO_MOTION;
    }
    let offset = bitcast<vec2<f32>>(moved) * params.offset_scale;
    // a magnitude below 2^23 surely is a number that fits
    if any((bitcast<vec2<u32>>(offset) & vec2<u32>(0x7fffffffu)) >= vec2<u32>(0x4b000000u)) {
        return because::OFF_SCREEN;
    }
    shift = (vec2<i32>(floor(offset)) + 1) >> vec2<u32>(1u);
    return 0u;
}

// Looks whether a pixel was off the screen, or hidden by something nearer, if it moved as its tile did.
fn look_back(p: vec2<u32>) {
    let position = (vec2<i32>(position_of(p)) + shift) >> vec2<u32>(8u);
    if any(position < vec2<i32>(0)) || any(position >= vec2<i32>(params.previous)) {
        atomicOr(&is_outside, 1u);
        return;
    }
#ifdef DEPTH
    let now = inverse_depth(textureLoad(depth, here(p), 0).x);
    let then = inverse_depth(textureLoad(depth_before, before(vec2<u32>(position)), 0).x);
    if was_covered(now, then) {
        atomicOr(&is_hidden, 1u);
    }
#endif
}

fn decide(low: vec2<u32>, high: vec2<u32>) -> vec3<u32> {
    if atomicLoad(&is_outside) != 0u {
        return full(because::OFF_SCREEN);
    }
    if atomicLoad(&is_hidden) != 0u {
        return full(because::DISOCCLUDED);
    }
    // of the whole tile, also where the picture ends before: at rest a tile has its own data alone
    let middle = low * 256u + 2048u;
    let position = shift
        + vec2<i32>(i32(high_product(middle.x << 8u, params.ratio.x)), i32(high_product(middle.y << 8u, params.ratio.y)));
    // between the middles of four tiles
    let tiles = vec2<i32>((params.previous + 15u) / 16u);
    let at = position - 2048;
    let first = at >> vec2<u32>(12u);
    let part = vec2<u32>(at & vec2<i32>(4095)) >> vec2<u32>(4u);
    var errors = vec2<u32>(0u);
    var light = 0u;
    var dull = 0u;
    for (var i = 0u; i < 4u; i++) {
        let step = vec2<u32>(i & 1u, i >> 1u);
        let sides = select(256u - part, part, step == vec2<u32>(1u));
        let weight = sides.x * sides.y;
        let tile = clamp(first + vec2<i32>(step), vec2<i32>(0), tiles - 1);
        let data = tile_data[u32(tile.y * tiles.x + tile.x)];
        if weight != 0u && (data.w >> 31u) != 0u {
            return full(because::INVALID);
        }
        errors += share_above(data.xy, weight);
        // rounded down: to a lower threshold
        light += (data.z * (weight >> 4u)) >> 12u;
        // rounded up: to a shinier surface
        dull += share_above(vec2<u32>(data.w & 0x7fffffffu), weight).x;
    }
    let fast = speeds_of(magnitudes(moved));
    let speed = Logs(vec4<u32>(fast.x), vec4<u32>(fast.y));
    let sums = Sums(vec4<u32>(errors.x), vec4<u32>(errors.y), vec4<u32>(light));
    let none = vec4<u32>(0u);
#ifdef MATERIALS
#ifdef MATERIALS_NOW
    let most = atomicLoad(&shine);
#else
    let most = dull;
#endif
    if most >= params.material_mirror {
        return full(because::MATERIAL);
    }
    let places = Places(speed, Logs(none, none), vec4<u32>(most), vec4<u32>(255u));
    let limits = limits_under(tolerances(low / 2u, places), none);
#else
    let limits = limits_everywhere(none);
#endif
    let logs = legal(logs_of(sums, speed, limits, limits));
    var rate = vec2<u32>(logs.across.x, logs.down.x);
#ifdef MOTION_ONLY
    let why = because::MOTION;
#else
    let why = because::CONTENT;
#endif
    let reason = select(why, 0u, all(rate == largest()));
    if all(rate == vec2<u32>(2u)) && params.largest != 10u {
        rate = select(vec2<u32>(1u, 2u), vec2<u32>(2u, 1u), errors.x >> 2u <= errors.y >> 2u);
    }
    return vec3<u32>(rate, reason);
}

@compute @workgroup_size(64)
fn tile_rates(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let low = group.xy * 16u;
    let high = min(low + 16u, params.size);
    if index == 0u {
        atomicStore(&furthest, select(0u, 0xffffffffu, params.reversed_z != 0u));
        atomicStore(&is_lost, 0u);
        atomicStore(&is_outside, 0u);
        atomicStore(&is_hidden, 0u);
#ifdef MATERIALS_NOW
        atomicStore(&shine, 0u);
#endif
    }
    workgroupBarrier();
    for (var i = index; i < 256u; i += 64u) {
        let p = low + vec2<u32>(i & 15u, i >> 4u);
        if all(p < high) {
            let bits = bitcast<u32>(textureLoad(depth, here(p), 0).x);
            let value = select(bits, 0u, bits == 0x80000000u);
            if value > 0x3f800000u {
                atomicOr(&is_lost, 1u);
            } else if params.reversed_z != 0u {
                atomicMin(&furthest, value);
            } else {
                atomicMax(&furthest, value);
            }
#ifdef MATERIALS_NOW
            let surface = textureLoad(materials, here(p), 0).xy;
            atomicMax(&shine, byte_of(surface.x) * byte_of(surface.y));
#endif
        }
    }
    workgroupBarrier();
    if index == 0u {
        if params.has_history == 0u {
            found = full(because::NO_HISTORY);
        } else if atomicLoad(&is_lost) != 0u {
            // without depth there is no motion
            found = full(because::NO_MOTION);
        } else {
            found = full(move_tile(low, high, bitcast<f32>(atomicLoad(&furthest))));
        }
    }
    workgroupBarrier();
    if found.z == 0u {
        for (var i = index; i < 256u; i += 64u) {
            let p = low + vec2<u32>(i & 15u, i >> 4u);
            if all(p < high) {
                look_back(p);
            }
        }
    }
    workgroupBarrier();
    if index == 0u && found.z == 0u {
        found = decide(low, high);
    }
    workgroupBarrier();
    let quads = (params.size + 1u) / 2u;
    let first = low / 2u + vec2<u32>((index & 1u) * 4u, index >> 1u);
    if index >= 16u || any(first >= quads) {
        return;
    }
    var word = 0u;
    var why = 0u;
    for (var i = 0u; i < min(quads.x - first.x, 4u); i++) {
        // a rate of 4 holds for whole blocks
        let block = (vec2<u32>(first.x + i, first.y) | vec2<u32>(1u));
        let logs = select(min(found.xy, vec2<u32>(1u)), found.xy, all(block < quads));
        word |= ((logs.x << 2u) | logs.y) << (i * 8u);
        why |= found.z << (i * 8u);
    }
    let to = first.y * params.sri_pitch + (first.x >> 2u);
    rates[to] = word;
#ifdef ATTACHMENT
    attachment[to] = word;
#endif
#ifdef REASONS
    reasons[to] = why;
#endif
}
