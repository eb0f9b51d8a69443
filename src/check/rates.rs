//! Shading rates to check with: uniform ones, random ones, and ones made to go wrong.

use fastrand::Rng;

use crate::{Rate, sri::Sri};

/// A way to fill a shading-rate image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// The same rate everywhere.
    Uniform(Rate),
    /// Each quad on its own, all rates alike.
    Noise,
    /// Each aligned block of 4×4 pixels on its own, all rates alike: 4-wide rates hold.
    Blocks,
    /// Each quad on its own, most of them coarse.
    MostlyCoarse,
    /// Each quad on its own, most of them full: tiles on either side of the nearly-full rule.
    MostlyFull,
    /// Patches of one rate, of random size.
    Patches,
    /// Full and coarse quads in turn.
    Checkerboard,
    /// Any byte, most of which are no code.
    Garbage,
    /// Coarse, but for one quad.
    OneFull,
    /// Full, but for one quad.
    OneCoarse,
}

impl Pattern {
    /// The pattern of a case: the uniform ones first, then the others in turn.
    pub fn of_case(case: u32, largest: Rate) -> Pattern {
        let uniform: Vec<Rate> = Rate::ALL
            .into_iter()
            .filter(|rate| rate.is_within(largest))
            .collect();
        match uniform.get(case as usize) {
            Some(&rate) => Pattern::Uniform(rate),
            None => match (case as usize - uniform.len()) % 9 {
                0 => Pattern::Noise,
                1 => Pattern::MostlyCoarse,
                2 => Pattern::MostlyFull,
                3 => Pattern::Patches,
                4 => Pattern::Checkerboard,
                5 => Pattern::Garbage,
                6 => Pattern::OneFull,
                7 => Pattern::Blocks,
                _ => Pattern::OneCoarse,
            },
        }
    }

    /// An image of this pattern for a picture of `width` × `height` pixels.
    pub fn image(self, width: u32, height: u32, rng: &mut Rng) -> Sri {
        let quads = [width.div_ceil(2), height.div_ceil(2)];
        let coarsest = [Rate::R2X2, Rate::R2X4, Rate::R4X2, Rate::R4X4][rng.usize(..4)];
        let odd_one = [rng.u32(0..quads[0]), rng.u32(0..quads[1])];
        match self {
            Pattern::Uniform(rate) => Sri::uniform(width, height, rate),
            Pattern::Noise => Sri::from_fn(width, height, |_, _| any(rng)),
            Pattern::MostlyCoarse => Sri::from_fn(width, height, |_, _| match rng.u8(0..8) {
                0 => any(rng),
                _ => coarsest.code(),
            }),
            Pattern::MostlyFull => {
                // about 224 of 256 primaries remain where one quad in six is coarse
                let one_in = rng.u8(3..12);
                Sri::from_fn(width, height, |_, _| match rng.u8(0..one_in) {
                    0 => any(rng),
                    _ => Rate::R1X1.code(),
                })
            }
            Pattern::Patches => patches(width, height, rng.u32(1..9), rng),
            Pattern::Blocks => patches(width, height, 2, rng),
            Pattern::Checkerboard => {
                let coarse = any(rng);
                Sri::from_fn(width, height, |x, y| match (x + y) % 2 {
                    0 => coarse,
                    _ => Rate::R1X1.code(),
                })
            }
            Pattern::Garbage => Sri::from_fn(width, height, |_, _| rng.u8(..)),
            Pattern::OneFull => Sri::from_fn(width, height, |x, y| match [x, y] == odd_one {
                true => Rate::R1X1.code(),
                false => coarsest.code(),
            }),
            Pattern::OneCoarse => {
                let coarse = any(rng);
                Sri::from_fn(width, height, |x, y| match [x, y] == odd_one {
                    true => coarse,
                    false => Rate::R1X1.code(),
                })
            }
        }
    }
}

fn any(rng: &mut Rng) -> u8 {
    Rate::ALL[rng.usize(..Rate::ALL.len())].code()
}

/// Patches of `size` quads on a side, each of one rate.
fn patches(width: u32, height: u32, size: u32, rng: &mut Rng) -> Sri {
    let key = rng.u64(..);
    Sri::from_fn(width, height, |x, y| {
        let patch = u64::from(x / size) << 32 | u64::from(y / size);
        any(&mut Rng::with_seed(
            key ^ patch.wrapping_mul(0x9e37_79b9_7f4a_7c15),
        ))
    })
}
