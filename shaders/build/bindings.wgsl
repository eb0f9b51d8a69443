// What the builder is given, and what it writes.

struct Params {
    extent: vec2<u32>,
    // Which texel of the coverage textures stands for a pixel, and texels a pixel.
    sample_at: vec2<u32>,
    // Pixels of the picture plane at distance 1, for rebuilt normals.
    plane: vec2<f32>,
    sample_scale: u32,
    tiles_per_row: u32,
    tile_count: u32,
    // Where the tiled entries start, in words.
    entries: u32,
    entries_per_tile: u32,
    // More primaries than this make a tile full: 0xffffffff if full tiles are kept.
    full: u32,
    // The largest rate, as its code.
    largest: u32,
    // Words in a row of the shading-rate image, and of the effective rates.
    sri_pitch: u32,
    // 0, or 1 + the frame's number modulo 4.
    phase: u32,
    list_capacity: u32,
    // Words of an entry of the lists.
    list_stride: u32,
    // Where the entries of mixed tiles start among the classified lists, in words.
    mixed: u32,
    graded_pitch: u32,
    wave: u32,
    depth_scale: f32,
    depth_bias: f32,
    depth_tolerance: f32,
    normal_tolerance: u32,
    sky: u32,
    layers: u32,
    // Of linear depth: what a distance is times inverse depth, where it is 0, and 1 over the way to where it is 1.
    linear_factor: f32,
    linear_near: f32,
    linear_share: f32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> sri: array<u32>;
#ifdef TILED
@group(0) @binding(2) var<storage, read_write> coords: array<u32>;
#endif
#ifdef COUNTERS
// See shaders/finish.wgsl.
@group(0) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;
#endif
#ifdef LIST
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
#endif
#ifdef CLASSIFIED
@group(0) @binding(5) var<storage, read_write> classified: array<u32>;
#endif
#ifdef EFFECTIVE
@group(0) @binding(6) var<storage, read_write> effective: array<atomic<u32>>;
#endif
#ifdef GRADED
@group(0) @binding(7) var<storage, read_write> graded: array<u32>;
#endif
#ifdef TRIANGLES
@group(0) @binding(8) var triangle_texture: texture_2d<u32>;
#endif
#ifdef SURFACES
@group(0) @binding(9) var surface_texture: texture_2d<u32>;
#endif
#ifdef DEPTH
@group(0) @binding(10) var depth_texture: texture_2d<f32>;
#endif
#ifdef OCTAHEDRAL
@group(0) @binding(11) var normal_texture: texture_2d<f32>;
#endif
#ifdef USER
// Four bits a tile.
@group(0) @binding(12) var<storage, read> user_bits: array<u32>;
#endif

// A workgroup builds TILES tiles beside one another.
const TILES: u32 = #{TILES}u;
const TILE: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
const AREA: u32 = TILE.x * TILE.y;
// a side that is odd, as of a workgroup of 64 by 1, ends in half a quad
const QUADS: vec2<u32> = (TILE + 1u) / 2u;
const QUAD_COUNT: u32 = QUADS.x * QUADS.y;
const TILE_IDENTITY: u32 = 0x40000u;
const TILE_UNIFORM: u32 = 0x80000u;
const TILE_SKY: u32 = 0x100000u;
const LIST_HEADER: u32 = 4u;
const CLASSIFIED_HEADER: u32 = 32u;
// The numbers of the counters.
const C_LIST: u32 = 0u;
const C_TILES: u32 = 2u;
const C_MIXED: u32 = 16u;
const C_STATISTICS: u32 = 18u;
const STATISTICS_WORDS: u32 = 20u;

#ifdef USER
// A shader that is told of its pixel finds its tile's bits at the end of the buffer; the first of eight tiles copies their word. To be called
// once for each tile.
fn hand_on_user_bits(slot: u32) {
    if slot % 8u != 0u {
        return;
    }
    let all_bits = user_bits[slot / 8u];
#ifdef LIST
    list[LIST_HEADER + params.list_capacity * params.list_stride + slot / 8u] = all_bits;
#endif
#ifdef CLASSIFIED
    classified[params.mixed + params.list_capacity * params.list_stride + slot / 8u] = all_bits;
#endif
#ifdef GRADED
    graded[params.graded_pitch * ((params.extent.y + 1u) / 2u) + slot / 8u] = all_bits;
#endif
}
#endif
