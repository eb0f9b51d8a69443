//! The coordinate builder on the CPU: the oracle in tests, and for whoever has no GPU at hand.

use super::{BuildOptions, CoordLayout, Entry, Header};
use crate::{rate::Rate, sri::Sri};
use vrcs_passes::options::FullTiles;

/// A coordinate buffer in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordinates {
    /// The logical extent, in pixels.
    pub extent: [u32; 2],
    /// How it was built.
    pub options: BuildOptions,
    /// Where things are.
    pub layout: CoordLayout,
    /// The words, as on the GPU. Words that no tile uses are zero.
    pub words: Vec<u32>,
}

/// Builds the coordinate buffer of a picture.
pub fn build(sri: &Sri, extent: [u32; 2], options: &BuildOptions) -> Coordinates {
    let layout = CoordLayout::new(extent, options);
    let mut words = vec![0; layout.words() as usize];
    for tile in 0..layout.tile_count() {
        let at = [tile % layout.tiles[0], tile / layout.tiles[0]];
        let entries = tile_entries(sri, extent, options, at);
        let (header, stored) = header(&entries, extent, options, at);
        words[tile as usize] = header.0;
        let start = (layout.entries + tile * layout.entries_per_tile) as usize;
        for (word, entry) in words[start..].iter_mut().zip(&entries[..stored]) {
            *word = entry.0;
        }
    }
    Coordinates {
        extent,
        options: *options,
        layout,
        words,
    }
}

/// The groups of a tile, quad by quad, and row by row within a quad.
fn tile_entries(sri: &Sri, extent: [u32; 2], options: &BuildOptions, tile: [u32; 2]) -> Vec<Entry> {
    let origin = [0, 1].map(|axis| tile[axis] * options.tile[axis]);
    let mut entries = Vec::new();
    for y in (0..options.tile[1]).step_by(2) {
        for x in (0..options.tile[0]).step_by(2) {
            let rate = sri.rate((origin[0] + x) / 2, (origin[1] + y) / 2, options.largest);
            quad_entries(extent, origin, [x, y], rate, &mut entries);
        }
    }
    entries
}

/// The groups whose first pixel lies in a quad.
fn quad_entries(
    extent: [u32; 2],
    origin: [u32; 2],
    quad: [u32; 2],
    rate: Rate,
    entries: &mut Vec<Entry>,
) {
    for i in 0..4 {
        let [x, y] = [quad[0] + (i & 1), quad[1] + (i >> 1)];
        let is_corner = x.is_multiple_of(rate.width()) && y.is_multiple_of(rate.height());
        let is_inside = origin[0] + x < extent[0] && origin[1] + y < extent[1];
        if !is_corner || !is_inside {
            continue;
        }
        let mut mask = 0;
        for dy in 0..rate.height() {
            for dx in 0..rate.width() {
                if origin[0] + x + dx < extent[0] && origin[1] + y + dy < extent[1] {
                    mask |= 1 << (((y + dy) & 3) * 4 + ((x + dx) & 3));
                }
            }
        }
        entries.push(Entry::new(x, y, mask));
    }
}

/// The header of a tile, and how many entries are stored.
fn header(
    entries: &[Entry],
    extent: [u32; 2],
    options: &BuildOptions,
    tile: [u32; 2],
) -> (Header, usize) {
    let count = entries.len() as u32;
    let pixels: u32 = [0, 1]
        .map(|axis| (extent[axis] - tile[axis] * options.tile[axis]).min(options.tile[axis]))
        .iter()
        .product();
    let promoted = options.full_tiles == FullTiles::Promote && count > options.entries_per_tile();
    // a whole tile at full rate needs no list under either rule
    if promoted || count == pixels && pixels == options.area() {
        return (Header(Header::IDENTITY), 0);
    }
    (Header(count), count as usize)
}

impl Coordinates {
    /// The header of a tile.
    pub fn header(&self, tile: u32) -> Header {
        Header(self.words[tile as usize])
    }

    /// The entries of a tile.
    pub fn entries(&self, tile: u32) -> impl Iterator<Item = Entry> {
        let start = (self.layout.entries + tile * self.layout.entries_per_tile) as usize;
        let count = self.header(tile).count() as usize;
        self.words[start..start + count]
            .iter()
            .map(|&word| Entry(word))
    }

    /// The effective map: for each pixel of the extent, row by row, the pixel that is shaded for it, `y * width + x`.
    pub fn map(&self) -> Vec<u32> {
        let [width, height] = self.extent;
        let mut map: Vec<u32> = (0..width * height).collect();
        for tile in 0..self.layout.tile_count() {
            let origin = [
                tile % self.layout.tiles[0] * self.options.tile[0],
                tile / self.layout.tiles[0] * self.options.tile[1],
            ];
            for entry in self.entries(tile) {
                let (x, y) = (origin[0] + entry.x(), origin[1] + entry.y());
                for bit in (0..16).filter(|bit| entry.mask() >> bit & 1 != 0) {
                    let (mx, my) = ((x & !3) + (bit & 3), (y & !3) + (bit >> 2));
                    map[(my * width + mx) as usize] = y * width + x;
                }
            }
        }
        map
    }

    /// How much is shaded.
    pub fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::default();
        let waves_per_tile = self.options.area().div_ceil(self.options.wave);
        for tile in 0..self.layout.tile_count() {
            let header = self.header(tile);
            let at = [tile % self.layout.tiles[0], tile / self.layout.tiles[0]];
            let pixels: u32 = [0, 1]
                .map(|axis| {
                    let start = at[axis] * self.options.tile[axis];
                    (self.extent[axis] - start).min(self.options.tile[axis])
                })
                .iter()
                .product();
            let (primaries, waves) = match header.is_identity() {
                true => (pixels, waves_per_tile),
                false => (header.count(), header.count().div_ceil(self.options.wave)),
            };
            statistics.pixels += u64::from(pixels);
            statistics.primaries += u64::from(primaries);
            statistics.waves += u64::from(waves_per_tile);
            statistics.waves_retired += u64::from(waves_per_tile - waves);
            statistics.identity_tiles += u64::from(header.is_identity());
        }
        statistics
    }
}

/// How much of a picture is shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Pixels of the extent.
    pub pixels: u64,
    /// Pixels that are shaded.
    pub primaries: u64,
    /// Waves launched.
    pub waves: u64,
    /// Waves that find nothing to do.
    pub waves_retired: u64,
    /// Tiles in which every pixel is its own primary.
    pub identity_tiles: u64,
}

impl Statistics {
    /// The share of pixels that are shaded, 0 to 1.
    pub fn primary_share(&self) -> f64 {
        self.primaries as f64 / self.pixels.max(1) as f64
    }

    /// The share of waves that retire at once, 0 to 1.
    pub fn retired_share(&self) -> f64 {
        self.waves_retired as f64 / self.waves.max(1) as f64
    }
}
