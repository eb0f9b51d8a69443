// Depth for kernels, in integers; its twin is src/analyse/params.rs.
#define_import_path vrcs::depth

// What no depth has.
const NO_DEPTH: u32 = 0xffffffffu;

// The upper 32 bits of a product.
fn high_product(a: u32, b: u32) -> u32 {
    let al = a & 0xffffu;
    let ah = a >> 16u;
    let bl = b & 0xffffu;
    let bh = b >> 16u;
    let middle = ah * bl + ((al * bl) >> 16u);
    let low = al * bh + (middle & 0xffffu);
    return ah * bh + (middle >> 16u) + (low >> 16u);
}

// Inverse distance, 1 at the near plane, in 1/2^30; NO_DEPTH for what is none. `offset` is near over far in the same unit. Bits
// are looked at, since drivers may take compares of NaN apart. Without a branch: it is asked for every pixel of a window that is unrolled,
// and some compilers take gigabytes for so many ways.
fn inverse_distance(depth: f32, offset: u32, is_reversed: bool) -> u32 {
    let bits = bitcast<u32>(depth);
    let is_none = (bits != 0x80000000u) & (bits > 0x3f800000u);
    let scaled = u32(depth * 1073741824.0);
    let toward = select((1u << 30u) - scaled, scaled, is_reversed);
    // the near plane itself is 2^30, of which two bits more would be lost
    let inverse = toward + offset - high_product(min(toward, (1u << 30u) - 1u) << 2u, offset);
    return select(inverse, NO_DEPTH, is_none);
}
