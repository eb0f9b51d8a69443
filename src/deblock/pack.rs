//! Pixels in words: how a picture lies in a storage buffer or an `r32uint` texture.

use half::f16;

/// How a pixel lies in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// One word, red in the low byte (`pack4x8unorm`).
    Rgba8Unorm,
    /// One word: red in the low 11 bits, green in 11, blue in 10, as the texture format. There is no alpha.
    Rg11b10Ufloat,
    /// Two words of halves (`pack2x16float`).
    Rgba16Float,
    /// Four words.
    Rgba32Float,
}

impl Packing {
    /// Words for each pixel.
    pub fn words(self) -> u32 {
        match self {
            Packing::Rgba8Unorm | Packing::Rg11b10Ufloat => 1,
            Packing::Rgba16Float => 2,
            Packing::Rgba32Float => 4,
        }
    }

    /// The words of a color, to the nearest, ties to even.
    pub fn pack(self, color: [f32; 4]) -> Vec<u32> {
        let [r, g, b, a] = color;
        let half = |v: f32| u32::from(f16::from_f32(v).to_bits());
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round_ties_even() as u32;
        match self {
            Packing::Rgba8Unorm => vec![byte(r) | byte(g) << 8 | byte(b) << 16 | byte(a) << 24],
            Packing::Rg11b10Ufloat => {
                vec![shorten(half(r), 4) | shorten(half(g), 4) << 11 | shorten(half(b), 5) << 22]
            }
            Packing::Rgba16Float => vec![half(r) | half(g) << 16, half(b) | half(a) << 16],
            Packing::Rgba32Float => color.map(f32::to_bits).to_vec(),
        }
    }

    /// The color in words; `None` if there are too few.
    pub fn unpack(self, words: &[u32]) -> Option<[f32; 4]> {
        let words = words.get(..self.words() as usize)?;
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        Some(match self {
            Packing::Rgba8Unorm => words[0].to_le_bytes().map(|byte| f32::from(byte) / 255.0),
            Packing::Rg11b10Ufloat => [
                half((words[0] & 0x7ff) << 4),
                half((words[0] >> 11 & 0x7ff) << 4),
                half((words[0] >> 22) << 5),
                1.0,
            ],
            Packing::Rgba16Float => [
                half(words[0] & 0xffff),
                half(words[0] >> 16),
                half(words[1] & 0xffff),
                half(words[1] >> 16),
            ],
            Packing::Rgba32Float => std::array::from_fn(|i| f32::from_bits(words[i])),
        })
    }
}

/// The bits of a half to those of a float without sign and with `drop` fewer bits of mantissa. Negative becomes 0, what is too
/// large the largest; infinity and NaN stay.
fn shorten(bits: u32, drop: u32) -> u32 {
    let is_nan = bits & 0x7fff > 0x7c00;
    match bits {
        _ if is_nan => 0x7fff >> drop,
        0x8000.. => 0,
        0x7c00 => 0x7c00 >> drop,
        _ => {
            let rounded = (bits + (1 << (drop - 1)) - 1 + (bits >> drop & 1)) >> drop;
            rounded.min((0x7c00 >> drop) - 1)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_packed_comes_back() {
        for packing in [
            Packing::Rgba8Unorm,
            Packing::Rg11b10Ufloat,
            Packing::Rgba16Float,
            Packing::Rgba32Float,
        ] {
            for color in [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 1.0, 1.0]] {
                assert_eq!(packing.unpack(&packing.pack(color)), Some(color));
            }
            assert_eq!(packing.unpack(&[]), None);
        }
    }

    #[test]
    fn small_floats_have_no_sign_and_a_largest_value() {
        let pack = |v: f32| {
            Packing::Rg11b10Ufloat
                .unpack(&Packing::Rg11b10Ufloat.pack([v; 4]))
                .map(|c| [c[0], c[2]])
        };
        assert_eq!(pack(-1.0), Some([0.0, 0.0]));
        assert_eq!(pack(65504.0), Some([65024.0, 64512.0]));
        assert_eq!(pack(f32::INFINITY), Some([f32::INFINITY; 2]));
        assert!(pack(f32::NAN).is_some_and(|c| c[0].is_nan() && c[1].is_nan()));
        // half a step of 6 bits of mantissa goes to the even one
        assert_eq!(pack(1.0 + 1.0 / 128.0).map(|c| c[0]), Some(1.0));
        assert_eq!(
            pack(1.0 + 3.0 / 128.0).map(|c| c[0]),
            Some(1.0 + 2.0 / 64.0)
        );
    }
}
