// The analysis of √luma where content alone decides; analyse.wgsl makes the same words, and those of all other plans.
//
// An invocation takes eight pixels across, four quads and so a word of rates, and goes down: each line of ten pixels is looked at once,
// the last two stay in registers. Floats compare first: with a margin for all that the integers round and they round themselves, so that
// what they are sure of is what the integers say (analyse/sure.wgsl); where they are not, about once in ten thousand, the integers decide.
// Compiled twice: with WHOLE, for a previous picture of the same size whose width is a multiple of 8, without the way for any other, which
// hardly runs and costs registers.

#import vrcs::analyse::params::{params, largest}
#import vrcs::analyse::rates::{Logs, logs_of, limits_everywhere}
#import vrcs::analyse::strips::{Strip, strip_of, sums_between}
#import vrcs::analyse::sums::Sums
#import vrcs::analyse::sure::{Bits, sure_bits}
#import vrcs::analyse::lines::line_at

// Invocations side by side, and blocks of 4x4 pixels that each goes down, twice.
const COLUMNS: u32 = #{TILE_WIDTH}u / 8u;
const BLOCKS: u32 = 2u;
const THREADS: u32 = COLUMNS * #{TILE_HEIGHT}u / (4u * BLOCKS);

@group(0) @binding(2) var<storage, read_write> rates: array<u32>;
#ifdef ATTACHMENT
@group(0) @binding(5) var<storage, read_write> attachment: array<u32>;
#endif

// A bit for each quad.
fn bits_of(logs: vec4<u32>, least: u32) -> u32 {
    let is_it = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), logs >= vec4<u32>(least));
    return is_it.x | is_it.y | is_it.z | is_it.w;
}

// What the integers say.
fn exact_bits(sums: Sums) -> Bits {
    let none = vec4<u32>(0u);
    let logs = logs_of(sums, Logs(none, none), limits_everywhere(none), limits_everywhere(none));
    return Bits(
        vec2<u32>(bits_of(logs.across, 1u), bits_of(logs.down, 1u)),
        vec2<u32>(bits_of(logs.across, 2u), bits_of(logs.down, 2u)),
        0u,
    );
}

fn decided(sums: Sums) -> Bits {
    var bits = sure_bits(sums);
    if (bits.doubt >> 31u) != 0u {
        bits = exact_bits(sums);
    }
    return bits;
}

// Four bits to the lowest ones of four bytes.
fn spread(bits: u32) -> u32 {
    return (bits * 0x00204081u) & 0x01010101u;
}

#ifdef QUARTERS
// Of bits of two rows of quads, those of blocks of which all four have them.
fn of_blocks(upper: u32, lower: u32) -> u32 {
    let both = upper & lower;
    return (both & (both >> 1u) & 5u) * 3u;
}
#endif

// The codes of a row of four quads, given which are half and which a quarter on each axis.
fn word_of(half: vec2<u32>, quarter: vec2<u32>) -> u32 {
#ifdef QUARTERS
    let one = half & ~quarter;
    return (spread(one.x) << 2u) | spread(one.y) | (spread(quarter.x) << 3u) | (spread(quarter.y) << 1u);
#else
    return (spread(half.x) << 2u) | spread(half.y);
#endif
}

fn store(row: u32, column: u32, word: u32) {
    let at = row * params.sri_pitch + column;
    rates[at] = word;
#ifdef ATTACHMENT
    attachment[at] = word;
#endif
}

@compute @workgroup_size(THREADS)
fn analyse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let origin = group.xy * vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
    let column = index % COLUMNS;
    var line = index / COLUMNS * (4u * BLOCKS);
    let to = origin / vec2<u32>(8u, 2u) + vec2<u32>(column, line / 2u);
    let quads = (params.size + 1u) / 2u;
    if to.x * 4u >= quads.x || to.y >= quads.y {
        return;
    }
#ifdef WHOLE
    let inside = 15u;
#else
    // quads outside the picture agree to nothing
    let inside = (1u << min(quads.x - to.x * 4u, 4u)) - 1u;
#endif
    let most = largest();
    let is_asked = params.has_history != 0u;
    let halves = select(vec2<u32>(0u), vec2<u32>(inside), (most >= vec2<u32>(1u)) & vec2<bool>(is_asked));
#ifdef QUARTERS
    let quarters = select(vec2<u32>(0u), halves, most >= vec2<u32>(2u));
#endif

    var strip = strip_of(line_at(origin, column, line), line_at(origin, column, line + 1u));
#ifdef QUARTERS
    // a block's upper row waits for its lower one, which may lie outside
    var upper_half = vec2<u32>(0u);
    var upper_quarter = vec2<u32>(0u);
    let end = (quads.y + 1u) & 0xfffffffeu;
#else
    let end = quads.y;
#endif
    for (var row = to.y; row < min(to.y + 2u * BLOCKS, end); row++) {
        let middle = line_at(origin, column, line + 2u);
        let next = strip_of(middle, line_at(origin, column, line + 3u));
        let sums = sums_between(strip, middle, next);
        strip = next;
        line += 2u;
        let bits = decided(sums);
#ifdef QUARTERS
        let half = select(vec2<u32>(0u), bits.half & halves, row < quads.y);
        // no 4 beside a 1
        let quarter = bits.quarter & vec2<u32>(half.x & half.y) & quarters;
        if (row & 1u) == 0u {
            upper_half = half;
            upper_quarter = quarter;
        } else {
            let fours = vec2<u32>(of_blocks(upper_quarter.x, quarter.x), of_blocks(upper_quarter.y, quarter.y));
            store(row - 1u, to.x, word_of(upper_half, fours));
            if row < quads.y {
                store(row, to.x, word_of(half, fours));
            }
        }
#else
        store(row, to.x, word_of(bits.half & halves, vec2<u32>(0u)));
#endif
    }
}
