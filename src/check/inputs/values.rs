//! The bytes of buffers and of immediates, member by member.

use fastrand::Rng;
use half::f16;
use naga::{AddressSpace, ArraySize, Handle, ScalarKind, Type, TypeInner, proc::Alignment};

use super::{InputError, Maker, why_unread};
use crate::dispatch::reflect::Resource;

impl Maker<'_> {
    /// Makes up immediates; empty if the shader has none.
    pub fn immediates(&self, seed: u64, breadth: u32) -> Vec<u8> {
        let immediate = self
            .module
            .global_variables
            .iter()
            .find(|(_, global)| global.space == AddressSpace::Immediate);
        let Some((_, global)) = immediate else {
            return Vec::new();
        };
        let mut bytes = vec![0; self.layouter[global.ty].size.next_multiple_of(4) as usize];
        let name = global.name.as_deref().unwrap_or_default();
        let maker = Maker {
            breadth,
            ..self.clone()
        };
        maker.fill(
            global.ty,
            name,
            &mut bytes,
            &mut Rng::with_seed(seed ^ 0x1d),
        );
        bytes
    }

    pub(super) fn buffer_bytes(
        &self,
        resource: &Resource,
        written: bool,
        rng: &mut Rng,
    ) -> Result<Vec<u8>, InputError> {
        if let Some(path) = self.settings.files.get(&resource.name) {
            return std::fs::read(path).map_err(|error| InputError::File {
                path: path.display().to_string(),
                why: why_unread(&error),
            });
        }
        let ty = self.module.global_variables[resource.global].ty;
        let mut bytes = vec![0; self.buffer_size(ty) as usize];
        match written {
            true => self.poison(ty, &mut bytes, rng),
            false => self.fill(ty, &resource.name, &mut bytes, rng),
        }
        Ok(bytes)
    }

    /// The size of a buffer: an array without a size gets four elements for each pixel, so that any usual stride fits.
    fn buffer_size(&self, ty: Handle<Type>) -> u32 {
        let elements = self.size[0] * self.size[1] * self.layers * 4;
        let of_array = |ty: Handle<Type>| match self.module.types[ty].inner {
            TypeInner::Array {
                size: ArraySize::Dynamic,
                stride,
                ..
            } => Some(stride * elements.min((64 << 20) / stride.max(1))),
            _ => None,
        };
        match &self.module.types[ty].inner {
            TypeInner::Struct { members, span } => match members.last() {
                Some(last) => match of_array(last.ty) {
                    Some(size) => (last.offset + size).next_multiple_of(16),
                    None => *span,
                },
                None => *span,
            },
            _ => of_array(ty).unwrap_or(self.layouter[ty].size),
        }
        .max(16)
    }

    /// Writes values of a type. `path` is how the author would name the place.
    fn fill(&self, ty: Handle<Type>, path: &str, bytes: &mut [u8], rng: &mut Rng) {
        let scalar_count = |count: usize, scalar: naga::Scalar, bytes: &mut [u8], rng: &mut Rng| {
            let values = self.values(path, count, scalar, rng);
            for (value, slot) in values.iter().zip(bytes.chunks_mut(scalar.width.into())) {
                write_scalar(*value, scalar, slot);
            }
        };
        match self.module.types[ty].inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
                scalar_count(1, scalar, bytes, rng);
            }
            TypeInner::Vector { size, scalar } => scalar_count(size as usize, scalar, bytes, rng),
            TypeInner::Matrix {
                columns,
                rows,
                scalar,
            } => {
                let stride = Alignment::from(rows) * u32::from(scalar.width);
                for column in 0..columns as usize {
                    for row in 0..rows as usize {
                        let at = column * stride as usize + row * usize::from(scalar.width);
                        let diagonal = f64::from(u8::from(column == row));
                        write_scalar(
                            diagonal + 0.25 * (rng.f64() - 0.5),
                            scalar,
                            &mut bytes[at..],
                        );
                    }
                }
            }
            TypeInner::Array { base, stride, .. } => {
                for element in bytes.chunks_mut(stride as usize) {
                    if element.len() >= self.layouter[base].size as usize {
                        self.fill(base, path, element, rng);
                    }
                }
            }
            TypeInner::Struct { ref members, .. } => {
                for member in members {
                    let name = member.name.as_deref().unwrap_or_default();
                    let inner = format!("{path}.{name}");
                    if let Some(rest) = bytes.get_mut(member.offset as usize..) {
                        let size = self.layouter[member.ty].size as usize;
                        let is_open = matches!(
                            self.module.types[member.ty].inner,
                            TypeInner::Array {
                                size: ArraySize::Dynamic,
                                ..
                            }
                        );
                        let end = if is_open {
                            rest.len()
                        } else {
                            size.min(rest.len())
                        };
                        self.fill(member.ty, &inner, &mut rest[..end], rng);
                    }
                }
            }
            _ => {}
        }
    }

    /// Values for `count` components that belong together.
    fn values(&self, path: &str, count: usize, scalar: naga::Scalar, rng: &mut Rng) -> Vec<f64> {
        let last = path.rsplit('.').next().unwrap_or(path);
        let set = self
            .settings
            .set
            .get(path)
            .or_else(|| self.settings.set.get(last));
        if let Some(set) = set.filter(|set| !set.is_empty()) {
            return (0..count).map(|i| set[i.min(set.len() - 1)]).collect();
        }
        let name = last.to_lowercase();
        let [width, height] = self.size.map(f64::from);
        let is = |words: &[&str]| words.iter().any(|word| name.contains(word));
        let inverse = is(&["inv", "rcp", "texel", "pixel_size"]);
        let sizes = if inverse {
            [1.0 / width, 1.0 / height, width, height]
        } else {
            [width, height, f64::from(self.layers), 1.0]
        };
        let named_size = is(&["size", "resolution", "dim", "extent", "viewport", "screen"]);
        if count >= 2 && named_size {
            return sizes[..count].to_vec();
        }
        if count == 1 && is(&["width", "stride", "pitch", "columns", "cols"]) || name == "w" {
            return vec![sizes[0]; count];
        }
        if count == 1 && is(&["height", "rows"]) || name == "h" {
            return vec![sizes[1]; count];
        }
        (0..count)
            .map(|_| match scalar.kind {
                ScalarKind::Float if self.reach > 0 && scalar.width == 2 => {
                    f64::from(self.reaching(rng).max(f16::MIN.into()))
                }
                ScalarKind::Float if self.reach > 0 => f64::from(self.reaching(rng)),
                ScalarKind::Float => match self.end(rng) {
                    Some(end) => f64::from(end),
                    None => {
                        let breadth = f64::from(self.breadth);
                        rng.f64() * (1.0 + 2.0 * breadth) - breadth
                    }
                },
                _ if is(&[
                    "count",
                    "num",
                    "samples",
                    "steps",
                    "iterations",
                    "octaves",
                    "max",
                ]) =>
                {
                    f64::from(rng.u8(1..5))
                }
                _ => f64::from(self.integer(rng)),
            })
            .collect()
    }

    /// An integer. With more breadth, often one that decides a comparison: a small one, or one next to an integer that
    /// the shader spells out.
    fn integer(&self, rng: &mut Rng) -> u32 {
        let wide = 8 << self.breadth.min(6);
        match rng.u8(0..4) {
            0 if self.breadth > 0 => rng.u32(0..3),
            1 if self.breadth > 0 && !self.literals.is_empty() => {
                let literal = self.literals[rng.usize(0..self.literals.len())];
                (literal + rng.u32(0..3)).saturating_sub(1)
            }
            _ => rng.u32(0..wide),
        }
    }

    /// Poison for a type: numbers that are valid but unlikely.
    fn poison(&self, ty: Handle<Type>, bytes: &mut [u8], rng: &mut Rng) {
        match self.scalar_of(ty) {
            Some(scalar) if scalar.kind == ScalarKind::Float => {
                for slot in bytes.chunks_mut(scalar.width.into()) {
                    if slot.len() == usize::from(scalar.width) {
                        write_scalar(2.0 + rng.f64(), scalar, slot);
                    }
                }
            }
            _ => bytes.fill_with(|| rng.u8(0x40..0x7f)),
        }
    }

    /// The scalar that a type is made of, if it is made of one alone.
    fn scalar_of(&self, ty: Handle<Type>) -> Option<naga::Scalar> {
        match self.module.types[ty].inner {
            TypeInner::Scalar(scalar)
            | TypeInner::Atomic(scalar)
            | TypeInner::Vector { scalar, .. }
            | TypeInner::Matrix { scalar, .. } => Some(scalar),
            TypeInner::Array { base, .. } => self.scalar_of(base),
            TypeInner::Struct { ref members, .. } => {
                let first = self.scalar_of(members.first()?.ty)?;
                members
                    .iter()
                    .all(|member| self.scalar_of(member.ty) == Some(first))
                    .then_some(first)
            }
            _ => None,
        }
    }

    /// With more breadth, often 0 or 1: a depth of nothing, a mask, a share of all, which chance never makes and shaders ask for.
    pub(super) fn end(&self, rng: &mut Rng) -> Option<u8> {
        if self.breadth == 0 {
            return None;
        }
        let end = rng.u8(0..8);
        (end < 2).then_some(end)
    }
}

fn write_scalar(value: f64, scalar: naga::Scalar, slot: &mut [u8]) {
    let width = usize::from(scalar.width);
    if slot.len() < width {
        return;
    }
    match (scalar.kind, width) {
        (ScalarKind::Float, 4) => slot[..4].copy_from_slice(&(value as f32).to_le_bytes()),
        (ScalarKind::Float, 2) => {
            slot[..2].copy_from_slice(&f16::from_f32(value as f32).to_le_bytes())
        }
        (ScalarKind::Float, 8) => slot[..8].copy_from_slice(&value.to_le_bytes()),
        (ScalarKind::Sint, _) => {
            slot[..width].copy_from_slice(&(value as i64).to_le_bytes()[..width]);
        }
        _ => slot[..width].copy_from_slice(&(value as u64).to_le_bytes()[..width]),
    }
}
