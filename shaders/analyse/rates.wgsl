// The rates of a block's four quads by content and motion (Eq. 16 and 22), under the tolerance of their place.
#define_import_path vrcs::analyse::rates

#import vrcs::analyse::params::{params, tables, largest, ONE, FACTOR_ONE, TABLE_SPEEDS, TABLE_FALLOFF, FALLOFF}
#import vrcs::analyse::fixed::{Mags, below, unpacked, product, times_below, is_less}
#import vrcs::depth::high_product
#import vrcs::analyse::sums::Sums

// Two logs for each of four quads.
struct Logs {
    across: vec4<u32>,
    down: vec4<u32>,
}

// What decisions depend on beside the windows.
struct Places {
    // The least speed of the window.
    speed: Logs,
    // Log2 of the previous rate.
    previous: Logs,
    shine: vec4<u32>,
    noise: vec4<u32>,
}

fn scaled(tolerance: vec4<u32>, by: vec4<u32>) -> vec4<u32> {
    return min((tolerance * by) >> vec4<u32>(12u), vec4<u32>(0xffffu));
}

#ifdef FOVEATION
fn falloff_at(quad: vec2<u32>) -> u32 {
    let d = abs(vec2<i32>(quad) * 2 - params.centre);
    let index = high_product(u32(d.x * d.x + d.y * d.y), params.falloff_scale);
    return tables[TABLE_FALLOFF + min(index, FALLOFF - 1u)];
}
#endif

#ifdef SAFE_AREA
fn safety_at(quad: vec2<u32>) -> u32 {
    let at = quad * 2u;
    let is_border = any(at < vec2<u32>(params.safe_width)) || any(at + params.safe_width >= params.size);
    return select(FACTOR_ONE, params.safe_tolerance, is_border);
}
#endif

#ifdef MATERIALS
// What of a tolerance is left to smooth metal in slow motion.
fn calmed(tolerance: vec4<u32>, places: Places) -> vec4<u32> {
    let speed = max(places.speed.across, places.speed.down);
    let most = (FACTOR_ONE - params.material_least) * (places.shine >> vec4<u32>(4u)) / 4064u;
    // where the speed is high enough there is nothing to subtract
    let still = params.material_slow - min(speed, vec4<u32>(params.material_slow));
    let slow = most * still / max(params.material_slow, 1u);
    return scaled(tolerance, FACTOR_ONE - min(slow, vec4<u32>(FACTOR_ONE)));
}
#endif

// The tolerance of quads, the first of which is given.
fn tolerances(quad: vec2<u32>, places: Places) -> vec4<u32> {
    let right = vec2<u32>(1u, 0u);
    let under = vec2<u32>(0u, 1u);
    var tolerance = vec4<u32>(params.tolerance);
#ifdef SAFE_AREA
    tolerance = scaled(tolerance, vec4<u32>(
        safety_at(quad), safety_at(quad + right), safety_at(quad + under), safety_at(quad + 1u)));
#endif
#ifdef FOVEATION
    tolerance = scaled(tolerance, vec4<u32>(
        falloff_at(quad), falloff_at(quad + right), falloff_at(quad + under), falloff_at(quad + 1u)));
#endif
#ifdef MATERIALS
    tolerance = calmed(tolerance, places);
#endif
    return tolerance;
}

// What errors on an axis are compared with.
struct Limits {
    half: Mags,
    quarter: Mags,
}

// params::limit
fn limit_of(reach: Mags, tolerance: vec4<u32>) -> Mags {
    let limit = times_below(reach, below(tolerance));
#ifdef NORM_LINF
    return limit;
#else
#ifdef SQUARED
    return times_below(times_below(limit, limit), below(vec4<u32>(#{PAIRS}u)));
#else
    return times_below(limit, below(vec4<u32>(#{PAIRS}u)));
#endif
#endif
}

// Of three words the one of the previous rate.
fn by_previous(words: vec4<u32>, previous: vec4<u32>) -> Mags {
#ifdef PREVIOUS_RATES
    let coarser = select(vec4<u32>(words.y), vec4<u32>(words.z), previous >= vec4<u32>(2u));
    return unpacked(select(coarser, vec4<u32>(words.x), previous == vec4<u32>(0u)));
#else
    return unpacked(vec4<u32>(words.x));
#endif
}

// Under a tolerance of the place.
fn limits_under(tolerance: vec4<u32>, previous: vec4<u32>) -> Limits {
    return Limits(
        limit_of(by_previous(params.reach_half, previous), tolerance),
        limit_of(by_previous(params.reach_quarter, previous), tolerance),
    );
}

// Under the tolerance that holds everywhere, worked out by the CPU.
fn limits_everywhere(previous: vec4<u32>) -> Limits {
    return Limits(by_previous(params.limit_half, previous), by_previous(params.limit_quarter, previous));
}

// The table's entries by speed, of the half rate (0) or the quarter rate (1).
fn entries(speed: vec4<u32>, rate: u32) -> vec4<u32> {
#ifdef MOTION
    let at = vec4<u32>(TABLE_SPEEDS + rate) + speed * 2u;
    return vec4<u32>(tables[at.x], tables[at.y], tables[at.z], tables[at.w]);
#else
    return vec4<u32>(tables[TABLE_SPEEDS + rate]);
#endif
}

// What errors have to be less than: the table has the limits in it where they are the same everywhere.
fn bounds(base: Mags, limit: Mags, speed: vec4<u32>, rate: u32) -> Mags {
    let entry = unpacked(entries(speed, rate));
#ifdef FIXED_LIMITS
    return product(base, entry);
#else
    return product(base, times_below(limit, entry));
#endif
}

fn logs_on(error: vec4<u32>, speed: vec4<u32>, base: Mags, limits: Limits, most: u32) -> vec4<u32> {
    let is_half = is_less(error, bounds(base, limits.half, speed, 0u));
    var logs = select(vec4<u32>(0u), vec4<u32>(1u), is_half);
#ifdef QUARTERS
    if any(is_half) {
        let is_quarter = is_less(error, bounds(base, limits.quarter, speed, 1u));
        logs += select(vec4<u32>(0u), vec4<u32>(1u), is_half & is_quarter);
    }
#endif
    return min(logs, vec4<u32>(most));
}

// No 4 beside a 1.
fn legal(logs: Logs) -> Logs {
#ifndef QUARTERS
    return logs;
#else
    let one = vec4<u32>(1u);
    let zero = vec4<u32>(0u);
    return Logs(
        select(logs.across, min(logs.across, one), logs.down == zero),
        select(logs.down, min(logs.down, one), logs.across == zero),
    );
#endif
}

fn logs_of(sums: Sums, speed: Logs, across: Limits, down: Limits) -> Logs {
    let most = largest();
#ifdef STANDALONE
    let half = Logs(entries(speed.across, 0u), entries(speed.down, 0u));
    let quarter = Logs(entries(speed.across, 1u), entries(speed.down, 1u));
    return Logs(
        min(half.across + (half.across & quarter.across), vec4<u32>(most.x)),
        min(half.down + (half.down & quarter.down), vec4<u32>(most.y)),
    );
#else
#ifdef LADDER
    let step = max(entries(speed.across, 0u), entries(speed.down, 0u));
    // 1x1, 2x1, 2x2, 4x2, 4x4
    let code = (vec4<u32>(0xa9540u) >> (min(step, vec4<u32>(4u)) * 4u)) & vec4<u32>(15u);
    return Logs(min(code >> vec4<u32>(2u), vec4<u32>(most.x)), min(code & vec4<u32>(3u), vec4<u32>(most.y)));
#else
#ifdef PAIRWISE
    var base = below(vec4<u32>(ONE));
#else
#ifdef ABSOLUTE
    var base = below(vec4<u32>(16u * ONE));
#else
    var base = below(sums.brightness + vec4<u32>(16u * params.ambient));
#endif
#endif
#ifdef SQUARED
    base = times_below(base, base);
#endif
    return Logs(
        logs_on(sums.across, speed.across, base, across, most.x),
        logs_on(sums.down, speed.down, base, down, most.y),
    );
#endif
#endif
}
