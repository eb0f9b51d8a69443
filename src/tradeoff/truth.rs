//! The truth: what coarsening really does to the picture, and how far analyses are from it.
//!
//! An analysis foresees an error; here the scene's passes are really run at each rate, everywhere, with the coverage and the
//! deblocker of the defaults, and the error is measured in what they drew: the root mean square of the luma that was lost (Yang et al.,
//! I3D 2019, Eq. 1), over a quad for rates up to 2×2, over the aligned block of 4×4 for rates that are 4 wide or high. The true rates of a
//! block are the cheapest whose errors all stay below the threshold of Eq. 15: one for each quad, or one for the block.
//!
//! *Needs*: frames of the animation; an analysis is shown the frame itself, so that no motion or feedback is in the way. *Guarantees*: full
//! rate is always right; what is found is the mean over some frames.

use rayon::prelude::*;

use super::{
    Trouble,
    bench::{Bench, average_rate},
    realise::realise,
    rig::Rig,
    setting::{LargestName, Setting},
    study::{Truth, TruthAt},
};
use crate::{
    Rate,
    analyse::{
        Colour, Inputs, Settings, content::Sensitivity, integer, luma::Luma, peers::Peer,
        settings::Content,
    },
    metrics::{self, Shown},
    sri::Sri,
};

/// The thresholds that are judged.
const THRESHOLDS: [f64; 9] = [0.02, 0.04, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5];
/// The lumas of the surroundings that are judged, at the paper's threshold.
const AMBIENTS: [f64; 5] = [0.0, 0.02, 0.05, 0.1, 0.2];
/// The largest rate: all are in the running.
const LARGEST: Rate = Rate::R4X4;
/// Frames from one to the next.
const APART: u32 = 12;

/// How rates compare with the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Judgement {
    /// The share of quads whose true error at their rate is not below the threshold.
    pub too_coarse: f64,
    /// The share of the others that shade more pixels than they would in the cheapest way that stays below it.
    pub too_fine: f64,
    /// Shaded pixels for each pixel of the truth.
    pub true_rate: f64,
}

/// Squares of pixels, of one error each.
#[derive(Clone, Debug)]
struct Units {
    /// Pixels across.
    side: u32,
    /// Units across.
    across: u32,
    /// The mean luma of each.
    means: Vec<f64>,
    /// The error of each, at each rate that is judged over such units.
    errors: Vec<(Rate, Vec<f64>)>,
}

impl Units {
    fn new(side: u32, full: &Luma, coarse: &[(Rate, Luma)]) -> Units {
        let [across, down] = [full.width(), full.height()].map(|pixels| pixels.div_ceil(side));
        let mean_of = |of: &(dyn Fn(i64, i64) -> f64 + Sync)| -> Vec<f64> {
            let units = (0..down).flat_map(|y| (0..across).map(move |x| [x * side, y * side]));
            let mean = |[left, top]: [u32; 2]| {
                let (right, bottom) = (
                    (left + side).min(full.width()),
                    (top + side).min(full.height()),
                );
                let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
                let sum: f64 = places.map(|(x, y)| of(i64::from(x), i64::from(y))).sum();
                sum / f64::from((right - left) * (bottom - top))
            };
            units.map(mean).collect()
        };
        Units {
            side,
            across,
            means: mean_of(&|x, y| full.at(x, y)),
            errors: coarse
                .par_iter()
                .filter(|(rate, _)| side_of(*rate) == side)
                .map(|(rate, drawn)| {
                    let squares = mean_of(&|x, y| (full.at(x, y) - drawn.at(x, y)).powi(2));
                    (*rate, squares.into_iter().map(f64::sqrt).collect())
                })
                .collect(),
        }
    }

    /// The unit of a quad.
    fn of(&self, [x, y]: [u32; 2]) -> usize {
        (y * 2 / self.side * self.across + x * 2 / self.side) as usize
    }

    fn threshold(&self, unit: usize, sensitivity: &Sensitivity) -> f64 {
        sensitivity.threshold * (self.means[unit] + sensitivity.ambient)
    }

    /// Whether the true error of a quad's unit at a rate stays below the threshold.
    fn stays_below(&self, quad: [u32; 2], rate: Rate, sensitivity: &Sensitivity) -> bool {
        let unit = self.of(quad);
        let threshold = self.threshold(unit, sensitivity);
        let known = self.errors.iter().find(|(known, _)| *known == rate);
        rate == Rate::R1X1 || known.is_some_and(|(_, errors)| errors[unit] < threshold)
    }

    /// What the cheapest rate within `largest` that stays below the threshold shades for each pixel; nothing if none does.
    fn cheapest(&self, quad: [u32; 2], largest: Rate, sensitivity: &Sensitivity) -> Option<f64> {
        let rates = self.errors.iter().map(|(rate, _)| *rate);
        rates
            .filter(|rate| rate.is_within(largest))
            .filter(|&rate| self.stays_below(quad, rate, sensitivity))
            .map(cost)
            .min_by(f64::total_cmp)
    }
}

/// Over how many pixels across a rate is judged.
fn side_of(rate: Rate) -> u32 {
    match rate.width().max(rate.height()) {
        4 => 4,
        _ => 2,
    }
}

fn cost(rate: Rate) -> f64 {
    1.0 / f64::from(rate.pixels())
}

/// The errors of a frame at each rate, as drawn.
#[derive(Clone, Debug)]
pub struct TrueErrors {
    size: [u32; 2],
    quads: Units,
    blocks: Units,
}

impl TrueErrors {
    /// From the luma at full rate, and at each other rate everywhere.
    pub fn new(full: &Luma, coarse: &[(Rate, Luma)]) -> TrueErrors {
        TrueErrors {
            size: [full.width(), full.height()],
            quads: Units::new(2, full, coarse),
            blocks: Units::new(4, full, coarse),
        }
    }

    /// What each quad of a block shades for each pixel in the cheapest way: by rates of their own, or by one of the block.
    fn true_costs(&self, block: &[[u32; 2]], largest: Rate, sensitivity: &Sensitivity) -> Vec<f64> {
        let apart: Vec<f64> = block
            .iter()
            .map(|&quad| {
                self.quads
                    .cheapest(quad, largest, sensitivity)
                    .unwrap_or(1.0)
            })
            .collect();
        let one = self.blocks.cheapest(block[0], largest, sensitivity);
        match one {
            Some(one) if one * block.len() as f64 <= apart.iter().sum() => vec![one; block.len()],
            _ => apart,
        }
    }

    /// Judges rates.
    pub fn judge(&self, sri: &Sri, largest: Rate, sensitivity: &Sensitivity) -> Judgement {
        let [width, height] = self.size.map(|pixels| pixels.div_ceil(2));
        let (mut too_coarse, mut too_fine, mut true_rate) = (0, 0, 0.0);
        for (top, left) in (0..height)
            .step_by(2)
            .flat_map(|y| (0..width).step_by(2).map(move |x| (y, x)))
        {
            let inside = |&[x, y]: &[u32; 2]| x < width && y < height;
            let block: Vec<[u32; 2]> = (0..4)
                .map(|i| [left + i % 2, top + i / 2])
                .filter(inside)
                .collect();
            let cheapest = self.true_costs(&block, largest, sensitivity);
            for (&quad, cheapest) in block.iter().zip(cheapest) {
                let chosen = sri.rate(quad[0], quad[1], largest);
                let units = if side_of(chosen) == 4 {
                    &self.blocks
                } else {
                    &self.quads
                };
                if !units.stays_below(quad, chosen, sensitivity) {
                    too_coarse += 1;
                } else if cheapest < cost(chosen) {
                    too_fine += 1;
                }
                true_rate += cheapest;
            }
        }
        let quads = f64::from(width) * f64::from(height);
        Judgement {
            too_coarse: f64::from(too_coarse) / quads,
            too_fine: f64::from(too_fine) / quads,
            true_rate: true_rate / quads,
        }
    }
}

/// An analysis that is judged, and the threshold that it is judged by.
struct Judged {
    name: String,
    settings: Settings,
    sensitivity: Sensitivity,
}

fn paper(sensitivity: Sensitivity) -> Judged {
    Judged {
        name: Peer::Paper.name().to_owned(),
        settings: Settings {
            content: Content {
                threshold: sensitivity.threshold,
                ambient: sensitivity.ambient,
                ..Content::default()
            },
            largest: LARGEST,
            ..Settings::default()
        },
        sensitivity,
    }
}

/// Everything that is judged: the paper's analysis over thresholds and surroundings, and every published estimator that looks at the
/// picture, by the paper's threshold.
fn judged() -> [Vec<Judged>; 3] {
    let usual = Sensitivity::default();
    let curve = THRESHOLDS.map(|threshold| paper(Sensitivity { threshold, ..usual }));
    let ambients = AMBIENTS.map(|ambient| paper(Sensitivity { ambient, ..usual }));
    let peers = Peer::ALL.into_iter().filter(|&peer| peer != Peer::Wicked);
    let peers = peers.map(|peer| Judged {
        name: peer.name().to_owned(),
        settings: Settings {
            largest: LARGEST,
            ..peer.settings(false)
        },
        sensitivity: usual,
    });
    [curve.into(), ambients.into(), peers.collect()]
}

/// Finds the truth for a scene in so many frames, and judges the paper's analysis over thresholds (its Fig. 10) and surroundings, and its peers.
///
/// # Errors
/// If the device lacks what it needs, or was lost.
pub fn truth(bench: &Bench, frames: u32) -> Result<Truth, Trouble> {
    let setting = Setting {
        largest: LargestName::R4x4,
        ..Setting::default()
    };
    let mut realised = realise(bench.scene(), &setting, false).map_err(Trouble::Setting)?;
    // rates are written, not found
    realised.analysis = None;
    realised.camera_motion = false;
    let mut rig = bench.rig(realised)?;
    let lists = judged();
    let all: Vec<&Judged> = lists.iter().flatten().collect();
    let mut all_sums = vec![TruthAt::default(); all.len()];
    for frame in 0..frames {
        let number = Bench::last(1) + frame * APART;
        let found = of_frame(bench, &mut rig, number, &all)?;
        for (sum, found) in all_sums.iter_mut().zip(found) {
            sum.add(&found, 1.0 / f64::from(frames));
        }
    }
    let mut sums = all_sums.into_iter();
    let sums: Vec<Vec<TruthAt>> = lists
        .iter()
        .map(|list| sums.by_ref().take(list.len()).collect())
        .collect();
    let names: Vec<String> = lists[2].iter().map(|judged| judged.name.clone()).collect();
    let mut sums = sums.into_iter();
    let mut next = || sums.next().unwrap_or_default();
    Ok(Truth {
        about: format!(
            "Every pass was really run at every rate everywhere, in {} of the animation, with the coverage and the deblocker of the defaults, and the \
             loss of luma was measured in what was drawn, over a quad for rates up to 2×2 and over the block of 4×4 for others. A quad is too \
             coarse if the loss at the analysis' rate is not below t · (luma + l), and too fine if a cheaper way would stay below it. An analysis \
             was shown the frame itself: no motion, no feedback.",
            match frames {
                1 => "one frame".to_owned(),
                more => format!("{more} frames"),
            }
        ),
        curve: next(),
        ambients: next(),
        peers: names.into_iter().zip(next()).collect(),
    })
}

/// One frame.
fn of_frame(
    bench: &Bench,
    rig: &mut Rig,
    number: u32,
    list: &[&Judged],
) -> Result<Vec<TruthAt>, Trouble> {
    let size = bench.size();
    let full = bench.full(number)?;
    let luma = |picture: &[u8]| Luma::from_rgba8(size[0], size[1], picture);
    let mut drawn = Vec::new();
    for rate in Rate::ALL.into_iter().filter(|rate| *rate != Rate::R1X1) {
        rig.write_rates(&Sri::uniform(size[0], size[1], rate))?;
        drawn.push((rate, bench.draw(rig, number)?));
    }
    let coarse: Vec<(Rate, Luma)> = drawn
        .par_iter()
        .map(|(rate, picture)| (*rate, luma(picture)))
        .collect();
    let errors = TrueErrors::new(&luma(&full), &coarse);
    let codes: &[[u8; 4]] = bytemuck::cast_slice(&full);
    let inputs = Inputs::of_colour(size, Colour::Codes(codes));
    let rates: Result<Vec<Sri>, Trouble> = list
        .par_iter()
        .map(|judged| {
            let found = integer::analyse(&inputs, &judged.settings);
            let found = found.map_err(|error| Trouble::Own(error.to_string()))?;
            Ok(found.sri)
        })
        .collect();
    let rates = rates?;
    let mut pictures = Vec::new();
    for sri in &rates {
        rig.write_rates(sri)?;
        pictures.push(bench.draw(rig, number)?);
    }
    let full: &[u8] = &full;
    Ok(list
        .par_iter()
        .zip(rates.par_iter().zip(&pictures))
        .map(|(judged, (sri, drawn))| {
            let judgement = errors.judge(sri, LARGEST, &judged.sensitivity);
            TruthAt {
                t: judged.sensitivity.threshold,
                l: judged.sensitivity.ambient,
                too_coarse: judgement.too_coarse,
                too_fine: judgement.too_fine,
                rate: average_rate(sri, LARGEST),
                true_rate: judgement.true_rate,
                ssim: metrics::ssim(Shown::new(size, full), Shown::new(size, drawn)),
            }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: impl Fn(u32, u32) -> u8) -> Luma {
        let bytes: Vec<u8> = (0..16 * 16)
            .flat_map(|i| {
                let v = value(i % 16, i / 16);
                [v, v, v, 255]
            })
            .collect();
        Luma::from_rgba8(16, 16, &bytes)
    }

    /// A picture, and what copies of first pixels make of it at every rate.
    fn coarsened(value: impl Fn(u32, u32) -> u8) -> TrueErrors {
        let coarse: Vec<(Rate, Luma)> = Rate::ALL[1..]
            .iter()
            .map(|&rate| {
                let (w, h) = (rate.width(), rate.height());
                (rate, picture(|x, y| value(x / w * w, y / h * h)))
            })
            .collect();
        TrueErrors::new(&picture(&value), &coarse)
    }

    fn judge(errors: &TrueErrors, rate: Rate, largest: Rate) -> Judgement {
        let sri = Sri::uniform(16, 16, rate);
        errors.judge(&sri, largest, &Sensitivity::default())
    }

    #[test]
    fn full_rate_is_never_too_coarse() {
        let noise = coarsened(|x, y| (x * 113 + y * 57) as u8);
        assert_eq!(judge(&noise, Rate::R1X1, Rate::R4X4).too_coarse, 0.0);
    }

    #[test]
    fn of_a_plain_picture_the_coarsest_rate_is_right() {
        let plain = coarsened(|_, _| 90);
        let found = judge(&plain, Rate::R1X1, Rate::R2X2);
        assert_eq!((found.too_fine, found.true_rate), (1.0, 0.25));
        let found = judge(&plain, Rate::R4X4, Rate::R4X4);
        assert_eq!(
            (found.too_coarse, found.too_fine, found.true_rate),
            (0.0, 0.0, 0.0625)
        );
    }

    #[test]
    fn stripes_can_be_coarse_along_and_not_across() {
        let stripes = coarsened(|x, _| if x % 2 == 0 { 30 } else { 220 });
        let found = judge(&stripes, Rate::R2X2, Rate::R2X2);
        assert_eq!((found.too_coarse, found.true_rate), (1.0, 0.5));
        let found = judge(&stripes, Rate::R1X2, Rate::R2X2);
        assert_eq!((found.too_coarse, found.too_fine), (0.0, 0.0));
    }

    #[test]
    fn a_rate_of_four_is_judged_over_its_block_and_not_quad_by_quad() {
        // quads like a chessboard: two of a block's lose nothing, two all of it
        let steps = coarsened(|x, y| if (x / 2 + y / 2) % 2 == 0 { 30 } else { 220 });
        let found = judge(&steps, Rate::R4X4, Rate::R4X4);
        assert_eq!(found.too_coarse, 1.0, "the block as a whole");
        assert_eq!(found.true_rate, 0.25, "2x2 loses nothing");
        let found = judge(&steps, Rate::R2X2, Rate::R4X4);
        assert_eq!((found.too_coarse, found.too_fine), (0.0, 0.0));
    }

    #[test]
    fn the_error_is_the_root_mean_square_of_the_luma_lost() {
        let one_pixel = coarsened(|x, y| if (x, y) == (3, 2) { 255 } else { 0 });
        let (rate, errors) = &one_pixel.quads.errors[1];
        assert_eq!(*rate, Rate::R2X1);
        assert!((errors[8 + 1] - 0.5).abs() < 1e-9, "{}", errors[9]);
        assert_eq!(errors[0], 0.0);
        let (rate, errors) = &one_pixel.blocks.errors[2];
        assert_eq!(*rate, Rate::R4X4);
        assert!((errors[0] - 0.25).abs() < 1e-9, "one pixel of sixteen");
    }
}
