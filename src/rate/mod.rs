//! Shading rates, the lattice that they form, and the functions that combine them.
//!
//! A rate W×H says that a block of W pixels by H is shaded once. Codes are those of D3D12 and `VK_KHR_fragment_shading_rate`,
//! `(log2 W << 2) | log2 H`. Rates are combined axis by axis: the finer of 4x2 and 2x4 is 2x2, while the smaller of
//! their codes would be 2x4.
//!
//! 4x1 and 1x4 are no rates: hardware leaves them undefined. [`meet`](Rate::meet) and [`join`](Rate::join) never lead there.
//! Sums do, and so do axes that are decided one by one; [`Rate::from_log2`] states the one rule by which they are resolved.
//!
//! [`WGSL`] is the same algebra for kernels; a test holds both equal on a driver, over every pair of bytes.

mod combine;

use std::fmt;

pub use combine::{Combiner, LargestAxis, effective};

use vrcs_passes::options::MaxRate;

/// This algebra in WGSL, a module for naga_oil: `#import vrcs::rate`. Codes are `u32`s there.
pub const WGSL: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/rate.wgsl"));

/// A shading rate.
///
/// 4x1 and 1x4 do not exist: hardware leaves them undefined, and no operation here gives them.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rate(u8);

impl Rate {
    /// Every pixel is shaded.
    pub const R1X1: Rate = Rate(0);
    /// Once for 1 pixel across, 2 down.
    pub const R1X2: Rate = Rate(1);
    /// Once for 2 pixels across, 1 down.
    pub const R2X1: Rate = Rate(4);
    /// Once for 2 pixels across, 2 down.
    pub const R2X2: Rate = Rate(5);
    /// Once for 2 pixels across, 4 down.
    pub const R2X4: Rate = Rate(6);
    /// Once for 4 pixels across, 2 down.
    pub const R4X2: Rate = Rate(9);
    /// Once for 4 pixels across, 4 down.
    pub const R4X4: Rate = Rate(10);

    /// All rates, from fine to coarse.
    pub const ALL: [Rate; 7] = [
        Rate::R1X1,
        Rate::R1X2,
        Rate::R2X1,
        Rate::R2X2,
        Rate::R2X4,
        Rate::R4X2,
        Rate::R4X4,
    ];

    /// The rate with a code; `None` if there is none.
    pub fn from_code(code: u8) -> Option<Rate> {
        Rate::ALL.into_iter().find(|rate| rate.0 == code)
    }

    /// The rate with a code; full rate if there is none. Any doubt means full rate.
    pub fn from_code_or_full(code: u8) -> Rate {
        Rate::from_code(code).unwrap_or(Rate::R1X1)
    }

    /// The code, `(log2 W << 2) | log2 H`.
    pub const fn code(self) -> u8 {
        self.0
    }

    /// Pixels across: 1, 2 or 4.
    pub const fn width(self) -> u32 {
        1 << (self.0 >> 2)
    }

    /// Pixels down: 1, 2 or 4.
    pub const fn height(self) -> u32 {
        1 << (self.0 & 3)
    }

    /// Pixels that are shaded at once: 1, 2, 4, 8 or 16.
    pub const fn pixels(self) -> u32 {
        self.width() * self.height()
    }

    /// The two axes, as `[log2 W, log2 H]`.
    pub const fn log2(self) -> [u32; 2] {
        [(self.0 >> 2) as u32, (self.0 & 3) as u32]
    }

    /// The rate for two axes that were decided one by one, as `[log2 W, log2 H]`.
    ///
    /// What is no rate becomes the coarsest rate that is coarser on neither axis. So an axis of 8 or more pixels falls to 4, and
    /// an axis of 4 falls to 2 where the other is 1: 4x1 becomes 2x1, and 1x4 becomes 1x2, as in NVIDIA's sample of adaptive
    /// shading, and as Vulkan's clamp gives it (§ "Combining the Fragment Shading Rates").
    pub fn from_log2(axes: [u32; 2]) -> Rate {
        let [width, height] = axes.map(|axis| axis.min(2));
        // beside an axis of 1 pixel there is room for 2, beside any other for 4
        Rate::of_axes(width.min(height + 1) as u8, height.min(width + 1) as u8)
    }

    /// The same rate in the transposed picture.
    pub fn transposed(self) -> Rate {
        Rate::of_axes(self.0 & 3, self.0 >> 2)
    }

    fn of_axes(log_width: u8, log_height: u8) -> Rate {
        Rate(log_width << 2 | log_height)
    }

    /// The lattice meet: on each axis the finer of the two. At least as fine as both.
    ///
    /// Never 4x1 or 1x4: an axis of 4 is one of both, and neither has a 1 beside it.
    pub fn meet(self, other: Rate) -> Rate {
        Rate::of_axes(
            (self.0 >> 2).min(other.0 >> 2),
            (self.0 & 3).min(other.0 & 3),
        )
    }

    /// The lattice join: on each axis the coarser of the two. At least as coarse as both.
    ///
    /// Never 4x1 or 1x4: an axis of 4 comes with at least 2 beside it.
    pub fn join(self, other: Rate) -> Rate {
        Rate::of_axes(
            (self.0 >> 2).max(other.0 >> 2),
            (self.0 & 3).max(other.0 & 3),
        )
    }

    /// Whether this rate is at least as fine as another, on both axes.
    pub fn is_within(self, other: Rate) -> bool {
        self.meet(other) == self
    }
}

impl From<MaxRate> for Rate {
    fn from(largest: MaxRate) -> Rate {
        match largest {
            MaxRate::R2x2 => Rate::R2X2,
            MaxRate::R2x4 => Rate::R2X4,
            MaxRate::R4x2 => Rate::R4X2,
            MaxRate::R4x4 => Rate::R4X4,
        }
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width(), self.height())
    }
}

impl fmt::Debug for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// An unknown rate's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a shading rate; the rates are 1x1, 1x2, 2x1, 2x2, 2x4, 4x2 and 4x4")]
pub struct UnknownRate(String);

impl std::str::FromStr for Rate {
    type Err = UnknownRate;

    fn from_str(name: &str) -> Result<Rate, UnknownRate> {
        Rate::ALL
            .into_iter()
            .find(|rate| rate.to_string() == name)
            .ok_or_else(|| UnknownRate(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs() -> impl Iterator<Item = (Rate, Rate)> {
        Rate::ALL
            .into_iter()
            .flat_map(|a| Rate::ALL.into_iter().map(move |b| (a, b)))
    }

    #[test]
    fn codes_are_those_of_d3d12_and_vulkan() {
        let codes: Vec<u8> = Rate::ALL.iter().map(|rate| rate.code()).collect();
        assert_eq!(codes, [0x0, 0x1, 0x4, 0x5, 0x6, 0x9, 0xA]);
    }

    #[test]
    fn meet_is_per_axis_and_no_integer_minimum() {
        assert_eq!(Rate::R2X4.meet(Rate::R4X2), Rate::R2X2);
        assert_eq!(Rate::R1X2.meet(Rate::R2X1), Rate::R1X1);
        assert_eq!(Rate::R2X4.code().min(Rate::R4X2.code()), Rate::R2X4.code());
    }

    #[test]
    fn meet_and_join_are_a_lattice_that_is_closed_without_4x1_and_1x4() {
        for (a, b) in pairs() {
            for rate in [a.meet(b), a.join(b)] {
                assert!(
                    Rate::ALL.contains(&rate),
                    "{a} and {b} give {:#x}",
                    rate.code()
                );
            }
            assert_eq!(a.meet(b), b.meet(a));
            assert_eq!(a.join(b), b.join(a));
            assert_eq!((a.meet(a), a.join(a)), (a, a));
            assert_eq!(a.meet(a.join(b)), a);
            assert_eq!(a.join(a.meet(b)), a);
            assert!(a.meet(b).is_within(a) && a.is_within(a.join(b)));
            for c in Rate::ALL {
                assert_eq!(a.meet(b).meet(c), a.meet(b.meet(c)));
                assert_eq!(a.join(b).join(c), a.join(b.join(c)));
            }
        }
    }

    #[test]
    fn meet_and_join_commute_with_transposition() {
        for (a, b) in pairs() {
            let (ta, tb) = (a.transposed(), b.transposed());
            assert_eq!(a.meet(b).transposed(), ta.meet(tb));
            assert_eq!(a.join(b).transposed(), ta.join(tb));
        }
        assert_eq!(Rate::R4X2.transposed(), Rate::R2X4);
    }

    #[test]
    fn axes_that_make_a_rate_are_that_rate() {
        for rate in Rate::ALL {
            assert_eq!(Rate::from_log2(rate.log2()), rate);
            assert_eq!(rate.pixels(), rate.width() * rate.height());
        }
    }

    #[test]
    fn axes_that_make_no_rate_become_the_coarsest_rate_that_is_coarser_on_neither() {
        for (width, height) in (0..6).flat_map(|w| (0..6).map(move |h| (w, h))) {
            let rate = Rate::from_log2([width, height]);
            let fits = |rate: &Rate| rate.log2()[0] <= width && rate.log2()[1] <= height;
            assert!(fits(&rate), "{width} {height}: {rate}");
            for other in Rate::ALL.into_iter().filter(fits) {
                assert!(
                    other.is_within(rate),
                    "{width} {height}: {rate}, not {other}"
                );
            }
        }
        assert_eq!(Rate::from_log2([2, 0]), Rate::R2X1, "4x1");
        assert_eq!(Rate::from_log2([0, 2]), Rate::R1X2, "1x4");
    }

    #[test]
    fn bytes_that_are_no_code_mean_full_rate() {
        for byte in 0..=255u8 {
            let rate = Rate::from_code_or_full(byte);
            assert!(rate.code() == byte || rate == Rate::R1X1);
        }
        assert_eq!(Rate::from_code(2), None, "1x4");
        assert_eq!(Rate::from_code(8), None, "4x1");
    }
}
