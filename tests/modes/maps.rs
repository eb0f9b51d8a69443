//! Each pixel holds what its primary gives, and nothing else is written: sizes, counts, frames in a row, skies, and pictures whose
//! lists need more workgroups than one dimension of a dispatch has.

use fastrand::Rng;
use vrcs::{
    Rate,
    build::{BuildOptions, Modes, primary::Order},
    check::{gpu::Gpu, rates::Pattern},
    coverage::{self, Coverage, cpu::Samples},
    sri::Sri,
    view::View,
};
use vrcs_passes::options::{FullTiles, Mode, Sky};

use super::{POISON, Scene, Shader, common, rewrite};

const PLACE: &str = include_str!("place.wgsl");
const COPYING: [Mode; 3] = [Mode::Tiled, Mode::List, Mode::Classified];

/// The shader in every mode that copies.
fn shaders(gpu: &Gpu, sky: Sky, options: &BuildOptions) -> Vec<(Mode, Shader)> {
    COPYING
        .into_iter()
        .map(|mode| {
            let shader = Shader::new(gpu, "place.wgsl", PLACE, rewrite(mode, sky, options));
            (mode, shader)
        })
        .collect()
}

/// Draws a frame in every mode and holds it against the twin's effective map.
fn hold(gpu: &Gpu, scene: &Scene, view: &View, sky: Sky, shaders: &[(Mode, Shader)]) {
    let twin = scene.twin();
    let (map, is_sky) = (twin.map(), twin.sky());
    let width = scene.extent[0];
    for (mode, shader) in shaders {
        let words = shader.draw(gpu, view, 0, 0);
        for (at, word) in words.into_iter().enumerate() {
            let wanted = match is_sky[at] && sky == Sky::Skip {
                true => POISON,
                false => (map[at] % width) | ((map[at] / width) << 16),
            };
            assert_eq!(
                word,
                wanted,
                "{mode:?} {sky:?}: pixel ({}, {}) of {:?}, {:?} {:?}",
                at as u32 % width,
                at as u32 / width,
                scene.extent,
                scene.order,
                scene.options,
            );
        }
    }
}

/// Surfaces where 0 is sky.
fn surfaces(extent: [u32; 2], surface: impl FnMut(u32) -> u32) -> Samples {
    Samples {
        size: extent,
        surfaces: (0..extent[0] * extent[1]).map(surface).collect(),
        ..Samples::default()
    }
}

fn with_sky() -> Coverage {
    Coverage {
        surfaces: true,
        sky: Some(coverage::Sky::Surface(0)),
        ..Coverage::default()
    }
}

#[test]
fn pictures_of_every_size_in_every_mode() {
    let gpu = common::gpu();
    let seed = common::seed();
    let options = BuildOptions {
        largest: Rate::R4X4,
        ..BuildOptions::default()
    };
    let shaders = shaders(&gpu, Sky::Skip, &options);
    let sides = [1, 2, 3, 4, 5, 15, 16, 17, 31, 33];
    let mut sizes: Vec<[u32; 2]> = sides
        .into_iter()
        .flat_map(|x| [[x, 31], [33, x], [x, x]])
        .collect();
    sizes.extend([[64, 1080], [8192, 16], [3, 1080]]);
    for (index, extent) in sizes.into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed + index as u64);
        let pattern = Pattern::of_case(rng.u32(0..24), options.largest);
        let sri = pattern.image(extent[0], extent[1], &mut rng);
        let scene = Scene {
            extent,
            options,
            sri: &sri,
            samples: None,
            order: [Order::Fixed, Order::Rotating(rng.u32(0..4))][index % 2],
        };
        hold(&gpu, &scene, &scene.view(&gpu), Sky::Skip, &shaders);
    }
}

/// A picture of three tiles of which the middle one has `count` primaries, all apart; the others are sky, or full.
#[test]
fn any_number_of_primaries_in_a_tile() {
    let gpu = common::gpu();
    let extent = [48, 16];
    let counts = [0, 1, 31, 32, 33, 223, 224, 225, 255, 256];
    for full_tiles in [FullTiles::Promote, FullTiles::Keep] {
        let options = BuildOptions {
            coverage: with_sky(),
            full_tiles,
            ..BuildOptions::default()
        };
        for sky in [Sky::Skip, Sky::Shade] {
            let shaders = shaders(&gpu, sky, &options);
            for count in counts {
                let samples = surfaces(extent, |at| {
                    let [x, y] = [at % 48, at / 48];
                    match x / 16 {
                        0 => 0,
                        1 => u32::from(is_covered_at(x % 16, y, count)),
                        _ => 1,
                    }
                });
                let sri = Sri::uniform(extent[0], extent[1], Rate::R1X1);
                let scene = Scene {
                    extent,
                    options,
                    sri: &sri,
                    samples: Some(&samples),
                    order: Order::Fixed,
                };
                let header = scene.twin().header(1);
                match header.is_identity() {
                    true => assert!(count == 256 || count == 0, "{count}"),
                    false => assert_eq!(header.count(), count),
                }
                hold(&gpu, &scene, &scene.view(&gpu), sky, &shaders);
            }
        }
    }
}

/// Whether a pixel of a tile is one of the first `count` in an order that is no row's.
fn is_covered_at(x: u32, y: u32, count: u32) -> bool {
    (y * 16 + x) * 37 % 256 < count
}

/// The same without sky, where a tile with more than 224 becomes an identity: blocks of 2×2, some of them split by surfaces.
#[test]
fn the_rule_for_nearly_full_tiles_at_its_edge() {
    let gpu = common::gpu();
    let extent = [16, 16];
    for full_tiles in [FullTiles::Promote, FullTiles::Keep] {
        let options = BuildOptions {
            coverage: Coverage {
                surfaces: true,
                ..Coverage::default()
            },
            full_tiles,
            ..BuildOptions::default()
        };
        let shaders = shaders(&gpu, Sky::Skip, &options);
        for count in [64, 65, 223, 224, 225, 255, 256] {
            // a quad is one group, and one more for each pixel that is a surface of its own
            let mut left = count - 64;
            let alone: Vec<u32> = (0..64)
                .map(|_| {
                    let own = left.min(3);
                    left -= own;
                    own
                })
                .collect();
            let samples = surfaces(extent, |at| {
                let [x, y] = [at % 16, at / 16];
                let quad = y / 2 * 8 + x / 2;
                let place = y % 2 * 2 + x % 2;
                match place < alone[quad as usize] {
                    true => 1 + place,
                    false => 9,
                }
            });
            let sri = Sri::uniform(16, 16, Rate::R2X2);
            let scene = Scene {
                extent,
                options,
                sri: &sri,
                samples: Some(&samples),
                order: Order::Fixed,
            };
            let header = scene.twin().header(0);
            let is_full = full_tiles == FullTiles::Promote && count > 224 || count == 256;
            assert_eq!(header.is_identity(), is_full, "{count} {full_tiles:?}");
            if !is_full {
                assert_eq!(header.count(), count);
            }
            hold(&gpu, &scene, &scene.view(&gpu), Sky::Skip, &shaders);
        }
    }
}

/// Nothing coarse, and everything coarse; nothing but sky, none of it, and much of it: each with the buffers that the frame before
/// has left behind, as the extent grows and shrinks.
#[test]
fn frame_after_frame_with_the_same_buffers() {
    let gpu = common::gpu();
    let seed = common::seed();
    let options = BuildOptions {
        coverage: with_sky(),
        ..BuildOptions::default()
    };
    for sky in [Sky::Skip, Sky::Shade] {
        let shaders = shaders(&gpu, sky, &options);
        let mut view: Option<View> = None;
        for (frame, extent) in [
            [61, 47],
            [61, 47],
            [17, 33],
            [17, 33],
            [90, 70],
            [16, 16],
            [90, 70],
        ]
        .into_iter()
        .enumerate()
        {
            let mut rng = Rng::with_seed(seed + frame as u64);
            let skies = [3, 0, 1, 0, 2, 1, 3][frame];
            let samples = surfaces(extent, |at| match skies {
                0 => 1,
                1 => 0,
                _ => (at % extent[0] / 7 + at / extent[0] / 5) % skies,
            });
            let sri = match frame % 3 {
                0 => Sri::uniform(extent[0], extent[1], Rate::R1X1),
                1 => Sri::uniform(extent[0], extent[1], Rate::R2X2),
                _ => Pattern::Noise.image(extent[0], extent[1], &mut rng),
            };
            let scene = Scene {
                extent,
                options,
                sri: &sri,
                samples: Some(&samples),
                order: Order::Rotating(frame as u32),
            };
            let view = match &mut view {
                Some(view) => {
                    view.set_extent(&gpu.queue, [extent[0], extent[1], 1])
                        .expect("another extent");
                    scene.fill(&gpu, view);
                    view
                }
                none => none.insert(scene.view(&gpu)),
            };
            hold(&gpu, &scene, view, sky, &shaders);
            // two frames in a row: counters start anew
            hold(&gpu, &scene, view, sky, &shaders);
        }
    }
}

/// With variable-rate shading off, every pixel is its own, in every mode, and no list is asked.
#[test]
fn off_is_every_pixel_for_itself() {
    let gpu = common::gpu();
    let extent = [50, 35];
    let options = BuildOptions::default();
    let sri = Sri::uniform(extent[0], extent[1], Rate::R2X2);
    let scene = Scene {
        extent,
        options,
        sri: &sri,
        samples: None,
        order: Order::Fixed,
    };
    let mut view = scene.view(&gpu);
    view.set_enabled(&gpu.queue, false);
    for (mode, shader) in shaders(&gpu, Sky::Skip, &options) {
        for (at, word) in (0..).zip(shader.draw(&gpu, &view, 0, 0)) {
            let own = (at % extent[0]) | ((at / extent[0]) << 16);
            assert_eq!(word, own, "{mode:?}");
        }
    }
}

/// A list of more than 65,535 workgroups, which one dimension of a dispatch cannot have, and which wgpu's validation of
/// indirect arguments would turn into none: tiles of 4×4 pixels, 8192 pixels wide.
#[test]
fn a_list_of_more_workgroups_than_a_dimension_has() {
    let gpu = common::gpu();
    let seed = common::seed();
    let extent = [8192, 144];
    let options = BuildOptions {
        tile: [4, 4],
        wave: 4,
        ..BuildOptions::default()
    };
    let mut rng = Rng::with_seed(seed);
    // one quad in sixteen is coarse
    let sri = Sri::from_fn(extent[0], extent[1], |_, _| match rng.u8(0..16) {
        0 => Rate::R2X2.code(),
        _ => Rate::R1X1.code(),
    });
    let scene = Scene {
        extent,
        options,
        sri: &sri,
        samples: None,
        order: Order::Fixed,
    };
    let primaries: u32 = scene.twin().list()[0].len() as u32;
    assert!(primaries.div_ceil(16) > 65_535, "{primaries}");
    let shaders = shaders(&gpu, Sky::Skip, &options);
    hold(&gpu, &scene, &scene.view(&gpu), Sky::Skip, &shaders);
}

/// An 8K picture as a list in groups of 8×8, half a million of them: nothing is lost, under wgpu's default limits. The tiled and the classified
/// buffers of such tiles are larger than those allow, and refused.
#[test]
fn an_8k_picture_loses_nothing() {
    let gpu = common::gpu();
    let extent = [7680, 4320];
    let options = BuildOptions {
        tile: [8, 8],
        modes: Modes::NONE.with(Mode::List),
        ..BuildOptions::default()
    };
    // one quad in sixteen is coarse
    let mut rng = Rng::with_seed(common::seed());
    let sri = Sri::from_fn(extent[0], extent[1], |_, _| match rng.u8(0..16) {
        0 => Rate::R2X2.code(),
        _ => Rate::R1X1.code(),
    });
    let scene = Scene {
        extent,
        options,
        sri: &sri,
        samples: None,
        order: Order::Fixed,
    };
    let list = Shader::new(
        &gpu,
        "place.wgsl",
        PLACE,
        rewrite(Mode::List, Sky::Skip, &options),
    );
    let [width, height] = extent;
    let view = View::new(&gpu.device, &gpu.queue, [width, height, 1], options);
    let mut view = view.expect("a view");
    scene.fill(&gpu, &mut view);
    hold(&gpu, &scene, &view, Sky::Skip, &[(Mode::List, list)]);
}
