//! Content: how much detail each quad would lose (Yang et al., I3D 2019, §3).

use super::luma::Luma;
use crate::{Rate, sri::Sri};

/// What makes a difference noticeable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// t of Eq. 15: the share of the luma that a difference may have. The paper uses 0.15.
    pub threshold: f64,
    /// l of Eq. 15: the luma of the surroundings, in the picture's units. The paper uses 0.05.
    pub ambient: f64,
}

impl Default for Sensitivity {
    fn default() -> Sensitivity {
        Sensitivity {
            threshold: 0.15,
            ambient: 0.05,
        }
    }
}

/// What a quad shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The error that halving the rate across would make (Eq. 2): the root mean square of half the difference between
    /// neighbours in a row.
    pub across: f64,
    /// The same down the columns.
    pub down: f64,
    /// The mean luma.
    pub luma: f64,
}

/// The estimate of a quad, from the window of 4×4 pixels that has the quad in its middle: all twelve pairs of neighbours on
/// each axis, so that a shift by one pixel changes little (§3.1). At the border, pixels repeat.
pub fn estimate(luma: &Luma, quad: [u32; 2]) -> Estimate {
    let (left, top) = (i64::from(quad[0]) * 2 - 1, i64::from(quad[1]) * 2 - 1);
    let mut across = 0.0;
    let mut down = 0.0;
    let mut sum = 0.0;
    for y in 0..4 {
        for x in 0..4 {
            let here = luma.at(left + x, top + y);
            sum += here;
            if x > 0 {
                across += ((here - luma.at(left + x - 1, top + y)) / 2.0).powi(2);
            }
            if y > 0 {
                down += ((here - luma.at(left + x, top + y - 1)) / 2.0).powi(2);
            }
        }
    }
    Estimate {
        across: (across / 12.0).sqrt(),
        down: (down / 12.0).sqrt(),
        luma: sum / 16.0,
    }
}

/// The rate of a quad (Eq. 15 and 16 with rates up to one half on each axis): an axis is halved only if its error is surely
/// below the threshold, so that NaN means full rate.
pub fn rate(estimate: &Estimate, sensitivity: &Sensitivity) -> Rate {
    let threshold = sensitivity.threshold * (estimate.luma + sensitivity.ambient);
    match (estimate.across < threshold, estimate.down < threshold) {
        (true, true) => Rate::R2X2,
        (true, false) => Rate::R2X1,
        (false, true) => Rate::R1X2,
        (false, false) => Rate::R1X1,
    }
}

/// The shading-rate image of a picture.
pub fn analyse(luma: &Luma, sensitivity: &Sensitivity) -> Sri {
    Sri::from_fn(luma.width(), luma.height(), |x, y| {
        rate(&estimate(luma, [x, y]), sensitivity).code()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> Luma {
        let bytes: Vec<u8> = (0..width * height)
            .flat_map(|i| {
                let v = value(i % width, i / width);
                [v, v, v, 255]
            })
            .collect();
        Luma::from_rgba8(width, height, &bytes)
    }

    #[test]
    fn a_plain_picture_is_coarse() {
        let luma = picture(8, 8, |_, _| 90);
        assert_eq!(
            analyse(&luma, &Sensitivity::default()),
            Sri::uniform(8, 8, Rate::R2X2)
        );
    }

    #[test]
    fn vertical_stripes_stay_fine_across_and_go_coarse_down() {
        let luma = picture(16, 16, |x, _| if x % 2 == 0 { 30 } else { 220 });
        assert_eq!(
            analyse(&luma, &Sensitivity::default()),
            Sri::uniform(16, 16, Rate::R1X2)
        );
        let luma = picture(16, 16, |_, y| if y % 2 == 0 { 30 } else { 220 });
        assert_eq!(
            analyse(&luma, &Sensitivity::default()),
            Sri::uniform(16, 16, Rate::R2X1)
        );
    }

    #[test]
    fn an_error_that_is_no_number_means_full_rate() {
        let estimate = Estimate {
            across: f64::NAN,
            down: 0.0,
            luma: 0.5,
        };
        assert_eq!(rate(&estimate, &Sensitivity::default()), Rate::R1X2);
        let estimate = Estimate {
            luma: f64::NAN,
            ..estimate
        };
        assert_eq!(rate(&estimate, &Sensitivity::default()), Rate::R1X1);
    }

    #[test]
    fn a_ramp_has_half_its_step_as_error() {
        // codes far enough apart that the ramp of codes is what is measured, not its linear light
        let luma = picture(8, 8, |x, _| x as u8);
        let step = luma.at(4, 0) - luma.at(3, 0);
        let found = estimate(&luma, [2, 2]);
        assert!((found.across - step / 2.0).abs() < 1e-12, "{found:?}");
        assert_eq!(found.down, 0.0);
    }
}
