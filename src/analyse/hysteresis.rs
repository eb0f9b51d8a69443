//! Stability: the analysis looks at pictures that its own rates made coarse (Yang et al., I3D 2019, §5.4).
//!
//! The paper leaves ε open. Here it follows from the norm and the window: on a ramp, a rate of 2 or 4 makes the error over its threshold
//! g times as large ([`swell`]). A rate taken at E < t (1 − ε) then measures g E, and stays if g E < t (1 + ε): so
//! (1 + ε) / (1 − ε) = g, and ε = (g − 1) / (g + 1).
//!
//! On an endless ramp g is the norm's [`gain`]. A quad's window is not endless: of its three steps in a row two lie on the borders of
//! coarse pixels, not one and a half, so that even L1 has a gain, 4/3; a tile of 16 pixels has 7 of 15, and L1 14/15 there; and copies of a group's first pixel move the window's mean, and
//! with it the threshold. With the endless ramp's ε, ramps by L1 swing for ever (`tests/hard_cases`, E15).

use super::settings::{Content, Form, Granularity, Norm, Pairs};

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

/// What copies of 2^`log2` pixels do to a ramp's error in a quad's window, or in a tile. Sets of pairs that look only into the quad see
/// none of its borders: they cannot tell what was lost, and have a gain of 1 here.
pub fn window_gain(norm: Norm, pairs: Pairs, granularity: Granularity, log2: u8) -> f64 {
    let side = f64::from(granularity.side());
    // borders of coarse pixels in a tile's row
    let borders = side / f64::from(1u32 << log2.min(2)) - 1.0;
    // the share of steps that lie on borders of coarse pixels, and how high each is
    let (share, height) = match (pairs, log2, granularity) {
        (_, 0, _) | (Pairs::SubSampled | Pairs::Quad, ..) => return 1.0,
        // over two pixels, so that one border lies in each
        (Pairs::Sobel, 1, _) => (1.0, 1.0),
        (Pairs::Sobel, _, Granularity::Quad) => (0.5, 2.0),
        (Pairs::Sobel, ..) => (2.0 * borders / (side - 2.0), 2.0),
        (_, 1, Granularity::Quad) => (2.0 / 3.0, 2.0),
        (_, _, Granularity::Quad) => (1.0 / 3.0, 4.0),
        (_, 1, _) => (borders / (side - 1.0), 2.0),
        (_, _, _) => (borders / (side - 1.0), 4.0),
    };
    let mean: f64 = share * height;
    match norm {
        Norm::L1 => mean,
        Norm::L2 => (share * height * height).sqrt(),
        Norm::LInf if share == 0.0 => 0.0,
        Norm::LInf => height,
        Norm::Root => mean.sqrt(),
    }
}

/// How much a rate of 2^`log2` swells a ramp's error over its threshold, at the threshold: [`window_gain`], and the mean of a window
/// that copies of each group's first pixel make darker by 1/2 and 3/2 steps.
pub fn swell(content: &Content, granularity: Granularity, log2: u8) -> f64 {
    let steps = match log2 {
        0 => 0.0,
        1 => 0.5,
        _ => 1.5 / content.k,
    };
    let darker = match content.form {
        // a step at the threshold is twice t times the base
        Form::Window | Form::Pairwise { .. } => (2.0 * content.threshold * steps).min(0.5),
        Form::Absolute => 0.0,
    };
    window_gain(content.norm, content.pairs, granularity, log2) / (1.0 - darker)
}

/// ε of t± = t (1 ± ε) for a rate of 2^`log2`; 0 where a coarse rate makes the error smaller, which swings nothing.
pub fn epsilon(content: &Content, granularity: Granularity, log2: u8) -> f64 {
    let g = swell(content, granularity, log2);
    ((g - 1.0) / (g + 1.0)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn e15_gains_of_a_window_are_those_of_its_own_sixteen_pixels() {
        use crate::analyse::{Colour, Inputs, Settings, exact};
        // twice a coarse ramp's threshold by its gain: just above it is fine, just below coarse
        for norm in [Norm::L1, Norm::L2, Norm::LInf, Norm::Root] {
            for pairs in [Pairs::All, Pairs::Interleaved, Pairs::Sobel] {
                for (log2, granularity) in [1u8, 2]
                    .into_iter()
                    .flat_map(|log2| Granularity::ALL.map(|granularity| (log2, granularity)))
                {
                    let gain = window_gain(norm, pairs, granularity, log2);
                    if gain == 0.0 {
                        // a tile as large as the coarse pixel shows nothing of the ramp
                        assert_eq!((granularity, log2), (Granularity::Tile4, 2));
                        continue;
                    }
                    let code = |share: f64| {
                        let step = 0.02;
                        let ramp: Vec<[f32; 4]> = (0..1024u32)
                            .map(|i| {
                                [(0.1 + step * f64::from(((i % 32) >> log2) << log2)) as f32; 4]
                            })
                            .collect();
                        let error = match norm {
                            Norm::Root => (step / 2.0).sqrt(),
                            _ => step / 2.0,
                        };
                        let content = Content {
                            norm,
                            pairs,
                            form: Form::Absolute,
                            threshold: error * gain * share,
                            ..Content::default()
                        };
                        let settings = Settings {
                            content,
                            granularity,
                            ..Settings::default()
                        };
                        let inputs = Inputs::of_colour([32, 32], Colour::Linear(&ramp));
                        let found = exact::analyse(&inputs, &settings).expect("inputs that fit");
                        found.output.sri.code(8, 8) >> 2
                    };
                    assert_eq!(
                        (code(0.99), code(1.01)),
                        (0, 1),
                        "{norm:?} {pairs:?} {log2} {granularity:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn e15_epsilon_follows_from_the_gain_on_a_ramp() {
        let of = |norm, log2| {
            let content = Content {
                norm,
                form: Form::Absolute,
                ..Content::default()
            };
            epsilon(&content, Granularity::Quad, log2)
        };
        for (norm, half, quarter) in [
            (Norm::L1, 1.0 / 7.0, 1.0 / 7.0),
            (Norm::L2, 0.2404, 0.3957),
            (Norm::LInf, 1.0 / 3.0, 0.6),
        ] {
            assert!((of(norm, 1) - half).abs() < 1e-4, "{}", of(norm, 1));
            assert!((of(norm, 2) - quarter).abs() < 1e-4, "{}", of(norm, 2));
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
