//! How rates from several sources become one: the combiners of D3D12 and Vulkan.
//!
//! Does: combines the rate of a draw, of a primitive and of an image, as the hardware would, on the CPU.
//! Needs: what the device says of itself: its largest axis, and for Vulkan whether it multiplies strictly.
//! Guarantees: a rate, never 4x1 or 1x4, no axis above the device's largest.
//! Refuses: nothing; a number that names no combiner is `None`.
//!
//! Sources: D3D12's specification of variable-rate shading, "Combining Shading Rate Factors" (NVIDIA's slides on adaptive
//! shading, GDC 2019, "Using Combiners"); Vulkan's specification, "Combining the Fragment Shading Rates". Both compare
//! *sizes*, so the smaller is the finer: D3D12's reference page of the enumeration has minimum and maximum swapped, its
//! specification has not ("the MIN of 1X2 and 2X1 … is 1x1").

use super::Rate;

/// A function of a first rate, A, and a second, B. It works on each axis by itself, never on codes as numbers.
///
/// | | D3D12 | Vulkan |
/// |---|---|---|
/// | `Passthrough` | `PASSTHROUGH` 0 | `KEEP` 0 |
/// | `Override` | `OVERRIDE` 1 | `REPLACE` 1 |
/// | `Min` | `MIN` 2 | `MIN` 2 |
/// | `Max` | `MAX` 3 | `MAX` 3 |
/// | `Sum` | `SUM` 4 | `MUL` 4 |
/// | `LooseSum` | | `MUL` 4 where `fragmentShadingRateStrictMultiplyCombiner` is false |
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum Combiner {
    /// A. What is in force where no combiner was ever set.
    Passthrough,
    /// B.
    Override,
    /// On each axis the finer: [`Rate::meet`].
    Min,
    /// On each axis the coarser: [`Rate::join`].
    Max,
    /// The product of the sizes, which is the sum of their logarithms: B relative to A.
    Sum,
    /// The sum of the sizes, as some Vulkan devices have it in place of the product. As sizes are powers of two, rounded
    /// down, it differs from the product in one case: 1 and 1 give 2.
    LooseSum,
}

impl Combiner {
    /// All combiners.
    pub const ALL: [Combiner; 6] = [
        Combiner::Passthrough,
        Combiner::Override,
        Combiner::Min,
        Combiner::Max,
        Combiner::Sum,
        Combiner::LooseSum,
    ];

    /// The combiner of a `D3D12_SHADING_RATE_COMBINER`; `None` if there is none.
    pub fn from_d3d12(value: u32) -> Option<Combiner> {
        Combiner::ALL[..5].get(value as usize).copied()
    }

    /// The combiner of a `VkFragmentShadingRateCombinerOpKHR` on a device that multiplies strictly; `None` if there is none.
    pub fn from_vulkan(value: u32) -> Option<Combiner> {
        Combiner::from_d3d12(value)
    }

    /// What this combiner is on a Vulkan device whose `fragmentShadingRateStrictMultiplyCombiner` is false.
    pub fn loose(self) -> Combiner {
        match self {
            Combiner::Sum => Combiner::LooseSum,
            other => other,
        }
    }

    /// Combines two rates on a device.
    ///
    /// The inputs are clamped to what the device can shade, and so is the result (both specifications allow the first and
    /// demand the second). What is no rate is resolved by [`Rate::from_log2`]: 2x1 and 2x1 sum up to 4x1, thus to 2x1. Sums
    /// are therefore not associative.
    pub fn combine(self, a: Rate, b: Rate, largest: LargestAxis) -> Rate {
        let largest = largest.rate();
        let (a, b) = (a.meet(largest), b.meet(largest));
        let per_axis = |op: fn(u32, u32) -> u32| {
            let ([aw, ah], [bw, bh]) = (a.log2(), b.log2());
            Rate::from_log2([op(aw, bw), op(ah, bh)]).meet(largest)
        };
        match self {
            Combiner::Passthrough => a,
            Combiner::Override => b,
            Combiner::Min => a.meet(b),
            Combiner::Max => a.join(b),
            Combiner::Sum => per_axis(|a, b| a + b),
            Combiner::LooseSum => per_axis(|a, b| ((1u32 << a) + (1 << b)).ilog2()),
        }
    }
}

/// The longest side of a coarse pixel on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LargestAxis {
    /// 2 pixels: D3D12's `AdditionalShadingRatesSupported` is false.
    Two,
    /// 4 pixels.
    Four,
}

impl LargestAxis {
    /// The rate that is as large on both axes.
    pub fn rate(self) -> Rate {
        match self {
            LargestAxis::Two => Rate::R2X2,
            LargestAxis::Four => Rate::R4X4,
        }
    }
}

/// The rate that a pixel is shaded at: the draw's (Vulkan: the pipeline's) and the primitive's are combined by the first
/// combiner, the result and the image's by the second.
pub fn effective(
    draw: Rate,
    primitive: Rate,
    image: Rate,
    combiners: [Combiner; 2],
    largest: LargestAxis,
) -> Rate {
    let first = combiners[0].combine(draw, primitive, largest);
    combiners[1].combine(first, image, largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triples() -> impl Iterator<Item = (Combiner, Rate, Rate)> {
        Combiner::ALL.into_iter().flat_map(|combiner| {
            Rate::ALL
                .into_iter()
                .flat_map(move |a| Rate::ALL.into_iter().map(move |b| (combiner, a, b)))
        })
    }

    #[test]
    fn no_combiner_set_leaves_the_rate_of_the_draw() {
        let none = [Combiner::Passthrough; 2];
        for rate in Rate::ALL {
            assert_eq!(
                effective(rate, Rate::R4X4, Rate::R2X4, none, LargestAxis::Four),
                rate
            );
        }
    }

    #[test]
    fn no_combiner_gives_what_is_no_rate_or_above_the_devices_largest() {
        for (combiner, a, b) in triples() {
            for largest in [LargestAxis::Two, LargestAxis::Four] {
                let c = combiner.combine(a, b, largest);
                assert!(Rate::ALL.contains(&c), "{combiner:?} {a} {b}: {c}");
                assert!(c.is_within(largest.rate()), "{combiner:?} {a} {b}: {c}");
            }
        }
    }

    #[test]
    fn numbers_are_those_of_both_interfaces_and_mean_the_same() {
        for (value, combiner) in Combiner::ALL[..5].iter().enumerate() {
            assert_eq!(Combiner::from_d3d12(value as u32), Some(*combiner));
            assert_eq!(Combiner::from_vulkan(value as u32), Some(*combiner));
        }
        assert_eq!(Combiner::from_d3d12(5), None);
    }

    // E40
    #[test]
    fn a_loose_product_differs_only_where_both_axes_are_1() {
        for (a, b) in triples().map(|(_, a, b)| (a, b)) {
            let strict = Combiner::Sum.combine(a, b, LargestAxis::Four);
            let loose = Combiner::Sum.loose().combine(a, b, LargestAxis::Four);
            let both_1 = a
                .log2()
                .into_iter()
                .zip(b.log2())
                .any(|pair| pair == (0, 0));
            assert_eq!(strict == loose, !both_1, "{a} {b}: {strict} {loose}");
        }
        let full = Rate::R1X1;
        assert_eq!(
            Combiner::LooseSum.combine(full, full, LargestAxis::Four),
            Rate::R2X2
        );
        for combiner in Combiner::ALL.into_iter().filter(|c| *c != Combiner::Sum) {
            assert_eq!(combiner.loose(), combiner);
        }
    }

    // the whole table, in words of the specification rather than in those of the code
    #[test]
    fn sums_are_products_of_sizes() {
        let rate = |name: &str| name.parse::<Rate>().expect("a rate");
        let cases = [
            ("1x1", "1x1", "1x1"),
            ("1x2", "2x1", "2x2"),
            ("2x1", "2x1", "2x1"), // 4x1
            ("1x2", "1x2", "1x2"), // 1x4
            ("2x1", "2x2", "4x2"),
            ("2x2", "1x2", "2x4"),
            ("2x2", "2x2", "4x4"),
            ("4x4", "4x4", "4x4"), // 16x16
            ("2x4", "2x1", "4x4"),
            ("4x2", "1x1", "4x2"),
        ];
        for (a, b, c) in cases {
            let got = Combiner::Sum.combine(rate(a), rate(b), LargestAxis::Four);
            assert_eq!(got, rate(c), "{a} {b}");
            let got = Combiner::Sum.combine(rate(b), rate(a), LargestAxis::Four);
            assert_eq!(got, rate(c), "{b} {a}");
        }
    }

    #[test]
    fn a_sum_stops_at_the_largest_axis_of_the_device() {
        let (two, four) = (LargestAxis::Two, LargestAxis::Four);
        assert_eq!(
            Combiner::Sum.combine(Rate::R2X2, Rate::R2X2, two),
            Rate::R2X2
        );
        assert_eq!(
            Combiner::Sum.combine(Rate::R2X2, Rate::R2X2, four),
            Rate::R4X4
        );
        assert_eq!(
            Combiner::Override.combine(Rate::R1X1, Rate::R4X2, two),
            Rate::R2X2
        );
    }

    #[test]
    fn sums_are_not_associative_as_4x1_is_resolved_at_once() {
        let sum = |a, b| Combiner::Sum.combine(a, b, LargestAxis::Four);
        let (wide, tall) = (Rate::R2X1, Rate::R1X2);
        assert_eq!(sum(sum(wide, wide), tall), Rate::R2X2);
        assert_eq!(sum(wide, sum(wide, tall)), Rate::R4X2);
    }
}
