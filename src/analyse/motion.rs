//! Motion: how much of the error a blur hides (Yang et al., I3D 2019, §4).
//!
//! Speeds are in pixels a frame. *Guarantees*: every function is even, never grows with speed, stays within its bounds
//! from 0 to infinity, and takes what is no number as standing still.

use super::{
    fixed,
    settings::{Blur, Ladder},
};
use crate::Rate;

/// b_H(v), the share of the half-rate error that remains visible (Eq. 20): 1 at rest.
pub fn half(speed: f64) -> f64 {
    (1.0 / (1.0 + (1.05 * still(speed)).powf(3.10))).powf(0.35)
}

/// b_Q(v), the same for the quarter rate, in units of the half-rate error (Eq. 21): k at rest; the paper's k is 2.13.
pub fn quarter(speed: f64, k: f64) -> f64 {
    k * (1.0 / (1.0 + (0.55 * still(speed)).powf(2.41))).powf(0.49)
}

fn still(speed: f64) -> f64 {
    match speed.is_nan() {
        true => 0.0,
        false => speed.abs(),
    }
}

/// b_H and b_Q by Intel VALAR's straight lines, which hold up to 16 pixels a frame; beyond, as there.
pub fn linear(speed: f64, k: f64) -> [f64; 2] {
    let speed = still(speed).min(16.0);
    [1.0 - 0.0596 * speed, (k - 0.1229 * speed).max(0.0)]
}

/// The speed from which on a half rate may be used without looking at the content: b_H(v) < t / e (Eq. 24), solved for v. 0
/// where any will do.
pub fn standalone_speed(threshold: f64, error: f64) -> f64 {
    let ratio = (error / threshold).powf(1.0 / 0.35) - 1.0;
    ratio.max(0.0).powf(1.0 / 3.10) / 1.05
}

/// Wicked Engine's rate for a speed in pictures a frame; what is no number is at rest.
pub fn ladder(speed: f64, steps: &Ladder) -> Rate {
    match speed {
        v if v >= steps.r4x4 => Rate::R4X4,
        v if v >= steps.r4x2 => Rate::R4X2,
        v if v >= steps.r2x2 => Rate::R2X2,
        v if v >= steps.r2x1 => Rate::R2X1,
        _ => Rate::R1X1,
    }
}

/// The rates of [`Ladder`], from slow to fast.
pub const LADDER: [Rate; 5] = [Rate::R1X1, Rate::R2X1, Rate::R2X2, Rate::R4X2, Rate::R4X4];

/// Entries of the table of speeds: 1/16 pixel each, the last for all that is faster.
pub const SPEEDS: u32 = 1024;

/// A speed on one axis as an index of the table, rounded to slow; what is no number is 0. `scale` is at least 0.
pub fn speed_index(vector: f32, scale: f32) -> u32 {
    let bits = vector.to_bits() & 0x7fff_ffff;
    if bits > 0x7f80_0000 {
        return 0;
    }
    let sixteenths = f32::from_bits(bits) * scale;
    match sixteenths < (SPEEDS - 1) as f32 {
        true => sixteenths as u32,
        false => SPEEDS - 1,
    }
}

/// The speed of an index, in pixels a frame.
pub fn speed_at(index: u32) -> f64 {
    f64::from(index) / 16.0
}

/// The deterministic path's table: b_H and b_Q as factors, rounded up, never 0: `b_H | b_Q << 16`. Where motion alone
/// decides, 1 where the speed allows the rate and 0 where it does not ([`Blur::Standalone`]), or the step of the ladder, 0 to
/// 4, for speeds in 1/8192 picture ([`Blur::Ladder`]).
pub fn table(blur: Option<Blur>, threshold: f64, k: f64) -> Vec<u32> {
    (0..SPEEDS)
        .map(|index| {
            let speed = speed_at(index);
            let (h, q) = match blur {
                None => (fixed::factor_up(1.0), fixed::factor_up(k)),
                Some(Blur::Scaled) => (
                    fixed::factor_up(half(speed)),
                    fixed::factor_up(quarter(speed, k)),
                ),
                Some(Blur::Linear) => {
                    let [half, quarter] = linear(speed, k);
                    (fixed::factor_up(half), fixed::factor_up(quarter).max(1))
                }
                Some(Blur::Ladder(steps)) => {
                    let step = ladder(f64::from(index) / 8192.0, &steps);
                    let index = LADDER.iter().position(|&rate| rate == step);
                    (index.unwrap_or_default() as u32, 0)
                }
                Some(Blur::Standalone { error }) => {
                    let allowed = |b: f64| u32::from(b * error < threshold);
                    (allowed(half(speed)), allowed(quarter(speed, k)))
                }
            };
            h | q << 16
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_the_standalone_example_gives_2_86_pixels() {
        // §4.2: t = 0.03, e = 0.1; the paper reads 2.8 off its plot
        let speed = standalone_speed(0.03, 0.1);
        assert!((speed - 2.86).abs() < 0.01, "{speed}");
        assert!((half(speed) - 0.3).abs() < 1e-9);
        assert_eq!(
            standalone_speed(0.2, 0.1),
            0.0,
            "the error is below t at rest"
        );
    }

    #[test]
    fn paper_b_h_and_b_q_at_rest_are_1_and_k() {
        assert_eq!(half(0.0), 1.0);
        assert_eq!(quarter(0.0, 2.13), 2.13);
        // §4.2 by the fit, and its quarter rate
        assert!((half(2.8) - 0.307).abs() < 0.001, "{}", half(2.8));
    }

    #[test]
    fn e10_e11_scalers_fall_from_rest_to_infinity_and_are_even() {
        let speeds = [
            0.0,
            1e-40,
            0.5,
            1.0,
            34.0,
            35.0,
            181.0,
            182.0,
            1e4,
            1e30,
            1e300,
            f64::INFINITY,
        ];
        for (f, most) in [
            (half as fn(f64) -> f64, 1.0),
            ((|v| quarter(v, 2.13)) as fn(f64) -> f64, 2.13),
        ] {
            let mut last = most;
            for v in speeds {
                let b = f(v);
                assert!((0.0..=last).contains(&b), "b({v}) = {b}");
                assert_eq!(b, f(-v));
                last = b;
            }
            assert_eq!(f(f64::NAN), most);
        }
        let table = table(Some(Blur::Scaled), 0.15, 2.13);
        for pair in table.windows(2) {
            assert!(pair[1] & 0xffff <= pair[0] & 0xffff && pair[1] >> 16 <= pair[0] >> 16);
        }
        assert!(
            table
                .iter()
                .all(|entry| entry & 0xffff > 0 && entry >> 16 > 0)
        );
    }

    #[test]
    fn e10_speeds_saturate_and_no_number_stands_still() {
        assert_eq!(speed_index(f32::NAN, 16.0), 0);
        assert_eq!(speed_index(f32::INFINITY, 16.0), SPEEDS - 1);
        assert_eq!(speed_index(-2.0, 16.0), 32);
        assert_eq!(speed_index(1e30, 16.0), SPEEDS - 1);
        assert_eq!(speed_index(1e-40, 16.0), 0);
    }

    #[test]
    fn wicked_the_ladder_has_its_steps() {
        let steps = Ladder::default();
        let rates = [0.0, 0.001, 0.005, 0.01, 0.1, f64::NAN].map(|v| ladder(v, &steps));
        assert_eq!(
            rates,
            [
                Rate::R1X1,
                Rate::R2X1,
                Rate::R2X2,
                Rate::R4X2,
                Rate::R4X4,
                Rate::R1X1
            ]
        );
    }
}
