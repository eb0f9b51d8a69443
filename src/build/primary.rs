//! Which pixel of a block comes first, and how that changes from frame to frame ("Rotating Pixels").
//!
//! The slides: "Improvement for 1x2 and 2x1 rate, flip the checkerboard; 2x2 rate requires 4 frames to converge = 15hz = too slow; instead,
//! alternate primary pixel between top left and bottom right; + ping pong sequence for 3 covered pixels".
//!
//! An order is a *flip*: pixels are visited by ascending `place XOR flip`, where a pixel's place in its aligned 4×4 block is
//! `(y & 3) * 4 + (x & 3)`. Any covered pixel comes first under some flip, and a primary is always one of its own group.

use crate::rate::Rate;

/// How primaries are chosen in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The first pixel, in every frame.
    #[default]
    Fixed,
    /// By the frame's number.
    Rotating(u32),
}

impl Order {
    /// How many [codes](Order::code) there are.
    pub const CODES: usize = 5;

    /// An order of each code.
    pub fn all() -> [Order; Order::CODES] {
        std::array::from_fn(|code| match code {
            0 => Order::Fixed,
            _ => Order::Rotating(code as u32 - 1),
        })
    }

    /// The code in headers and parameters: 0, or 1 to 4.
    pub fn code(self) -> u32 {
        match self {
            Order::Fixed => 0,
            Order::Rotating(frame) => 1 + (frame & 3),
        }
    }

    /// The flip of a block whose first corner is a pixel of the picture, and whose pixels that are not sky are `covered` of the
    /// block.
    pub fn flip(self, rate: Rate, corner: [u32; 2], covered: u32) -> u32 {
        let Order::Rotating(frame) = self else {
            return 0;
        };
        let odd = frame & 1;
        match rate {
            // a checkerboard, since neighbouring rows start with the other pixel
            Rate::R2X1 => (corner[1] + odd) & 1,
            Rate::R1X2 => ((corner[0] + odd) & 1) << 2,
            Rate::R2X2 if covered.count_ones() == 3 => {
                let turn = [0, 1, 2, 1][(frame & 3) as usize];
                let nth = (0..16).filter(|bit| covered >> bit & 1 != 0).nth(turn);
                // within the quad
                nth.map_or(0, |place| place as u32 & 5)
            }
            _ => odd * ((rate.width() - 1) | (rate.height() - 1) << 2),
        }
    }

    /// The pixel of `left` that comes first.
    pub fn first(left: u32, flip: u32) -> u32 {
        let key = |place: u32| place ^ flip;
        (0..16)
            .filter(|place| left >> place & 1 != 0)
            .min_by_key(|&place| key(place))
            .unwrap_or(0)
    }
}
