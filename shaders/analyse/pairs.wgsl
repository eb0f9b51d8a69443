// What a pair of pixels adds to an estimate, whatever area it is of: a quad's window (analyse/sums.wgsl) or a tile (analyse/areas.wgsl).
// Channels and luma of a pixel are x, y, z and w.
#define_import_path vrcs::analyse::pairs

#import vrcs::analyse::params::{params, ONE}
#import vrcs::analyse::fixed::luma

fn apart(a: vec4<u32>, b: vec4<u32>) -> u32 {
    let d = max(a, b) - min(a, b);
#ifdef LARGEST_CHANNEL
    return max(d.x, max(d.y, d.z));
#else
#ifdef RGB
    return luma(d.xyz);
#else
    return d.w;
#endif
#endif
}

// A sum, or a maximum, that a pair has joined.
fn joined(sum: u32, a: vec4<u32>, b: vec4<u32>, sensitivity: u32) -> u32 {
#ifdef SOBEL
    // sums of four pixels each, two apart: eight steps from pixel to pixel
    var d = (apart(a, b) + 7u) >> 3u;
    let least = min(a.w, b.w) >> 2u;
#else
    var d = apart(a, b);
    let least = min(a.w, b.w);
#endif
#ifdef PAIRWISE
    let base = least + sensitivity;
    if d != 0u {
        d = select(min(((d << 10u) + max(base, 1u) - 1u) / max(base, 1u), 16383u), 16383u, base == 0u);
    }
#endif
#ifdef MEAN
    return sum + d;
#else
#ifdef NORM_LINF
    return max(sum, d);
#else
    return sum + d * d;
#endif
#endif
}

#ifdef PAIRWISE
// What is added to a pair's luma, given the darkest pixel of its area: less the darker that is.
fn sensitivity_under(darkest: u32) -> u32 {
    let ramp = min(max(50u * darkest, 5u * ONE / 2u) - 5u * ONE / 2u, ONE);
    return (params.sensitivity * (ONE - ramp)) >> 14u;
}
#endif
