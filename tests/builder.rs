//! The coordinate builder: the GPU makes the same words as its CPU twin, and every pixel has exactly one primary.

mod common;

use fastrand::Rng;
use vrcs::{
    Rate, View,
    analyse::half::{self, HalfResolution},
    build::{
        BuildOptions, Entry, LinearDepth, Modes,
        cpu::{self, Coordinates, Frame},
        effective,
        primary::Order,
    },
    check::{
        coordinates::{Built, SampleTextures, build_on, compare},
        gpu::Gpu,
        rates::Pattern,
    },
    coverage::{Coverage, Depth, DepthKind, Normals, Sky, Textures, cpu::Samples},
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
    let waves = [4, 8, 32, 64];
    largest
        .into_iter()
        .enumerate()
        .flat_map(move |(index, largest)| {
            rules.into_iter().map(move |full_tiles| BuildOptions {
                wave: waves[(index + usize::from(full_tiles == FullTiles::Keep)) % 4],
                full_tiles,
                largest,
                ..BuildOptions::default()
            })
        })
}

/// What is asked of a build, besides the tiled buffer.
fn everything(options: BuildOptions) -> BuildOptions {
    BuildOptions {
        modes: Modes::ALL,
        effective: true,
        statistics: true,
        user: true,
        ..options
    }
}

/// Builds on the GPU, two frames in a row, and holds all of it against the twin.
fn hold(
    gpu: &Gpu,
    sri: &Sri,
    extent: [u32; 2],
    options: BuildOptions,
    frame: &Frame,
) -> Coordinates {
    let twin = cpu::build_frame(sri, extent, &options, frame);
    let builder = gpu.builder(options).expect("a device for it");
    let built = build_on(gpu, &builder, sri, frame.samples, &twin, 2).expect("a build");
    if let Err(difference) = compare(&twin, &built) {
        panic!("{extent:?} {options:?} {:?}: {difference:?}", frame.order);
    }
    twin
}

#[test]
fn the_gpu_makes_what_its_cpu_twin_makes() {
    let gpu = common::gpu();
    let seed = common::seed();
    let mut tried = 0;
    for options in options() {
        for (index, extent) in SIZES.into_iter().enumerate() {
            let mut rng = Rng::with_seed(seed + index as u64);
            let pattern = Pattern::of_case(rng.u32(0..24), options.largest);
            let sri = pattern.image(extent[0], extent[1], &mut rng);
            let bits: Vec<u32> = (0..4096).map(|_| rng.u32(..)).collect();
            let frame = Frame {
                user: &bits,
                order: match rng.bool() {
                    true => Order::Rotating(rng.u32(..)),
                    false => Order::Fixed,
                },
                ..Frame::default()
            };
            hold(&gpu, &sri, extent, everything(options), &frame);
            tried += 1;
        }
    }
    assert_eq!(tried, 80);
}

/// What a scene may have, in every combination that changes the kernel.
fn coverages() -> Vec<Coverage> {
    let depth = |kind| Some(Depth::new(kind));
    let standard = DepthKind::Standard {
        near: 0.5,
        far: 100.0,
    };
    let none = Coverage::default();
    vec![
        Coverage {
            triangles: true,
            ..none
        },
        Coverage {
            triangles: true,
            sky: Some(Sky::Triangle(0)),
            ..none
        },
        Coverage {
            surfaces: true,
            sky: Some(Sky::Surface(0)),
            ..none
        },
        Coverage {
            surfaces: true,
            depth: depth(DepthKind::Reversed),
            sky: Some(Sky::Depth),
            ..none
        },
        Coverage {
            depth: depth(standard),
            sky: Some(Sky::Depth),
            ..none
        },
        Coverage {
            depth: depth(DepthKind::Linear),
            normals: Some(Normals::Octahedral { tolerance: 4 }),
            sky: Some(Sky::Depth),
            ..none
        },
        Coverage {
            triangles: true,
            depth: depth(DepthKind::Reversed),
            normals: Some(Normals::Rebuilt {
                tolerance: 5,
                tangents: [0.8, 0.5],
            }),
            sky: Some(Sky::Depth),
            ..none
        },
        Coverage {
            triangles: true,
            surfaces: true,
            ..none
        },
    ]
}

/// A scene of planes: each patch of triangles lies in one of a few, some of it is sky. Depth suits the kind.
fn planes([width, height]: [u32; 2], coverage: &Coverage, rng: &mut Rng) -> Samples {
    let size = [1, 3, 7, 40][rng.usize(..4)];
    let key = rng.u64(..);
    let mut samples = Samples {
        size: [width, height],
        ..Samples::default()
    };
    for at in 0..width * height {
        let (x, y) = (at % width, at / width);
        let patch = u64::from(x / size) << 32 | u64::from(y / size);
        let mut patch = Rng::with_seed(key ^ patch.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let surface = patch.u32(0..5);
        // powers of two, so that inverse depth is exact where depth is linear
        let inverse = match (coverage.depth.map(|depth| depth.kind), surface) {
            (_, 0) => 0.0,
            (Some(DepthKind::Linear), n) => 1.0 / f32::from(1u16 << n),
            (_, 1) => 0.25 + x as f32 / 65536.0 + y as f32 / 32768.0,
            (_, n) => n as f32 / 8.0,
        };
        samples.surfaces.push(surface);
        samples.triangles.push(match surface {
            0 => 0,
            _ => 1 + patch.u32(0..3) + 3 * rng.u32(0..2),
        });
        samples
            .depth
            .push(match coverage.depth.map(|depth| depth.kind) {
                Some(DepthKind::Standard { .. }) => 1.0 - inverse,
                Some(DepthKind::Linear) if inverse == 0.0 => f32::INFINITY,
                Some(DepthKind::Linear) => 1.0 / inverse,
                _ => inverse,
            });
        let normal = patch.u8(0..4);
        samples.normals.push([f32::from(normal) / 4.0, 0.5]);
    }
    samples
}

#[test]
fn coverage_on_the_gpu_is_that_of_its_cpu_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let sizes = [[1, 1], [33, 31], [64, 48], [17, 100]];
    let (mut split, mut whole, mut skies) = (0, 0, 0);
    // each of them with pictures of its own: a seed that gives a few poor ones shall not decide
    for (number, coverage) in (0u64..).zip(coverages()) {
        coverage.check().expect("a declaration that makes sense");
        for largest in [Rate::R2X2, Rate::R4X4] {
            for (index, extent) in sizes.into_iter().enumerate() {
                let mut rng = Rng::with_seed(seed + 100 + 8 * number + index as u64);
                let samples = planes(extent, &coverage, &mut rng);
                let pattern = Pattern::of_case(rng.u32(1..16), largest);
                let sri = pattern.image(extent[0], extent[1], &mut rng);
                let options = everything(BuildOptions {
                    largest,
                    coverage,
                    full_tiles: [FullTiles::Promote, FullTiles::Keep][index % 2],
                    ..BuildOptions::default()
                });
                let frame = Frame {
                    order: Order::Rotating(index as u32),
                    samples: Some(&samples),
                    ..Frame::default()
                };
                let twin = hold(&gpu, &sri, extent, options, &frame);
                assert_partition(&twin);
                for byte in twin.effective() {
                    split += u32::from(byte & effective::SPLIT != 0);
                    whole += u32::from(*byte != 0 && byte & effective::SPLIT == 0);
                }
                skies += twin.sky().iter().filter(|sky| **sky).count();
            }
        }
    }
    assert!(
        split > 1000 && whole > 1000 && skies > 1000,
        "{split} {whole} {skies}"
    );
}

/// Entries carry the linear depth of their primaries, in every kind of depth and every list; what is packed is read again.
#[test]
fn entries_carry_linear_depth() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let linear = LinearDepth {
        near: 0.5,
        far: 100.0,
    };
    let kinds = [
        DepthKind::Reversed,
        DepthKind::ReversedFinite {
            near: 0.5,
            far: 100.0,
        },
        DepthKind::Standard {
            near: 0.5,
            far: 100.0,
        },
        DepthKind::Linear,
    ];
    for (index, kind) in kinds.into_iter().enumerate() {
        // a distance, as the kind of texture has it, is told to a step
        let step = 1.0 / LinearDepth::LISTED as f32;
        for distance in [0.5, 0.75, 3.0, 40.0, 99.0] {
            let texel = match kind {
                DepthKind::Linear => distance,
                DepthKind::Reversed => 0.5 / distance,
                DepthKind::Standard { near, far } => {
                    far / (far - near) - far * near / (far - near) / distance
                }
                DepthKind::ReversedFinite { near, far } => {
                    far * near / (far - near) / distance - near / (far - near)
                }
            };
            let wanted = (distance - 0.5) / 99.5;
            // near the far plane a texel has few digits of the distance
            let few = 4e-7 * distance * distance;
            assert!(
                (linear.share(texel, kind) - wanted).abs() <= step + few,
                "{kind:?} at {distance}"
            );
        }
        for texel in [f32::NAN, f32::INFINITY, -3.0] {
            assert_eq!(
                linear.share(texel, DepthKind::Linear),
                1.0,
                "{texel} is far"
            );
        }
        let coverage = Coverage {
            surfaces: true,
            depth: Some(Depth::new(kind)),
            sky: Some(Sky::Surface(0)),
            ..Coverage::default()
        };
        for (turn, extent) in [[61, 47], [16, 16], [33, 18]].into_iter().enumerate() {
            let mut samples = planes(extent, &coverage, &mut rng);
            for texel in &mut samples.depth {
                if rng.u32(..12) == 0 {
                    *texel = [f32::NAN, 0.0, -1.0, f32::INFINITY, 1e-30, 1.0][rng.usize(..6)];
                }
            }
            let options = everything(BuildOptions {
                tile: [[16, 16], [8, 8], [6, 10]][turn],
                coverage,
                linear_depth: Some(linear),
                full_tiles: [FullTiles::Promote, FullTiles::Keep][turn % 2],
                ..BuildOptions::default()
            });
            let pattern = Pattern::of_case(rng.u32(1..16), options.largest);
            let sri = pattern.image(extent[0], extent[1], &mut rng);
            let frame = Frame {
                order: Order::Rotating(index as u32),
                samples: Some(&samples),
                ..Frame::default()
            };
            let twin = hold(&gpu, &sri, extent, options, &frame);
            assert_partition(&twin);
            for tile in 0..twin.layout.tile_count() {
                let start = twin.layout.entries + tile * twin.layout.entries_per_tile;
                let origin = twin.origin(tile);
                let stored = twin.header(tile).stored() as usize;
                for (word, entry) in twin.words[start as usize..]
                    .iter()
                    .zip(twin.entries(tile))
                    .take(stored)
                {
                    let pixel = [origin[0] + entry.x(), origin[1] + entry.y()];
                    let share = twin.linear_depth(pixel).expect("asked for");
                    let (read, code) = Entry::read_deep(origin, *word);
                    assert_eq!(
                        (read, code),
                        (entry, LinearDepth::code(share, LinearDepth::TILED))
                    );
                    let off = LinearDepth::decode(code, LinearDepth::TILED) - share;
                    assert!(off.abs() <= 0.6 / LinearDepth::TILED as f32);
                }
            }
        }
    }
}

/// A view of half the size: the rates of half the resolution, and of every two by two pixels the surface and depth of the one
/// that the pass shades.
#[test]
fn half_the_size_goes_by_a_chosen_sample() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let coverage = Coverage {
        surfaces: true,
        depth: Some(Depth::new(DepthKind::Reversed)),
        sky: Some(Sky::Surface(0)),
        ..Coverage::default()
    };
    let options = BuildOptions {
        coverage,
        full_tiles: FullTiles::Keep,
        ..BuildOptions::default()
    };
    let mut maps = Vec::new();
    for full in [[66, 50], [67, 51], [1, 1]] {
        let half = half::size_of(full);
        let mut samples = planes(full, &coverage, &mut rng);
        for surface in &mut samples.surfaces {
            *surface = rng.u32(0..3);
        }
        let sri = Pattern::MostlyCoarse.image(full[0], full[1], &mut rng);
        let rates = half::half(&sri, full, HalfResolution::Code);
        let textures = SampleTextures::new(&gpu, &coverage, &samples);
        for sample in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let chosen = |at: u32| {
                let [x, y] = [at % half[0], at / half[0]];
                let x = (2 * x + sample[0]).min(full[0] - 1);
                let y = (2 * y + sample[1]).min(full[1] - 1);
                (y * full[0] + x) as usize
            };
            let pixels = || (0..half[0] * half[1]).map(chosen);
            let picked = Samples {
                size: half,
                surfaces: pixels().map(|at| samples.surfaces[at]).collect(),
                depth: pixels().map(|at| samples.depth[at]).collect(),
                ..Samples::default()
            };
            let frame = Frame {
                samples: Some(&picked),
                ..Frame::default()
            };
            let twin = cpu::build_frame(&rates, half, &options, &frame);
            // as many layers as all builds of these tests
            let size = [half[0], half[1], 3];
            let mut view = View::new(&gpu.device, &gpu.queue, size, options).expect("a view");
            let given = Textures {
                scale: 1,
                sample,
                ..textures.get()
            };
            view.cover(&gpu.queue, &given).expect("its textures");
            view.write_sri(&gpu.queue, &rates).expect("its rates");
            let [coords, list, arguments] = [
                &view.buffers().coords,
                &view.buffers().list,
                &view.buffers().arguments,
            ]
            .map(|buffer| buffer.as_ref().expect("asked for by default"));
            let poison = vec![0xa5; coords.size() as usize];
            gpu.queue.write_buffer(coords, 0, &poison);
            let mut encoder = gpu.encoder();
            view.build(&mut encoder).expect("covered");
            let read = gpu
                .submit_and_read(encoder, &[coords, list, arguments])
                .expect("what was built");
            let words = |index: usize| bytemuck::pod_collect_to_vec::<u8, u32>(&read[index]);
            let built = Built {
                coords: words(0),
                list: words(1),
                arguments: words(2),
                ..Built::default()
            };
            if let Err(difference) = compare(&twin, &built) {
                panic!("{full:?}, sample {sample:?}: {difference:?}");
            }
            assert_partition(&twin);
            maps.push(twin.map());
        }
    }
    assert_ne!(maps[0], maps[3], "which sample is chosen matters");
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
        let header = coordinates.header(tile);
        let entries: Vec<_> = coordinates.entries(tile).collect();
        if !header.is_identity() {
            assert_eq!(entries.len() as u32, header.count() + header.sky_count());
        }
        for entry in entries {
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

/// Tiles as workgroups of any shape need them: sides that are odd, or no multiples of 4.
#[test]
fn tiles_of_every_shape() {
    let gpu = common::gpu();
    let seed = common::seed();
    let tiles = [
        [64, 1],
        [1, 64],
        [32, 1],
        [256, 1],
        [6, 10],
        [15, 9],
        [12, 2],
        [5, 4],
        [1, 1],
        [3, 7],
        [20, 12],
    ];
    let surfaces = Coverage {
        surfaces: true,
        sky: Some(Sky::Surface(0)),
        ..Coverage::default()
    };
    for (index, tile) in tiles.into_iter().enumerate() {
        for (turn, extent) in [[61, 47], [130, 9], [1, 1]].into_iter().enumerate() {
            let mut rng = Rng::with_seed(seed + (index * 3 + turn) as u64);
            let options = BuildOptions {
                wave: [4, 32, 8][turn],
                coverage: [Coverage::default(), surfaces][(index + turn) % 2],
                largest: [Rate::R4X4, Rate::R2X2][turn % 2],
                statistics: true,
                ..BuildOptions::default()
            }
            .for_tile(tile);
            let is_odd = tile[0] % 2 + tile[1] % 2 > 0;
            let options = BuildOptions {
                effective: !is_odd,
                modes: Modes {
                    graded: !is_odd,
                    ..Modes::ALL
                },
                ..options
            };
            let samples = planes(extent, &surfaces, &mut rng);
            let pattern = Pattern::of_case(rng.u32(1..20), options.largest);
            let sri = pattern.image(extent[0], extent[1], &mut rng);
            let frame = Frame {
                order: Order::Rotating(turn as u32),
                samples: Some(&samples),
                ..Frame::default()
            };
            assert_partition(&hold(&gpu, &sri, extent, options, &frame));
        }
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
    assert_eq!(statistics.class_shares(), [1.0, 0.0, 0.0, 0.0]);
    // a tile of each class: full rate, one rate, mixed
    let sri = Sri::from_fn(48, 16, |x, y| match x / 8 {
        0 => 0,
        1 => Rate::R2X2.code(),
        _ => [0, Rate::R2X2.code()][(x + y) as usize % 2],
    });
    let statistics = cpu::build(&sri, [48, 16], &BuildOptions::default()).statistics();
    let third = 1.0 / 3.0;
    assert_eq!(statistics.class_shares(), [third, third, third, 0.0]);
    assert_eq!(statistics.share_at(Rate::R2X2), 0.5);
}

/// The table of rotation: every coverage of a quad, and of the quads of a block, under every rate, in every phase, at an extent
/// that cuts blocks. Whatever is covered, the primary is covered with it, and is its own primary; and over four frames the
/// primary of a half rate takes both pixels in turn, that of a whole quad two corners, that of three pixels all three.
#[test]
fn a_primary_is_of_its_own_group_for_every_coverage_rate_and_phase() {
    let gpu = common::gpu();
    // a block of 4x4 for each mask; even rows of blocks: the mask is of pixels in each quad; odd ones: of quads
    let extent = [16 * 4 - 1, 4 * 7 * 2 - 1];
    let block_of = |at: u32| [at % extent[0] / 4, at / extent[0] / 4];
    let is_covered = |at: u32| {
        let [x, y] = [at % extent[0], at / extent[0]];
        let [mask, row] = block_of(at);
        let bit = match row % 2 {
            0 => y % 2 * 2 + x % 2,
            _ => y / 2 % 2 * 2 + x / 2 % 2,
        };
        mask >> bit & 1 == 1
    };
    let sri = Sri::from_fn(extent[0], extent[1], |_, y| {
        Rate::ALL[(y * 2 / 4 / 2) as usize].code()
    });
    for sky in [None, Some(Sky::Surface(0))] {
        let coverage = Coverage {
            surfaces: true,
            sky,
            ..Coverage::default()
        };
        let samples = Samples {
            size: extent,
            surfaces: (0..extent[0] * extent[1])
                .map(|at| u32::from(is_covered(at)))
                .collect(),
            ..Samples::default()
        };
        let options = everything(BuildOptions {
            largest: Rate::R4X4,
            coverage,
            full_tiles: FullTiles::Keep,
            ..BuildOptions::default()
        });
        let mut primaries: Vec<Vec<u32>> = Vec::new();
        for order in [
            Order::Fixed,
            Order::Rotating(0),
            Order::Rotating(1),
            Order::Rotating(2),
            Order::Rotating(3),
        ] {
            let frame = Frame {
                order,
                samples: Some(&samples),
                ..Frame::default()
            };
            let twin = hold(&gpu, &sri, extent, options, &frame);
            assert_partition(&twin);
            let map = twin.map();
            for (at, &primary) in (0..).zip(&map) {
                assert_eq!(is_covered(at), is_covered(primary), "{order:?} {at}");
                assert_eq!(map[primary as usize], primary, "{order:?} {at}");
                let rate = Rate::ALL[(block_of(at)[1] / 2) as usize];
                let near = [at % extent[0], at / extent[0]];
                let far = [primary % extent[0], primary / extent[0]];
                assert_eq!(near[0] / rate.width(), far[0] / rate.width());
                assert_eq!(near[1] / rate.height(), far[1] / rate.height());
            }
            primaries.push(map);
        }
        // how many primaries the first pixel of a block's cover has had over the four frames
        let turns = |[x, y]: [u32; 2]| {
            let at = (y * extent[0] + x) as usize;
            let mut seen: Vec<u32> = primaries[1..].iter().map(|map| map[at]).collect();
            seen.sort_unstable();
            seen.dedup();
            seen.len()
        };
        let row_of = |rate: Rate| {
            let row = Rate::ALL.iter().position(|known| *known == rate);
            row.expect("a rate") as u32 * 8
        };
        let full_mask = 15 * 4;
        assert_eq!(turns([full_mask, row_of(Rate::R1X1)]), 1);
        for rate in [Rate::R1X2, Rate::R2X1, Rate::R2X2, Rate::R4X4] {
            // the last column of blocks is cut by the extent; its first quads are whole
            let turned = turns([full_mask, row_of(rate)]);
            assert_eq!(turned, 2, "{rate}");
        }
        // three covered pixels of a quad, the fourth being sky: masks 7, 11, 13 and 14
        if sky.is_none() {
            continue;
        }
        for (mask, first) in [(7, [0, 0]), (11, [0, 0]), (13, [0, 0]), (14, [1, 0])] {
            let at = [mask * 4 + first[0], row_of(Rate::R2X2) + first[1]];
            assert_eq!(turns(at), 3, "{mask:04b}");
        }
    }
}
