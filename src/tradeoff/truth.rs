//! The truth: what coarsening really does to the picture, and how far an analysis is from it.
//!
//! An analysis foresees an error; here the scene's passes are really run at each rate, everywhere, with the coverage and the
//! deblocker of the defaults, and each quad's error is measured in what they drew: the root mean square of the luma that it
//! lost (Yang et al., I3D 2019, Eq. 1). The true rate of a quad is the cheapest whose error stays below the threshold of Eq. 15.
//!
//! *Needs*: one frame; the analysis is shown the frame itself, so that no motion or feedback is in the way. *Guarantees*: full rate is
//! always right.

use super::{
    Trouble,
    bench::{Bench, average_rate},
    realise::realise,
    setting::{LargestName, Setting},
    study::{Truth, TruthAt},
};
use crate::{
    Rate,
    analyse::{
        Colour, Inputs, Settings, content::Sensitivity, integer, luma::Luma, settings::Content,
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

/// Each quad's error at each rate, as drawn.
#[derive(Clone, Debug)]
pub struct TrueErrors {
    quads: [u32; 2],
    /// Mean luma, quad by quad.
    means: Vec<f64>,
    /// Rates but 1×1, with errors quad by quad.
    errors: Vec<(Rate, Vec<f64>)>,
}

/// How rates compare with the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Judgement {
    /// The share of quads whose true error at their rate is not below the threshold.
    pub too_coarse: f64,
    /// The share of the others for which a rate that shades fewer pixels stays below it.
    pub too_fine: f64,
    /// Shaded pixels for each pixel of the truth.
    pub true_rate: f64,
}

/// The pixels of a quad that are in the picture.
fn pixels(luma: &Luma, quad: [u32; 2]) -> impl Iterator<Item = (i64, i64)> {
    let [width, height] = [luma.width(), luma.height()];
    let [left, top] = quad.map(|q| q * 2);
    (top..(top + 2).min(height))
        .flat_map(move |y| (left..(left + 2).min(width)).map(move |x| (i64::from(x), i64::from(y))))
}

fn cost(rate: Rate) -> f64 {
    1.0 / f64::from(rate.pixels())
}

impl TrueErrors {
    /// From the luma at full rate, and at each other rate everywhere.
    pub fn new(full: &Luma, coarse: &[(Rate, Luma)]) -> TrueErrors {
        let quads = [full.width().div_ceil(2), full.height().div_ceil(2)];
        let each = || (0..quads[1]).flat_map(|y| (0..quads[0]).map(move |x| [x, y]));
        let mean = |quad, of: &dyn Fn(i64, i64) -> f64| {
            let values: Vec<f64> = pixels(full, quad).map(|(x, y)| of(x, y)).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        TrueErrors {
            quads,
            means: each()
                .map(|quad| mean(quad, &|x, y| full.at(x, y)))
                .collect(),
            errors: coarse
                .iter()
                .map(|(rate, drawn)| {
                    let square = |x, y| (full.at(x, y) - drawn.at(x, y)).powi(2);
                    let errors = each().map(|quad| mean(quad, &square).sqrt()).collect();
                    (*rate, errors)
                })
                .collect(),
        }
    }

    /// Whether a quad's true error at a rate stays below the threshold.
    fn stays_below(&self, quad: usize, rate: Rate, sensitivity: &Sensitivity) -> bool {
        let threshold = sensitivity.threshold * (self.means[quad] + sensitivity.ambient);
        rate == Rate::R1X1
            || self
                .errors
                .iter()
                .any(|(known, errors)| *known == rate && errors[quad] < threshold)
    }

    /// Judges rates.
    pub fn judge(&self, sri: &Sri, largest: Rate, sensitivity: &Sensitivity) -> Judgement {
        let mut judgement = Judgement::default();
        for index in 0..self.means.len() {
            let (x, y) = (index as u32 % self.quads[0], index as u32 / self.quads[0]);
            let chosen = sri.rate(x, y, largest);
            let cheapest = Rate::ALL
                .into_iter()
                .filter(|rate| rate.is_within(largest))
                .filter(|&rate| self.stays_below(index, rate, sensitivity))
                .map(cost)
                .fold(1.0, f64::min);
            if !self.stays_below(index, chosen, sensitivity) {
                judgement.too_coarse += 1.0;
            } else if cheapest < cost(chosen) {
                judgement.too_fine += 1.0;
            }
            judgement.true_rate += cheapest;
        }
        let count = self.means.len() as f64;
        Judgement {
            too_coarse: judgement.too_coarse / count,
            too_fine: judgement.too_fine / count,
            true_rate: judgement.true_rate / count,
        }
    }
}

/// Finds the truth for a scene, and judges the paper's analysis over thresholds (its Fig. 10) and surroundings.
///
/// # Errors
/// If the device lacks what it needs, or was lost.
pub fn truth(bench: &Bench) -> Result<Truth, Trouble> {
    let size = bench.size();
    let number = Bench::last(1);
    let setting = Setting {
        largest: LargestName::R4x4,
        ..Setting::default()
    };
    let mut realised = realise(bench.scene(), &setting, false).map_err(Trouble::Setting)?;
    // rates are written, not found
    realised.analysis = None;
    realised.camera_motion = false;
    let mut rig = bench.rig(realised)?;
    let full = bench.full(number)?;
    let luma = |picture: &[u8]| Luma::from_rgba8(size[0], size[1], picture);
    let mut coarse = Vec::new();
    for rate in Rate::ALL.into_iter().filter(|rate| *rate != Rate::R1X1) {
        rig.write_rates(&Sri::uniform(size[0], size[1], rate))?;
        coarse.push((rate, luma(&bench.draw(&mut rig, number)?)));
    }
    let errors = TrueErrors::new(&luma(&full), &coarse);
    let codes: &[[u8; 4]] = bytemuck::cast_slice(&full);
    let mut at = |t: f64, l: f64| -> Result<TruthAt, Trouble> {
        let settings = Settings {
            content: Content {
                threshold: t,
                ambient: l,
                ..Content::default()
            },
            largest: LARGEST,
            ..Settings::default()
        };
        let inputs = Inputs::of_colour(size, Colour::Codes(codes));
        let found = integer::analyse(&inputs, &settings)
            .map_err(|error| Trouble::Own(error.to_string()))?;
        rig.write_rates(&found.sri)?;
        let drawn = bench.draw(&mut rig, number)?;
        let sensitivity = Sensitivity {
            threshold: t,
            ambient: l,
        };
        let judgement = errors.judge(&found.sri, LARGEST, &sensitivity);
        Ok(TruthAt {
            t,
            l,
            too_coarse: judgement.too_coarse,
            too_fine: judgement.too_fine,
            rate: average_rate(&found.sri, LARGEST),
            true_rate: judgement.true_rate,
            ssim: metrics::ssim(Shown::new(size, &full), Shown::new(size, &drawn)),
        })
    };
    let paper = Sensitivity::default();
    let curve: Result<Vec<TruthAt>, Trouble> = THRESHOLDS
        .into_iter()
        .map(|t| at(t, paper.ambient))
        .collect();
    let ambients: Result<Vec<TruthAt>, Trouble> = AMBIENTS
        .into_iter()
        .map(|l| at(paper.threshold, l))
        .collect();
    Ok(Truth {
        about: "Every pass was really run at every rate everywhere, with the coverage and the deblocker of the defaults, and each \
                quad's loss of luma measured in what was drawn. A quad is too coarse if its loss at the analysis' rate is not below \
                t · (luma + l), and too fine if a cheaper rate's loss would be. The analysis was shown the frame itself: no motion, no feedback."
            .to_owned(),
        curve: curve?,
        ambients: ambients?,
    })
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
    fn the_error_is_the_root_mean_square_of_the_luma_lost() {
        let one_pixel = coarsened(|x, y| if (x, y) == (3, 2) { 255 } else { 0 });
        let (_, errors) = &one_pixel.errors[1];
        assert_eq!(one_pixel.errors[1].0, Rate::R2X1);
        assert!((errors[8 + 1] - 0.5).abs() < 1e-9, "{}", errors[9]);
        assert_eq!(errors[0], 0.0);
    }
}
