//! The coordinate builder: the GPU makes the same words as its CPU twin, and every pixel has exactly one primary.

mod common;

use fastrand::Rng;
use vrcs::{
    Rate,
    build::{
        BuildOptions, Header,
        cpu::{self, Coordinates},
        gpu::Builder,
    },
    check::{gpu::Gpu, rates::Pattern},
    sri::Sri,
};
use vrcs_passes::options::FullTiles;

const SIZES: [[u32; 2]; 10] = [
    [1, 1],
    [2, 3],
    [15, 17],
    [31, 33],
    [16, 16],
    [64, 48],
    [3, 1080],
    [201, 1080],
    [8192, 5],
    [5, 2161],
];

fn options() -> impl Iterator<Item = BuildOptions> {
    let largest = [Rate::R2X2, Rate::R4X4, Rate::R2X1, Rate::R1X1];
    let rules = [FullTiles::Promote, FullTiles::Keep];
    let waves = [32, 64, 8];
    largest.into_iter().flat_map(move |largest| {
        rules.into_iter().flat_map(move |full_tiles| {
            waves.into_iter().map(move |wave| BuildOptions {
                wave,
                full_tiles,
                largest,
                ..BuildOptions::default()
            })
        })
    })
}

fn build_on(gpu: &Gpu, builder: &Builder, sri: &Sri, extent: [u32; 2], words: usize) -> Vec<u32> {
    let buffer = |label, bytes: &[u8]| gpu.buffer(label, bytes, wgpu::BufferUsages::STORAGE);
    let image = buffer("rates", sri.bytes());
    // poisoned: what is not written shows
    let coords = buffer("coordinates", &vec![0xa5; words * 4]);
    let bound = builder.bind(&gpu.device, &image, &coords);
    builder.set_extent(&gpu.queue, &bound, extent);
    let mut encoder = gpu.encoder();
    builder.record(
        &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        &bound,
        extent,
    );
    let read = gpu
        .submit_and_read(encoder, &[&coords])
        .expect("coordinates");
    bytemuck::pod_collect_to_vec(&read[0])
}

#[test]
fn the_gpu_makes_the_words_of_its_cpu_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let mut tried = 0;
    for options in options() {
        let builder = Builder::new(&gpu.device, options);
        for (index, extent) in SIZES.into_iter().enumerate() {
            let mut rng = Rng::with_seed(seed + index as u64);
            let pattern = Pattern::of_case(rng.u32(0..24), options.largest);
            let sri = pattern.image(extent[0], extent[1], &mut rng);
            let wanted = cpu::build(&sri, extent, &options);
            let got = build_on(&gpu, &builder, &sri, extent, wanted.words.len());
            for tile in 0..wanted.layout.tile_count() {
                let header = wanted.header(tile);
                assert_eq!(
                    Header(got[tile as usize]),
                    header,
                    "{pattern:?} {extent:?} tile {tile}"
                );
                let start =
                    (wanted.layout.entries + tile * wanted.layout.entries_per_tile) as usize;
                let count = header.count() as usize;
                assert_eq!(
                    got[start..start + count],
                    wanted.words[start..start + count],
                    "{pattern:?} {extent:?} tile {tile}"
                );
                let room = wanted.layout.entries_per_tile as usize;
                assert!(
                    got[start + count..start + room]
                        .iter()
                        .all(|&word| word == 0xa5a5_a5a5),
                    "more than the tile's entries was written"
                );
            }
            tried += 1;
        }
    }
    assert_eq!(tried, 240);
}

/// Each pixel of the extent is a member of exactly one group, its primary is a member of that group, and a group shares
/// one rate's block.
fn assert_partition(coordinates: &Coordinates) {
    let [width, height] = coordinates.extent;
    let mut seen = vec![0; (width * height) as usize];
    for tile in 0..coordinates.layout.tile_count() {
        let [tile_width, tile_height] = coordinates.options.tile;
        let origin = [
            tile % coordinates.layout.tiles[0] * tile_width,
            tile / coordinates.layout.tiles[0] * tile_height,
        ];
        if coordinates.header(tile).is_identity() {
            assert_eq!(coordinates.header(tile).count(), 0);
            for y in origin[1]..(origin[1] + tile_height).min(height) {
                for x in origin[0]..(origin[0] + tile_width).min(width) {
                    seen[(y * width + x) as usize] += 1;
                }
            }
        }
        for entry in coordinates.entries(tile) {
            let (x, y) = (origin[0] + entry.x(), origin[1] + entry.y());
            let own = (y & 3) * 4 + (x & 3);
            assert!(
                entry.mask() >> own & 1 == 1,
                "a primary outside its group: {entry:?}"
            );
            for bit in (0..16).filter(|bit| entry.mask() >> bit & 1 == 1) {
                let (mx, my) = ((x & !3) + bit % 4, (y & !3) + bit / 4);
                assert!(mx < width && my < height, "a member outside the extent");
                seen[(my * width + mx) as usize] += 1;
            }
        }
    }
    assert!(
        seen.iter().all(|&times| times == 1),
        "{:?}",
        coordinates.extent
    );
}

#[test]
fn every_pixel_has_exactly_one_primary() {
    let seed = common::seed();
    for options in options() {
        for extent in SIZES {
            for case in 0..12 {
                let mut rng = Rng::with_seed(seed + u64::from(case));
                let pattern = Pattern::of_case(case, options.largest);
                let sri = pattern.image(extent[0], extent[1], &mut rng);
                assert_partition(&cpu::build(&sri, extent, &options));
            }
        }
    }
}

/// A whole tile with `count` primaries: full rate, but for the first quads.
fn tile_with(count: u32, options: &BuildOptions) -> Coordinates {
    assert!((64..=256).contains(&count));
    let mut saved = 256 - count;
    let sri = Sri::from_fn(16, 16, |_, _| {
        let (rate, saves) = match saved {
            0 => (Rate::R1X1, 0),
            1 | 2 => (Rate::R2X1, 2),
            _ => (Rate::R2X2, 3),
        };
        saved = saved.saturating_sub(saves);
        rate.code()
    });
    cpu::build(&sri, [16, 16], options)
}

#[test]
fn a_nearly_full_tile_is_promoted_or_kept() {
    let promote = BuildOptions::default();
    let keep = BuildOptions {
        full_tiles: FullTiles::Keep,
        ..promote
    };
    assert_eq!(promote.entries_per_tile(), 224, "the slides' 256 - 32");
    for count in [64, 223, 224, 226, 240, 254] {
        let coordinates = tile_with(count, &promote);
        let exact = tile_with(count, &keep);
        let stored = exact.header(0).count();
        assert!(stored.abs_diff(count) <= 2 && !exact.header(0).is_identity());
        assert_eq!(
            coordinates.header(0).is_identity(),
            stored > 224,
            "{stored} primaries"
        );
        assert_partition(&coordinates);
        assert_partition(&exact);
    }
    for options in [promote, keep] {
        let full = cpu::build(&Sri::uniform(16, 16, Rate::R1X1), [16, 16], &options);
        assert!(full.header(0).is_identity());
    }
}

#[test]
fn statistics_count_what_a_wave_does() {
    let sri = Sri::uniform(32, 16, Rate::R2X2);
    let coordinates = cpu::build(&sri, [32, 16], &BuildOptions::default());
    let statistics = coordinates.statistics();
    assert_eq!(statistics.pixels, 512);
    assert_eq!(statistics.primaries, 128);
    assert_eq!(statistics.waves, 16);
    // 64 primaries fill 2 of a tile's 8 waves
    assert_eq!(statistics.waves_retired, 12);
    let sri = Sri::uniform(32, 16, Rate::R1X1);
    let statistics = cpu::build(&sri, [32, 16], &BuildOptions::default()).statistics();
    assert_eq!(
        (statistics.waves_retired, statistics.identity_tiles),
        (0, 2)
    );
}
