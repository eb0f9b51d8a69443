//! The build stage: from shading rates to coordinate buffers.
//!
//! A picture is cut into tiles. In each tile, pixels that share a rate fall into groups; one pixel of a group is its
//! primary, the others are its duplicates. The tile's primaries are packed into the low end of the tile's entries, so
//! that whole waves find nothing to do and retire (DOOM: The Dark Ages, "Coordinate Remapping").
//!
//! [`cpu`] is the oracle and [`gpu`] the kernel; both make the same words.
//!
//! # The buffer
//!
//! | words | what |
//! |---|---|
//! | one for each tile, row by row | a [header](Header) |
//! | from [`CoordLayout::entries`] on, [`CoordLayout::entries_per_tile`] for each tile | [entries](Entry), quad by quad |

pub mod cpu;
pub mod gpu;

use vrcs_passes::options::FullTiles;

use crate::rate::Rate;

/// How coordinate buffers are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Width and height of a tile, in pixels: multiples of 4, at most 256 pixels in all.
    pub tile: [u32; 2],
    /// How many invocations retire together.
    pub wave: u32,
    /// What becomes of a tile with more than tile area − wave primaries.
    pub full_tiles: FullTiles,
    /// The largest rate. Coarser ones are cut down to it, axis by axis.
    pub largest: Rate,
}

impl Default for BuildOptions {
    fn default() -> BuildOptions {
        BuildOptions {
            tile: [16, 16],
            wave: 32,
            full_tiles: FullTiles::Promote,
            largest: Rate::R2X2,
        }
    }
}

impl BuildOptions {
    /// The pixels of a tile.
    pub fn area(&self) -> u32 {
        self.tile[0] * self.tile[1]
    }

    /// The most entries that a tile stores: a tile with more saves no wave, and under [`FullTiles::Promote`] stores
    /// none (the slides' 224).
    pub fn entries_per_tile(&self) -> u32 {
        match self.full_tiles {
            FullTiles::Promote => self.area().saturating_sub(self.wave),
            FullTiles::Keep => self.area(),
        }
    }
}

/// Where things are in a coordinate buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoordLayout {
    /// Tiles across and down.
    pub tiles: [u32; 2],
    /// The word at which the entries start.
    pub entries: u32,
    /// Words for each tile's entries.
    pub entries_per_tile: u32,
}

impl CoordLayout {
    /// The layout for a logical extent, in pixels.
    pub fn new(extent: [u32; 2], options: &BuildOptions) -> CoordLayout {
        let tiles = [0, 1].map(|axis| extent[axis].div_ceil(options.tile[axis]));
        CoordLayout {
            tiles,
            // a full cache line, so that a tile's entries start on one when their number is a multiple of 32
            entries: (tiles[0] * tiles[1]).next_multiple_of(32),
            entries_per_tile: options.entries_per_tile(),
        }
    }

    /// The number of tiles.
    pub fn tile_count(&self) -> u32 {
        self.tiles[0] * self.tiles[1]
    }

    /// The number of words.
    pub fn words(&self) -> u32 {
        (self.entries + self.tile_count() * self.entries_per_tile).max(1)
    }
}

/// What a tile's first word says: the number of its entries in the low half, flags above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header(pub u32);

impl Header {
    /// Every pixel of the tile is its own primary; no entries are stored.
    pub const IDENTITY: u32 = 0x1_0000;

    /// The number of entries.
    pub fn count(self) -> u32 {
        self.0 & 0xffff
    }

    /// Whether every pixel is its own primary.
    pub fn is_identity(self) -> bool {
        self.0 & Header::IDENTITY != 0
    }
}

/// A group: its primary's place in the tile, and its members.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry(pub u32);

impl Entry {
    /// Packs an entry. `mask` is over the aligned 4×4 block of the primary, bit `(y & 3) * 4 + (x & 3)`.
    pub fn new(x: u32, y: u32, mask: u32) -> Entry {
        debug_assert!(x < 256 && y < 256 && mask < 0x1_0000);
        Entry(x | y << 8 | mask << 16)
    }

    /// The primary's column in the tile.
    pub fn x(self) -> u32 {
        self.0 & 0xff
    }

    /// The primary's row in the tile.
    pub fn y(self) -> u32 {
        self.0 >> 8 & 0xff
    }

    /// The members, over the aligned 4×4 block.
    pub fn mask(self) -> u32 {
        self.0 >> 16
    }
}
