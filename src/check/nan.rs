//! Makes all NaNs alike, so that a NaN matches a NaN whatever its payload, and nothing else.

use naga::{
    ArraySize, Handle, Module, Scalar, ScalarKind, Type, TypeInner,
    proc::{Alignment, Layouter},
};

/// Makes the NaNs in a buffer of a type alike.
pub fn canonicalise_buffer(module: &Module, ty: Handle<Type>, bytes: &mut [u8]) {
    let mut layouter = Layouter::default();
    if layouter.update(module.to_ctx()).is_ok() {
        Walk {
            module,
            layouter: &layouter,
        }
        .visit(ty, bytes);
    }
}

struct Walk<'w> {
    module: &'w Module,
    layouter: &'w Layouter,
}

impl Walk<'_> {
    fn visit(&self, ty: Handle<Type>, bytes: &mut [u8]) {
        match self.module.types[ty].inner {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => {
                scalars(scalar, bytes);
            }
            TypeInner::Matrix { rows, scalar, .. } => {
                let stride = Alignment::from(rows) * u32::from(scalar.width);
                for column in bytes.chunks_mut(stride as usize) {
                    scalars(scalar, column);
                }
            }
            TypeInner::Array { base, stride, .. } => {
                for element in bytes.chunks_mut(stride as usize) {
                    self.visit(base, element);
                }
            }
            TypeInner::Struct { ref members, .. } => {
                for member in members {
                    let is_open = matches!(
                        self.module.types[member.ty].inner,
                        TypeInner::Array {
                            size: ArraySize::Dynamic,
                            ..
                        }
                    );
                    let size = self.layouter[member.ty].size as usize;
                    if let Some(rest) = bytes.get_mut(member.offset as usize..) {
                        let end = if is_open {
                            rest.len()
                        } else {
                            size.min(rest.len())
                        };
                        self.visit(member.ty, &mut rest[..end]);
                    }
                }
            }
            _ => {}
        }
    }
}

fn scalars(scalar: Scalar, bytes: &mut [u8]) {
    if scalar.kind != ScalarKind::Float {
        return;
    }
    for slot in bytes.chunks_exact_mut(scalar.width.into()) {
        match slot {
            [a, b] => {
                let bits = u16::from_le_bytes([*a, *b]);
                if bits & 0x7c00 == 0x7c00 && bits & 0x3ff != 0 {
                    slot.copy_from_slice(&0x7e00u16.to_le_bytes());
                }
            }
            [a, b, c, d] if f32::from_le_bytes([*a, *b, *c, *d]).is_nan() => {
                slot.copy_from_slice(&0x7fc0_0000u32.to_le_bytes());
            }
            _ => {}
        }
    }
}

/// Makes the NaNs in texels of a format alike.
pub fn canonicalise_texels(format: wgpu::TextureFormat, bytes: &mut [u8]) {
    use wgpu::TextureFormat as F;
    match format {
        F::R32Float | F::Rg32Float | F::Rgba32Float => scalars(Scalar::F32, bytes),
        F::R16Float | F::Rg16Float | F::Rgba16Float => scalars(Scalar::F16, bytes),
        F::Rg11b10Ufloat => {
            for slot in bytes.chunks_exact_mut(4) {
                let mut bits = u32::from_le_bytes([slot[0], slot[1], slot[2], slot[3]]);
                for (shift, mantissa) in [(0, 6), (11, 6), (22, 5)] {
                    let part = bits >> shift;
                    let fraction = (1 << mantissa) - 1;
                    if part >> mantissa & 31 == 31 && part & fraction != 0 {
                        bits |= fraction << shift;
                    }
                }
                slot.copy_from_slice(&bits.to_le_bytes());
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn payloads_are_forgotten_and_numbers_are_kept() {
        let mut bytes = [
            f32::NAN.to_bits() | 1,
            1.0f32.to_bits(),
            f32::INFINITY.to_bits(),
        ]
        .map(u32::to_le_bytes)
        .concat();
        canonicalise_texels(wgpu::TextureFormat::R32Float, &mut bytes);
        let words: Vec<u32> = bytes
            .chunks(4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        assert_eq!(
            words,
            [0x7fc0_0000, 1.0f32.to_bits(), f32::INFINITY.to_bits()]
        );
    }
}
