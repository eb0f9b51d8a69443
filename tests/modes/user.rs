//! `vrcs_user()`: the user's own bits of a tile, such as that fog covers it, in every mode; and the early-out that they are for.

use std::collections::BTreeMap;

use fastrand::Rng;
use vrcs::{
    Rate,
    build::{BuildOptions, primary::Order, user_words},
    check::{Job, Law, rates::Pattern},
    dispatch::{Mismatch, PassOptions},
};
use vrcs_passes::{
    Source,
    options::{Mode, Policy, Sky},
};

use super::{POISON, Scene, Shader, common, rewrite};

const MARKS: &str = include_str!("marks.wgsl");

/// The words that `marks.wgsl` leaves behind over the twin of a view whose tiles have these bits.
fn expected(scene: &Scene, mode: Mode, bits: &[u32]) -> Vec<u32> {
    let twin = scene.twin();
    let (map, width) = (twin.map(), scene.extent[0]);
    let mut sharing = vec![0; map.len()];
    map.iter()
        .for_each(|primary| sharing[*primary as usize] += 1);
    (0..)
        .zip(&map)
        .map(|(at, &primary)| {
            let [x, y] = [at % width, at / width];
            let [tile_width, tile_height] = scene.options.tile;
            let own = bits[(y / tile_height * twin.layout.tiles[0] + x / tile_width) as usize];
            let (shaded, copies) = match mode {
                Mode::Graded => (at, sharing[primary as usize] - 1),
                _ => (primary, 0),
            };
            match own & 1 {
                0 => (shaded % width) | (shaded / width) << 10 | own << 20 | copies << 24,
                _ => POISON,
            }
        })
        .collect()
}

/// Views of many sizes and tiles, as a renderer uses them: bits are written, the build carries them to where each mode looks, frame
/// after frame; and switched off, nothing is marked.
#[test]
fn every_mode_tells_a_pixel_its_tiles_marks() {
    let gpu = common::gpu();
    let seed = common::seed();
    let mut marked = 0;
    let sizes = [[61, 47], [1, 1], [33, 170], [160, 16], [17, 31]];
    for (index, extent) in sizes.into_iter().enumerate() {
        let mut rng = Rng::with_seed(seed + index as u64);
        let largest = [Rate::R2X2, Rate::R4X4][index % 2];
        let sri = Pattern::of_case(rng.u32(1..20), largest).image(extent[0], extent[1], &mut rng);
        let scene = Scene {
            extent,
            options: BuildOptions {
                tile: [[16, 16], [8, 4]][index / 2 % 2],
                largest,
                user: true,
                ..BuildOptions::default()
            },
            sri: &sri,
            samples: None,
            order: Order::Rotating(index as u32),
        };
        let mut view = scene.view(&gpu);
        let tiles = view.layout().tile_count();
        let shaders = Mode::ALL.map(|mode| {
            let options = rewrite(mode, Sky::Skip, &scene.options);
            (mode, Shader::new(&gpu, "marks.wgsl", MARKS, options))
        });
        for frame in 0..2 {
            let bits: Vec<u32> = (0..tiles).map(|_| rng.u32(0..16)).collect();
            let words = user_words(bits.iter().copied());
            let user = view.user().expect("asked for");
            gpu.queue
                .write_buffer(user, 0, bytemuck::cast_slice(&words));
            for (mode, shader) in &shaders {
                let got = shader.draw(&gpu, &view, frame, 0);
                assert_eq!(got, expected(&scene, *mode, &bits), "{mode:?} {extent:?}");
                marked += got.iter().filter(|word| **word >> 20 & 15 != 0).count();
            }
        }
        view.set_enabled(&gpu.queue, false);
        for (mode, shader) in &shaders {
            for (at, word) in (0..).zip(shader.draw(&gpu, &view, 0, 0)) {
                let own = (at % extent[0]) | (at / extent[0]) << 10;
                assert_eq!(word, own, "{mode:?}: off, nothing is marked");
            }
        }
    }
    assert!(marked > 10_000, "{marked}");
}

/// A view without such bits is refused by a pass that asks for them, and `Pass::build_options` asks for them.
#[test]
fn a_view_without_marks_is_refused() {
    let gpu = common::gpu();
    let extent = [40, 30];
    let sri = vrcs::sri::Sri::uniform(extent[0], extent[1], Rate::R2X2);
    let scene = Scene {
        extent,
        options: BuildOptions::default(),
        sri: &sri,
        samples: None,
        order: Order::Fixed,
    };
    let view = scene.view(&gpu);
    for mode in Mode::ALL {
        let options = PassOptions {
            rewrite: rewrite(mode, Sky::Skip, &scene.options),
            ..PassOptions::default()
        };
        let source = Source::new("marks.wgsl", MARKS);
        let pass = vrcs::Pass::new(&gpu.device, &source, &options).expect("a pass");
        assert_eq!(pass.check(&view), Err(Mismatch::User), "{mode:?}");
        assert!(pass.build_options(BuildOptions::default()).user);
    }
}

/// The laws, in every mode, for a shader that leaves by its tile's marks; for one whose whole workgroup leaves before a barrier; and for
/// one of whose targets every pixel has its own.
#[test]
fn the_laws_hold_by_tiles() {
    let whole = common::shader("tile_bits");
    let together = Source::new("marks_together.wgsl", include_str!("marks_together.wgsl"));
    let full = Source::new("marks_full.wgsl", include_str!("marks_full.wgsl"));
    let job = |mode, cases| {
        let mut job = Job::new("main");
        job.seed = common::seed();
        job.cases = cases;
        job.options.mode = mode;
        job
    };
    for mode in [Mode::Tiled, Mode::List, Mode::Classified] {
        let report = common::run(&whole, &job(mode, 32));
        common::assert_passed(&report);
        assert!(report.held[&Law::Contract] >= 6, "{mode:?}: {report:?}");
    }
    let report = common::run(&together, &job(Mode::Tiled, 32));
    common::assert_passed(&report);
    let mut of_full = job(Mode::Tiled, 32);
    of_full.options.targets = BTreeMap::from([("normals".to_owned(), Policy::Full)]);
    common::assert_passed(&common::run(&full, &of_full));
}
