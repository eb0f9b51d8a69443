//! What a quad's estimate is of, and what a tile's (Yang et al., I3D 2019, §3.1 and §3.4).

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{Colour, Frame, Inputs, exact, integer, settings::*},
    sri::Sri,
};

use crate::{
    common,
    made::{Made, assert_equal},
};

/// A picture of linear grey.
fn grey([width, height]: [u32; 2], of: impl Fn(u32, u32) -> f32) -> Vec<[f32; 4]> {
    (0..width * height)
        .map(|i| [of(i % width, i / width); 4])
        .collect()
}

/// The rates of compute passes and of the attachment.
fn fixed(size: [u32; 2], picture: &[[f32; 4]], settings: &Settings) -> [Sri; 2] {
    let inputs = Inputs::of_colour(size, Colour::Linear(picture));
    let found = integer::analyse(&inputs, settings).expect("inputs");
    [found.sri, found.attachment]
}

/// The same where no error lies near a threshold, so that both twins have them.
fn rates(size: [u32; 2], picture: &[[f32; 4]], settings: &Settings) -> [Sri; 2] {
    let inputs = Inputs::of_colour(size, Colour::Linear(picture));
    let fixed = integer::analyse(&inputs, settings).expect("inputs");
    let real = exact::analyse(&inputs, settings).expect("inputs").output;
    assert_eq!(fixed.sri, real.sri, "{settings:?}");
    assert_eq!(fixed.attachment, real.attachment, "{settings:?}");
    [fixed.sri, fixed.attachment]
}

fn by(granularity: Granularity) -> Settings {
    Settings {
        granularity,
        ..Settings::default()
    }
}

const TILES: [Granularity; 4] = [
    Granularity::Tile4,
    Granularity::Tile8,
    Granularity::Tile16,
    Granularity::Tile32,
];

// fails when a tile's sums are over the windows of its quads, whose border lies beyond it
#[test]
fn a_step_on_a_tiles_border_is_no_error_of_the_tile_and_one_inside_is() {
    for tile in TILES {
        let side = tile.side();
        let size = [side * 2, side * 2];
        for (at, is_error) in [(side, false), (side - 1, true), (1, true)] {
            // the tile is mostly dark, where a step is seen best
            let is_bright = |x: u32| (x < at) == (at == 1);
            let picture = grey(size, |x, _| if is_bright(x) { 0.9 } else { 0.05 });
            let [found, _] = rates(size, &picture, &by(tile));
            let wanted = match is_error {
                true => Rate::R1X2,
                false => Rate::R2X2,
            };
            assert_eq!(found.code(0, 0), wanted.code(), "{tile:?}, step at {at}");
            if at == side {
                let quads = rates(size, &picture, &by(Granularity::Quad));
                let beside = quads[0].code(side / 2 - 1, 0);
                assert_eq!(beside, Rate::R1X2.code(), "a quad's window has the step");
            }
        }
    }
}

// Eq. 2 and 15 by hand: one step of d in each row of a tile, so that E is d / 2 / sqrt(side - 1), against t (I_avg + l)
#[test]
fn a_tiles_error_is_the_root_mean_square_over_all_its_pairs_against_its_mean_luma() {
    for tile in TILES {
        let side = tile.side();
        let root = f64::from(side - 1).sqrt();
        let code = |d: f64| {
            let picture = grey([side; 2], |x, _| {
                (0.2 + if x < side / 2 { 0.0 } else { d }) as f32
            });
            rates([side; 2], &picture, &by(tile))[0].code(0, 0)
        };
        // half the tile is 0.2 and half 0.2 + d, so that I_avg is 0.2 + d / 2
        let content = Content::default();
        let visible =
            2.0 * content.threshold * (0.2 + content.ambient) / (1.0 / root - content.threshold);
        match visible < 0.75 {
            true => {
                assert_eq!(code(visible * 0.99), Rate::R2X2.code(), "{tile:?}");
                assert_eq!(code(visible * 1.01), Rate::R1X2.code(), "{tile:?}");
            }
            // among so many pairs no single step is
            false => assert_eq!((code(0.8), side), (Rate::R2X2.code(), 32)),
        }
        // the other norms: the mean is d / 2 / (side - 1), the maximum d / 2
        for (norm, error) in [(Norm::L1, 0.4 / f64::from(side - 1)), (Norm::LInf, 0.4)] {
            // t has 1/4096
            for (share, wanted) in [(1.02, Rate::R2X2), (0.98, Rate::R1X2)] {
                let mut settings = by(tile);
                settings.content.norm = norm;
                settings.content.form = Form::Absolute;
                settings.content.threshold = error * share;
                let picture = grey([side; 2], |x, _| if x < side / 2 { 0.1 } else { 0.9 });
                let found = rates([side; 2], &picture, &settings)[0].code(0, 0);
                assert_eq!(found, wanted.code(), "{tile:?}, {norm:?}, {share}");
            }
        }
    }
}

#[test]
fn every_quad_of_a_tile_has_its_rate_and_rates_of_4_need_whole_blocks() {
    let mut rng = Rng::with_seed(common::seed());
    for tile in TILES {
        for size in [[67, 35], [64, 64], [33, 31], [1, 1], [3, 40]] {
            let picture = grey(size, |x, y| {
                let noise = ((x * 7919 + y * 104_729) % 97) as f32 / 97.0;
                0.4 + noise * if x / 20 % 2 == 0 { 0.02 } else { 0.3 }
            });
            let settings = Settings {
                largest: [Rate::R2X2, Rate::R4X4, Rate::R4X2][rng.usize(..3)],
                ..by(tile)
            };
            let [found, attachment] = fixed(size, &picture, &settings);
            assert_eq!(found, attachment, "the attachment has the tiles' rates");
            let (layout, quads) = (found.layout(), tile.side() / 2);
            for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
                let own = Rate::from_code(found.code(x, y)).expect("a rate");
                let first =
                    Rate::from_code_or_full(found.code(x / quads * quads, y / quads * quads));
                let is_whole = (x | 1) < layout.width && (y | 1) < layout.height;
                match is_whole {
                    true if quads > 1 => assert_eq!(own.meet(Rate::R2X2), first.meet(Rate::R2X2)),
                    _ => assert!(own.is_within(Rate::R2X2), "{x},{y}: {own}"),
                }
            }
        }
    }
}

#[test]
fn e26_transposing_the_picture_transposes_the_rates_of_tiles() {
    let mut rng = Rng::with_seed(common::seed());
    for tile in TILES {
        for (norm, pairs) in [
            (Norm::L2, Pairs::All),
            (Norm::L1, Pairs::Sobel),
            (Norm::LInf, Pairs::Quad),
            (Norm::L2, Pairs::SubSampled),
        ] {
            let size = [61u32, 38];
            let values: Vec<f32> = (0..size[0] * size[1])
                .map(|i| 0.3 + rng.f32() * if i % size[0] > 30 { 0.25 } else { 0.03 })
                .collect();
            let mut settings = by(tile);
            settings.content.norm = norm;
            settings.content.pairs = pairs;
            let at = |x: u32, y: u32| values[(y * size[0] + x) as usize];
            let [one, _] = fixed(size, &grey(size, at), &settings);
            let turned = [size[1], size[0]];
            let [other, _] = fixed(turned, &grey(turned, |x, y| at(y, x)), &settings);
            for (x, y) in (0..19).flat_map(|y| (0..31).map(move |x| (x, y))) {
                let wanted = Rate::from_code_or_full(one.code(x, y)).transposed();
                assert_eq!(
                    other.code(y, x),
                    wanted.code(),
                    "{tile:?} {pairs:?} {x},{y}"
                );
            }
        }
        // vertical stripes stay fine across and go coarse down
        let stripes = grey([64, 64], |x, _| if x % 2 == 0 { 0.1 } else { 0.8 });
        let [found, _] = rates([64, 64], &stripes, &by(tile));
        assert_eq!(found, Sri::uniform(64, 64, Rate::R1X2));
    }
}

// any doubt: one pixel in a tile, and no other tile
#[test]
fn e1_e22_a_pixel_in_doubt_keeps_its_tile_fine_and_what_no_pair_tells_of_is_fine() {
    for tile in TILES {
        let (side, size) = (tile.side(), [tile.side() * 2, tile.side() * 2]);
        for bad in [f32::NAN, f32::INFINITY, -0.5, 2.0] {
            let picture = grey(
                size,
                |x, y| if (x, y) == (side, side - 1) { bad } else { 0.4 },
            );
            let [found, _] = rates(size, &picture, &by(tile));
            let quads = side / 2;
            for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
                let is_bad = x >= quads && y < quads;
                let wanted = if is_bad { 0 } else { Rate::R2X2.code() };
                assert_eq!(found.code(x, y), wanted, "{tile:?} {bad} {x},{y}");
            }
        }
    }
    // Sobel has no gradient in what is two pixels wide; a single column has nothing to share
    for (width, wanted) in [(2u32, Rate::R1X1), (1, Rate::R2X1), (3, Rate::R2X2)] {
        let mut settings = by(Granularity::Tile16);
        settings.content.pairs = Pairs::Sobel;
        let picture = grey([width, 12], |_, _| 0.4);
        let [found, _] = rates([width, 12], &picture, &settings);
        assert_eq!(found.code(0, 0), wanted.code(), "{width} wide");
    }
}

// of the tile's own window, as the default; and of its quads, as a setting
#[test]
fn the_attachment_is_by_tiles_unless_it_is_asked_for_by_quads_and_each_costs_what_it_says() {
    let scene = Scene {
        attachment: true,
        ..Scene::default()
    };
    let kernels = |settings: &Settings| -> Vec<&'static str> {
        let plan = Plan::new(&scene, settings).expect("a plan");
        plan.passes.iter().map(|pass| pass.kernel).collect()
    };
    let quads = Settings {
        attachment: Granularity::Quad,
        ..Settings::default()
    };
    assert_eq!(
        kernels(&Settings::default()),
        ["analyse.wgsl", "tiles.wgsl"]
    );
    assert_eq!(kernels(&quads), ["analyse.wgsl"]);
    assert_eq!(kernels(&by(Granularity::Tile8)), ["tiles.wgsl"]);
    let none = Plan::new(&Scene::default(), &Settings::default()).expect("a plan");
    assert_eq!(none.passes.len(), 1, "no attachment, no pass for it");
    // a thin line: the mean of a tile's pairs does not show it, the worst of its quads does
    let size = [64, 64];
    let picture = grey(size, |x, _| if x == 21 { 0.7 } else { 0.4 });
    let [of_quads, by_tile] = rates(size, &picture, &Settings::default());
    let [same, by_quads] = rates(size, &picture, &quads);
    assert_eq!(
        of_quads, same,
        "the attachment changes no rate of compute passes"
    );
    assert_eq!(by_tile, Sri::uniform(64, 64, Rate::R2X2));
    assert_eq!(by_quads, of_quads);
    assert_eq!(by_quads.code(10, 0), Rate::R1X2.code());
}

/// How much is coarse in a tile's rate by its own pixels, and in the finest of its quads', on pictures like nature's; and how often the one is coarser
/// than the other.
#[test]
fn a_tiles_own_estimate_is_seldom_finer_than_its_finest_quad() {
    let mut rng = Rng::with_seed(common::seed());
    let size = [256, 256];
    let [mut coarser, mut finer, mut all] = [0; 3];
    for contrast in [0.05f32, 0.15, 0.4] {
        let octaves: Vec<Vec<f32>> = (0..7)
            .map(|_| (0..4096).map(|_| rng.f32() - 0.5).collect())
            .collect();
        let picture = grey(size, |x, y| {
            let mut value = 0.4;
            for (octave, values) in octaves.iter().enumerate() {
                let side = 1u32 << octave;
                // bilinear, so that each octave is smooth
                let (fx, fy) = (x as f32 / side as f32, y as f32 / side as f32);
                let at = |dx: u32, dy: u32| {
                    let (px, py) = (fx as u32 + dx, fy as u32 + dy);
                    values[((px * 61 + py * 1031) % 4096) as usize]
                };
                let (px, py) = (fx.fract(), fy.fract());
                let top = at(0, 0) * (1.0 - px) + at(1, 0) * px;
                let bottom = at(0, 1) * (1.0 - px) + at(1, 1) * px;
                value += contrast * side as f32 / 8.0 * (top * (1.0 - py) + bottom * py);
            }
            value.clamp(0.01, 1.0)
        });
        let inputs = Inputs::of_colour(size, Colour::Linear(&picture));
        let attachment = |attachment| {
            let settings = Settings {
                attachment,
                ..Settings::default()
            };
            let found = integer::analyse(&inputs, &settings).expect("inputs");
            found.attachment
        };
        let own = attachment(Granularity::Tile16);
        let of_quads = attachment(Granularity::Quad);
        for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x * 8, y * 8))) {
            let finest = (y..y + 8)
                .flat_map(|y| (x..x + 8).map(move |x| (x, y)))
                .map(|(x, y)| Rate::from_code_or_full(of_quads.code(x, y)))
                .fold(Rate::R4X4, Rate::meet);
            let own = Rate::from_code_or_full(own.code(x, y));
            coarser += usize::from(!own.is_within(finest));
            finer += usize::from(!finest.is_within(own));
            all += 1;
        }
    }
    println!(
        "{coarser} of {all} tiles are coarser by their own pixels than by their finest quad, {finer} finer"
    );
    assert!(coarser > 0 && finer * 20 < all, "{coarser} {finer} {all}");
}

// the twin, the kernel and every place where tiles end
#[test]
fn the_gpu_makes_the_bytes_of_its_twin_for_every_tile_and_size() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let sizes = [
        [1u32, 1],
        [2, 3],
        [17, 33],
        [31, 8],
        [32, 32],
        [65, 40],
        [100, 7],
    ];
    for tile in TILES {
        for size in sizes {
            let scene = Scene {
                attachment: true,
                reasons: true,
                materials: true,
                flags: true,
                colour: [
                    vrcs::plan::ColourForm::Codes,
                    vrcs::plan::ColourForm::Linear,
                    vrcs::plan::ColourForm::SqrtLuma,
                ][rng.usize(..3)],
                ..Scene::default()
            };
            let settings = Settings {
                materials: Some(Materials {
                    of: [MaterialsOf::This, MaterialsOf::Previous][rng.usize(..2)],
                    mirror: 2.0,
                    ..Materials::default()
                }),
                largest: Rate::R4X2,
                smoothing: [Smoothing::None, Smoothing::Limit, Smoothing::Conservative]
                    [rng.usize(..3)],
                // the attachment's beside quads, or both of one
                granularity: [Granularity::Quad, tile][rng.usize(..2)],
                attachment: tile,
                ..Settings::default()
            };
            let previous = [size, [size[0] + 5, size[1].div_ceil(2)]][rng.usize(..2)];
            let made = Made::new(size, previous, &mut rng);
            let plan = Plan::new(&scene, &settings).expect("a plan");
            let frame = Frame {
                previous_size: previous,
                ..Frame::of_size(size)
            };
            let wanted = integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs");
            assert_equal(&made.run(&gpu, &plan, &frame), &wanted, &plan);
        }
    }
}
