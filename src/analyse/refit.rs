//! Constants from content: k (Eq. 13) and the motion scalers (Eq. 17 to 19) by their definitions, not by the paper's fits.
//!
//! The convention, which decides k: continuous spectra up to the Nyquist frequency, box filters without phase, so that
//! F(B_n) at f cycles a pixel is sin(π n f) / (π n f); S = 1/f. With it k is 2.126. Discrete filters would give 2.28 to 2.43,
//! causal ones 2.03.
//!
//! The fits of Eq. 20 and 21 stay within 12 % and 15 % of their definitions up to 8 pixels a frame; at 16 and 32, Eq. 20 is
//! 16 % and 21 % too low, and so too coarse.

use std::f64::consts::PI;

/// The response of a box of `width` pixels at `f` cycles a pixel.
pub fn box_response(width: f64, f: f64) -> f64 {
    let x = PI * width * f;
    match x.abs() < 1e-9 {
        true => 1.0,
        false => x.sin() / x,
    }
}

/// ‖S (1 − F(B_width)) F(B_v)‖₂ for an amplitude spectrum S over frequencies of 0 to 1/2 cycles a pixel.
fn energy(spectrum: &dyn Fn(f64) -> f64, width: f64, speed: f64) -> f64 {
    const STEPS: u32 = 8192;
    let sum: f64 = (0..STEPS)
        .map(|i| {
            let f = (f64::from(i) + 0.5) / f64::from(STEPS) / 2.0;
            (spectrum(f) * (1.0 - box_response(width, f)) * box_response(speed, f)).powi(2)
        })
        .sum();
    sum.sqrt()
}

/// The amplitude spectrum of natural pictures, 1/f (Field 1987).
pub fn natural(f: f64) -> f64 {
    1.0 / f
}

/// k of Eq. 13 for an amplitude spectrum.
pub fn k(spectrum: &dyn Fn(f64) -> f64) -> f64 {
    energy(spectrum, 4.0, 0.0) / energy(spectrum, 2.0, 0.0)
}

/// b_H(v) of Eq. 18, by its definition.
pub fn half(spectrum: &dyn Fn(f64) -> f64, speed: f64) -> f64 {
    energy(spectrum, 2.0, speed) / energy(spectrum, 2.0, 0.0)
}

/// b_Q(v) of Eq. 19, by its definition.
pub fn quarter(spectrum: &dyn Fn(f64) -> f64, speed: f64) -> f64 {
    energy(spectrum, 4.0, speed) / energy(spectrum, 2.0, 0.0)
}

/// k refitted to a picture's luma: the exponent s of an amplitude spectrum 1/f^s is had from how the mean square of differences
/// grows from one pixel to two, 2^(2s − 1) for ½ < s < 1½, and Eq. 13 is solved for it. `None` for a picture without
/// differences, or of fewer than 3 pixels on an axis.
pub fn refit_k(luma: &super::luma::Luma) -> Option<f64> {
    let (width, height) = (i64::from(luma.width()), i64::from(luma.height()));
    if width < 3 || height < 3 {
        return None;
    }
    let structure = |lag: i64| -> f64 {
        let mut sum = 0.0;
        for y in 0..height - 2 {
            for x in 0..width - 2 {
                let here = luma.at(x, y);
                sum += (luma.at(x + lag, y) - here).powi(2) + (luma.at(x, y + lag) - here).powi(2);
            }
        }
        sum
    };
    let (one, two) = (structure(1), structure(2));
    let growth = (two / one).log2();
    growth.is_finite().then(|| {
        let slope = ((growth + 1.0) / 2.0).clamp(0.0, 2.0);
        k(&|f: f64| f.powf(-slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyse::{luma::Luma, motion};

    #[test]
    fn e14_paper_k_is_2_126() {
        let k = k(&natural);
        assert!((k - 2.126).abs() < 0.01, "{k}");
    }

    #[test]
    fn e13_the_fits_of_b_h_and_b_q_are_near_their_definitions() {
        let mut worst = [0.0f64; 2];
        for step in 1..=32 {
            let speed = f64::from(step) / 4.0;
            let h = motion::half(speed) / half(&natural, speed) - 1.0;
            let q = motion::quarter(speed, 2.13) / quarter(&natural, speed) - 1.0;
            worst = [worst[0].max(h.abs()), worst[1].max(q.abs())];
        }
        println!("up to 8 pixels a frame, the fits are off by at most {worst:?}");
        // at quarter pixels; the fits are the paper's, and smooth where the definitions ripple
        assert!(worst[0] < 0.12 && worst[1] < 0.15, "{worst:?}");
        let far = [16.0, 32.0].map(|speed| motion::half(speed) / half(&natural, speed) - 1.0);
        println!("at 16 and 32: {far:?}");
        assert!(far.iter().all(|off| (-0.25..0.0).contains(off)), "{far:?}");
    }

    #[test]
    fn k_is_refitted_to_what_is_rougher_or_smoother_than_nature() {
        let mut rng = fastrand::Rng::with_seed(5);
        let noise: Vec<u8> = (0..128 * 128)
            .flat_map(|_| [rng.u8(..), 0, 0, 255])
            .collect();
        let ramp: Vec<u8> = (0..128u32 * 128)
            .flat_map(|i| [(i % 128) as u8, (i % 128) as u8, 0, 255])
            .collect();
        let rough = refit_k(&Luma::from_rgba8(128, 128, &noise)).expect("differences");
        let smooth = refit_k(&Luma::from_rgba8(128, 128, &ramp)).expect("differences");
        assert!(rough < 2.126 && 2.126 < smooth, "{rough} {smooth}");
        assert_eq!(refit_k(&Luma::from_rgba8(8, 8, &[9; 256])), None);
    }
}
