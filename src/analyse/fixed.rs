//! Numbers of the deterministic path: integers only, so that every driver and the CPU get the same bits.
//!
//! *Guarantees*: nothing overflows; where a value must be rounded, an error is rounded up and a tolerance down, so that
//! rounding can only make a rate finer. `shaders/analyse.wgsl` has the same functions under the same names.
//!
//! | quantity | unit | bits |
//! |---|---|---|
//! | luma, channel | white / 16384 ([`ONE`]) | 15 |
//! | difference of two pixels | the same | 15 |
//! | sum of ≤ 12 differences / of their squares | the same / its square | 18 / 32 |
//! | sum of 16 lumas | the same | 19 |
//! | factor (t, b, tolerance) | 1 / 4096 ([`FACTOR_ONE`]) | 16 |
//! | speed | 1 / 16 pixel a frame | 10 (saturates: 64 px/frame) |
//! | position | 1 / 256 pixel | 23 |

/// White, in units of luma.
pub const ONE: u32 = 1 << 14;

/// The factor 1.
pub const FACTOR_ONE: u32 = 1 << 12;

/// A factor as 4.12 fixed point, rounded to the nearest and saturated to what 16 bits hold; no number and negatives are 0.
pub fn factor(value: f64) -> u32 {
    match value > 0.0 {
        true => (value * f64::from(FACTOR_ONE)).round().min(65535.0) as u32,
        false => 0,
    }
}

/// A factor that scales an error: as [`factor`], but rounded up.
pub fn factor_up(value: f64) -> u32 {
    match value > 0.0 {
        true => (value * f64::from(FACTOR_ONE)).ceil().min(65535.0) as u32,
        false => 0,
    }
}

/// A magnitude without overflow: `m · 2^e`, m at most 2^15, but for a [product](Mag::product).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mag {
    m: u32,
    e: i32,
}

impl Mag {
    /// At least `x`, by a factor of at most 1 + 2^-14.
    pub fn above(x: u32) -> Mag {
        let shift = 17u32.saturating_sub(x.leading_zeros());
        // the sum may need 33 bits, so the rest is looked at instead
        let rest = x & ((1 << shift) - 1);
        Mag {
            m: (x >> shift) + u32::from(rest != 0),
            e: shift as i32,
        }
    }

    /// At most `x`, by a factor of at least 1 − 2^-14.
    pub fn below(x: u32) -> Mag {
        let shift = 17u32.saturating_sub(x.leading_zeros());
        Mag {
            m: x >> shift,
            e: shift as i32,
        }
    }

    /// The product, exact: its mantissa may have 30 bits, so it can be compared, not multiplied.
    pub fn product(self, other: Mag) -> Mag {
        Mag {
            m: self.m * other.m,
            e: self.e + other.e,
        }
    }

    /// The product, rounded up.
    pub fn times_above(self, other: Mag) -> Mag {
        let product = self.product(other);
        Mag::above(product.m).scaled(product.e)
    }

    /// The product, rounded down.
    pub fn times_below(self, other: Mag) -> Mag {
        let product = self.product(other);
        Mag::below(product.m).scaled(product.e)
    }

    /// Times a power of two.
    pub fn scaled(self, log2: i32) -> Mag {
        Mag {
            m: self.m,
            e: self.e + log2,
        }
    }

    /// A whole number, exact: its mantissa may have 32 bits, so it can be compared, not multiplied.
    pub fn whole(x: u32) -> Mag {
        Mag { m: x, e: 0 }
    }

    /// At most 1 / `x`, by a factor of at least 1 − 2^-14; of 0 as of 1.
    pub fn inverse(x: u32) -> Mag {
        let inverse = (1u64 << 62) / u64::from(x.max(1));
        let shift = 49u32.saturating_sub(inverse.leading_zeros());
        Mag {
            m: (inverse >> shift) as u32,
            e: shift as i32 - 62,
        }
    }

    /// Whether this is less: `a · 2^d < b` is `a < b / 2^d`, rounded up. Exact for mantissas of 30 bits on the right, and of 32 on the
    /// left unless the right is above 2^31 times as much; then it may say no.
    pub fn is_less(self, other: Mag) -> bool {
        let apart = self.e - other.e;
        let (over, under) = (apart.clamp(0, 30), (-apart).clamp(0, 31));
        self.m >> under < (other.m + (1 << over) - 1) >> over
    }

    /// As a float, exact; `None` where products with numbers of up to 40 bits might be too large or too small for one.
    pub fn as_float(self) -> Option<f32> {
        match (self.m, self.e) {
            (0, _) => Some(0.0),
            (m, e @ -80..=60) => Some(m as f32 * f32::from_bits(exponent(e))),
            _ => None,
        }
    }

    /// In one word, as tables and parameters have it: the mantissa in the low 16 bits, the exponent above them, from -512 up.
    pub fn packed(self) -> u32 {
        debug_assert!(
            self.m <= 1 << 15 && (-512..512).contains(&self.e),
            "{self:?}"
        );
        self.m | ((self.e + 512) as u32) << 16
    }

    /// What [`packed`](Mag::packed) made a word of.
    pub fn unpacked(word: u32) -> Mag {
        Mag {
            m: word & 0xffff,
            e: (word >> 16) as i32 - 512,
        }
    }
}

/// The upper 32 bits of a product.
pub fn mul_high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

/// Luma units of a linear value, given white as a power of two; `None` where it is no number, infinite, negative (beyond
/// rounding) or above white: doubt. It looks at the bits, since drivers may take compares of NaN apart.
pub fn quantise(value: f32, white_log2: i32) -> Option<u32> {
    let bits = value.to_bits();
    let white = exponent(white_log2);
    let nothing = exponent(white_log2 - 15);
    match bits >= 0x8000_0000 {
        true => (bits & 0x7fff_ffff < nothing).then_some(0),
        false => (bits <= white)
            .then(|| (value * f32::from_bits(exponent(14 - white_log2)) + 0.5).floor() as u32),
    }
}

/// The bits of 2^n as `f32`, n clamped to normal numbers.
pub fn exponent(n: i32) -> u32 {
    ((n.clamp(-126, 127) + 127) as u32) << 23
}

/// The 8-bit √luma of a luma: `round(255 · √(luma / white))`.
pub fn sqrt_code(luma: u32) -> u32 {
    let square = (luma.min(ONE) * 260_100) >> 14;
    let guess = ((square as f32).sqrt() * 0.5 + 0.5) as u32;
    let more = u32::from((2 * guess + 1) * (2 * guess + 1) <= square);
    let odd = (2 * guess).max(1) - 1;
    let less = u32::from(guess > 0 && odd * odd > square);
    guess + more - less
}

/// The luma of an 8-bit √luma code.
pub fn sqrt_luma(code: u8) -> u32 {
    (u32::from(code) * u32::from(code) * ONE + 32_512) / 65_025
}

/// The weights of red, green and blue (Eq. 25), in 1/16384.
pub const WEIGHTS: [u32; 3] = [4899, 9617, 1868];

/// Luma of three channels (Eq. 25), given weights in 1/16384; at most the largest channel.
pub fn luma([r, g, b]: [u32; 3], weights: [u32; 3]) -> u32 {
    (r * weights[0] + g * weights[1] + b * weights[2] + (1 << 13)) >> 14
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(x: Mag) -> f64 {
        f64::from(x.m) * 2f64.powi(x.e)
    }

    #[test]
    fn magnitudes_round_to_their_side_and_compare_exactly() {
        let numbers = [
            0,
            1,
            2,
            3,
            32767,
            32768,
            32769,
            65535,
            65537,
            1 << 24,
            u32::MAX,
        ];
        for a in numbers {
            let (up, down) = (value(Mag::above(a)), value(Mag::below(a)));
            let exact = f64::from(a);
            assert!(down <= exact && exact <= up, "{a}");
            assert!(
                up <= exact * (1.0 + 0.5f64.powi(14)) && down >= exact * (1.0 - 0.5f64.powi(14))
            );
            let inverse = value(Mag::inverse(a)) * exact.max(1.0);
            assert!(inverse <= 1.0 && inverse >= 1.0 - 0.5f64.powi(14), "{a}");
            assert_eq!(Mag::unpacked(Mag::inverse(a).packed()), Mag::inverse(a));
            for b in numbers {
                let (x, y) = (Mag::whole(a), Mag::below(b));
                assert_eq!(x.is_less(y), exact < value(y), "{a} < {b}");
                for shift in [-40, -17, -16, -1, 0, 1, 16, 17, 40] {
                    let (x, y) = (Mag::above(a).scaled(shift), Mag::below(b));
                    assert_eq!(x.is_less(y), value(x) < value(y), "{a} << {shift} < {b}");
                }
                let (x, y) = (Mag::above(a), Mag::above(b));
                assert!(value(x.times_above(y)) >= exact * f64::from(b));
                assert_eq!(value(x.product(y)), value(x) * value(y));
                for other in numbers {
                    let (up, down) = (x.product(y), Mag::below(other).product(y));
                    assert_eq!(up.is_less(down), value(up) < value(down), "{a} {b} {other}");
                }
            }
        }
    }

    #[test]
    fn e1_e2_e3_what_is_no_luma_is_doubt() {
        for bad in [
            f32::NAN,
            -f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            65504.0,
            1e30,
            -0.5,
            -1e30,
            1.0001,
        ] {
            assert_eq!(quantise(bad, 0), None, "{bad}");
        }
        for (good, units) in [
            (0.0, 0),
            (-0.0, 0),
            (1e-40, 0),
            (-1e-6, 0),
            (1.0, ONE),
            (0.5, ONE / 2),
        ] {
            assert_eq!(quantise(good, 0), Some(units), "{good}");
        }
        assert_eq!(
            quantise(65536.0, 16),
            Some(ONE),
            "HDR: white as a power of two"
        );
    }

    #[test]
    fn sqrt_codes_are_rounded_exactly_and_survive_a_round_trip() {
        for luma in 0..=ONE {
            let exact = (f64::from(luma) / f64::from(ONE)).sqrt() * 255.0;
            assert_eq!(f64::from(sqrt_code(luma)), exact.round(), "{luma}");
        }
        for code in 0..=255 {
            // code 1 is a quarter of a unit: black
            let kept = if code == 1 { 0 } else { u32::from(code) };
            assert_eq!(sqrt_code(sqrt_luma(code)), kept);
        }
    }
}
