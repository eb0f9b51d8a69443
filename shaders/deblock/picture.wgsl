// The picture that is deblocked: a texture or a buffer, read and written in place or through a scratch texture.
#define_import_path vrcs::deblock::picture

#import vrcs::deblock::params::params

#ifdef SCRATCH
@group(0) @binding(2) var picture: texture_2d<f32>;
#ifdef RGBA8
@group(0) @binding(3) var result: texture_storage_2d<rgba8unorm, write>;
#endif
#ifdef RGBA16
@group(0) @binding(3) var result: texture_storage_2d<rgba16float, write>;
#endif
#ifdef RGBA32
@group(0) @binding(3) var result: texture_storage_2d<rgba32float, write>;
#endif
#ifdef RG11B10
@group(0) @binding(3) var result: texture_storage_2d<rg11b10ufloat, write>;
#endif
#endif

#ifdef IN_PLACE
#ifdef RGBA8
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, read_write>;
#endif
#ifdef RGBA16
@group(0) @binding(2) var picture: texture_storage_2d<rgba16float, read_write>;
#endif
#ifdef RGBA32
@group(0) @binding(2) var picture: texture_storage_2d<rgba32float, read_write>;
#endif
#ifdef RG11B10
@group(0) @binding(2) var picture: texture_storage_2d<rg11b10ufloat, read_write>;
#endif
#endif

#ifdef R32UINT
@group(0) @binding(2) var picture: texture_storage_2d<r32uint, read_write>;
#endif

#ifdef BUFFER
@group(0) @binding(2) var<storage, read_write> picture: array<u32>;
#endif

#ifdef PACKED_RGBA8
fn unpack(word: u32) -> vec4<f32> {
    return unpack4x8unorm(word);
}

fn pack(color: vec4<f32>) -> u32 {
    return pack4x8unorm(color);
}
#endif

#ifdef PACKED_RG11B10
// Small floats are halves without a sign and with fewer bits of mantissa.
fn unpack(word: u32) -> vec4<f32> {
    let rg = unpack2x16float(((word & 0x7ffu) << 4u) | ((word & 0x3ff800u) << 9u));
    let b = unpack2x16float((word >> 22u) << 5u);
    return vec4<f32>(rg, b.x, 1.0);
}

// A half without its sign to one with `drop` fewer bits, to the nearest, ties to even; what is too large becomes the
// largest, and infinity and NaN stay what they are.
fn shorten(bits: u32, drop: u32) -> u32 {
    if bits > 0x7fffu {
        // negative: there is no such thing
        return select(0u, 0x7fffu >> drop, (bits & 0x7fffu) > 0x7c00u);
    }
    if bits >= 0x7c00u {
        return select(0x7c00u, 0x7fffu, bits > 0x7c00u) >> drop;
    }
    let rounded = (bits + (1u << (drop - 1u)) - 1u + ((bits >> drop) & 1u)) >> drop;
    return min(rounded, (0x7c00u >> drop) - 1u);
}

fn pack(color: vec4<f32>) -> u32 {
    let rg = pack2x16float(color.rg);
    let b = pack2x16float(vec2<f32>(color.b, 0.0));
    return shorten(rg & 0xffffu, 4u) | (shorten(rg >> 16u, 4u) << 11u) | (shorten(b & 0xffffu, 5u) << 22u);
}
#endif

fn load(pixel: vec2<u32>) -> vec4<f32> {
    let at = pixel + params.origin;
#ifdef SCRATCH
    return textureLoad(picture, at, 0);
#endif
#ifdef IN_PLACE
    return textureLoad(picture, at);
#endif
#ifdef R32UINT
    return unpack(textureLoad(picture, at).r);
#endif
#ifdef BUFFER
    let index = at.y * params.picture_pitch + at.x;
#ifdef ONE_WORD
    return unpack(picture[index]);
#endif
#ifdef TWO_WORDS
    return vec4<f32>(unpack2x16float(picture[index * 2u]), unpack2x16float(picture[index * 2u + 1u]));
#endif
#ifdef FOUR_WORDS
    return vec4<f32>(
        bitcast<f32>(picture[index * 4u]),
        bitcast<f32>(picture[index * 4u + 1u]),
        bitcast<f32>(picture[index * 4u + 2u]),
        bitcast<f32>(picture[index * 4u + 3u]),
    );
#endif
#endif
}

fn store(pixel: vec2<u32>, color: vec4<f32>) {
    let at = pixel + params.origin;
#ifdef SCRATCH
    textureStore(result, at, color);
#endif
#ifdef IN_PLACE
    textureStore(picture, at, color);
#endif
#ifdef R32UINT
    textureStore(picture, at, vec4<u32>(pack(color), 0u, 0u, 0u));
#endif
#ifdef BUFFER
    let index = at.y * params.picture_pitch + at.x;
#ifdef ONE_WORD
    picture[index] = pack(color);
#endif
#ifdef TWO_WORDS
    picture[index * 2u] = pack2x16float(color.rg);
    picture[index * 2u + 1u] = pack2x16float(color.ba);
#endif
#ifdef FOUR_WORDS
    // alpha keeps its place
    picture[index * 4u] = bitcast<u32>(color.r);
    picture[index * 4u + 1u] = bitcast<u32>(color.g);
    picture[index * 4u + 2u] = bitcast<u32>(color.b);
#endif
#endif
}
