// What the builder is given, what it writes, and what the invocations of a workgroup share.

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

// A workgroup builds TILES tiles beside one another, with an invocation for PER quads beside one another.
const TILES: u32 = #{TILES}u;
const PER: u32 = #{PER}u;
const TILE: vec2<u32> = vec2<u32>(#{TILE_WIDTH}u, #{TILE_HEIGHT}u);
const AREA: u32 = TILE.x * TILE.y;
// a side that is odd, as of a workgroup of 64 by 1, ends in half a quad
const QUADS: vec2<u32> = (TILE + 1u) / 2u;
const QUAD_COUNT: u32 = QUADS.x * QUADS.y;
const LANES: u32 = QUAD_COUNT / PER;
const INVOCATIONS: u32 = TILES * LANES;
// An invocation's count is 4 bits for a quad, 8 for four: so many to a word; words of counts for a tile, and for all.
const FIELDS: u32 = #{FIELDS}u;
const FIELD_BITS: u32 = 32u / FIELDS;
const COUNT_WORDS: u32 = (LANES + FIELDS - 1u) / FIELDS;
const ALL_COUNT_WORDS: u32 = TILES * COUNT_WORDS;
const ALL_PIXELS: u32 = TILES * AREA;
const ALL_PLACES: u32 = TILES * 4u;
const TILE_IDENTITY: u32 = 0x40000u;
const TILE_UNIFORM: u32 = 0x80000u;
const TILE_SKY: u32 = 0x100000u;
const IS_SKY: u32 = 0x10000u;
const LIST_HEADER: u32 = 4u;
const CLASSIFIED_HEADER: u32 = 32u;
// The numbers of the counters.
const C_LIST: u32 = 0u;
const C_TILES: u32 = 2u;
const C_MIXED: u32 = 16u;
const C_STATISTICS: u32 = 18u;
const CLASSES: u32 = 14u;
const STATISTICS_WORDS: u32 = 20u;

// The number of primaries that each invocation has found; of sky apart.
var<workgroup> counts: array<atomic<u32>, ALL_COUNT_WORDS>;
#ifdef SKY
var<workgroup> sky_counts: array<atomic<u32>, ALL_COUNT_WORDS>;
#endif
// Bit n: there is a quad with rate n.
var<workgroup> rates_seen: array<atomic<u32>, TILES>;
// The entries of each tile, to be written out side by side.
var<workgroup> staged: array<u32, ALL_PIXELS>;
#ifndef LOCAL
// For each pixel of the tile, the members of the group that it leads over its aligned 4x4 block, and IS_SKY.
var<workgroup> leads: array<u32, ALL_PIXELS>;
#ifdef GRADED
var<workgroup> grades: array<u32, ALL_PIXELS>;
#endif
#ifdef EFFECTIVE
// Whether coverage has split the block of a quad.
var<workgroup> splits: array<atomic<u32>, INVOCATIONS>;
#endif
#endif
#ifdef EFFECTIVE
#ifdef SHARED_WORDS
var<workgroup> effective_words: array<atomic<u32>, INVOCATIONS>;
#endif
#endif
#ifdef COUNTERS
// What each tile adds to the lists (covered, sky, and both of mixed tiles), then where its entries start in them.
var<workgroup> places: array<u32, ALL_PLACES>;
#endif
#ifdef CLASSIFIED
// How many tiles of each class are here, and where they start.
var<workgroup> class_counts: array<atomic<u32>, CLASSES>;
var<workgroup> class_starts: array<u32, CLASSES>;
#endif
#ifdef STATISTICS
var<workgroup> tally: array<atomic<u32>, STATISTICS_WORDS>;
#endif
