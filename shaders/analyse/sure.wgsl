// What floats are sure of: an error is less than its limit, or is not, whatever either is rounded by.
//
// The integers' limit (fixed::below three times: the base, its square, and their product) is at most the exact one, and more than
// (1 - 2^-14)^3 of it. Floats are rounded to 24 bits, in which order and to which side soever. LOW and HIGH leave room for both.
#define_import_path vrcs::analyse::sure

#import vrcs::analyse::params::{params, tables, ONE, TABLE_SURE, TABLE_DOUBT}
#import vrcs::analyse::sums::Sums

// 1 - 2^-12 and 1 + 2^-16
const LOW: f32 = 0.999755859375;
const HIGH: f32 = 1.0000152587890625;

// A bit for each quad, across and down.
struct Bits {
    half: vec2<u32>,
    quarter: vec2<u32>,
    // The highest bit, if any of them is not sure.
    doubt: u32,
}

// The highest bits.
fn signs(words: vec4<u32>) -> u32 {
    var all = words.w >> 31u;
    all = (all << 1u) | (words.z >> 31u);
    all = (all << 1u) | (words.y >> 31u);
    return (all << 1u) | (words.x >> 31u);
}

// Which errors are less than base times limit; and in the highest bit, whether any of them is too close.
fn compared(error: vec4<f32>, base: vec4<f32>, limit: f32) -> vec2<u32> {
    let low = bitcast<vec4<u32>>(error - base * (limit * LOW));
    let high = bitcast<vec4<u32>>(error - base * (limit * HIGH));
    let apart = low ^ high;
    return vec2<u32>(signs(low), apart.x | apart.y | apart.z | apart.w);
}

fn sure_bits(sums: Sums) -> Bits {
#ifdef ABSOLUTE
    var base = vec4<f32>(f32(16u * ONE));
#else
    var base = vec4<f32>(sums.brightness + vec4<u32>(16u * params.ambient));
#endif
#ifdef SQUARED
    base *= base;
#endif
    let across = vec4<f32>(sums.across);
    let down = vec4<f32>(sums.down);
    let half = bitcast<f32>(tables[TABLE_SURE]);
    let half_across = compared(across, base, half);
    let half_down = compared(down, base, half);
    var bits = Bits(vec2<u32>(half_across.x, half_down.x), vec2<u32>(0u), half_across.y | half_down.y | tables[TABLE_DOUBT]);
#ifdef QUARTERS
    let quarter = bitcast<f32>(tables[TABLE_SURE + 1u]);
    let quarter_across = compared(across, base, quarter);
    let quarter_down = compared(down, base, quarter);
    bits.quarter = vec2<u32>(quarter_across.x, quarter_down.x);
    bits.doubt |= quarter_across.y | quarter_down.y;
#endif
    return bits;
}
