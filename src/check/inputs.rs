//! Makes up every resource that a shader binds, from a seed.
//!
//! Integers are small, so that loops end and indices stay in range; what is named like a size gets the picture's size;
//! floats lie in 0 to 1. Settings and files override all of that by name. Resources that the shader writes start as
//! poison: values that a shader would hardly store by chance, and never NaN, since a shader may read them.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
    rc::Rc,
};

use fastrand::Rng;
use naga::{
    AddressSpace, ArraySize, Expression, Handle, Literal, Module, ScalarKind, Type, TypeInner,
    proc::{Alignment, Layouter},
};

use super::gpu::Gpu;
use crate::dispatch::reflect::Resource;

/// What the user says of the inputs.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Settings {
    /// Values by name: of a variable, of a member, of `variable.member`, or of an override.
    pub set: BTreeMap<String, Vec<f64>>,
    /// Files by the name of a texture or buffer.
    pub files: BTreeMap<String, PathBuf>,
}

/// Texels of a 1-D texture at most: WebGPU's default limit.
const MOST_IN_A_LINE: u32 = 2048;

/// Why the resources could not be made up.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// Nothing can be made up for this.
    #[error("nothing can be made up for `{name}`: {why}")]
    Unsupported {
        /// The resource.
        name: String,
        /// Why.
        why: String,
    },
    /// A file that was named could not be used.
    #[error("{path}: {why}")]
    File {
        /// The file.
        path: String,
        /// Why.
        why: String,
    },
    /// A name that was set does not occur in the shader.
    #[error("the shader has nothing called `{name}`{instead}")]
    Unknown {
        /// The name.
        name: String,
        /// What it has instead, for the message.
        instead: String,
    },
}

/// A resource, made up.
#[derive(Debug)]
pub struct Made {
    /// What it is bound as.
    pub resource: Resource,
    /// The resource itself.
    pub kind: MadeKind,
    /// Whether the shader writes it.
    pub written: bool,
}

/// The resource itself.
#[derive(Debug)]
pub enum MadeKind {
    /// A buffer and what it starts with.
    Buffer {
        /// The buffer.
        buffer: wgpu::Buffer,
        /// What it starts with.
        initial: Vec<u8>,
    },
    /// A texture and what its first level starts with.
    Texture {
        /// The texture.
        texture: wgpu::Texture,
        /// The view that is bound.
        view: wgpu::TextureView,
        /// What its first level starts with, without padding.
        initial: Vec<u8>,
    },
    /// A sampler.
    Sampler(wgpu::Sampler),
}

/// What is made up.
#[derive(Clone)]
pub struct Maker<'m> {
    /// Where it is made.
    pub gpu: &'m Gpu,
    /// The shader.
    pub module: &'m Module,
    /// What the user says.
    pub settings: &'m Settings,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Layers of arrayed textures, depth of 3-D ones.
    pub layers: u32,
    layouter: Rc<Layouter>,
    /// The smaller integers that the shader spells out.
    literals: Rc<[u32]>,
    breadth: u32,
    reach: u32,
}

/// The integers below 1024 that a module spells out, in order.
fn literals(module: &Module) -> Rc<[u32]> {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let local = functions
        .chain(entries)
        .flat_map(|function| function.expressions.iter());
    let literals = local
        .chain(module.global_expressions.iter())
        .filter_map(|(_, expression)| match *expression {
            Expression::Literal(Literal::U32(value)) => Some(value),
            Expression::Literal(Literal::I32(value)) => u32::try_from(value).ok(),
            _ => None,
        });
    let literals: BTreeSet<u32> = literals.filter(|&value| value < 1024).collect();
    literals.into_iter().collect()
}

/// The seeds of a set of inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seeds {
    /// Of uniforms and immediates.
    pub uniforms: u64,
    /// Of textures and storage buffers that are only read.
    pub data: u64,
    /// How varied the numbers are: 0 for small integers, and floats between 0 and 1.
    pub breadth: u32,
    /// How far floats that are only read lie from 0, to either side; 0 leaves them to `breadth`.
    pub reach: u32,
}

impl<'m> Maker<'m> {
    /// A maker.
    pub fn new(
        gpu: &'m Gpu,
        module: &'m Module,
        settings: &'m Settings,
        size: [u32; 2],
        layers: u32,
    ) -> Maker<'m> {
        let mut layouter = Layouter::default();
        // a valid module has a layout
        let _ = layouter.update(module.to_ctx());
        Maker {
            gpu,
            module,
            settings,
            size,
            layers,
            layouter: Rc::new(layouter),
            literals: literals(module),
            breadth: 0,
            reach: 0,
        }
    }

    /// Makes up resources.
    ///
    /// # Errors
    /// If there is one that nothing can be made up for, or a file cannot be used.
    pub fn make(
        &self,
        resources: &[Resource],
        written: &dyn Fn(Handle<naga::GlobalVariable>) -> bool,
        seeds: Seeds,
    ) -> Result<Vec<Made>, InputError> {
        let fixed = Maker {
            breadth: seeds.breadth,
            ..self.clone()
        };
        let read = Maker {
            reach: seeds.reach,
            ..fixed.clone()
        };
        resources
            .iter()
            .enumerate()
            .map(|(index, resource)| {
                let written = written(resource.global);
                let is_uniform =
                    self.module.global_variables[resource.global].space == AddressSpace::Uniform;
                let (seed, maker) = match is_uniform || written {
                    true => (seeds.uniforms, &fixed),
                    false => (seeds.data, &read),
                };
                let mut rng = Rng::with_seed(seed.wrapping_add(index as u64 * 0x9e37_79b9));
                Ok(Made {
                    resource: resource.clone(),
                    kind: maker.make_one(resource, written, &mut rng)?,
                    written,
                })
            })
            .collect()
    }

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

    /// Checks that every name that the user set occurs in the shader.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check_names(&self) -> Result<(), InputError> {
        let module = self.module;
        let is_global = |name: &str| {
            module
                .global_variables
                .iter()
                .any(|(_, g)| g.name.as_deref() == Some(name))
        };
        let is_member = |name: &str| {
            module.types.iter().any(|(_, ty)| match &ty.inner {
                TypeInner::Struct { members, .. } => members
                    .iter()
                    .any(|member| member.name.as_deref() == Some(name)),
                _ => false,
            })
        };
        let is_override = |name: &str| {
            module
                .overrides
                .iter()
                .any(|(_, o)| o.name.as_deref() == Some(name))
        };
        for name in self.settings.set.keys() {
            let last = name.rsplit('.').next().unwrap_or(name);
            if !is_global(name) && !is_member(last) && !is_override(name) {
                return Err(self.unknown(name));
            }
        }
        match self.settings.files.keys().find(|name| !is_global(name)) {
            Some(name) => Err(self.unknown(name)),
            None => Ok(()),
        }
    }

    /// A name that does not occur, and what does: what is nearest, or all.
    fn unknown(&self, name: &str) -> InputError {
        let module = self.module;
        let mut names = Vec::new();
        for (_, global) in module.global_variables.iter() {
            let Some(name) = &global.name else { continue };
            if let TypeInner::Struct { members, .. } = &module.types[global.ty].inner {
                let members = members.iter().filter_map(|member| member.name.as_ref());
                names.extend(members.map(|member| format!("{name}.{member}")));
            }
            names.push(name.clone());
        }
        names.extend(module.overrides.iter().filter_map(|(_, o)| o.name.clone()));
        let known = names.iter().map(String::as_str);
        let instead = match vrcs_passes::near::nearest(name, known.clone()) {
            Some(near) => format!("; did you mean `{near}`?"),
            None if names.is_empty() => String::new(),
            None => format!("; it has {}", vrcs_passes::near::list(known)),
        };
        InputError::Unknown {
            name: name.to_owned(),
            instead,
        }
    }

    fn make_one(
        &self,
        resource: &Resource,
        written: bool,
        rng: &mut Rng,
    ) -> Result<MadeKind, InputError> {
        let unsupported = |why: &str| {
            Err(InputError::Unsupported {
                name: resource.name.clone(),
                why: why.to_owned(),
            })
        };
        if resource.entry.count.is_some() {
            return unsupported("it is a binding array");
        }
        match resource.entry.ty {
            wgpu::BindingType::Buffer { ty, .. } => {
                let initial = self.buffer_bytes(resource, written, rng)?;
                let usage = match ty {
                    wgpu::BufferBindingType::Uniform => wgpu::BufferUsages::UNIFORM,
                    wgpu::BufferBindingType::Storage { .. } => wgpu::BufferUsages::STORAGE,
                };
                Ok(MadeKind::Buffer {
                    buffer: self.gpu.buffer(&resource.name, &initial, usage),
                    initial,
                })
            }
            wgpu::BindingType::Sampler(ty) => {
                let filter = match rng.bool() {
                    true => wgpu::FilterMode::Linear,
                    false => wgpu::FilterMode::Nearest,
                };
                Ok(MadeKind::Sampler(
                    self.gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                        label: Some(&resource.name),
                        mag_filter: filter,
                        min_filter: filter,
                        compare: (ty == wgpu::SamplerBindingType::Comparison)
                            .then_some(wgpu::CompareFunction::Less),
                        ..wgpu::SamplerDescriptor::default()
                    }),
                ))
            }
            wgpu::BindingType::Texture {
                sample_type,
                view_dimension,
                multisampled,
            } => {
                if multisampled {
                    return unsupported("it is multisampled, and nothing can be uploaded to it");
                }
                let format = match sample_type {
                    wgpu::TextureSampleType::Float { filterable: true } => {
                        wgpu::TextureFormat::Rgba16Float
                    }
                    wgpu::TextureSampleType::Float { filterable: false } => {
                        wgpu::TextureFormat::Rgba32Float
                    }
                    wgpu::TextureSampleType::Depth => wgpu::TextureFormat::Depth16Unorm,
                    wgpu::TextureSampleType::Sint => wgpu::TextureFormat::Rgba32Sint,
                    wgpu::TextureSampleType::Uint => wgpu::TextureFormat::Rgba32Uint,
                };
                self.texture(resource, format, view_dimension, None, rng)
            }
            wgpu::BindingType::StorageTexture {
                format,
                view_dimension,
                ..
            } => self.texture(resource, format, view_dimension, Some(written), rng),
            wgpu::BindingType::AccelerationStructure { .. } => {
                unsupported("it is an acceleration structure")
            }
            wgpu::BindingType::ExternalTexture => unsupported("it is an external texture"),
        }
    }

    fn buffer_bytes(
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
                ScalarKind::Float if self.reach > 0 => {
                    (rng.f64() * 2.0 - 1.0) * f64::from(self.reach)
                }
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

    fn texture(
        &self,
        resource: &Resource,
        format: wgpu::TextureFormat,
        view_dimension: wgpu::TextureViewDimension,
        storage: Option<bool>,
        rng: &mut Rng,
    ) -> Result<MadeKind, InputError> {
        let [width, height] = self.size;
        let mut size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let mut dimension = wgpu::TextureDimension::D2;
        match view_dimension {
            wgpu::TextureViewDimension::D1 => {
                // a line that holds a picture row by row, with any usual stride, as far as devices go
                dimension = wgpu::TextureDimension::D1;
                size.width = (width * height * 4).min(MOST_IN_A_LINE);
                size.height = 1;
            }
            wgpu::TextureViewDimension::D2 => {}
            wgpu::TextureViewDimension::D2Array => size.depth_or_array_layers = self.layers,
            wgpu::TextureViewDimension::D3 => {
                dimension = wgpu::TextureDimension::D3;
                size.depth_or_array_layers = self.layers;
            }
            wgpu::TextureViewDimension::Cube | wgpu::TextureViewDimension::CubeArray => {
                let side = width.min(height).min(16);
                size = wgpu::Extent3d {
                    width: side,
                    height: side,
                    depth_or_array_layers: 6,
                };
            }
        }
        let from_file = match self.settings.files.get(&resource.name) {
            Some(path) => Some(read_picture(path, format)?),
            None => None,
        };
        if let Some(picture) = &from_file {
            size.width = picture.width;
            size.height = picture.height;
        }
        let levels = match (storage, dimension) {
            (None, wgpu::TextureDimension::D2) if from_file.is_none() => {
                size.max_mips(dimension).min(4)
            }
            _ => 1,
        };
        let usage = match storage {
            Some(_) => wgpu::TextureUsages::STORAGE_BINDING,
            None => wgpu::TextureUsages::TEXTURE_BINDING,
        };
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&resource.name),
            size,
            mip_level_count: levels,
            sample_count: 1,
            dimension,
            format,
            usage: usage | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut initial = Vec::new();
        for level in 0..levels {
            let level_size = texture.size().mip_level_size(level, dimension);
            let texels = level_size.width * level_size.height * level_size.depth_or_array_layers;
            let mut bytes: Vec<u8> = match &from_file {
                Some(picture) => picture.texels.clone(),
                None => (0..texels)
                    .flat_map(|_| self.texel(format, storage == Some(true), rng))
                    .collect(),
            };
            if self.breadth > 0 && from_file.is_none() && storage.is_none() {
                let rows = level_size.height * level_size.depth_or_array_layers;
                make_plain_patches(&mut bytes, [level_size.width, rows], rng);
            }
            write_texture(self.gpu, &texture, level, &bytes);
            if level == 0 {
                initial = bytes;
            }
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(view_dimension),
            ..wgpu::TextureViewDescriptor::default()
        });
        Ok(MadeKind::Texture {
            texture,
            view,
            initial,
        })
    }

    /// A texel: poison, or something that a shader can read; floats as far from 0 as `reach`, if it is not 0.
    fn texel(&self, format: wgpu::TextureFormat, poison: bool, rng: &mut Rng) -> Vec<u8> {
        use wgpu::TextureFormat as F;
        let bytes = format.block_copy_size(None).unwrap_or(4) as usize;
        let components = usize::from(format.components());
        let float = |rng: &mut Rng| match poison {
            true => 2.0 + rng.f32(),
            false if self.reach > 0 => (rng.f32() * 2.0 - 1.0) * self.reach as f32,
            false => match self.end(rng) {
                Some(end) => f32::from(end),
                None => rng.f32(),
            },
        };
        match format {
            F::R16Float | F::Rg16Float | F::Rgba16Float => (0..components)
                .flat_map(|_| half(float(rng)).to_le_bytes())
                .collect(),
            F::R32Float | F::Rg32Float | F::Rgba32Float => (0..components)
                .flat_map(|_| float(rng).to_le_bytes())
                .collect(),
            // exponents 8 to 15 of 31: no NaN, no infinity
            F::Rg11b10Ufloat => {
                let part = |rng: &mut Rng, mantissa: u32| {
                    rng.u32(8..16) << mantissa | rng.u32(0..1 << mantissa)
                };
                let bits = part(rng, 6) | part(rng, 6) << 11 | part(rng, 5) << 22;
                bits.to_le_bytes().to_vec()
            }
            F::R32Uint | F::Rg32Uint | F::Rgba32Uint | F::R32Sint | F::Rg32Sint | F::Rgba32Sint => {
                (0..components)
                    .flat_map(|_| {
                        match poison {
                            true => rng.u32(0x4000_0000..0x7fff_ffff),
                            false => rng.u32(0..8),
                        }
                        .to_le_bytes()
                    })
                    .collect()
            }
            F::Depth16Unorm if !poison => {
                let end = self.end(rng).map(|end| u16::from(end) * u16::MAX);
                end.unwrap_or_else(|| rng.u16(..)).to_le_bytes().to_vec()
            }
            _ => (0..bytes)
                .map(|_| match poison {
                    true => rng.u8(1..0x7f),
                    false => rng.u8(..),
                })
                .collect(),
        }
    }

    /// With more breadth, often 0 or 1: a depth of nothing, a mask, a share of all, which chance never makes and shaders ask for.
    fn end(&self, rng: &mut Rng) -> Option<u8> {
        if self.breadth == 0 {
            return None;
        }
        let end = rng.u8(0..8);
        (end < 2).then_some(end)
    }
}

/// Values for overrides: those that are set, and a small number for each that has no default.
pub fn constants(module: &Module, settings: &Settings) -> Vec<(String, f64)> {
    module
        .overrides
        .iter()
        .filter_map(|(_, item)| {
            let name = item.name.as_deref().unwrap_or_default();
            let key = match item.id {
                Some(id) => id.to_string(),
                None => name.to_owned(),
            };
            let set = settings.set.get(name).and_then(|v| v.first());
            match (set, item.init) {
                (Some(&value), _) => Some((key, value)),
                (None, Some(_)) => None,
                // most often a workgroup's side
                (None, None) => Some((key, 8.0)),
            }
        })
        .collect()
}

/// Writes a level of a texture, all layers.
pub fn write_texture(gpu: &Gpu, texture: &wgpu::Texture, level: u32, bytes: &[u8]) {
    let size = texture.size().mip_level_size(level, texture.dimension());
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size.width * texel),
            rows_per_image: Some(size.height),
        },
        size,
    );
}

fn write_scalar(value: f64, scalar: naga::Scalar, slot: &mut [u8]) {
    let width = usize::from(scalar.width);
    if slot.len() < width {
        return;
    }
    match (scalar.kind, width) {
        (ScalarKind::Float, 4) => slot[..4].copy_from_slice(&(value as f32).to_le_bytes()),
        (ScalarKind::Float, 2) => slot[..2].copy_from_slice(&half(value as f32).to_le_bytes()),
        (ScalarKind::Float, 8) => slot[..8].copy_from_slice(&value.to_le_bytes()),
        (ScalarKind::Sint, _) => {
            slot[..width].copy_from_slice(&(value as i64).to_le_bytes()[..width]);
        }
        _ => slot[..width].copy_from_slice(&(value as u64).to_le_bytes()[..width]),
    }
}

/// A half float, for values that have one: 0, and 2⁻¹⁴ to 65504; cut off, not rounded.
pub fn half(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = (bits >> 16 & 0x8000) as u16;
    let exponent = (bits >> 23 & 0xff) as i32 - 127 + 15;
    match exponent {
        ..=0 => sign,
        31.. => sign | 0x7bff,
        _ => sign | (exponent as u16) << 10 | (bits >> 13 & 0x3ff) as u16,
    }
}

/// Makes a quarter of a picture plain, in patches of 16 by 16 texels: shaders that work by tiles ask whether one is the same throughout.
fn make_plain_patches(bytes: &mut [u8], [width, rows]: [u32; 2], rng: &mut Rng) {
    const SIDE: u32 = 16;
    let texel = bytes.len() / (width * rows).max(1) as usize;
    let at = |x: u32, y: u32| (y * width + x) as usize * texel;
    for top in (0..rows).step_by(SIDE as usize) {
        for left in (0..width).step_by(SIDE as usize) {
            if rng.u8(0..4) > 0 {
                continue;
            }
            let first = bytes[at(left, top)..at(left, top) + texel].to_vec();
            for y in top..rows.min(top + SIDE) {
                for x in left..width.min(left + SIDE) {
                    bytes[at(x, y)..at(x, y) + texel].copy_from_slice(&first);
                }
            }
        }
    }
}

struct Picture {
    width: u32,
    height: u32,
    texels: Vec<u8>,
}

/// Why a file cannot be read.
fn why_unread(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        _ => error.to_string(),
    }
}

/// Reads a picture in the form of a texture format.
fn read_picture(
    path: &std::path::Path,
    format: wgpu::TextureFormat,
) -> Result<Picture, InputError> {
    use wgpu::TextureFormat as F;
    let wrong = |why: String| InputError::File {
        path: path.display().to_string(),
        why,
    };
    let bytes = std::fs::read(path).map_err(|error| wrong(why_unread(&error)))?;
    let picture = crate::picture::decode(&bytes).map_err(wrong)?;
    let (width, height) = (picture.width(), picture.height());
    let components = usize::from(format.components());
    let floats = picture.to_rgba32f();
    let texels = match format {
        F::Rgba16Float | F::Rg16Float | F::R16Float => floats
            .pixels()
            .flat_map(|p| {
                p.0[..components]
                    .iter()
                    .flat_map(|&v| half(v).to_le_bytes())
                    .collect::<Vec<_>>()
            })
            .collect(),
        F::Rgba32Float | F::Rg32Float | F::R32Float => floats
            .pixels()
            .flat_map(|p| {
                p.0[..components]
                    .iter()
                    .flat_map(|v| v.to_le_bytes())
                    .collect::<Vec<_>>()
            })
            .collect(),
        F::Rgba8Unorm => picture.to_rgba8().into_raw(),
        F::Depth16Unorm => picture
            .to_luma16()
            .into_raw()
            .into_iter()
            .flat_map(u16::to_le_bytes)
            .collect(),
        other => {
            return Err(wrong(format!(
                "a picture does not fit a texture of format {other:?}"
            )));
        }
    };
    Ok(Picture {
        width,
        height,
        texels,
    })
}
