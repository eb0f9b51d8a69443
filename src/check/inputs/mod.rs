//! Makes up every resource that a shader binds, from a seed.
//!
//! Integers are small, so that loops end and indices stay in range; what is named like a size gets the picture's size;
//! floats lie in 0 to 1. Settings and files override all of that by name. Resources that the shader writes start as
//! poison: values that a shader would hardly store by chance, and never NaN, since a shader may read them.
//!
//! - `names`: whether what the user set occurs in the shader, and what it has instead;
//! - `values`: buffers and immediates, member by member;
//! - `textures`: textures, from chance or from files.

mod names;
mod textures;
mod values;

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
    rc::Rc,
};

use fastrand::Rng;
use naga::{AddressSpace, Expression, Handle, Literal, Module, proc::Layouter};

use super::gpu::Gpu;
use crate::dispatch::reflect::Resource;

pub use textures::write_texture;

/// What the user says of the inputs.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Settings {
    /// Values by name: of a variable, of a member, of `variable.member`, or of an override.
    pub set: BTreeMap<String, Vec<f64>>,
    /// Files by the name of a texture or buffer.
    pub files: BTreeMap<String, PathBuf>,
}

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

/// Why a file cannot be read.
fn why_unread(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        _ => error.to_string(),
    }
}
