//! The coordinate builder on the CPU: the oracle in tests, and for whoever has no GPU at hand.

use super::{
    BuildOptions, CoordLayout, Entry, Header, LinearDepth, ListEntry, RATES, effective,
    primary::Order, rate_index, statistics::Statistics, tile_place,
};
use crate::{
    coverage::cpu::Samples,
    rate::Rate,
    sri::{Sri, SriLayout},
};

/// What a frame's build is made from, besides its rates.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame<'f> {
    /// How primaries are chosen.
    pub order: Order,
    /// What coverage is told by; needed if the options declare any.
    pub samples: Option<&'f Samples>,
    /// The user's own bits, if the options ask for them, in the form of [`user_words`](super::user_words).
    pub user: &'f [u32],
}

/// A coordinate buffer in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinates {
    /// The logical extent, in pixels.
    pub extent: [u32; 2],
    /// How it was built.
    pub options: BuildOptions,
    /// Where things are.
    pub layout: CoordLayout,
    /// The words of the tiled buffer, as on the GPU. Words that no tile uses are zero.
    pub words: Vec<u32>,
    /// How primaries were chosen.
    pub order: Order,
    tiles: Vec<Tile>,
    effective: Vec<u8>,
    linear: Vec<f32>,
}

/// A tile's groups.
#[derive(Clone, Debug, Default, PartialEq)]
struct Tile {
    header: u32,
    /// Groups of covered pixels, then of sky; each pixel its own in an identity tile.
    covered: Vec<Entry>,
    sky: Vec<Entry>,
    /// Its pixels at each rate.
    pixels_at: [u64; RATES],
}

/// Builds the coordinate buffer of a picture from its rates alone.
pub fn build(sri: &Sri, extent: [u32; 2], options: &BuildOptions) -> Coordinates {
    build_frame(sri, extent, options, &Frame::default())
}

/// Builds the coordinate buffer of a frame.
///
/// # Panics
/// If coverage is declared and no samples are given.
pub fn build_frame(
    sri: &Sri,
    extent: [u32; 2],
    options: &BuildOptions,
    frame: &Frame,
) -> Coordinates {
    assert!(
        options.coverage.is_empty() || frame.samples.is_some(),
        "coverage is declared, and there are no samples"
    );
    let layout = CoordLayout::new(extent, options);
    let mut words = vec![0; layout.words() as usize];
    let mut bytes = vec![0; SriLayout::new(extent[0], extent[1]).bytes() as usize];
    let mut tiles = Vec::with_capacity(layout.tile_count() as usize);
    let linear = linear_depths(extent, options, frame);
    for tile in 0..layout.tile_count() {
        let at = [tile % layout.tiles[0], tile / layout.tiles[0]];
        let build = TileBuild {
            sri,
            extent,
            options,
            frame,
            origin: [0, 1].map(|axis| at[axis] * options.tile[axis]),
        };
        let mut built = build.run(&mut bytes);
        if options.user {
            let word = frame.user.get(tile as usize / 8).copied().unwrap_or(0);
            built.header |= (word >> (tile % 8 * 4) & 15) << 28;
        }
        words[tile as usize] = built.header;
        let stored = Header(built.header).stored() as usize;
        let start = (layout.entries + tile * layout.entries_per_tile) as usize;
        let entries = built.covered.iter().chain(&built.sky).take(stored);
        for (word, entry) in words[start..].iter_mut().zip(entries) {
            let at = (build.origin[1] + entry.y()) * extent[0] + build.origin[0] + entry.x();
            *word = match linear.get(at as usize) {
                Some(&share) => {
                    entry.deep(build.origin, LinearDepth::code(share, LinearDepth::TILED))
                }
                None => entry.0,
            };
        }
        tiles.push(built);
    }
    Coordinates {
        extent,
        options: *options,
        layout,
        words,
        order: frame.order,
        tiles,
        effective: bytes,
        linear,
    }
}

/// The linear depth of each pixel, row by row, if entries carry it.
fn linear_depths(extent: [u32; 2], options: &BuildOptions, frame: &Frame) -> Vec<f32> {
    match (options.linear_depth, options.coverage.depth, frame.samples) {
        (Some(linear), Some(depth), Some(samples)) => (0..extent[0] * extent[1])
            .map(|at| samples.depth_at([at % extent[0], at / extent[0]]))
            .map(|texel| linear.share(texel, depth.kind))
            .collect(),
        _ => Vec::new(),
    }
}

/// A tile while it is built.
struct TileBuild<'t> {
    sri: &'t Sri,
    extent: [u32; 2],
    options: &'t BuildOptions,
    frame: &'t Frame<'t>,
    origin: [u32; 2],
}

impl TileBuild<'_> {
    /// The tile's groups. Writes the effective rates of its quads.
    fn run(&self, effective: &mut [u8]) -> Tile {
        let [width, height] = self.options.tile;
        let quads = self.options.quads();
        // for each pixel, the members of the group that it leads, and whether it is sky
        let mut leads = vec![(0, false); self.options.area() as usize];
        let mut split = vec![false; (quads[0] * quads[1]) as usize];
        for qy in 0..quads[1] {
            for qx in 0..quads[0] {
                self.cluster([qx, qy], &mut leads, &mut split);
            }
        }
        let mut tile = Tile::default();
        let mut rates = Vec::new();
        for qy in 0..quads[1] {
            for qx in 0..quads[0] {
                for i in 0..4 {
                    let [x, y] = [qx * 2 + (i & 1), qy * 2 + (i >> 1)];
                    if x >= width || y >= height {
                        continue;
                    }
                    let (mask, is_sky) = leads[(y * width + x) as usize];
                    let list = if is_sky {
                        &mut tile.sky
                    } else {
                        &mut tile.covered
                    };
                    if mask != 0 {
                        list.push(Entry::new(x, y, mask));
                    }
                }
                if self.room([qx * 2, qy * 2]).iter().all(|room| *room > 0) {
                    rates.push(self.rate_at([qx * 2, qy * 2]));
                }
            }
        }
        self.finish(&mut tile, &rates);
        let is_identity = Header(tile.header).is_identity();
        tile.pixels_at = self.pixels_at(is_identity);
        if self.options.is_odd() {
            // its quads are not the picture's
            return tile;
        }
        let pitch = SriLayout::new(self.extent[0], self.extent[1]).pitch;
        for qy in 0..quads[1] {
            for qx in 0..quads[0] {
                let room = self.room([qx * 2, qy * 2]);
                if room.contains(&0) {
                    continue;
                }
                let at = (self.origin[1] / 2 + qy) * pitch + self.origin[0] / 2 + qx;
                effective[at as usize] = match is_identity {
                    true => 0,
                    false => {
                        let split = split[(qy * quads[0] + qx) as usize];
                        self.cut_rate([qx * 2, qy * 2]).code()
                            | if split { effective::SPLIT } else { 0 }
                    }
                };
            }
        }
        tile
    }

    /// The rate at a pixel of the tile.
    fn rate_at(&self, pixel: [u32; 2]) -> Rate {
        let [x, y] = [0, 1].map(|axis| (self.origin[axis] + pixel[axis]) / 2);
        self.sri.rate(x, y, self.options.largest)
    }

    /// How far the extent reaches from a pixel of the tile.
    fn room(&self, pixel: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|axis| self.extent[axis].saturating_sub(self.origin[axis] + pixel[axis]))
    }

    /// A pixel's rate where the extent cuts its block.
    fn cut_rate(&self, pixel: [u32; 2]) -> Rate {
        let rate = self.rate_at(pixel);
        let size = [rate.width(), rate.height()];
        let corner = [0, 1].map(|axis| pixel[axis] / size[axis] * size[axis]);
        let room = self.room(corner);
        let cut = [0, 1].map(|axis| size[axis].min(room[axis].next_power_of_two()));
        // there is no 4x1 and no 1x4
        Rate::from_code((cut[0].ilog2() << 2 | cut[1].ilog2()) as u8).unwrap_or(rate)
    }

    /// The tile's pixels at each rate.
    fn pixels_at(&self, is_identity: bool) -> [u64; RATES] {
        let room = self.room([0, 0]);
        let [width, height] = [0, 1].map(|axis| room[axis].min(self.options.tile[axis]));
        let mut pixels_at = [0; RATES];
        for y in 0..height {
            for x in 0..width {
                let rate = match is_identity {
                    true => Rate::R1X1,
                    false => self.cut_rate([x, y]),
                };
                pixels_at[rate_index(rate)] += 1;
            }
        }
        pixels_at
    }

    /// Finds the groups of the blocks that start in a quad.
    fn cluster(&self, quad: [u32; 2], leads: &mut [(u32, bool)], split: &mut [bool]) {
        let [width, height] = self.options.tile;
        for i in 0..4 {
            let [x, y] = [quad[0] * 2 + (i & 1), quad[1] * 2 + (i >> 1)];
            if x >= width || y >= height {
                continue;
            }
            let rate = self.rate_at([x, y]);
            let is_corner = x.is_multiple_of(rate.width()) && y.is_multiple_of(rate.height());
            if is_corner {
                self.block(rate, [x, y], leads, split);
            }
        }
    }

    fn block(&self, rate: Rate, corner: [u32; 2], leads: &mut [(u32, bool)], split: &mut [bool]) {
        let first_corner = [0, 1].map(|axis| self.origin[axis] + corner[axis]);
        let absolute = |place: u32| {
            [
                (first_corner[0] & !3) + (place & 3),
                (first_corner[1] & !3) + (place >> 2),
            ]
        };
        let pixel = |place: u32| {
            let at = absolute(place);
            [0, 1].map(|axis| at[axis] - self.origin[axis])
        };
        let room = self.room(corner);
        let mut left = 0;
        let mut sky = 0;
        for dy in 0..rate.height().min(room[1]) {
            for dx in 0..rate.width().min(room[0]) {
                let place = ((first_corner[1] + dy) & 3) * 4 + ((first_corner[0] + dx) & 3);
                left |= 1 << place;
                sky |= u32::from(self.is_sky(absolute(place))) << place;
            }
        }
        let flip = self.frame.order.flip(rate, first_corner, left & !sky);
        let mut groups = 0;
        while left != 0 {
            let home = Order::first(left, flip);
            let members = (0..16)
                .filter(|place| left >> place & 1 != 0)
                .filter(|&place| place == home || self.share(absolute(home), absolute(place)))
                .fold(0, |mask, place| mask | 1 << place);
            let [x, y] = pixel(home);
            leads[(y * self.options.tile[0] + x) as usize] = (members, sky >> home & 1 != 0);
            left &= !members;
            groups += 1;
        }
        if groups > 1 {
            let across = self.options.quads()[0];
            for qy in 0..rate.height().div_ceil(2) {
                for qx in 0..rate.width().div_ceil(2) {
                    let at = (corner[1] / 2 + qy) * across + corner[0] / 2 + qx;
                    split[at as usize] = true;
                }
            }
        }
    }

    fn is_sky(&self, pixel: [u32; 2]) -> bool {
        let coverage = &self.options.coverage;
        self.frame
            .samples
            .is_some_and(|samples| samples.is_sky(coverage, pixel))
    }

    fn share(&self, a: [u32; 2], b: [u32; 2]) -> bool {
        let coverage = &self.options.coverage;
        match self.frame.samples {
            Some(samples) if !coverage.is_empty() => samples.share(coverage, a, b),
            _ => true,
        }
    }

    /// The tile's header; groups of an identity tile become its pixels.
    fn finish(&self, tile: &mut Tile, rates: &[Rate]) {
        let area = self.options.area();
        let (covered, sky) = (tile.covered.len() as u32, tile.sky.len() as u32);
        let room = self.room([0, 0]);
        let is_whole = (0..2).all(|axis| room[axis] >= self.options.tile[axis]);
        let is_alone = covered == 0 || sky == 0;
        let total = covered + sky;
        let sky_flag = if covered == 0 { Header::SKY } else { 0 };
        let phase = self.frame.order.code() << 21;
        if is_alone && (total > self.options.full() || is_whole && total == area) {
            tile.header = Header::IDENTITY | sky_flag | phase;
            let own = self.pixels();
            match covered {
                0 => tile.sky = own,
                _ => tile.covered = own,
            }
            return;
        }
        tile.header = covered | sky << 9 | sky_flag | phase;
        let first = rates.first().copied().unwrap_or(Rate::R1X1);
        let of_rate = area / (first.width() * first.height());
        let is_uniform = rates.iter().all(|rate| *rate == first);
        let is_even = !self.options.is_odd();
        if is_even && is_whole && is_alone && is_uniform && total == of_rate {
            tile.header |= Header::UNIFORM | u32::from(first.code()) << 24;
        }
    }

    /// Every pixel of the tile that lies in the extent, as a group of its own, quad by quad.
    fn pixels(&self) -> Vec<Entry> {
        let [across, down] = self.options.quads();
        let [width, height] = self.options.tile;
        let room = self.room([0, 0]);
        (0..4 * across * down)
            .map(|index| {
                let (quad, i) = (index / 4, index % 4);
                [quad % across * 2 + (i & 1), quad / across * 2 + (i >> 1)]
            })
            .filter(|at| at[0] < room[0].min(width) && at[1] < room[1].min(height))
            .map(|[x, y]| {
                let [in_x, in_y] = [self.origin[0] + x, self.origin[1] + y].map(|side| side & 3);
                Entry::new(x, y, 1 << (in_y * 4 + in_x))
            })
            .collect()
    }
}

impl Coordinates {
    /// The header of a tile.
    pub fn header(&self, tile: u32) -> Header {
        Header(self.words[tile as usize])
    }

    /// The groups of a tile, those of an identity tile not included: covered ones, then those of sky.
    pub fn entries(&self, tile: u32) -> impl Iterator<Item = Entry> {
        let own = &self.tiles[tile as usize];
        let is_identity = Header(own.header).is_identity();
        own.covered
            .iter()
            .chain(&own.sky)
            .copied()
            .filter(move |_| !is_identity)
    }

    /// The first pixel of a tile.
    pub fn origin(&self, tile: u32) -> [u32; 2] {
        [
            tile % self.layout.tiles[0] * self.options.tile[0],
            tile / self.layout.tiles[0] * self.options.tile[1],
        ]
    }

    /// The effective map: for each pixel of the extent, row by row, the pixel that is shaded for it, `y * width + x`.
    pub fn map(&self) -> Vec<u32> {
        let [width, height] = self.extent;
        let mut map: Vec<u32> = (0..width * height).collect();
        self.each_member(|_, _, primary, member| {
            map[(member[1] * width + member[0]) as usize] = primary[1] * width + primary[0];
        });
        map
    }

    /// For each pixel of the extent, row by row, whether it is sky.
    pub fn sky(&self) -> Vec<bool> {
        let [width, height] = self.extent;
        let mut sky = vec![false; (width * height) as usize];
        self.each_member(|_, is_sky, _, member| {
            sky[(member[1] * width + member[0]) as usize] = is_sky;
        });
        sky
    }

    /// Visits each pixel with its group's entry, whether it is sky, and its primary.
    fn each_member(&self, mut visit: impl FnMut(Entry, bool, [u32; 2], [u32; 2])) {
        for (number, tile) in self.tiles.iter().enumerate() {
            let origin = self.origin(number as u32);
            let groups = tile.covered.iter().map(|entry| (entry, false));
            for (entry, is_sky) in groups.chain(tile.sky.iter().map(|entry| (entry, true))) {
                let (x, y) = (origin[0] + entry.x(), origin[1] + entry.y());
                for bit in (0..16).filter(|bit| entry.mask() >> bit & 1 != 0) {
                    let member = [(x & !3) + (bit & 3), (y & !3) + (bit >> 2)];
                    visit(*entry, is_sky, [x, y], member);
                }
            }
        }
    }

    /// The effective rates, one [byte](effective) a quad, in the form of [`SriLayout`].
    pub fn effective(&self) -> &[u8] {
        &self.effective
    }

    /// The linear depth of a pixel, 0 to 1, if entries [carry](BuildOptions::linear_depth) it.
    pub fn linear_depth(&self, pixel: [u32; 2]) -> Option<f32> {
        let at = pixel[1] * self.extent[0] + pixel[0];
        self.linear.get(at as usize).copied()
    }

    /// The user's own bits of all tiles, as the lists and the graded buffer have them at their end; none if the options ask for none.
    pub fn user_words(&self) -> Vec<u32> {
        match self.options.user {
            true => super::user_words(
                (0..self.layout.tile_count()).map(|tile| self.header(tile).user()),
            ),
            false => Vec::new(),
        }
    }

    /// The graded buffer.
    pub fn graded(&self) -> Vec<u32> {
        let pitch = self.extent[0].div_ceil(2);
        let mut words = vec![0; (pitch * self.extent[1].div_ceil(2)) as usize];
        self.each_member(|entry, _, _, member| {
            let at = (member[1] / 2 * pitch + member[0] / 2) as usize;
            let byte = (member[1] & 1) * 2 + (member[0] & 1);
            words[at] |= grade(entry.mask()) << (byte * 8);
        });
        words.extend(self.user_words());
        words
    }

    /// The entries of the list, in no particular order: of covered pixels, and of sky.
    pub fn list(&self) -> [Vec<ListEntry>; 2] {
        self.listed(|_| true)
    }

    /// The classified lists.
    pub fn classified(&self) -> Classified {
        let mut lists = Classified::default();
        for (number, tile) in self.tiles.iter().enumerate() {
            let header = Header(tile.header);
            if header.is_identity() || header.is_uniform() {
                let rate = Rate::from_code_or_full((tile.header >> 24 & 15) as u8);
                let of = &mut lists.tiles[usize::from(header.is_sky())];
                of[rate_index(rate)].push(tile_place(number as u32, self.layout.tiles[0]));
            }
        }
        lists.mixed = self.listed(|header| !header.is_identity() && !header.is_uniform());
        lists
    }

    fn listed(&self, of: impl Fn(Header) -> bool) -> [Vec<ListEntry>; 2] {
        let mut lists = [Vec::new(), Vec::new()];
        for (number, tile) in self.tiles.iter().enumerate() {
            if !of(Header(tile.header)) {
                continue;
            }
            let origin = self.origin(number as u32);
            for (list, entries) in lists.iter_mut().zip([&tile.covered, &tile.sky]) {
                list.extend(entries.iter().map(|entry| ListEntry {
                    pixel: [origin[0] + entry.x(), origin[1] + entry.y()],
                    mask: entry.mask(),
                }));
            }
        }
        lists
    }

    /// How much is shaded.
    pub fn statistics(&self) -> Statistics {
        let mut statistics = Statistics::default();
        let waves = self.options.area().div_ceil(self.options.wave);
        for (number, tile) in self.tiles.iter().enumerate() {
            let header = Header(tile.header);
            let (covered, sky) = (tile.covered.len() as u32, tile.sky.len() as u32);
            let origin = self.origin(number as u32);
            let room =
                [0, 1].map(|axis| (self.extent[axis] - origin[axis]).min(self.options.tile[axis]));
            // an identity tile's pixels stay where they are, beyond the extent included
            let busy = match header.is_identity() {
                true if covered > 0 => waves,
                true => 0,
                false => covered.div_ceil(self.options.wave),
            };
            statistics.pixels += u64::from(room[0] * room[1]);
            statistics.primaries += u64::from(covered);
            statistics.sky_primaries += u64::from(sky);
            statistics.groups += 1;
            statistics.groups_retired += u64::from(busy == 0);
            statistics.waves += u64::from(waves);
            statistics.waves_retired += u64::from(waves - busy);
            let is_partial = !header.is_identity() && !covered.is_multiple_of(self.options.wave);
            statistics.waves_partial += u64::from(is_partial);
            statistics.identity_tiles += u64::from(header.is_identity());
            statistics.uniform_tiles += u64::from(header.is_uniform());
            statistics.mixed_tiles += u64::from(!header.is_identity() && !header.is_uniform());
            statistics.sky_tiles += u64::from(header.is_sky());
            for (sum, pixels) in statistics.pixels_at.iter_mut().zip(tile.pixels_at) {
                *sum += pixels;
            }
        }
        for sky in self.sky() {
            statistics.sky_pixels += u64::from(sky);
        }
        statistics
    }
}

/// The classified lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Classified {
    /// [Places](super::tile_place) of tiles that are one rate throughout, by [`rate_index`]: of covered pixels, and of sky.
    pub tiles: [[Vec<u32>; RATES]; 2],
    /// Entries of mixed tiles: of covered pixels, and of sky.
    pub mixed: [Vec<ListEntry>; 2],
}

/// A member's byte in the graded buffer: in the low half how many others share with it, in the high half the rate of the
/// group's bounds.
pub fn grade(mask: u32) -> u32 {
    let columns = (mask | mask >> 4 | mask >> 8 | mask >> 12) & 15;
    let rows = (0..4).fold(0, |rows, row| {
        rows | u32::from(mask >> (row * 4) & 15 != 0) << row
    });
    // the smallest aligned block that holds all of them: the highest bit in which they differ
    let log = |bits: u32| (bits.ilog2() ^ bits.trailing_zeros()).min(2);
    (mask.count_ones() - 1) | (log(columns) << 2 | log(rows)) << 4
}
