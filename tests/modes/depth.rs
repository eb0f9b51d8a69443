//! `vrcs_depth()`: the linear depth that entries carry in their spare bits, in every mode.

use fastrand::Rng;
use vrcs::{
    Rate,
    build::{BuildOptions, LinearDepth, primary::Order},
    check::{Job, Verdict, rates::Pattern},
    coverage::{Coverage, Depth, DepthKind, Sky as SkyOf, cpu::Samples},
    dispatch::{Mismatch, PassOptions},
};
use vrcs_passes::{
    Options, Source,
    options::{FullTiles, MaxRate, Mode, Sky},
};

use super::{Scene, Shader, common, rewrite};

const DEPTHS: &str = include_str!("depths.wgsl");
const LINEAR: LinearDepth = LinearDepth {
    near: 0.5,
    far: 40.0,
};

/// A plane, so that pixels share though none is as far as its neighbour; some of it is sky.
fn samples(extent: [u32; 2], rng: &mut Rng) -> Samples {
    let first = 0.01 + rng.f32() * 0.1;
    let texel = |at: u32| {
        let [x, y] = [at % extent[0], at / extent[0]];
        match (x / 5 + y / 7) % 9 {
            0 => 0.0,
            _ => 1.0 / (first + x as f32 * 1e-3 + y as f32 * 7e-4),
        }
    };
    Samples {
        size: extent,
        surfaces: (0..extent[0] * extent[1])
            .map(|at| at / extent[0] / 9)
            .collect(),
        depth: (0..extent[0] * extent[1]).map(texel).collect(),
        ..Samples::default()
    }
}

/// What a shader is told is the depth of the pixel that is shaded, to a step, wherever an entry was loaded; nothing where a tile is of one
/// rate throughout, in graded mode, and with shading rates off.
#[test]
fn every_mode_tells_a_pixel_the_depth_of_its_entry() {
    let gpu = common::gpu();
    let seed = common::seed();
    let (mut told, mut untold, mut shared) = (0, 0, 0);
    for (index, extent) in [[61, 47], [33, 31], [16, 16], [1, 1]]
        .into_iter()
        .enumerate()
    {
        let mut rng = Rng::with_seed(seed + index as u64);
        let samples = samples(extent, &mut rng);
        let sri = Pattern::Patches.image(extent[0], extent[1], &mut rng);
        let scene = Scene {
            extent,
            options: BuildOptions {
                coverage: Coverage {
                    depth: Some(Depth {
                        kind: DepthKind::Linear,
                        tolerance: 5,
                    }),
                    surfaces: true,
                    sky: Some(SkyOf::Depth),
                    ..Coverage::default()
                },
                full_tiles: FullTiles::Keep,
                linear_depth: Some(LINEAR),
                ..BuildOptions::default()
            },
            sri: &sri,
            samples: Some(&samples),
            order: Order::Rotating(index as u32),
        };
        let twin = scene.twin();
        let map = twin.map();
        let mut view = scene.view(&gpu);
        for mode in Mode::ALL {
            let options = rewrite(mode, Sky::Shade, &scene.options);
            // what asks for nothing that graded mode tells is refused by it
            let text = DEPTHS.replace(
                "(vrcs_depth())",
                "(vrcs_depth() - 0.0 * f32(vrcs_copies()))",
            ) + "fn vrcs_copies() -> u32 { return 0u; }";
            let shader = Shader::new(&gpu, "depths.wgsl", &text, options);
            for (at, word) in (0..).zip(shader.draw(&gpu, &view, 0, 0)) {
                let [x, y] = [at % extent[0], at / extent[0]];
                let primary = map[at as usize];
                let header = twin.header(y / 16 * twin.layout.tiles[0] + x / 16);
                let (is_loaded, most) = match mode {
                    Mode::Graded => (false, 1),
                    // a list has entries of all tiles
                    Mode::List => (true, LinearDepth::LISTED),
                    Mode::Classified => (
                        !header.is_identity() && !header.is_uniform(),
                        LinearDepth::LISTED,
                    ),
                    _ => (
                        !header.is_identity() && !header.is_uniform(),
                        LinearDepth::TILED,
                    ),
                };
                let got = f32::from_bits(word);
                if !is_loaded {
                    assert_eq!(got, -1.0, "{mode:?} ({x}, {y})");
                    untold += 1;
                    continue;
                }
                let texel = samples.depth[primary as usize];
                let wanted = match texel > 0.0 {
                    true => ((texel - LINEAR.near) / (LINEAR.far - LINEAR.near)).clamp(0.0, 1.0),
                    false => 1.0,
                };
                let off = (got - wanted).abs() * most as f32;
                assert!(off <= 1.5, "{mode:?} ({x}, {y}): {got} for {wanted}");
                told += 1;
                shared += u32::from(primary != at);
            }
        }
        view.set_enabled(&gpu.queue, false);
        let options = rewrite(Mode::Tiled, Sky::Shade, &scene.options);
        let shader = Shader::new(&gpu, "depths.wgsl", DEPTHS, options);
        let off = shader.draw(&gpu, &view, 0, 0);
        assert!(off.iter().all(|&word| f32::from_bits(word) == -1.0), "off");
    }
    assert!(
        told > 5000 && untold > 2000 && shared > 1000,
        "{told} {untold} {shared}"
    );
}

/// Entries of two kinds are not confused: a pass and a view that do not agree are refused, and so is a shader for whose groups there is no
/// room. A shader that asks for nothing keeps the laws over such entries.
#[test]
fn a_pass_reads_the_entries_that_its_view_has() {
    let gpu = common::gpu();
    let extent = [40, 30];
    let mut rng = Rng::with_seed(common::seed());
    let samples = samples(extent, &mut rng);
    let sri = vrcs::sri::Sri::uniform(extent[0], extent[1], Rate::R2X2);
    let plain = BuildOptions {
        coverage: Coverage {
            depth: Some(Depth::new(DepthKind::Linear)),
            ..Coverage::default()
        },
        ..BuildOptions::default()
    };
    let deep = BuildOptions {
        linear_depth: Some(LINEAR),
        ..plain
    };
    for (options, view_has) in [(plain, false), (deep, true)] {
        let scene = Scene {
            extent,
            options,
            sri: &sri,
            samples: Some(&samples),
            order: Order::Fixed,
        };
        let view = scene.view(&gpu);
        for (text, asks) in [(DEPTHS, true), (include_str!("place.wgsl"), false)] {
            for mode in [Mode::Tiled, Mode::List, Mode::Classified] {
                for by_hand in [false, true] {
                    let options = PassOptions {
                        rewrite: Options {
                            linear_depth: by_hand,
                            ..rewrite(mode, Sky::Skip, &scene.options)
                        },
                        ..PassOptions::default()
                    };
                    let source = Source::new("shader.wgsl", text);
                    let pass = vrcs::Pass::new(&gpu.device, &source, &options).expect("a pass");
                    let has = asks || by_hand;
                    let wanted = match has == view_has {
                        true => Ok(()),
                        false => Err(Mismatch::LinearDepth {
                            pass: has,
                            view: view_has,
                        }),
                    };
                    assert_eq!(pass.check(&view), wanted, "{mode:?} {asks} {by_hand}");
                }
            }
        }
    }
    let source = Source::new("depths.wgsl", DEPTHS);
    let (module, info) = common::parse(&source);
    let wide = Options {
        mode: Mode::Tiled,
        max_rate: MaxRate::R4x4,
        ..Options::default()
    };
    let refusal = vrcs_passes::rewrite(&module, &info, "main", &wide).expect_err("no room");
    assert!(refusal.to_string().contains("larger than 2x2"), "{refusal}");
}

#[test]
fn the_laws_hold_over_entries_that_carry_depth() {
    let job = |mode| {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = 32;
        job.options.mode = mode;
        job.options.linear_depth = true;
        job
    };
    for mode in [Mode::Tiled, Mode::List, Mode::Classified] {
        common::assert_passed(&common::run(&common::shader("guarded"), &job(mode)));
    }
    let asking = Source::new("depths.wgsl", DEPTHS);
    let report = common::run(&asking, &job(Mode::Tiled));
    assert_eq!(report.verdict, Verdict::Inconclusive, "{report:?}");
}
