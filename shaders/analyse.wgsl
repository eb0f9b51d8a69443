// The analysis: a workgroup takes 128 pixels by 16, 8 or 4, an invocation a block of 4x4 of them, which are four quads.
//
// Its CPU twin is src/analyse/integer.rs; both make the same words. Only integers decide: see src/analyse/fixed.rs. What the scene does
// not declare is not here: no binding, no code. Pixels are read once, by neighbours side by side, into workgroup memory
// (analyse/cells.wgsl), but √luma where it lies (analyse/sums.wgsl); a block's windows are summed together (analyse/sums.wgsl) and decided on together (analyse/rates.wgsl); two
// neighbours then put the words together that their bytes share. shaders/NOTES.md tells what that brought.

#import vrcs::analyse::params::{params, largest, SPEEDS, FACTOR_ONE, here}
#ifdef MATERIALS_BEFORE
#import vrcs::analyse::params::before
#endif
#import vrcs::analyse::fixed::byte_of
#import vrcs::analyse::pictures
#import vrcs::analyse::source
#import vrcs::analyse::because
#ifdef SHARED
#import vrcs::analyse::cells::fill
#endif
#ifdef ASIDES
#import vrcs::analyse::cells::{asides, ROW, ODD}
#endif
#import vrcs::analyse::sums::sums_of
#import vrcs::analyse::rates::{Logs, Places, legal, logs_of, tolerances, scaled, limits_everywhere, limits_under}

@group(0) @binding(2) var<storage, read_write> rates: array<u32>;
#ifdef ATTACHMENT
@group(0) @binding(5) var<storage, read_write> attachment: array<u32>;
#endif
#ifdef REASONS
@group(0) @binding(6) var<storage, read_write> reasons: array<u32>;
#endif
#ifdef PLAIN
// without the extra half rate
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

const THREADS: u32 = #{TILE_WIDTH}u * #{TILE_HEIGHT}u / 16u;

// A block's bytes, to be put together with its neighbour's.
var<workgroup> coded: array<u32, THREADS>;
#ifdef PLAIN
var<workgroup> plain_coded: array<u32, THREADS>;
#endif
#ifdef REASONS
var<workgroup> reasoned: array<u32, THREADS>;
#endif

// The pixel i of a quad; at the border, pixels repeat.
fn own(quad: vec2<u32>, i: u32) -> vec2<u32> {
    return min(quad * 2u + vec2<u32>(i & 1u, i >> 1u), params.size - 1u);
}

#ifdef FLAGS
fn flags_at(quad: vec2<u32>) -> u32 {
    var flags = 0u;
    for (var i = 0u; i < 4u; i++) {
        flags |= textureLoad(source::marks, here(own(quad, i)), 0).x;
    }
    return flags;
}
#endif

#ifdef PAST
// The pixel of the previous picture that a pixel shows.
fn past_of(p: vec2<u32>) -> vec2<u32> {
#ifdef REPROJECTION
    return source::moved_source(p).xy;
#else
    return source::still_source(p);
#endif
}
#endif

#ifdef MATERIALS
fn shine_at(quad: vec2<u32>) -> u32 {
    var shine = 0u;
    for (var i = 0u; i < 4u; i++) {
#ifdef MATERIALS_BEFORE
        let surface = textureLoad(materials, before(past_of(own(quad, i))), 0).xy;
#else
        let surface = textureLoad(materials, here(own(quad, i)), 0).xy;
#endif
        shine = max(shine, byte_of(surface.x) * byte_of(surface.y));
    }
    return shine;
}
#endif

#ifdef NOISE
fn noise_at(quad: vec2<u32>) -> u32 {
    var most = 0u;
    for (var i = 0u; i < 4u; i++) {
        most = max(most, byte_of(textureLoad(noise, here(own(quad, i)), 0).x));
    }
    return most;
}
#endif

#ifdef PREVIOUS_RATES
// The code of the rate that a quad's source had; full rate if it is none.
fn previous_at(quad: vec2<u32>) -> u32 {
    let past = past_of(own(quad, 0u)) >> vec2<u32>(1u);
    let word = rates_before[past.y * params.previous_pitch + (past.x >> 2u)];
    let had = extractBits(word, (past.x & 3u) * 8u, 8u);
    return select(0u, had, had <= 10u && ((0x673u >> (had & 31u)) & 1u) != 0u);
}
#endif

#ifdef ASIDES
// The squares around a block's quads, three by three.
struct Around {
    upper: vec3<u32>,
    middle: vec3<u32>,
    lower: vec3<u32>,
}

fn squares_at(at: u32) -> vec3<u32> {
    return vec3<u32>(asides[at], asides[at + ODD], asides[at + 1u]);
}
#endif

#ifdef MOTION
// The least of each window's four squares.
fn least_of(upper: vec3<u32>, middle: vec3<u32>, lower: vec3<u32>) -> vec4<u32> {
    let above = min(upper, middle);
    let under = min(middle, lower);
    return vec4<u32>(min(above.xy, above.yz), min(under.xy, under.yz));
}

fn speeds_of(around: Around) -> Logs {
    let low = vec3<u32>(1023u);
    let ten = vec3<u32>(10u);
    return Logs(
        least_of(around.upper & low, around.middle & low, around.lower & low),
        least_of((around.upper >> ten) & low, (around.middle >> ten) & low, (around.lower >> ten) & low),
    );
}
#endif

#ifdef MOTION
#ifdef REASONS
// Whether a pixel of each window has no known motion.
fn lost_motions(around: Around) -> vec4<bool> {
    let above = around.upper | around.middle;
    let under = around.middle | around.lower;
    let any_of = vec4<u32>(above.xy | above.yz, under.xy | under.yz);
    return (any_of & vec4<u32>(1u << 25u)) != vec4<u32>(0u);
}
#endif
#endif

#ifdef DOUBT
// The reason of a window's first lost pixel, line by line; else whether one is invalid; else none.
fn doubt_of(a: u32, b: u32, c: u32, d: u32) -> u32 {
    if (((a | b | c | d) >> 20u) & 31u) == 0u {
        return 0u;
    }
    let lines = vec4<u32>(20u, 22u, 20u, 22u);
    let left = (vec4<u32>(a, a, c, c) >> lines) & vec4<u32>(3u);
    let right = (vec4<u32>(b, b, d, d) >> lines) & vec4<u32>(3u);
    let first = select(right, left, left != vec4<u32>(0u));
    var lost = first.w;
    lost = select(lost, first.z, first.z != 0u);
    lost = select(lost, first.y, first.y != 0u);
    lost = select(lost, first.x, first.x != 0u);
    return because::of_doubt(lost);
}
#endif

struct Block {
    rate: Logs,
    attachment: Logs,
    // before the extra half rate
    plain: Logs,
    reason: vec4<u32>,
    // of all four, across and down
    error: vec2<u32>,
}

// A quarter of each error, so that four of them fit.
fn together(errors: vec4<u32>) -> u32 {
    let quarters = errors >> vec4<u32>(2u);
    return quarters.x + quarters.y + quarters.z + quarters.w;
}

fn at_full_rate(reason: vec4<u32>) -> Block {
    let none = Logs(vec4<u32>(0u), vec4<u32>(0u));
    return Block(none, none, none, reason, vec2<u32>(0u));
}

// Decides on four quads, of which the first is given, and the block's place in the tile.
fn decide(quad: vec2<u32>, block: vec2<u32>) -> Block {
    if params.has_history == 0u {
        return at_full_rate(vec4<u32>(because::NO_HISTORY));
    }
    let right = vec2<u32>(1u, 0u);
    let under = vec2<u32>(0u, 1u);
    let zero = vec4<u32>(0u);
    let none = Logs(zero, zero);
    var places = Places(none, none, zero, vec4<u32>(255u));
    // why a quad is at full rate whatever its content
    var why = zero;
#ifdef ASIDES
    let at = block.y * 2u * ROW + block.x;
    let around = Around(squares_at(at), squares_at(at + ROW), squares_at(at + 2u * ROW));
#ifdef MOTION
    places.speed = speeds_of(around);
#endif
#ifdef DOUBT
    why = vec4<u32>(
        doubt_of(around.upper.x, around.upper.y, around.middle.x, around.middle.y),
        doubt_of(around.upper.y, around.upper.z, around.middle.y, around.middle.z),
        doubt_of(around.middle.x, around.middle.y, around.lower.x, around.lower.y),
        doubt_of(around.middle.y, around.middle.z, around.lower.y, around.lower.z),
    );
#endif
#endif
    var flags = zero;
#ifdef FLAGS
    flags = vec4<u32>(flags_at(quad), flags_at(quad + right), flags_at(quad + under), flags_at(quad + 1u));
    why = select(why, vec4<u32>(because::MASK), (why == zero) & ((flags & vec4<u32>(4u)) != zero));
#endif
#ifdef PREVIOUS_RATES
    let had = vec4<u32>(
        previous_at(quad), previous_at(quad + right), previous_at(quad + under), previous_at(quad + 1u));
    places.previous = Logs(had >> vec4<u32>(2u), had & vec4<u32>(3u));
#endif
#ifdef MATERIALS
    places.shine = vec4<u32>(shine_at(quad), shine_at(quad + right), shine_at(quad + under), shine_at(quad + 1u));
    why = select(why, vec4<u32>(because::MATERIAL), (why == zero) & (places.shine >= vec4<u32>(params.material_mirror)));
#endif
#ifdef NOISE
    places.noise = vec4<u32>(noise_at(quad), noise_at(quad + right), noise_at(quad + under), noise_at(quad + 1u));
#endif
    if all(why != zero) {
        return at_full_rate(why);
    }
#ifdef LOCAL_TOLERANCE
    let tolerance = tolerances(quad, places);
    let across = limits_under(tolerance, places.previous.across);
    let down = limits_under(tolerance, places.previous.down);
#else
    let tolerance = vec4<u32>(params.tolerance);
    let across = limits_everywhere(places.previous.across);
    let down = limits_everywhere(places.previous.down);
#endif
    let sums = sums_of(quad, block, 0u);
    let solid = legal(logs_of(sums, places.speed, across, down));
    var out = Block(solid, solid, solid, vec4<u32>(because::CONTENT), vec2<u32>(together(sums.across), together(sums.down)));
#ifdef TRANSPARENTS
    out.attachment = legal(logs_of(sums_of(quad, block, 1u), places.speed, across, down));
    // transparents can make a solid coarser, never finer
    out.rate = Logs(max(solid.across, out.attachment.across), max(solid.down, out.attachment.down));
#endif
#ifdef MOTION_ONLY
    out.reason = vec4<u32>(because::MOTION);
#endif
#ifdef MOTION
#ifdef REASONS
    out.reason = select(out.reason, vec4<u32>(because::NO_MOTION), lost_motions(around));
#endif
#endif
    let most = largest();
    let is_largest = (out.rate.across == vec4<u32>(most.x)) & (out.rate.down == vec4<u32>(most.y));
    out.reason = select(out.reason, zero, is_largest);
#ifdef PLAIN
    out.plain = out.rate;
#endif
#ifdef HALF_RATE
    let fast = vec4<u32>(params.half_fast);
    let again = (out.rate.across != zero)
        & (out.rate.down != zero)
        & ((places.speed.across < fast) | (places.speed.down < fast))
        & ((flags & vec4<u32>(2u)) == zero)
        & (places.noise != zero);
    if any(again) {
        let less = (FACTOR_ONE - params.half_tolerance) * places.noise / 255u;
        let strict = scaled(tolerance, FACTOR_ONE - less);
        let second = logs_of(
            sums,
            places.speed,
            limits_under(strict, places.previous.across),
            limits_under(strict, places.previous.down),
        );
        var met = legal(Logs(min(out.rate.across, second.across), min(out.rate.down, second.down)));
        let is_lost = (met.across == zero) & (met.down == zero);
        let is_across = (sums.across >> vec4<u32>(2u)) <= (sums.down >> vec4<u32>(2u));
        met.across = select(met.across, vec4<u32>(1u), is_lost & is_across);
        met.down = select(met.down, vec4<u32>(1u), is_lost & !is_across);
        let is_new = (met.across != out.rate.across) | (met.down != out.rate.down);
        out.reason = select(out.reason, vec4<u32>(because::HALF_RATE), again & is_new);
        out.rate = Logs(select(out.rate.across, met.across, again), select(out.rate.down, met.down, again));
    }
#endif
#ifdef FULL_RATES
    let is_full = why != zero;
    out.rate = Logs(select(out.rate.across, zero, is_full), select(out.rate.down, zero, is_full));
    out.attachment = Logs(select(out.attachment.across, zero, is_full), select(out.attachment.down, zero, is_full));
#ifdef PLAIN
    out.plain = Logs(select(out.plain.across, zero, is_full), select(out.plain.down, zero, is_full));
#endif
    out.reason = select(out.reason, why, is_full);
#endif
    return out;
}

fn least(of_quads: vec4<u32>) -> u32 {
    return min(min(of_quads.x, of_quads.y), min(of_quads.z, of_quads.w));
}

// The codes of four quads: a rate of 4 holds across and down where the block agrees.
fn codes_of(logs: Logs, error: vec2<u32>) -> vec4<u32> {
#ifndef QUARTERS
    return (logs.across << vec4<u32>(2u)) | logs.down;
#else
    let all_quads = vec2<u32>(least(logs.across), least(logs.down));
    var four = (all_quads == vec2<u32>(2u)) & (all_quads.yx >= vec2<u32>(1u));
    if all(four) && params.largest != 10u {
        four.x = error.x <= error.y;
        four.y = !four.x;
    }
    let most = select(vec2<u32>(1u), vec2<u32>(2u), four);
    return (min(logs.across, vec4<u32>(most.x)) << vec4<u32>(2u)) | min(logs.down, vec4<u32>(most.y));
#endif
}

fn packed(bytes: vec4<u32>) -> u32 {
    return bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u);
}

// The word that two blocks share: the left one has the upper quads' and the right one the lower quads'.
fn word_of(mine: u32, other: u32, is_right: bool) -> u32 {
    return select((mine & 0xffffu) | (other << 16u), (mine & 0xffff0000u) | (other >> 16u), is_right);
}

@compute @workgroup_size(THREADS)
fn analyse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let origin = group.xy * vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
#ifdef CODES
    pictures::share_codes(index, THREADS);
    workgroupBarrier();
#endif
#ifdef SHARED
    fill(index, THREADS, origin);
    workgroupBarrier();
#endif

    let quads = (params.size + 1u) / 2u;
    let block = vec2<u32>(index % (#{TILE_WIDTH}u / 4u), index / (#{TILE_WIDTH}u / 4u));
    let first = origin / 2u + block * 2u;
    var mine = 0u;
#ifdef PLAIN
    plain_coded[index] = 0u;
#endif
    if all(first < quads) {
        var decided = decide(first, block);
        // quads outside the picture agree to nothing
        let x = first.x + vec4<u32>(0u, 1u, 0u, 1u);
        let y = first.y + vec4<u32>(0u, 0u, 1u, 1u);
        let is_inside = (x < vec4<u32>(quads.x)) & (y < vec4<u32>(quads.y));
        let zero = vec4<u32>(0u);
        decided.rate.across = select(zero, decided.rate.across, is_inside);
        decided.rate.down = select(zero, decided.rate.down, is_inside);
        mine = packed(codes_of(decided.rate, decided.error));
#ifdef ATTACHMENT
        decided.attachment.across = select(zero, decided.attachment.across, is_inside);
        decided.attachment.down = select(zero, decided.attachment.down, is_inside);
        mine |= packed(codes_of(decided.attachment, decided.error)) << 4u;
#endif
#ifdef PLAIN
        decided.plain.across = select(zero, decided.plain.across, is_inside);
        decided.plain.down = select(zero, decided.plain.down, is_inside);
        plain_coded[index] = packed(codes_of(decided.plain, decided.error));
#endif
#ifdef REASONS
        reasoned[index] = packed(select(zero, decided.reason, is_inside));
#endif
    }
#ifdef REASONS
    else {
        reasoned[index] = 0u;
    }
#endif
    coded[index] = mine;
    workgroupBarrier();

    let is_right = (index & 1u) != 0u;
    let column = first.x >> 2u;
    let row = first.y + (index & 1u);
    if column * 4u < quads.x && row < quads.y {
        let to = row * params.sri_pitch + column;
        let word = word_of(mine, coded[index ^ 1u], is_right);
        rates[to] = word & 0x0f0f0f0fu;
#ifdef ATTACHMENT
        attachment[to] = (word >> 4u) & 0x0f0f0f0fu;
#endif
#ifdef PLAIN
        plain_rates[to] = word_of(plain_coded[index], plain_coded[index ^ 1u], is_right);
#endif
#ifdef REASONS
        reasons[to] = word_of(reasoned[index], reasoned[index ^ 1u], is_right);
#endif
    }
}
