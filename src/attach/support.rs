//! What a device can shade, and the nearest to what is asked.

use std::fmt;

use crate::rate::Rate;

/// Samples for each pixel of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Samples {
    /// No multisampling.
    X1,
    /// Two.
    X2,
    /// Four.
    X4,
    /// Eight.
    X8,
    /// Sixteen.
    X16,
}

/// A sample count that no target has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a pixel has 1, 2, 4, 8 or 16 samples, not {0}")]
pub struct UnknownSampleCount(pub u32);

impl Samples {
    /// All counts.
    pub const ALL: [Samples; 5] = [
        Samples::X1,
        Samples::X2,
        Samples::X4,
        Samples::X8,
        Samples::X16,
    ];

    /// The count as a number, which is also its bit in `VkSampleCountFlags`.
    pub const fn count(self) -> u32 {
        1 << self as u32
    }
}

impl TryFrom<u32> for Samples {
    type Error = UnknownSampleCount;

    fn try_from(count: u32) -> Result<Samples, UnknownSampleCount> {
        Samples::ALL
            .into_iter()
            .find(|samples| samples.count() == count)
            .ok_or(UnknownSampleCount(count))
    }
}

/// The rates that a device supports, each with the sample counts that it supports it at.
#[derive(Clone, PartialEq, Eq)]
pub struct Support {
    /// Sample counts by the place of the rate in [`Rate::ALL`], as bits of `VkSampleCountFlags`.
    counts: [u32; 7],
}

impl Support {
    /// What Direct3D 12 guarantees of a device of tier 2: 1x2, 2x1 and 2x2 up to four samples, and with
    /// `AdditionalShadingRatesSupported` also 2x4, 4x2 and 4x4 for one sample, and 2x4 for two.
    ///
    /// Source: the specification of variable-rate shading, "List of Caps" and "Using the Shading Rate Requested".
    pub fn d3d12(additional: AdditionalRates) -> Support {
        Support::of(|rate| match (rate, additional) {
            (Rate::R1X1, _) => ANY,
            (Rate::R1X2 | Rate::R2X1 | Rate::R2X2, _) => 0b111,
            (_, AdditionalRates::No) => 0,
            (Rate::R2X4, AdditionalRates::Yes) => 0b11,
            (_, AdditionalRates::Yes) => 0b1,
        })
    }

    /// What `vkGetPhysicalDeviceFragmentShadingRatesKHR` lists: width and height in pixels, and `VkSampleCountFlags`.
    ///
    /// Sizes that are no rate here, such as 4x1, are passed over; 1x1 is always there.
    pub fn vulkan(listed: impl IntoIterator<Item = ([u32; 2], u32)>) -> Support {
        let listed: Vec<([u32; 2], u32)> = listed.into_iter().collect();
        Support::of(|rate| match rate {
            Rate::R1X1 => ANY,
            _ => listed
                .iter()
                .filter(|(size, _)| *size == [rate.width(), rate.height()])
                .fold(0, |counts, (_, more)| counts | more),
        })
    }

    /// What `VK_NV_shading_rate_image` and its siblings support: all rates, as long as a coarse pixel has no more than
    /// `shadingRateMaxCoarseSamples` samples (`GL_SHADING_RATE_IMAGE_…_MAX_COARSE_SAMPLES_NV`), 16 on Turing.
    ///
    /// Source: NVIDIA Adaptive Shading Overview, GDC 2019, the table of "VRS and MSAA modes". Later devices shade less of it:
    /// [`nvidia`](Support::nvidia).
    pub fn nv(max_coarse_samples: u32) -> Support {
        Support::of(|rate| match rate {
            Rate::R1X1 => ANY,
            _ => Samples::ALL
                .into_iter()
                .filter(|samples| rate.pixels() * samples.count() <= max_coarse_samples)
                .fold(0, |counts, samples| counts | samples.count()),
        })
    }

    /// What NVIDIA's driver shades at each sample count, by either extension: less than the slide's table at 2 and 8 samples. Seen on an
    /// H100, driver 580.159.04, where a palette's entry above it is clamped to what [`nearest`](Support::nearest) gives
    /// (`tests/hardware_vrs/NOTES.md`). Ask the device, and [`vulkan`](Support::vulkan), where there is one to ask.
    pub fn nvidia() -> Support {
        Support::of(|rate| match rate {
            Rate::R1X1 => ANY,
            Rate::R1X2 => 0b1111,
            Rate::R2X1 | Rate::R2X2 => 0b111,
            Rate::R2X4 => 0b11,
            _ => 0b1,
        })
    }

    fn of(counts: impl Fn(Rate) -> u32) -> Support {
        Support {
            counts: Rate::ALL.map(counts),
        }
    }

    /// Whether a rate is supported at a sample count.
    pub fn has(&self, rate: Rate, samples: Samples) -> bool {
        Rate::ALL
            .iter()
            .zip(self.counts)
            .any(|(&other, counts)| other == rate && counts & samples.count() != 0)
    }

    /// The supported rate that comes nearest to the one that is asked for, and is coarser on neither axis.
    ///
    /// That is Vulkan's clamp ("Combining the Fragment Shading Rates"): of those that fit, the largest area; of these, the
    /// lowest aspect ratio. Of two that are equal in both, Vulkan lets a device choose; here it is the one that lies along
    /// the longer axis of what was asked, and the wide one where that has none.
    pub fn nearest(&self, asked: Rate, samples: Samples) -> Rate {
        let along = |rate: Rate| match asked.height() > asked.width() {
            true => rate.height() > rate.width(),
            false => rate.width() > rate.height(),
        };
        let key = |rate: &Rate| {
            let perimeter = rate.width() + rate.height();
            (rate.pixels(), std::cmp::Reverse(perimeter), along(*rate))
        };
        Rate::ALL
            .into_iter()
            .filter(|rate| rate.is_within(asked) && self.has(*rate, samples))
            .max_by_key(key)
            .unwrap_or(Rate::R1X1)
    }
}

/// Every sample count.
const ANY: u32 = 0b11111;

/// D3D12's `AdditionalShadingRatesSupported`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AdditionalRates {
    /// Up to 2x2.
    No,
    /// Up to 4x4.
    Yes,
}

impl fmt::Debug for Support {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rates = Rate::ALL.iter().zip(self.counts);
        f.debug_map()
            .entries(rates.map(|(rate, counts)| (rate, format!("{counts:#07b}"))))
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every set of supported rates beyond 1x1, for one sample.
    fn every_support() -> impl Iterator<Item = Support> {
        (0..64u32).map(|set| {
            Support::vulkan(
                Rate::ALL[1..]
                    .iter()
                    .enumerate()
                    .filter(move |(bit, _)| set >> bit & 1 != 0)
                    .map(|(_, rate)| ([rate.width(), rate.height()], 1)),
            )
        })
    }

    #[test]
    fn what_is_supported_stays_and_what_is_not_becomes_no_coarser_on_either_axis() {
        for support in every_support() {
            for asked in Rate::ALL {
                let got = support.nearest(asked, Samples::X1);
                assert!(support.has(got, Samples::X1), "{support:?} {asked}: {got}");
                assert!(got.is_within(asked), "{support:?} {asked}: {got}");
                if support.has(asked, Samples::X1) {
                    assert_eq!(got, asked);
                }
                let larger = Rate::ALL.into_iter().find(|rate| {
                    support.has(*rate, Samples::X1)
                        && rate.is_within(asked)
                        && rate.pixels() > got.pixels()
                });
                assert_eq!(larger, None, "{support:?} {asked}: {got}");
            }
        }
    }

    #[test]
    fn the_nearest_rate_commutes_with_transposition_unless_the_square_has_to_choose() {
        for support in every_support() {
            let transposed = Support::vulkan(
                Rate::ALL
                    .into_iter()
                    .filter(|rate| support.has(rate.transposed(), Samples::X1))
                    .map(|rate| ([rate.width(), rate.height()], 1)),
            );
            for asked in Rate::ALL.into_iter().filter(|r| r.width() != r.height()) {
                let got = support.nearest(asked, Samples::X1);
                let wanted = transposed.nearest(asked.transposed(), Samples::X1);
                assert_eq!(got.transposed(), wanted, "{support:?} {asked}");
            }
        }
        let both = Support::vulkan([([2, 1], 1), ([1, 2], 1)]);
        assert_eq!(both.nearest(Rate::R2X2, Samples::X1), Rate::R2X1);
    }

    #[test]
    fn sizes_that_are_no_rate_are_passed_over() {
        let support = Support::vulkan([([4, 1], 0b11111), ([1, 4], 0b11111), ([2, 2], 0b1)]);
        assert_eq!(support.nearest(Rate::R4X4, Samples::X1), Rate::R2X2);
        assert_eq!(support.nearest(Rate::R4X4, Samples::X2), Rate::R1X1);
    }

    /// The slide's table: coarse pixels down, samples across; X where there is no such mode.
    #[test]
    fn nvidias_modes_are_those_of_the_slide() {
        let table = [
            ("1x1", "1 2 4 8 16"),
            ("2x1", "2 4 8 16 X"),
            ("1x2", "2 4 8 16 X"),
            ("2x2", "4 8 16 X X"),
            ("4x2", "8 16 X X X"),
            ("2x4", "8 16 X X X"),
            ("4x4", "16 X X X X"),
        ];
        let support = Support::nv(16);
        for (name, row) in table {
            let rate: Rate = name.parse().expect("a rate");
            for (samples, cell) in Samples::ALL.into_iter().zip(row.split(' ')) {
                assert_eq!(
                    support.has(rate, samples),
                    cell != "X",
                    "{rate} {samples:?}"
                );
                if let Ok(number) = cell.parse::<u32>() {
                    assert_eq!(rate.pixels() * samples.count(), number);
                }
            }
        }
        assert_eq!(support.nearest(Rate::R4X2, Samples::X8), Rate::R2X1);
        assert_eq!(support.nearest(Rate::R2X4, Samples::X8), Rate::R1X2);
        assert_eq!(support.nearest(Rate::R4X4, Samples::X4), Rate::R2X2);
        assert_eq!(support.nearest(Rate::R4X4, Samples::X16), Rate::R1X1);
    }

    // the device's own list and what it made of each entry, as noted
    #[test]
    fn an_h100_clamps_as_was_noted_and_never_beyond_the_slide() {
        let (seen, slide) = (Support::nvidia(), Support::nv(16));
        let notes = include_str!("../../tests/hardware_vrs/NOTES.md");
        for rate in Rate::ALL {
            let counts = Samples::ALL
                .into_iter()
                .filter(|&samples| seen.has(rate, samples))
                .fold(0, |counts, samples| counts | samples.count());
            if rate != Rate::R1X1 {
                let line = format!("{rate} at sample counts {counts:#b}\n");
                assert!(notes.contains(&line), "{line}");
            }
            assert!(
                Samples::ALL
                    .into_iter()
                    .all(|samples| { slide.has(rate, samples) || !seen.has(rate, samples) })
            );
        }
        let clamped = [
            (Samples::X2, "2x1 1x2 2x2 2x4 2x2 2x4"),
            (Samples::X4, "2x1 1x2 2x2 2x2 2x2 2x2"),
            (Samples::X8, "1x1 1x2 1x2 1x2 1x2 1x2"),
        ];
        for (samples, wanted) in clamped {
            let asked = ["2x1", "1x2", "2x2", "2x4", "4x2", "4x4"];
            for (asked, wanted) in asked.into_iter().zip(wanted.split(' ')) {
                let asked: Rate = asked.parse().expect("a rate");
                let got = seen.nearest(asked, samples);
                assert_eq!(got.to_string(), wanted, "{asked} at {samples:?}");
            }
        }
    }

    #[test]
    fn d3d12_guarantees_up_to_four_samples() {
        let (no, yes) = (
            Support::d3d12(AdditionalRates::No),
            Support::d3d12(AdditionalRates::Yes),
        );
        assert_eq!(no.nearest(Rate::R4X4, Samples::X4), Rate::R2X2);
        assert_eq!(no.nearest(Rate::R4X4, Samples::X8), Rate::R1X1);
        assert_eq!(yes.nearest(Rate::R4X4, Samples::X1), Rate::R4X4);
        assert_eq!(yes.nearest(Rate::R4X4, Samples::X2), Rate::R2X4);
        assert_eq!(yes.nearest(Rate::R4X2, Samples::X2), Rate::R2X2);
    }

    #[test]
    fn sample_counts_are_powers_of_two_up_to_16() {
        for count in 0..40 {
            match Samples::try_from(count) {
                Ok(samples) => assert_eq!(samples.count(), count),
                Err(error) => {
                    assert!(![1, 2, 4, 8, 16].contains(&count));
                    assert!(error.to_string().contains(&count.to_string()));
                }
            }
        }
    }
}
