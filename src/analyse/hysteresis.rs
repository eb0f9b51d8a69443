//! Stability: the analysis looks at pictures that its own rates made coarse (Yang et al., I3D 2019, §5.4).
//!
//! The paper leaves ε open. Here it follows from the norm: on a ramp, a rate of 2 or 4 multiplies the measured error by the
//! norm's [`gain`]. A rate taken at E < t (1 − ε) then measures g E, and stays if g E < t (1 + ε): so
//! (1 + ε) / (1 − ε) = g, and ε = (g − 1) / (g + 1).

use super::settings::Norm;

/// What copies of 2^`log2` pixels do to the error that is measured on a ramp: 1, √2 and 2 for a half rate; 1, 2 and 4 for a
/// quarter (L1, L2, L∞).
pub fn gain(norm: Norm, log2: u8) -> f64 {
    let copies = f64::from(1u32 << log2.min(2));
    match norm {
        Norm::L1 | Norm::Root => 1.0,
        Norm::L2 => copies.sqrt(),
        Norm::LInf => copies,
    }
}

/// ε of t± = t (1 ± ε) for a rate of 2^`log2`: 0, 0.172 and 1/3 for a half rate, 0, 1/3 and 0.6 for a quarter.
pub fn epsilon(norm: Norm, log2: u8) -> f64 {
    let g = gain(norm, log2);
    (g - 1.0) / (g + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn e15_epsilon_follows_from_the_gain_on_a_ramp() {
        for (norm, half, quarter) in [
            (Norm::L1, 0.0, 0.0),
            (Norm::L2, 0.1716, 1.0 / 3.0),
            (Norm::LInf, 1.0 / 3.0, 0.6),
        ] {
            assert!((epsilon(norm, 1) - half).abs() < 1e-4);
            assert!((epsilon(norm, 2) - quarter).abs() < 1e-4);
        }
    }

    #[test]
    fn e15_gains_are_those_of_duplicated_ramps() {
        let ramp: Vec<f64> = (0..16_384).map(f64::from).collect();
        for log2 in [1u8, 2] {
            let coarse: Vec<f64> = (0..ramp.len()).map(|i| ramp[i >> log2 << log2]).collect();
            let errors = |signal: &[f64]| {
                let d: Vec<f64> = signal
                    .windows(2)
                    .map(|p| (p[1] - p[0]).abs() / 2.0)
                    .collect();
                let n = d.len() as f64;
                [
                    d.iter().sum::<f64>() / n,
                    (d.iter().map(|x| x * x).sum::<f64>() / n).sqrt(),
                    d.iter().copied().fold(0.0, f64::max),
                ]
            };
            let (before, after) = (errors(&ramp), errors(&coarse));
            for (index, norm) in [Norm::L1, Norm::L2, Norm::LInf].into_iter().enumerate() {
                let measured = after[index] / before[index];
                assert!(
                    (measured - gain(norm, log2)).abs() < 1e-3,
                    "{norm:?} {measured}"
                );
            }
        }
    }
}
