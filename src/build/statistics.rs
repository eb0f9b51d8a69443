//! How much of a picture is shaded.

use super::RATES;

/// How much of a picture is shaded.
///
/// Waves and workgroups are those of tiled dispatch by a pass that skips sky; a list has at most one wave that is neither full
/// nor absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Pixels of the extent.
    pub pixels: u64,
    /// Pixels that are shaded, those of sky not among them.
    pub primaries: u64,
    /// Pixels of sky.
    pub sky_pixels: u64,
    /// Pixels of sky that a pass shades if it shades sky.
    pub sky_primaries: u64,
    /// Workgroups launched: one for each tile.
    pub groups: u64,
    /// Workgroups that find nothing to do.
    pub groups_retired: u64,
    /// Waves launched.
    pub waves: u64,
    /// Waves that find nothing to do.
    pub waves_retired: u64,
    /// Waves in which some invocations find nothing to do.
    pub waves_partial: u64,
    /// Tiles in which every pixel is its own primary.
    pub identity_tiles: u64,
    /// Tiles of one rate throughout.
    pub uniform_tiles: u64,
    /// All other tiles.
    pub mixed_tiles: u64,
    /// Tiles of sky throughout; they are counted above, too.
    pub sky_tiles: u64,
    /// Pixels by the rate that takes effect, as [`super::rate_index`] orders them.
    pub pixels_at: [u64; RATES],
}

impl Statistics {
    /// Words of the GPU's counts.
    pub const WORDS: usize = 13 + RATES;
    /// The bytes of the GPU's counts.
    pub const BYTES: u64 = 4 * Statistics::WORDS as u64;

    /// Reads the GPU's counts: the bytes of [`View::statistics`](crate::View::statistics).
    ///
    /// Bytes that are missing count as zero.
    pub fn read(bytes: &[u8]) -> Statistics {
        let mut words = bytes
            .chunks_exact(4)
            .map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        let mut next = || words.next().unwrap_or(0);
        Statistics {
            pixels: next(),
            primaries: next(),
            sky_pixels: next(),
            sky_primaries: next(),
            groups: next(),
            groups_retired: next(),
            waves: next(),
            waves_retired: next(),
            waves_partial: next(),
            identity_tiles: next(),
            uniform_tiles: next(),
            mixed_tiles: next(),
            sky_tiles: next(),
            pixels_at: std::array::from_fn(|_| next()),
        }
    }

    /// Pixels that get a copy, those of sky not among them.
    pub fn duplicates(&self) -> u64 {
        self.pixels.saturating_sub(self.sky_pixels + self.primaries)
    }

    /// The share of pixels that are shaded, 0 to 1.
    pub fn primary_share(&self) -> f64 {
        self.primaries as f64 / self.pixels.max(1) as f64
    }

    /// The share of waves that retire at once, 0 to 1.
    pub fn retired_share(&self) -> f64 {
        self.waves_retired as f64 / self.waves.max(1) as f64
    }

    /// The shares of tiles by class, 0 to 1: those in which every pixel is its own primary, those of one rate throughout, all others (which
    /// sum up to 1); and of all of them those of sky throughout.
    pub fn class_shares(&self) -> [f64; 4] {
        [
            self.identity_tiles,
            self.uniform_tiles,
            self.mixed_tiles,
            self.sky_tiles,
        ]
        .map(|tiles| tiles as f64 / self.groups.max(1) as f64)
    }

    /// The share of pixels at a rate, 0 to 1.
    pub fn share_at(&self, rate: crate::Rate) -> f64 {
        self.pixels_at[super::rate_index(rate)] as f64 / self.pixels.max(1) as f64
    }
}
