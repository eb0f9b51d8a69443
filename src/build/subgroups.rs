//! How many subgroups of a tiled dispatch have anything to do: what a shading-rate image promises, to be held against what a
//! driver's counters say.
//!
//! *Needs*: a driver that puts invocations into subgroups by their local index, as all that we know of do.

use super::cpu::Coordinates;

/// Subgroups of a tiled dispatch, one workgroup a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Subgroups {
    /// Those that are launched.
    pub launched: u64,
    /// Those of workgroups that do not leave at once: a workgroup without a primary does.
    pub started: u64,
    /// Those of which an invocation has a primary.
    pub busy: u64,
}

impl Subgroups {
    /// Those that retire, or skip what is done for primaries.
    pub fn retired(&self) -> u64 {
        self.launched - self.busy
    }
}

impl Coordinates {
    /// The subgroups of `size` invocations of a tiled dispatch over this extent, for a shader whose domain is the extent.
    pub fn subgroups(&self, size: u32, skips_sky: bool) -> Subgroups {
        let [width, height] = self.options.tile;
        let each = u64::from(self.options.area().div_ceil(size));
        let mut sum = Subgroups::default();
        for tile in 0..self.layout.tile_count() {
            let header = self.header(tile);
            let is_skipped = skips_sky && header.is_sky();
            let count = header.count() + if skips_sky { 0 } else { header.sky_count() };
            let busy = match header.is_identity() {
                _ if is_skipped => 0,
                false => u64::from(count.div_ceil(size)),
                true => {
                    // every invocation is its own, and those beyond the extent have nothing to do
                    let [x, y] = self.origin(tile);
                    let is_inside = |lane: u32| {
                        lane < width * height
                            && x + lane % width < self.extent[0]
                            && y + lane / width < self.extent[1]
                    };
                    let has_work = |first: &u32| (*first..first + size).any(is_inside);
                    let firsts = (0..width * height).step_by(size as usize);
                    firsts.filter(has_work).count() as u64
                }
            };
            sum.launched += each;
            sum.started += if busy > 0 { each } else { 0 };
            sum.busy += busy;
        }
        sum
    }
}
