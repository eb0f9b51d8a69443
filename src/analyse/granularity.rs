//! What an estimate is of: a quad and its window, or a tile and its own pixels.
//!
//! Does: names them. The twin of tiles is in `decide.rs`, their kernels are `shaders/tiles.wgsl` and `shaders/analyse/areas.wgsl`.

/// What has one estimate, and so one rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize))]
pub enum Granularity {
    /// A quad of 2×2 pixels, as DOOM's image for compute passes has it. Its window is 4×4 pixels, the quad in the middle: twelve pairs on
    /// each axis, the mean luma of sixteen, the least speed of sixteen. Two pixels would tell of no step but their own; the border is
    /// what a shift by one pixel brings in.
    ///
    /// The hardware's attachment then has the finest rate of a tile's quads ([`attach`](mod@crate::attach)): finer than a tile's own
    /// estimate, since the worst quad decides and not the mean. On pictures like nature's one tile in six was coarser by its own pixels,
    /// and none finer (`tests/analyse/granularity.rs` counts them).
    #[default]
    #[cfg_attr(feature = "cli", serde(rename = "quad", alias = "2x2"))]
    Quad,
    /// A tile of 4×4 pixels.
    #[cfg_attr(feature = "cli", serde(rename = "4x4"))]
    Tile4,
    /// A tile of 8×8 pixels, as AMD's hardware has (DOOM's second image).
    #[cfg_attr(feature = "cli", serde(rename = "8x8"))]
    Tile8,
    /// A tile of 16×16 pixels, as NVIDIA's hardware has: Eq. 2 and 15 as the paper has them (§3.1, §3.4), over the tile's own pixels. All
    /// pairs that lie in it, the mean luma of its pixels, the least speed of them (§4.1), doubt that of any. Steps to the pixels next to it
    /// do not count, as a coarse pixel never reaches over a tile's border.
    #[cfg_attr(feature = "cli", serde(rename = "16x16"))]
    Tile16,
    /// A tile of 32×32 pixels.
    #[cfg_attr(feature = "cli", serde(rename = "32x32"))]
    Tile32,
}

impl Granularity {
    /// All, from fine to coarse.
    pub const ALL: [Granularity; 5] = [
        Granularity::Quad,
        Granularity::Tile4,
        Granularity::Tile8,
        Granularity::Tile16,
        Granularity::Tile32,
    ];

    /// Its side in pixels: 2, 4, 8, 16 or 32.
    pub const fn side(self) -> u32 {
        2 << self as u32
    }

    /// That of a side in pixels.
    pub fn of_side(side: u32) -> Option<Granularity> {
        Granularity::ALL.into_iter().find(|of| of.side() == side)
    }

    /// Whether it is a tile.
    pub fn is_tile(self) -> bool {
        self != Granularity::Quad
    }
}
