// The groups of pixels that share a value, and where that value was computed.
#define_import_path vrcs::deblock::groups

#import vrcs::deblock::params::params

@group(0) @binding(1) var<storage, read> rates: array<u32>;

// The words of rates of a workgroup's 16x16 quads, and of what lies around them: taps lie in a quad beside it, whose rate may be that of a
// block, two quads further. So taps need not wait for their rates after the quads' own.
const AROUND: vec2<u32> = vec2<u32>(6u, 20u);
var<workgroup> around: array<u32, AROUND.x * AROUND.y>;
// The first of those quads, which may lie outside the picture: wrapped.
var<private> corner: vec2<u32>;

// Has to be called by all 256 invocations of a workgroup, and be followed by a barrier.
fn load_rates(group: vec2<u32>, index: u32) {
    corner = group * 16u - vec2<u32>(4u, 2u);
    if index < AROUND.x * AROUND.y {
        let at = vec2<u32>(index % AROUND.x, index / AROUND.x);
        let quad = corner + at * vec2<u32>(4u, 1u);
        var word = 0u;
        if all(quad < (params.extent + 1u) / 2u) {
            word = rates[quad.y * params.rates_pitch + (quad.x >> 2u)];
        }
        around[index] = word;
    }
}

#ifdef SPLITS
const NO_RATE: u32 = 0x70u;
#else
// nobody declared coverage, so what it has split is left alone
const NO_RATE: u32 = 0xf0u;
#endif

// The byte of a quad, full rate outside the picture or if it is no code; bit 7 if coverage split its block.
fn byte_of(quad: vec2<u32>) -> u32 {
    if any(quad * 2u >= params.extent) {
        return 0u;
    }
    let at = quad - corner;
    let word = around[at.y * AROUND.x + (at.x >> 2u)];
    let byte = extractBits(word, (quad.x & 3u) * 8u, 8u);
    let code = byte & 15u;
    // 1x1, 1x2, 2x1, 2x2, 2x4, 4x2 and 4x4
    let is_rate = code <= 10u && ((0x673u >> code) & 1u) != 0u && (byte & NO_RATE) == 0u;
    return select(0u, byte, is_rate && code != 0u);
}

// The width and height of a quad's groups, as powers of two, and whether coverage split its block.
fn rate_of(quad: vec2<u32>) -> vec3<u32> {
    let byte = byte_of(quad);
    var rate = vec2<u32>((byte >> 2u) & 3u, byte & 3u);
    let split = byte >> 7u;
    if any(rate > vec2<u32>(1u)) {
        let block = quad & vec2<u32>(~1u);
        let agreed = split == 0u
            && byte_of(block) == byte
            && byte_of(block + vec2<u32>(1u, 0u)) == byte
            && byte_of(block + vec2<u32>(0u, 1u)) == byte
            && byte_of(block + vec2<u32>(1u, 1u)) == byte;
        if !agreed {
            rate = min(rate, vec2<u32>(1u));
        }
    }
    return vec3<u32>(rate, split);
}

// Where the value of a pixel's group was computed. No invocation ever writes there.
fn sample_of(pixel: vec2<u32>, rate: vec2<u32>) -> vec2<u32> {
    let corner = (pixel >> rate) << rate;
    var offset = vec2<u32>(0u);
    if params.phase != 0u {
        let odd = (params.phase - 1u) & 1u;
        if all(rate == vec2<u32>(1u, 0u)) {
            offset.x = (pixel.y + odd) & 1u;
        } else if all(rate == vec2<u32>(0u, 1u)) {
            offset.y = (pixel.x + odd) & 1u;
        } else {
            offset = odd * ((vec2<u32>(1u) << rate) - 1u);
        }
    }
    return min(corner + offset, params.extent - 1u);
}
