// What the invocations of a workgroup share, of which each has a quad.

const INVOCATIONS: u32 = TILES * QUAD_COUNT;
// An invocation's count is 4 bits: so many to a word; words of counts for a tile, and for all.
const FIELDS: u32 = 8u;
const FIELD_BITS: u32 = 4u;
const COUNT_WORDS: u32 = (QUAD_COUNT + FIELDS - 1u) / FIELDS;
const ALL_COUNT_WORDS: u32 = TILES * COUNT_WORDS;
const ALL_PIXELS: u32 = TILES * AREA;
const ALL_PLACES: u32 = TILES * 4u;
const IS_SKY: u32 = 0x10000u;
const CLASSES: u32 = 14u;

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
