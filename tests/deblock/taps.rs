//! What the filter leaves alone, and where its taps lie.

use fastrand::Rng;
use vrcs::{
    Rate,
    deblock::{Counters, Packing, Picture},
    sri::Sri,
};

use crate::{
    bench::Bench,
    case::{COARSE, Case, FORMATS, packing_of, primary, random_color, random_rates},
    common,
};

#[test]
fn a_full_rate_picture_keeps_its_bits() {
    let bench = Bench::new();
    let mut rng = Rng::with_seed(common::seed());
    for picture in FORMATS {
        let case = Case::new([33, 17], Sri::uniform(33, 17, Rate::R1X1), |_, _| [0.0; 4]);
        let mut case = case.rounded(packing_of(picture));
        case.colors.fill_with(|| random_color(&mut rng));
        case.colors[40] = [f32::NAN, f32::INFINITY, -0.0, 1.0];
        let got = bench.run(&case, picture);
        let wanted: Vec<u32> = case
            .colors
            .iter()
            .flat_map(|c| packing_of(picture).pack(*c))
            .collect();
        assert_eq!(got.words, wanted, "{picture:?}");
        assert_eq!(got.counters, Counters::default(), "nothing is coarse");
    }
}

#[test]
fn a_plain_picture_and_every_primary_keep_their_bits() {
    let bench = Bench::new();
    let seed = common::seed();
    for (index, picture) in FORMATS.into_iter().enumerate() {
        let packing = packing_of(picture);
        let mut rng = Rng::with_seed(seed + index as u64);
        let rates = random_rates([40, 23], &mut rng);
        let plain = Case::new([40, 23], rates, |_, _| [0.3, 0.7, 0.11, 0.5]).rounded(packing);
        let words = packing.pack(plain.colors[0]);
        let got = bench.run(&plain, picture);
        assert!(
            got.words
                .chunks_exact(words.len())
                .all(|pixel| pixel == words)
        );

        let rate = COARSE[index % COARSE.len()];
        for order in 0..=4 {
            let mut case = Case::new([40, 23], Sri::uniform(40, 23, rate), |_, _| [0.0; 4]);
            case.colors.fill_with(|| random_color(&mut rng));
            case.order = order;
            let case = case.copied().rounded(packing);
            let got = bench.run(&case, picture);
            let mut moved = 0;
            for (i, (got, was)) in got.colors.iter().zip(&case.colors).enumerate() {
                let (x, y) = (i as u32 % 40, i as u32 / 40);
                if primary(&case, x, y) == [x, y] {
                    assert_eq!(got, was, "the primary {x},{y} at {rate}, order {order}");
                }
                moved += u32::from(got != was);
            }
            assert!(moved > 100, "the filter did nothing at {rate}");
        }
    }
}

/// The root of the mean square distance from a ramp, over the pixels that have samples on both sides.
fn ramp_error(
    case: &Case,
    colors: impl Iterator<Item = f64>,
    value: impl Fn(u32, u32) -> f64,
) -> f64 {
    let [width, height] = case.extent;
    let mut sum = 0.0;
    let mut count = 0.0;
    for (i, color) in colors.enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        if (4..width - 4).contains(&x) && (4..height - 4).contains(&y) {
            sum += (color - value(x, y)).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(sum / count)
}

/// The number: how much nearer to a linear ramp the filter comes than the copies. Where all groups are of one size it is
/// exact but for f32; where rates are mixed, neighbours' samples lie in other rows and columns, and the factor is what is left.
#[test]
fn a_ramp_comes_back() {
    let bench = Bench::new();
    let seed = common::seed();
    let extent = [64, 48];
    let picture = Picture::Buffer(Packing::Rgba32Float);
    for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (0.75, -0.5)] {
        let value = move |x: u32, y: u32| 40.0 + dx * f64::from(x) + dy * f64::from(y);
        let color = move |x, y| [value(x, y) as f32, 1.0, 0.0, 1.0];
        for rate in COARSE {
            for order in 0..=4 {
                let mut case = Case::new(extent, Sri::uniform(64, 48, rate), color);
                case.order = order;
                let case = case.copied();
                let before = ramp_error(&case, case.colors.iter().map(|c| f64::from(c[0])), value);
                let got = bench.run(&case, picture);
                let after = ramp_error(&case, got.colors.iter().map(|c| f64::from(c[0])), value);
                // a half rate does not touch a ramp along its fine axis
                let is_blocked = before > 0.0;
                assert_eq!(
                    is_blocked,
                    dx != 0.0 && rate.width() > 1 || dy != 0.0 && rate.height() > 1
                );
                assert!(
                    after * 1e5 <= before,
                    "{rate}, order {order}, slope {dx},{dy}: {before} became {after}"
                );
            }
        }
        let mut rng = Rng::with_seed(seed);
        let mixed = Sri::from_fn(64, 48, |_, _| Rate::ALL[rng.usize(0..4)].code());
        let blocks: Vec<Rate> = (0..16 * 12).map(|_| Rate::ALL[rng.usize(0..7)]).collect();
        let coarse = Sri::from_fn(64, 48, |x, y| blocks[(y / 2 * 16 + x / 2) as usize].code());
        for (name, rates, factor) in [("up to 2x2", mixed, 4.0), ("up to 4x4", coarse, 3.0)] {
            for order in 0..=4 {
                let mut case = Case::new(extent, rates.clone(), color);
                case.order = order;
                let case = case.copied();
                let before = ramp_error(&case, case.colors.iter().map(|c| f64::from(c[0])), value);
                let got = bench.run(&case, picture);
                let after = ramp_error(&case, got.colors.iter().map(|c| f64::from(c[0])), value);
                println!(
                    "mixed {name}, order {order}, slope {dx},{dy}: {:.2}",
                    before / after
                );
                assert!(
                    after * factor <= before,
                    "{name}, order {order}: {before} became {after}"
                );
            }
        }
    }
}

#[test]
fn the_slides_averages_are_what_comes_out() {
    // 2x1: the mean of two across; 1x2: of two down; 2x2: of the four around a corner
    let bench = Bench::new();
    let picture = Picture::Buffer(Packing::Rgba32Float);
    let of = |rate| {
        let case = Case::new([4, 4], Sri::uniform(4, 4, rate), |x, y| {
            [(x + 10 * y) as f32, 0.0, 0.0, 1.0]
        });
        let case = case.copied();
        bench
            .run(&case, picture)
            .colors
            .iter()
            .map(|c| c[0])
            .collect::<Vec<_>>()
    };
    assert_eq!(of(Rate::R2X1)[..4], [0.0, 1.0, 2.0, 2.0]);
    let down = of(Rate::R1X2);
    assert_eq!(
        [down[0], down[4], down[8], down[12]],
        [0.0, 10.0, 20.0, 20.0]
    );
    let both = of(Rate::R2X2);
    assert_eq!(both[..2], [0.0, 1.0]);
    assert_eq!(both[4..6], [10.0, (0.0 + 2.0 + 20.0 + 22.0) / 4.0]);
}
