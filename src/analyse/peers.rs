//! What others decide by, as settings of this stage: to be compared on the same pictures, by the same kernel.
//!
//! *Guarantees*: each is the estimator that its source describes or ships, with the constants that it ships. *Refuses*: nothing.
//! Defects are not copied (`research`: NAS' smoothing with its axes swapped, FidelityFX' decimated tiles, VALAR's lines that
//! fall below 0); where ours has no such knob, the doc comment says what is left out.

use super::settings::{
    Blur, Content, Form, Ladder, Motion, Norm, Pairs, Settings, Smoothing, Transfer, Weights,
};
use crate::Rate;

/// A published estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Peer {
    /// Yang et al., I3D 2019, §3: L2 over all pairs, t = 0.15, l = 0.05, k = 2.13.
    Paper,
    /// GDC 2019 (Wolfenstein II), pass 1: mean of Weber–Fechner differences, `c²` for sRGB, every other pair; pass 3: only fine
    /// spreads. Its tile is 16×16; here, the quad's window.
    Gdc,
    /// NVIDIA's `nas-sample`: the largest difference, t = 0.07, l = 0.1, half the motion, limits between neighbours.
    NvidiaSample,
    /// AMD FidelityFX Variable Shading: the quad's own range against a fixed cutoff of encoded luma. Without the range's diagonals and
    /// without the cutoff's growth with motion.
    FidelityFx,
    /// Intel VALAR, balanced: the root of the mean difference of Rec. 709 luma by `c²`, t = 0.5, l = 0.02, motion by straight lines.
    /// Its speed is the length of the vector, ours that of each axis.
    Valar,
    /// Sobel's filter of Rec. 709 luma against a fixed threshold of 0.02 for each axis (Monsho's VisibilityBuffer), the largest of the quad.
    Sobel,
    /// Wicked Engine: motion alone, by its ladder.
    Wicked,
}

impl Peer {
    /// All.
    pub const ALL: [Peer; 7] = [
        Peer::Paper,
        Peer::Gdc,
        Peer::NvidiaSample,
        Peer::FidelityFx,
        Peer::Valar,
        Peer::Sobel,
        Peer::Wicked,
    ];

    /// Its name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Peer::Paper => "paper",
            Peer::Gdc => "gdc",
            Peer::NvidiaSample => "nvidia-sample",
            Peer::FidelityFx => "fidelityfx",
            Peer::Valar => "valar",
            Peer::Sobel => "sobel",
            Peer::Wicked => "wicked",
        }
    }

    /// Its settings. With motion vectors in pixels a frame, those that use motion use it; without, only [`Peer::Wicked`] asks for it.
    pub fn settings(self, has_motion: bool) -> Settings {
        let motion = |blur, weight| {
            has_motion.then(|| Motion {
                blur,
                weight,
                ..Motion::default()
            })
        };
        let content = Content::default();
        match self {
            Peer::Paper => Settings {
                motion: motion(Blur::Scaled, 1.0),
                ..Settings::default()
            },
            Peer::Gdc => Settings {
                content: Content {
                    norm: Norm::L1,
                    pairs: Pairs::Interleaved,
                    transfer: Transfer::Square,
                    form: Form::Pairwise { sensitivity: 0.05 },
                    ..content
                },
                motion: motion(Blur::Scaled, 1.0),
                smoothing: Smoothing::Conservative,
                ..Settings::default()
            },
            Peer::NvidiaSample => Settings {
                content: Content {
                    norm: Norm::LInf,
                    pairs: Pairs::Interleaved,
                    threshold: 0.07,
                    ambient: 0.1,
                    ..content
                },
                motion: motion(Blur::Scaled, 0.5),
                smoothing: Smoothing::Limit,
                ..Settings::default()
            },
            Peer::FidelityFx => Settings {
                content: Content {
                    norm: Norm::LInf,
                    pairs: Pairs::Quad,
                    form: Form::Absolute,
                    // the range is twice a half step
                    threshold: 0.05 / 2.0,
                    ..content
                },
                ..Settings::default()
            },
            Peer::Valar => Settings {
                content: Content {
                    norm: Norm::Root,
                    transfer: Transfer::Square,
                    weights: Weights::Rec709,
                    threshold: 0.5,
                    ambient: 0.02,
                    ..content
                },
                motion: motion(Blur::Linear, 1.0),
                ..Settings::default()
            },
            Peer::Sobel => Settings {
                content: Content {
                    norm: Norm::LInf,
                    pairs: Pairs::Sobel,
                    weights: Weights::Rec709,
                    form: Form::Absolute,
                    // Sobel's sum is eight steps, the error half of one
                    threshold: 0.02 / 16.0,
                    ..content
                },
                ..Settings::default()
            },
            Peer::Wicked => Settings {
                motion: Some(Motion {
                    blur: Blur::Ladder(Ladder::default()),
                    ..Motion::default()
                }),
                largest: Rate::R4X4,
                ..Settings::default()
            },
        }
    }
}

impl std::str::FromStr for Peer {
    type Err = String;

    fn from_str(name: &str) -> Result<Peer, String> {
        let found = Peer::ALL.into_iter().find(|peer| peer.name() == name);
        found.ok_or_else(|| {
            let names = Peer::ALL.map(Peer::name).join(", ");
            format!("no estimator is called `{name}`; there are {names}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyse::{Colour, Inputs, exact, integer};

    /// A ramp of linear light across, `step` from pixel to pixel, and what each peer makes of it.
    fn of_ramp(peer: Peer, step: f32) -> u8 {
        let ramp: Vec<[f32; 4]> = (0..256u32)
            .map(|i| [0.3 + step * (i % 16) as f32; 4])
            .collect();
        let still = vec![[0.0; 2]; 256];
        let inputs = Inputs {
            motion: Some(&still),
            ..Inputs::of_colour([16, 16], Colour::Linear(&ramp))
        };
        let settings = peer.settings(true);
        let fixed = integer::analyse(&inputs, &settings).expect("inputs that fit");
        let real = exact::analyse(&inputs, &settings).expect("inputs that fit");
        assert_eq!(fixed.sri.code(4, 4), real.output.sri.code(4, 4), "{peer:?}");
        fixed.sri.code(4, 4)
    }

    #[test]
    fn a_plain_picture_is_coarse_by_content_and_full_by_motion_alone() {
        for peer in Peer::ALL {
            let wanted = if peer == Peer::Wicked {
                Rate::R1X1
            } else {
                Rate::R2X2
            };
            assert_eq!(of_ramp(peer, 0.0), wanted.code(), "{peer:?}");
        }
    }

    // the step at which each goes from coarse to fine, in a picture of one luma but for a line of small steps up and down
    #[test]
    fn each_changes_its_rate_where_its_own_formula_says() {
        // stripes 0.5 ± d/2: every step is d, the mean luma 0.5
        let of_stripes = |peer: Peer, d: f32| {
            let stripes: Vec<[f32; 4]> = (0..256u32)
                .map(|i| [0.5 + d * ((i % 2) as f32 - 0.5); 4])
                .collect();
            let inputs = Inputs::of_colour([16, 16], Colour::Linear(&stripes));
            let settings = peer.settings(false);
            integer::analyse(&inputs, &settings)
                .expect("inputs that fit")
                .sri
                .code(4, 4)
        };
        let cases = [
            // d / 2 = 0.15 (0.5 + 0.05)
            (Peer::Paper, 0.165),
            // d / (0.5 - d / 2) / 2 = 0.15; brightness sensitivity is 0 above 0.07
            (Peer::Gdc, 0.15 / 1.15),
            // d / 2 = 0.07 (0.5 + 0.1)
            (Peer::NvidiaSample, 0.084),
            (Peer::FidelityFx, 0.05),
            // sqrt(d / 2) = 0.5 (0.5 + 0.02)
            (Peer::Valar, 0.1352),
        ];
        for (peer, d) in cases {
            assert_eq!(of_stripes(peer, d * 0.98), Rate::R2X2.code(), "{peer:?}");
            assert_eq!(of_stripes(peer, d * 1.02), Rate::R1X2.code(), "{peer:?}");
        }
        // Sobel's filter does not see stripes of one pixel; a ramp's sum is 8 steps. So small a threshold is five steps of
        // its fixed point
        assert_eq!(of_stripes(Peer::Sobel, 0.4), Rate::R2X2.code());
        assert_eq!(of_ramp(Peer::Sobel, 0.0022), Rate::R2X2.code());
        assert_eq!(of_ramp(Peer::Sobel, 0.0028), Rate::R1X2.code());
    }

    #[test]
    fn names_lead_back_and_what_is_none_is_refused() {
        for peer in Peer::ALL {
            assert_eq!(peer.name().parse(), Ok(peer));
        }
        assert!(
            "nvidia"
                .parse::<Peer>()
                .expect_err("none")
                .contains("nvidia-sample")
        );
    }
}
