// Parameters of the deblocker; src/deblock/gpu/mod.rs writes them.
#define_import_path vrcs::deblock::params

struct Params {
    extent: vec2<u32>,
    // Words in a row of the effective rates, and of the luma.
    rates_pitch: u32,
    luma_pitch: u32,
    // 0 if the first pixel of a group is always its primary, else 1 + the frame's number modulo 4.
    phase: u32,
    // Pixels in a row of a picture in a buffer.
    picture_pitch: u32,
    // Inverse depth is this factor times what the texture holds, plus this.
    inverse_depth: vec2<f32>,
    // How far from a plane is still in it, relative to inverse depth.
    tolerance: f32,
    // White of the luma, as a power of two.
    white_log: i32,
    // Where the extent lies in the picture, and in depth and surfaces.
    origin: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
