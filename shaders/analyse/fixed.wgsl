// Numbers that every driver and the CPU agree on: the twin of src/analyse/fixed.rs, four at a time.
#define_import_path vrcs::analyse::fixed

// Magnitudes m * 2^e, m at most 2^15, or 2^30 where they are products.
struct Mags {
    m: vec4<u32>,
    e: vec4<i32>,
}

// At most x.
fn below(x: vec4<u32>) -> Mags {
    let shift = vec4<u32>(17u) - min(countLeadingZeros(x), vec4<u32>(17u));
    return Mags(x >> shift, vec4<i32>(shift));
}

fn unpacked(word: vec4<u32>) -> Mags {
    return Mags(word & vec4<u32>(0xffffu), vec4<i32>(word >> vec4<u32>(16u)) - vec4<i32>(512));
}

// Exact; to be compared, not multiplied.
fn product(a: Mags, b: Mags) -> Mags {
    return Mags(a.m * b.m, a.e + b.e);
}

fn times_below(a: Mags, b: Mags) -> Mags {
    let rounded = below(a.m * b.m);
    return Mags(rounded.m, rounded.e + a.e + b.e);
}

// Whole numbers against products: a < m * 2^e, which is rounded up.
fn is_less(a: vec4<u32>, b: Mags) -> vec4<bool> {
    let over = vec4<u32>(clamp(-b.e, vec4<i32>(0), vec4<i32>(30)));
    let under = vec4<u32>(clamp(b.e, vec4<i32>(0), vec4<i32>(31)));
    return (a >> under) < ((b.m + (vec4<u32>(1u) << over) - vec4<u32>(1u)) >> over);
}

// The bits of 2^n.
fn exponent(n: i32) -> u32 {
    return u32(clamp(n, -126, 127) + 127) << 23u;
}

// What stands for no number.
const BAD: u32 = 0xffffffffu;

// Units of luma of a linear value; BAD for what is none. Bits are looked at, since drivers may take compares of NaN apart.
fn quantise(value: f32, white_log: i32) -> u32 {
    let bits = bitcast<u32>(value);
    if bits >= 0x80000000u {
        return select(BAD, 0u, (bits & 0x7fffffffu) < exponent(white_log - 15));
    }
    if bits > exponent(white_log) {
        return BAD;
    }
    return u32(floor(value * bitcast<f32>(exponent(14 - white_log)) + 0.5));
}

// Luma of three channels (Eq. 25).
fn luma(c: vec3<u32>) -> u32 {
#ifdef REC709
    return (c.x * 3483u + c.y * 11718u + c.z * 1183u + 8192u) >> 14u;
#else
    return (c.x * 4899u + c.y * 9617u + c.z * 1868u + 8192u) >> 14u;
#endif
}

// A byte of 0 to 1. No number is 1: the shiniest surface, the strongest noise, and so the finer rate.
fn byte_of(value: f32) -> u32 {
    let is_none = (bitcast<u32>(value) & 0x7fffffffu) > 0x7f800000u;
    return select(u32(clamp(value, 0.0, 1.0) * 255.0 + 0.5), 255u, is_none);
}
