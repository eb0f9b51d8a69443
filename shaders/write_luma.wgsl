// √luma of the previous picture, 8 bits a pixel, for later frames to use instead of its colour: an invocation makes one word, four pixels;
// after transparents if they are told apart. Its twin is integer::analyse, its parameters those of the analysis.

#import vrcs::analyse::params::{params, ONE}
#import vrcs::analyse::fixed::BAD
#import vrcs::analyse::pictures

@group(0) @binding(14) var<storage, read_write> sqrt_luma: array<u32>;

// round(255 sqrt(luma / white)): the root is guessed in float, and made exact in integers.
fn sqrt_code(value: u32) -> u32 {
    let square = (min(value, ONE) * 260100u) >> 14u;
    let guess = u32(sqrt(f32(square)) * 0.5 + 0.5);
    let more = select(0u, 1u, (2u * guess + 1u) * (2u * guess + 1u) <= square);
    let odd = max(2u * guess, 1u) - 1u;
    let less = select(0u, 1u, guess > 0u && odd * odd > square);
    return guess + more - less;
}

@compute @workgroup_size(16, 16)
fn write_luma(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) index: u32) {
#ifdef CODES
    pictures::share_codes(index, 256u);
    workgroupBarrier();
#endif
    if id.x * 4u >= params.previous.x || id.y >= params.previous.y {
        return;
    }
    var word = 0u;
    for (var i = 0u; i < 4u; i++) {
        let p = vec2<u32>(id.x * 4u + i, id.y);
        if p.x < params.previous.x {
#ifdef TRANSPARENTS
            let value = pictures::after_at(p).w;
#else
            let value = pictures::before_at(p).w;
#endif
            // what has no luma is white, which does not hide
            word |= select(sqrt_code(value), 255u, value == BAD) << (i * 8u);
        }
    }
    sqrt_luma[id.y * params.luma_pitch + id.x] = word;
}
