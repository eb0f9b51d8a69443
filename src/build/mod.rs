//! The build stage: from shading rates and coverage to coordinate buffers.
//!
//! A picture is cut into tiles. In each tile, pixels that share a rate and a surface fall into groups; one pixel of a group is
//! its primary, the others are its duplicates. The tile's primaries are packed into the low end of the tile's entries, so
//! that whole waves find nothing to do and retire (DOOM: The Dark Ages, "Coordinate Remapping"); and, on request, all
//! primaries of the picture into one list ("Pixel Commands", bonus slide 8), or into a list for each class of tiles.
//!
//! [`cpu`] is the oracle and [`gpu`] the kernel; both make the same words.
//!
//! # Groups
//!
//! Within each block of a rate, the first pixel that has no group yet leads one, and every pixel without a group that
//! [shares](crate::coverage) with it joins. *First* is by an order that [rotates](primary::Order) from frame to frame.
//!
//! # The tiled buffer
//!
//! | words | what |
//! |---|---|
//! | one for each tile, row by row | a [header](Header) |
//! | from [`CoordLayout::entries`] on, [`CoordLayout::entries_per_tile`] for each tile | [entries](Entry), quad by quad by their primaries; those of sky last |
//!
//! # The list
//!
//! | words | what |
//! |---|---|
//! | 0, 1 | entries of covered pixels, and of sky |
//! | 2, 3 | not used |
//! | from [`LIST_HEADER`] on | entries of covered pixels; those of sky from the end of the capacity downwards |
//!
//! An entry is [one word](ListEntry::quad) where 2×2 is the largest rate and no side is above 16,384 pixels, else
//! [two](ListEntry::block).
//!
//! # The classified lists
//!
//! | words | what |
//! |---|---|
//! | 0 to 6 | tiles of covered pixels that are one rate throughout, by [rate](rate_index); rate 0 is identity |
//! | 7 to 13 | the same of sky |
//! | 14, 15 | entries of mixed tiles: of covered pixels, and of sky |
//! | 16 to 22 | workgroups up to the end of each rate's segment, that of mixed tiles standing first: of covered pixels |
//! | 23 to 29 | the same where sky is shaded, too |
//! | 30 | the [phase](primary::Order::code) |
//! | 31 | not used |
//! | from [`CLASSIFIED_HEADER`] on | for each rate, room for all tiles' [places](tile_place), those of sky from the end downwards |
//! | then | the entries of mixed tiles, as in the list |
//!
//! With [linear depth](BuildOptions::linear_depth) it has two words, the second with the depth in its high half; an entry of a tile is then
//! [packed](Entry::deep) more tightly.
//!
//! If there are [bits of the user's own](BuildOptions::user), those of all tiles follow the room for entries, in the list too,
//! [eight tiles to a word](user_words); in the graded buffer they follow the quads. The tiled buffer has them in its headers.
//!
//! # The graded buffer
//!
//! One word for each quad, one byte for each of its pixels: in the low half how many pixels share with it, in the high half
//! the rate of the group's bounds.

pub mod buffers;
pub mod cpu;
pub mod gpu;
pub mod primary;
pub mod statistics;
pub mod subgroups;

use vrcs_passes::options::{FullTiles, Mode};

use crate::{coverage::Coverage, rate::Rate};

/// Words before a list's entries.
pub const LIST_HEADER: u32 = 4;
/// Words before the classified lists.
pub const CLASSIFIED_HEADER: u32 = 32;
/// The largest side of a picture whose list has entries of one word.
pub const QUAD_LIST_SIDE: u32 = 1 << 14;

/// How coordinate buffers are built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Width and height of a tile, in pixels: at most 256 pixels in all. Where a side is no multiple of 4, as with the workgroups
    /// of some shaders whose invocations work together, [`BuildOptions::for_tile`] cuts the largest rate down. Effective rates and
    /// the graded buffer are by the picture's quads, and need sides that are even.
    pub tile: [u32; 2],
    /// How many invocations retire together: 4, 8, 16, 32, 64 or 128.
    pub wave: u32,
    /// What becomes of a tile with more than tile area − wave primaries.
    pub full_tiles: FullTiles,
    /// The largest rate. Coarser ones are cut down to it, axis by axis.
    pub largest: Rate,
    /// What is made, for the modes of the passes that share the view.
    pub modes: Modes,
    /// What tells surfaces apart.
    pub coverage: Coverage,
    /// Whether effective rates are written, one byte a quad: see [`effective`].
    pub effective: bool,
    /// Whether statistics are counted.
    pub statistics: bool,
    /// Whether entries carry the linear depth of their primaries in their spare bits, and between which planes (slides: "utilise 21 spare bits
    /// for linearZ"). Needs depth among the coverage, groups of at most 2×2, tiles with sides of at most 16 and even. A list's entries then
    /// have two words. A pass over the view has to be rewritten [for it](vrcs_passes::Options::linear_depth).
    pub linear_depth: Option<LinearDepth>,
    /// Whether tiles carry [bits of the user's own](Header::user), such as that fog covers them. A shader that declares `fn vrcs_user() -> u32
    /// { return 0u; }` is [told](vrcs_passes::graded) its tile's, in every mode.
    pub user: bool,
}

impl Default for BuildOptions {
    fn default() -> BuildOptions {
        BuildOptions {
            tile: [16, 16],
            wave: 32,
            full_tiles: FullTiles::Promote,
            largest: Rate::R2X2,
            modes: Modes::default(),
            coverage: Coverage::default(),
            effective: false,
            statistics: false,
            linear_depth: None,
            user: false,
        }
    }
}

/// The planes between which [linear depth](BuildOptions::linear_depth) is counted, as distances: 0 < near < far. What is nearer or
/// farther is 0 or 1; sky and what is no depth is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDepth {
    /// Where it is 0. With [`DepthKind::Reversed`](crate::coverage::DepthKind::Reversed) it is also the near plane of the depth texture.
    pub near: f32,
    /// Where it is 1.
    pub far: f32,
}

impl LinearDepth {
    /// The most that an entry of a tile says: 20 bits.
    pub const TILED: u32 = (1 << 20) - 1;
    /// The most that an entry of a list says: 16 bits.
    pub const LISTED: u32 = (1 << 16) - 1;

    /// What makes a distance of a value that is proportional to inverse depth, as [`DepthKind`](crate::coverage::DepthKind) gives it: the
    /// distance is this over the value. Nothing for depth that is linear already.
    pub(crate) fn factor(self, kind: crate::coverage::DepthKind) -> f32 {
        use crate::coverage::DepthKind;
        match kind {
            DepthKind::Linear => 0.0,
            DepthKind::Reversed => self.near,
            DepthKind::ReversedFinite { near, far } | DepthKind::Standard { near, far } => {
                far * near / (far - near)
            }
        }
    }

    /// A texel as a share of the way from near to far, 0 to 1.
    pub fn share(self, texel: f32, kind: crate::coverage::DepthKind) -> f32 {
        let distance = match kind.to_inverse() {
            None => texel,
            Some([scale, bias]) => self.factor(kind) / (texel * scale + bias),
        };
        // what lies behind the viewer, or is no number, is far
        match distance > 0.0 {
            true => ((distance - self.near) * (1.0 / (self.far - self.near))).clamp(0.0, 1.0),
            false => 1.0,
        }
    }

    /// A share in whole steps of which there are `most`, to the nearest.
    pub fn code(share: f32, most: u32) -> u32 {
        (share * most as f32 + 0.5) as u32
    }

    /// What a code says: the shader's `vrcs_depth()`.
    pub fn decode(code: u32, most: u32) -> f32 {
        code as f32 / most as f32
    }
}

impl BuildOptions {
    /// These options for another tile: no group may lie across a tile's edge, so the largest rate is cut down to what
    /// divides the tile, axis by axis.
    pub fn for_tile(self, tile: [u32; 2]) -> BuildOptions {
        let fits = |side: u32, most: u32| match side {
            side if side.is_multiple_of(4) => most,
            side if side.is_multiple_of(2) => most.min(2),
            _ => 1,
        };
        let (width, height) = (
            fits(tile[0], self.largest.width()),
            fits(tile[1], self.largest.height()),
        );
        // there is no 4x1 and no 1x4
        let cut = |side: u32, other: u32| if other == 1 { side.min(2) } else { side };
        let code = cut(width, height).ilog2() << 2 | cut(height, width).ilog2();
        BuildOptions {
            tile,
            largest: Rate::from_code(code as u8).unwrap_or(Rate::R1X1),
            ..self
        }
    }

    /// Whether a side of the tile is odd: then its quads are not the picture's.
    pub fn is_odd(&self) -> bool {
        self.tile.iter().any(|side| side % 2 != 0)
    }

    /// Quads across and down a tile; half ones count.
    pub fn quads(&self) -> [u32; 2] {
        self.tile.map(|side| side.div_ceil(2))
    }

    /// The pixels of a tile.
    pub fn area(&self) -> u32 {
        self.tile[0] * self.tile[1]
    }

    /// The most entries that a tile stores: a tile with more saves no wave, and under [`FullTiles::Promote`] stores
    /// none (the slides' 224). Where there is sky, a tile at its edge cannot be promoted, and may store all.
    pub fn entries_per_tile(&self) -> u32 {
        match self.full_tiles {
            FullTiles::Promote if self.coverage.sky.is_none() => {
                self.area().saturating_sub(self.wave)
            }
            _ => self.area(),
        }
    }

    /// More primaries than this make a tile full.
    pub fn full(&self) -> u32 {
        match self.full_tiles {
            FullTiles::Promote => self.area().saturating_sub(self.wave),
            FullTiles::Keep => u32::MAX,
        }
    }
}

/// The modes that a build serves. By default, those that the rewriter's `auto` chooses from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modes {
    /// The tiled buffer.
    pub tiled: bool,
    /// The list.
    pub list: bool,
    /// The classified lists.
    pub classified: bool,
    /// The graded buffer.
    pub graded: bool,
}

impl Modes {
    /// None.
    pub const NONE: Modes = Modes {
        tiled: false,
        list: false,
        classified: false,
        graded: false,
    };
    /// All.
    pub const ALL: Modes = Modes {
        tiled: true,
        list: true,
        classified: true,
        graded: true,
    };

    /// With a mode.
    pub fn with(mut self, mode: Mode) -> Modes {
        match mode {
            Mode::Tiled => self.tiled = true,
            Mode::List => self.list = true,
            Mode::Classified => self.classified = true,
            Mode::Graded => self.graded = true,
            // what may be chosen
            Mode::Auto => (self.tiled, self.list) = (true, true),
        }
        self
    }

    /// Whether a mode is among them.
    pub fn has(&self, mode: Mode) -> bool {
        match mode {
            Mode::Tiled => self.tiled,
            Mode::List => self.list,
            Mode::Classified => self.classified,
            Mode::Graded => self.graded,
            Mode::Auto => self.tiled && self.list,
        }
    }
}

impl Default for Modes {
    fn default() -> Modes {
        Modes {
            tiled: true,
            list: true,
            ..Modes::NONE
        }
    }
}

/// The bits of an effective rate's byte.
pub mod effective {
    /// The [code](crate::Rate::code) of the rate in which the quad really shares: after larger rates have had to agree, after
    /// the largest rate, the rule for nearly full tiles, and the extent.
    pub const RATE: u8 = 0x0f;
    /// Coverage has split the quad's block: not all of its pixels share.
    pub const SPLIT: u8 = 0x80;
}

/// Where things are in the tiled buffer.
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

/// Where things are in the lists and in the graded buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListLayout {
    /// Words of an entry: 1 or 2.
    pub stride: u32,
    /// The most entries: one for each pixel.
    pub capacity: u32,
    /// Tiles.
    pub tiles: u32,
    /// Quads in a row of the graded buffer.
    pub graded_pitch: u32,
    /// Rows of the graded buffer.
    pub graded_rows: u32,
    /// Words of the user's own bits, which follow what the buffer has else.
    pub user_words: u32,
}

impl ListLayout {
    /// The layout for a logical extent, in pixels.
    pub fn new(extent: [u32; 2], options: &BuildOptions) -> ListLayout {
        let is_quad = options.largest.is_within(Rate::R2X2)
            && extent.iter().all(|side| *side <= QUAD_LIST_SIDE)
            && options.linear_depth.is_none();
        ListLayout {
            stride: if is_quad { 1 } else { 2 },
            capacity: extent[0].saturating_mul(extent[1]),
            tiles: CoordLayout::new(extent, options).tile_count(),
            graded_pitch: extent[0].div_ceil(2),
            graded_rows: extent[1].div_ceil(2),
            user_words: match options.user {
                true => CoordLayout::new(extent, options).tile_count().div_ceil(8),
                false => 0,
            },
        }
    }

    /// The bytes of the list.
    pub fn list_bytes(&self) -> u64 {
        4 * (u64::from(LIST_HEADER) + self.entry_words() + u64::from(self.user_words))
    }

    /// The word at which the entries of mixed tiles start among the classified lists.
    pub fn mixed(&self) -> u32 {
        (CLASSIFIED_HEADER + RATES as u32 * self.tiles).next_multiple_of(32)
    }

    /// The bytes of the classified lists.
    pub fn classified_bytes(&self) -> u64 {
        4 * (u64::from(self.mixed()) + self.entry_words() + u64::from(self.user_words))
    }

    fn entry_words(&self) -> u64 {
        u64::from(self.capacity) * u64::from(self.stride)
    }

    /// The words of the quads in the graded buffer.
    pub fn graded_words(&self) -> u32 {
        self.graded_pitch * self.graded_rows.max(1)
    }

    /// The bytes of the graded buffer.
    pub fn graded_bytes(&self) -> u64 {
        4 * (u64::from(self.graded_words()) + u64::from(self.user_words))
    }
}

/// The number of rates.
pub const RATES: usize = 7;

/// A rate's place among all, from fine to coarse as in [`Rate::ALL`].
pub fn rate_index(rate: Rate) -> usize {
    Rate::ALL
        .iter()
        .position(|other| *other == rate)
        .unwrap_or(0)
}

/// What a tile's first word says.
///
/// | bits | what |
/// |---|---|
/// | 0–8 | entries of covered pixels |
/// | 9–17 | entries of sky |
/// | 18 | [identity](Header::IDENTITY) |
/// | 19 | [uniform](Header::UNIFORM) |
/// | 20 | [sky](Header::SKY) |
/// | 21–23 | the [phase](primary::Order::code) in which primaries were chosen |
/// | 24–27 | the rate of a uniform tile |
/// | 28–31 | the [user's own](Header::user) |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header(pub u32);

impl Header {
    /// Every pixel of the tile is its own primary; no entries are stored, and none are counted.
    pub const IDENTITY: u32 = 1 << 18;
    /// The whole tile is of one rate: its primaries are computed, no entries are stored, but they are counted.
    pub const UNIFORM: u32 = 1 << 19;
    /// The whole tile is sky.
    pub const SKY: u32 = 1 << 20;

    /// The number of entries of covered pixels.
    pub fn count(self) -> u32 {
        self.0 & 0x1ff
    }

    /// The number of entries of sky.
    pub fn sky_count(self) -> u32 {
        self.0 >> 9 & 0x1ff
    }

    /// The number of entries that are stored.
    pub fn stored(self) -> u32 {
        match self.is_identity() || self.is_uniform() {
            true => 0,
            false => self.count() + self.sky_count(),
        }
    }

    /// The four bits that the user gave the tile: see [`user_words`].
    pub fn user(self) -> u32 {
        self.0 >> 28
    }

    /// Whether every pixel is its own primary.
    pub fn is_identity(self) -> bool {
        self.0 & Header::IDENTITY != 0
    }

    /// Whether the whole tile is of one rate.
    pub fn is_uniform(self) -> bool {
        self.0 & Header::UNIFORM != 0
    }

    /// Whether the whole tile is sky.
    pub fn is_sky(self) -> bool {
        self.0 & Header::SKY != 0
    }
}

/// The words that hold four bits for each tile, eight tiles to a word, by the tiles' numbers: what
/// [`View::user`](crate::View::user) is written with.
pub fn user_words(bits: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut words = Vec::new();
    for (tile, bits) in bits.into_iter().enumerate() {
        if tile % 8 == 0 {
            words.push(0);
        }
        if let Some(word) = words.last_mut() {
            *word |= (bits & 15) << (tile % 8 * 4);
        }
    }
    words
}

/// A group: its primary's place in the tile, and its members. Where entries carry linear depth, the word of the buffer is
/// [another](Entry::deep).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Entry(pub u32);

impl Entry {
    /// Packs an entry. `mask` is over the aligned 4×4 block of the primary, bit `(y & 3) * 4 + (x & 3)`.
    pub fn new(x: u32, y: u32, mask: u32) -> Entry {
        debug_assert!(x < 256 && y < 256 && mask < 0x1_0000);
        Entry(x | y << 8 | mask << 16)
    }

    /// The word of an entry that carries linear depth, of a tile with this first pixel: x in bits 0–3, y in 4–7, the members of the quad
    /// in 8–11, depth in the rest.
    pub fn deep(self, origin: [u32; 2], depth: u32) -> u32 {
        let [x, y] = [origin[0] + self.x(), origin[1] + self.y()];
        let quad = self.mask() >> ((x & 2) + (y & 2) * 4);
        let members = quad & 3 | (quad >> 4 & 3) << 2;
        self.x() | self.y() << 4 | members << 8 | depth << 12
    }

    /// Reads such a word: the entry, and the depth's code.
    pub fn read_deep(origin: [u32; 2], word: u32) -> (Entry, u32) {
        let (x, y, quad) = (word & 15, word >> 4 & 15, word >> 8 & 15);
        let place = ((origin[0] + x) & 2) + ((origin[1] + y) & 2) * 4;
        let mask = (quad & 3 | (quad & 12) << 2) << place;
        (Entry::new(x, y, mask), word >> 12)
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

/// A tile as the classified lists have it: its column in the low half, its row in the high one, so that a shader need not divide.
pub fn tile_place(number: u32, tiles_per_row: u32) -> u32 {
    (number % tiles_per_row) | ((number / tiles_per_row) << 16)
}

/// Workgroups in a row of an indirect dispatch by a list: wgpu takes at most 65,535 on an axis, and a shader that knows the row beforehand
/// finds its entry without reading how long it is. `ROW` in `shaders/finish.wgsl`, `VRCS_ROW` in the prelude.
pub const LIST_ROW: u32 = 32;

/// The workgroups of a dispatch by a list, in a row and rows.
pub fn list_groups(groups: u32) -> [u32; 2] {
    [groups.min(LIST_ROW), groups.div_ceil(LIST_ROW)]
}

/// A pixel's bit in a mask over its aligned 4×4 block.
fn bit_of([x, y]: [u32; 2]) -> u32 {
    (y & 3) * 4 + (x & 3)
}

/// An entry of a list: a primary's place in the picture, and its group's members over its aligned 4×4 block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ListEntry {
    /// The primary.
    pub pixel: [u32; 2],
    /// The members.
    pub mask: u32,
}

impl ListEntry {
    /// The word of an entry whose group lies in one quad: x in bits 0–13, y in 14–27, and its duplicates as it sees them: bit 28 stands for
    /// the pixel beside it in the quad, 29 for that above or below it, 30 for the one across the corner (DOOM's three copy bits).
    pub fn quad(self) -> u32 {
        let [x, y] = self.pixel;
        let duplicates = (1..4u32)
            .filter(|place| self.mask >> bit_of([x ^ place & 1, y ^ place >> 1]) & 1 != 0)
            .fold(0, |bits, place| bits | 1 << (place - 1));
        x | y << 14 | duplicates << 28
    }

    /// The words of any entry: x in the low half, y in the high; the members.
    pub fn block(self) -> [u32; 2] {
        [self.pixel[0] | self.pixel[1] << 16, self.mask]
    }

    /// Reads an entry.
    pub fn read(words: &[u32]) -> ListEntry {
        match *words {
            [word] => {
                let pixel = [word & 0x3fff, word >> 14 & 0x3fff];
                let members = word >> 28 << 1 | 1;
                let mask = (0..4u32)
                    .filter(|place| members >> place & 1 != 0)
                    .map(|place| bit_of([pixel[0] ^ place & 1, pixel[1] ^ place >> 1]))
                    .fold(0, |mask, bit| mask | 1 << bit);
                ListEntry { pixel, mask }
            }
            // the high half may carry linear depth
            [place, mask, ..] => ListEntry {
                pixel: [place & 0xffff, place >> 16],
                mask: mask & 0xffff,
            },
            [] => ListEntry {
                pixel: [0; 2],
                mask: 0,
            },
        }
    }
}
