//! Coordinates for checks and tests: the words of every mode as the CPU twin has them, with what an earlier frame may have left
//! in between; and the GPU's build held against the twin.

use fastrand::Rng;
use vrcs_passes::options::{Mode, Sky};

use super::gpu::{Gpu, GpuError};
use crate::{
    build::{
        CLASSIFIED_HEADER, Entry, LIST_HEADER, LIST_ROW, LinearDepth, ListEntry, ListLayout, RATES,
        cpu::Coordinates,
        gpu::{Buffers, Builder},
        list_groups,
        statistics::Statistics,
    },
    coverage::{Coverage, Textures, cpu::Samples},
    object::ObjectOptions,
    sri::Sri,
};

/// The words that a pass of a mode reads, and the workgroups to dispatch on the first two axes.
///
/// Lists are in a random order and have a random number of workgroups in a row: a shader may rely on neither. Words that
/// nothing may read hold entries of some earlier frame.
pub fn words(
    coordinates: &Coordinates,
    mode: Mode,
    sky: Sky,
    rng: &mut Rng,
) -> (Vec<u32>, [u32; 2]) {
    match mode {
        Mode::Tiled => (tiled(coordinates, rng), coordinates.layout.tiles),
        Mode::List => {
            let layout = ListLayout::new(coordinates.extent, &coordinates.options);
            let lists = coordinates.list();
            let counts = [0, 1].map(|i| lists[i].len() as u32);
            let mut words = leftovers(layout.list_bytes(), coordinates.extent, rng);
            put_entries(&mut words, LIST_HEADER, coordinates, lists, rng);
            put_user(&mut words, coordinates);
            let area = coordinates.options.area();
            let rows = [counts[0], counts[0] + counts[1]].map(|n| grid(n.div_ceil(area), rng));
            words[..2].copy_from_slice(&counts);
            (words, rows[usize::from(sky == Sky::Shade)])
        }
        Mode::Classified => classified(coordinates, sky, rng),
        Mode::Graded | Mode::Auto => (coordinates.graded(), coordinates.layout.tiles),
    }
}

/// A number of workgroups in two dimensions; in every other case with too many, so that a second row is met in small pictures, too.
fn grid(groups: u32, rng: &mut Rng) -> [u32; 2] {
    let [row, rows] = list_groups(groups);
    match groups > 0 && rng.bool() {
        true => [LIST_ROW, rows + rng.u32(0..2)],
        false => [row, rows],
    }
}

fn tiled(coordinates: &Coordinates, rng: &mut Rng) -> Vec<u32> {
    let mut words = coordinates.words.clone();
    let layout = &coordinates.layout;
    let [width, height] = coordinates.options.tile;
    for tile in 0..layout.tile_count() {
        let start = layout.entries + tile * layout.entries_per_tile;
        let used = coordinates.header(tile).stored();
        let room = layout.entries_per_tile;
        for word in &mut words[(start + used) as usize..(start + room) as usize] {
            let (x, y) = (rng.u32(0..width), rng.u32(0..height));
            *word = Entry::new(x, y, rng.u32(0..0x1_0000) | 1 << ((y & 3) * 4 + (x & 3))).0;
        }
    }
    words
}

/// Words that look like entries.
fn leftovers(bytes: u64, extent: [u32; 2], rng: &mut Rng) -> Vec<u32> {
    (0..bytes / 4)
        .map(|_| rng.u32(0..extent[0]) | rng.u32(0..extent[1]) << 14 | rng.u32(0..8) << 28)
        .collect()
}

fn put_entries(
    words: &mut [u32],
    start: u32,
    coordinates: &Coordinates,
    [mut covered, mut sky]: [Vec<ListEntry>; 2],
    rng: &mut Rng,
) {
    let layout = ListLayout::new(coordinates.extent, &coordinates.options);
    rng.shuffle(&mut covered);
    rng.shuffle(&mut sky);
    let mut put = |place: u32, entry: ListEntry| {
        let at = (start + place * layout.stride) as usize;
        match layout.stride {
            1 => words[at] = entry.quad(),
            _ => {
                let [place, mask] = entry.block();
                let depth = coordinates.linear_depth(entry.pixel);
                let depth = depth.map_or(0, |share| LinearDepth::code(share, LinearDepth::LISTED));
                words[at..at + 2].copy_from_slice(&[place, mask | depth << 16]);
            }
        }
    };
    for (place, entry) in (0..).zip(covered) {
        put(place, entry);
    }
    for (place, entry) in (0..).zip(sky) {
        put(layout.capacity - 1 - place, entry);
    }
}

/// The user's own bits of all tiles, which follow everything else.
fn put_user(words: &mut [u32], coordinates: &Coordinates) {
    let user = coordinates.user_words();
    let start = words.len() - user.len();
    words[start..].copy_from_slice(&user);
}

fn classified(coordinates: &Coordinates, sky: Sky, rng: &mut Rng) -> (Vec<u32>, [u32; 2]) {
    let layout = ListLayout::new(coordinates.extent, &coordinates.options);
    let lists = coordinates.classified();
    let mut words = leftovers(layout.classified_bytes(), coordinates.extent, rng);
    let area = coordinates.options.area();
    let mixed = [0, 1].map(|of| lists.mixed[of].len() as u32);
    words[14] = mixed[0];
    words[15] = mixed[1];
    let mut groups = [mixed[0], mixed[0] + mixed[1]].map(|entries| entries.div_ceil(area));
    for rate in 0..RATES {
        let pixels = crate::Rate::ALL[rate].width() * crate::Rate::ALL[rate].height();
        let counts = [0, 1].map(|of| lists.tiles[of][rate].len() as u32);
        words[rate] = counts[0];
        words[rate + RATES] = counts[1];
        groups[0] += counts[0].div_ceil(pixels);
        groups[1] += (counts[0] + counts[1]).div_ceil(pixels);
        words[16 + rate] = groups[0];
        words[16 + RATES + rate] = groups[1];
        let region = (CLASSIFIED_HEADER + rate as u32 * layout.tiles) as usize;
        for (place, tile) in lists.tiles[0][rate].iter().enumerate() {
            words[region + place] = *tile;
        }
        for (place, tile) in lists.tiles[1][rate].iter().enumerate() {
            words[region + layout.tiles as usize - 1 - place] = *tile;
        }
    }
    let rows = groups.map(|groups| grid(groups, rng));
    words[30] = coordinates.order.code();
    put_entries(&mut words, layout.mixed(), coordinates, lists.mixed, rng);
    put_user(&mut words, coordinates);
    (words, rows[usize::from(sky == Sky::Shade)])
}

/// The textures of samples.
#[derive(Debug)]
pub struct SampleTextures {
    triangles: Option<wgpu::TextureView>,
    surfaces: Option<wgpu::TextureView>,
    depth: Option<wgpu::TextureView>,
    normals: Option<wgpu::TextureView>,
}

impl SampleTextures {
    /// Uploads what a scene has.
    pub fn new(gpu: &Gpu, coverage: &Coverage, samples: &Samples) -> SampleTextures {
        use wgpu::TextureFormat as F;
        let texture = |declared: bool, format: F, bytes: &[u8]| {
            (declared && !bytes.is_empty())
                .then(|| gpu.texture("vrcs samples", samples.size, format, bytes))
        };
        SampleTextures {
            triangles: texture(
                coverage.triangles,
                F::R32Uint,
                bytemuck::cast_slice(&samples.triangles),
            ),
            surfaces: texture(
                coverage.surfaces,
                F::R32Uint,
                bytemuck::cast_slice(&samples.surfaces),
            ),
            depth: texture(
                coverage.depth.is_some(),
                F::R32Float,
                bytemuck::cast_slice(&samples.depth),
            ),
            normals: texture(
                coverage.normals.is_some(),
                F::Rg32Float,
                bytemuck::cast_slice(&samples.normals),
            ),
        }
    }

    /// For a builder, or a view.
    pub fn get(&self) -> Textures<'_> {
        Textures {
            triangles: self.triangles.as_ref(),
            surfaces: self.surfaces.as_ref(),
            depth: self.depth.as_ref(),
            normals: self.normals.as_ref(),
            ..Textures::default()
        }
    }
}

/// What the GPU made of everything that a build's options ask for.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The tiled buffer.
    pub coords: Vec<u32>,
    /// The list.
    pub list: Vec<u32>,
    /// The classified lists.
    pub classified: Vec<u32>,
    /// The graded buffer.
    pub graded: Vec<u32>,
    /// The effective rates.
    pub effective: Vec<u8>,
    /// The arguments of indirect dispatches.
    pub arguments: Vec<u32>,
    /// The statistics.
    pub statistics: Statistics,
}

/// Builds on the GPU, `times` frames in a row with the same buffers, poisoned beforehand.
///
/// # Errors
/// If the device refuses, or is lost.
pub fn build_on(
    gpu: &Gpu,
    builder: &Builder,
    sri: &Sri,
    samples: Option<&Samples>,
    twin: &Coordinates,
    times: u32,
) -> Result<Built, GpuError> {
    let options = builder.options();
    let objects = ObjectOptions::default();
    let buffers = Buffers::new(&gpu.device, options, twin.extent, &objects);
    gpu.queue.write_buffer(&buffers.sri, 0, sri.bytes());
    let made = [
        &buffers.coords,
        &buffers.list,
        &buffers.classified,
        &buffers.graded,
        &buffers.effective,
        &buffers.arguments,
        &buffers.statistics,
    ];
    for buffer in made.into_iter().flatten() {
        let poison = vec![0xa5; buffer.size() as usize];
        gpu.queue.write_buffer(buffer, 0, &poison);
    }
    if let Some(buffer) = &buffers.user {
        let bits = (0..twin.layout.tile_count()).map(|tile| twin.header(tile).user());
        let words = crate::build::user_words(bits);
        gpu.queue
            .write_buffer(buffer, 0, bytemuck::cast_slice(&words));
    }
    let textures = samples.map(|samples| SampleTextures::new(gpu, &options.coverage, samples));
    let textures = textures.as_ref().map(SampleTextures::get);
    let Some(bound) = builder.bind(&gpu.device, &buffers, &textures.unwrap_or_default()) else {
        return Err(GpuError::Refused(
            "a declared texture is missing".to_owned(),
        ));
    };
    let extent = [twin.extent[0], twin.extent[1], 3];
    builder.set(&gpu.queue, &bound, extent);
    let mut encoder = gpu.encoder();
    for _ in 0..times {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        builder.record(&mut pass, &bound, twin.extent, twin.order);
    }
    let present: Vec<&wgpu::Buffer> = made.into_iter().flatten().collect();
    let mut read = gpu.submit_and_read(encoder, &present)?.into_iter();
    let mut next = |buffer: &Option<wgpu::Buffer>| match buffer {
        Some(_) => read.next().unwrap_or_default(),
        None => Vec::new(),
    };
    let words = |bytes: Vec<u8>| bytemuck::pod_collect_to_vec::<u8, u32>(&bytes);
    Ok(Built {
        coords: words(next(made[0])),
        list: words(next(made[1])),
        classified: words(next(made[2])),
        graded: words(next(made[3])),
        effective: next(made[4]),
        arguments: words(next(made[5])),
        statistics: Statistics::read(&next(made[6])),
    })
}

/// A difference between what the GPU built and what its twin did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Where.
    pub place: String,
    /// What the twin has.
    pub expected: String,
    /// What the GPU has.
    pub got: String,
}

fn differ<T: std::fmt::Debug + PartialEq>(
    place: impl FnOnce() -> String,
    expected: T,
    got: T,
) -> Result<(), Difference> {
    match expected == got {
        true => Ok(()),
        false => Err(Difference {
            place: place(),
            expected: format!("{expected:x?}"),
            got: format!("{got:x?}"),
        }),
    }
}

/// Holds everything that was built against the twin: the tiled buffer word for word, lists as sets, arguments by what they
/// cover; and that nothing else was written.
///
/// # Errors
/// The first difference.
pub fn compare(twin: &Coordinates, built: &Built) -> Result<(), Difference> {
    let options = &twin.options;
    let layout = ListLayout::new(twin.extent, options);
    if options.modes.tiled {
        compare_tiled(twin, &built.coords)?;
    }
    if options.modes.list {
        let counts = [0, 1].map(|i| built.list[i]);
        let got = read_entries(twin, &built.list, LIST_HEADER, counts)?;
        compare_lists("list", twin.list(), got)?;
        compare_user("list", twin, &built.list)?;
        let groups = [counts[0], counts[0] + counts[1]].map(|n| n.div_ceil(options.area()));
        compare_arguments(&built.arguments[..6], groups)?;
    }
    if options.modes.classified {
        compare_classified(twin, &layout, built)?;
        compare_user("classified lists", twin, &built.classified)?;
    }
    if options.modes.graded {
        for (at, (wanted, got)) in twin.graded().iter().zip(&built.graded).enumerate() {
            differ(|| format!("graded word {at}"), wanted, got)?;
        }
    }
    if options.effective {
        let sri = crate::sri::SriLayout::new(twin.extent[0], twin.extent[1]);
        for y in 0..sri.height {
            let row = (y * sri.pitch) as usize;
            let width = sri.width as usize;
            differ(
                || format!("effective rates, row {y}"),
                &twin.effective()[row..row + width],
                &built.effective[row..row + width],
            )?;
        }
    }
    if options.statistics {
        differ(
            || "statistics".to_owned(),
            twin.statistics(),
            built.statistics,
        )?;
    }
    Ok(())
}

fn compare_user(name: &str, twin: &Coordinates, got: &[u32]) -> Result<(), Difference> {
    let wanted = twin.user_words();
    let got = &got[got.len() - wanted.len()..];
    differ(|| format!("{name}: the user's bits"), &wanted[..], got)
}

fn compare_tiled(twin: &Coordinates, got: &[u32]) -> Result<(), Difference> {
    for tile in 0..twin.layout.tile_count() {
        let header = twin.header(tile);
        differ(
            || format!("header of tile {tile}"),
            header.0,
            got[tile as usize],
        )?;
        let start = (twin.layout.entries + tile * twin.layout.entries_per_tile) as usize;
        let used = start + header.stored() as usize;
        let wanted = &twin.words[start..used];
        let with_depth = |(wanted, got): (&u32, &u32)| match twin.options.linear_depth {
            // the distance is a quotient, which drivers round as they like: one step of depth
            Some(_) if (wanted >> 12).abs_diff(got >> 12) <= 1 => wanted & !0xfff | got & 0xfff,
            _ => *got,
        };
        let found: Vec<u32> = wanted
            .iter()
            .zip(&got[start..used])
            .map(with_depth)
            .collect();
        differ(|| format!("entries of tile {tile}"), wanted, &found[..])?;
        let unused = &got[used..start + twin.layout.entries_per_tile as usize];
        if let Some(word) = unused.iter().find(|word| **word != 0xa5a5_a5a5) {
            differ(|| format!("beyond tile {tile}"), 0xa5a5_a5a5, *word)?;
        }
    }
    Ok(())
}

fn read_entries(
    twin: &Coordinates,
    words: &[u32],
    start: u32,
    counts: [u32; 2],
) -> Result<[Vec<ListEntry>; 2], Difference> {
    let layout = ListLayout::new(twin.extent, &twin.options);
    let all = u64::from(counts[0]) + u64::from(counts[1]);
    if all > u64::from(layout.capacity) {
        differ(|| "entries".to_owned(), u64::from(layout.capacity), all)?;
    }
    let read = |place: u32| {
        let at = (start + place * layout.stride) as usize;
        let entry = ListEntry::read(&words[at..at + layout.stride as usize]);
        if let Some(share) = twin.linear_depth(entry.pixel) {
            let wanted = LinearDepth::code(share, LinearDepth::LISTED);
            let got = words[at + 1] >> 16;
            if wanted.abs_diff(got) > 1 {
                differ(|| format!("depth of {:?}", entry.pixel), wanted, got)?;
            }
        }
        Ok(entry)
    };
    let covered: Result<_, Difference> = (0..counts[0]).map(read).collect();
    let sky: Result<_, Difference> = (0..counts[1])
        .map(|place| read(layout.capacity - 1 - place))
        .collect();
    Ok([covered?, sky?])
}

fn compare_lists(
    name: &str,
    wanted: [Vec<ListEntry>; 2],
    got: [Vec<ListEntry>; 2],
) -> Result<(), Difference> {
    for (of, (mut wanted, mut got)) in wanted.into_iter().zip(got).enumerate() {
        wanted.sort_unstable();
        got.sort_unstable();
        let kind = ["covered", "sky"][of];
        differ(
            || format!("{name}: number of {kind} entries"),
            wanted.len(),
            got.len(),
        )?;
        for (wanted, got) in wanted.iter().zip(&got) {
            differ(|| format!("{name}: {kind} entries"), wanted, got)?;
        }
    }
    Ok(())
}

/// Arguments are those of so many workgroups, in three layers.
fn compare_arguments(got: &[u32], groups: [u32; 2]) -> Result<(), Difference> {
    for of in 0..2 {
        let [row, rows] = list_groups(groups[of]);
        let found = &got[of * 3..of * 3 + 3];
        differ(|| "arguments".to_owned(), [row, rows, 3].as_slice(), found)?;
    }
    Ok(())
}

fn compare_classified(
    twin: &Coordinates,
    layout: &ListLayout,
    built: &Built,
) -> Result<(), Difference> {
    let wanted = twin.classified();
    let got = &built.classified;
    let mixed = [got[14], got[15]];
    let area = twin.options.area();
    let mut groups = [mixed[0], mixed[0] + mixed[1]].map(|entries| entries.div_ceil(area));
    for rate in 0..RATES {
        let region = (CLASSIFIED_HEADER + rate as u32 * layout.tiles) as usize;
        let counts = [got[rate], got[rate + RATES]];
        let end = region + layout.tiles as usize;
        let found = [
            &got[region..region + counts[0] as usize],
            &got[end - counts[1] as usize..end],
        ];
        for of in 0..2 {
            let mut found = found[of].to_vec();
            found.sort_unstable();
            differ(
                || format!("classified tiles of rate {rate}"),
                &wanted.tiles[of][rate],
                &found,
            )?;
        }
        let pixels = crate::Rate::ALL[rate].width() * crate::Rate::ALL[rate].height();
        groups[0] += counts[0].div_ceil(pixels);
        groups[1] += (counts[0] + counts[1]).div_ceil(pixels);
        let ends = [got[16 + rate], got[16 + RATES + rate]];
        differ(|| format!("the end of rate {rate}"), groups, ends)?;
    }
    let entries = read_entries(twin, got, layout.mixed(), mixed)?;
    compare_lists("mixed tiles", wanted.mixed, entries)?;
    differ(|| "phase".to_owned(), twin.order.code(), got[30])?;
    compare_arguments(&built.arguments[6..12], groups)
}
