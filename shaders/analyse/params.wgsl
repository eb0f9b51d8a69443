// Parameters and tables of the analysis; src/analyse/params.rs makes them.
#define_import_path vrcs::analyse::params

struct Params {
    size: vec2<u32>,
    previous: vec2<u32>,
    ratio: vec2<u32>,
    sri_pitch: u32,
    luma_pitch: u32,
    speed_scale: vec2<f32>,
    offset_scale: vec2<f32>,
    // packed magnitudes by the previous rate; see fixed.wgsl
    reach_half: vec4<u32>,
    reach_quarter: vec4<u32>,
    limit_half: vec4<u32>,
    limit_quarter: vec4<u32>,
    ambient: u32,
    sensitivity: u32,
    white_log: i32,
    tolerance: u32,
    safe_width: u32,
    safe_tolerance: u32,
    largest: u32,
    material_least: u32,
    material_slow: u32,
    material_mirror: u32,
    half_tolerance: u32,
    half_fast: u32,
    has_history: u32,
    falloff_scale: u32,
    centre: vec2<i32>,
    depth_tolerance: u32,
    depth_offset: u32,
    reversed_z: u32,
    previous_pitch: u32,
    // where the view lies in this frame's pictures, and in the previous
    origin: vec2<u32>,
    previous_origin: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
// 256 lumas of codes; for each speed what limits are multiplied by, for the half and the quarter rate; tolerance over squared distance
@group(0) @binding(1) var<storage, read> tables: array<u32>;

const ONE: u32 = 16384u;
const FACTOR_ONE: u32 = 4096u;
const TABLE_SPEEDS: u32 = 256u;
const SPEEDS: u32 = 1024u;
const TABLE_FALLOFF: u32 = 2304u;
const FALLOFF: u32 = 256u;
// What floats compare errors with where nothing moves, for the half and the quarter rate; and whether they may
const TABLE_SURE: u32 = 2560u;
const TABLE_DOUBT: u32 = 2562u;

// Where a pixel of the view lies in this frame's pictures.
fn here(p: vec2<u32>) -> vec2<i32> {
#ifdef ORIGIN
    return vec2<i32>(p + params.origin);
#else
    return vec2<i32>(p);
#endif
}

// The same in the previous frame's.
fn before(p: vec2<u32>) -> vec2<i32> {
#ifdef ORIGIN
    return vec2<i32>(p + params.previous_origin);
#else
    return vec2<i32>(p);
#endif
}

// The largest rate, as log2.
fn largest() -> vec2<u32> {
    return vec2<u32>(params.largest >> 2u, params.largest & 3u);
}
