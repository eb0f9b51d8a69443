//! The bind group layouts that an entry point needs, read off its module.

use naga::{
    AddressSpace, ImageClass, ImageDimension, Module, StorageAccess, StorageFormat, TypeInner,
    valid::{GlobalUse, ModuleInfo},
};
use std::num::NonZeroU32;

/// A resource that an entry point uses.
#[derive(Clone, Debug)]
pub struct Resource {
    /// The variable.
    pub global: naga::Handle<naga::GlobalVariable>,
    /// Its name, or an empty string.
    pub name: String,
    /// Its bind group.
    pub group: u32,
    /// Its layout entry.
    pub entry: wgpu::BindGroupLayoutEntry,
}

/// Something that a wgpu bind group cannot hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the resource `{name}` cannot be bound: {why}")]
pub struct Unbindable {
    /// The variable's name.
    pub name: String,
    /// Why.
    pub why: String,
}

/// The resources of an entry point, in the order of their declaration.
///
/// # Errors
/// If wgpu has no binding type for one of them.
pub fn resources(
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
) -> Result<Vec<Resource>, Unbindable> {
    let uses = info.get_entry_point(entry);
    let filtered = |global| uses.sampling_set.iter().any(|key| key.image == global);
    let mut resources = Vec::new();
    for (global, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else {
            continue;
        };
        if uses[global] == GlobalUse::empty() {
            continue;
        }
        let name = variable.name.clone().unwrap_or_default();
        let (inner, count) = match module.types[variable.ty].inner {
            TypeInner::BindingArray { base, size } => {
                let count = match size {
                    naga::ArraySize::Constant(count) => NonZeroU32::new(count.get()),
                    naga::ArraySize::Pending(_) | naga::ArraySize::Dynamic => None,
                };
                if count.is_none() {
                    return Err(Unbindable {
                        name,
                        why: "the size of its binding array is not known".to_owned(),
                    });
                }
                (&module.types[base].inner, count)
            }
            ref inner => (inner, None),
        };
        let ty =
            binding_type(variable.space, inner, filtered(global)).map_err(|why| Unbindable {
                name: name.clone(),
                why,
            })?;
        resources.push(Resource {
            global,
            name,
            group: binding.group,
            entry: wgpu::BindGroupLayoutEntry {
                binding: binding.binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count,
            },
        });
    }
    Ok(resources)
}

fn binding_type(
    space: AddressSpace,
    inner: &TypeInner,
    filtered: bool,
) -> Result<wgpu::BindingType, String> {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    match (space, inner) {
        (AddressSpace::Uniform, _) => Ok(buffer(wgpu::BufferBindingType::Uniform)),
        (AddressSpace::Storage { access }, _) => {
            let read_only = !access.contains(StorageAccess::STORE);
            Ok(buffer(wgpu::BufferBindingType::Storage { read_only }))
        }
        (_, TypeInner::Sampler { comparison }) => {
            Ok(wgpu::BindingType::Sampler(match comparison {
                true => wgpu::SamplerBindingType::Comparison,
                false => wgpu::SamplerBindingType::Filtering,
            }))
        }
        (
            _,
            &TypeInner::Image {
                dim,
                arrayed,
                class,
            },
        ) => image_type(dim, arrayed, class, filtered),
        (_, TypeInner::AccelerationStructure { vertex_return }) => {
            Ok(wgpu::BindingType::AccelerationStructure {
                vertex_return: *vertex_return,
            })
        }
        (_, other) => Err(format!("no binding type for {other:?}")),
    }
}

fn image_type(
    dim: ImageDimension,
    arrayed: bool,
    class: ImageClass,
    filtered: bool,
) -> Result<wgpu::BindingType, String> {
    let view_dimension = match (dim, arrayed) {
        (ImageDimension::D1, _) => wgpu::TextureViewDimension::D1,
        (ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
        (ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
        (ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
        (ImageDimension::Cube, false) => wgpu::TextureViewDimension::Cube,
        (ImageDimension::Cube, true) => wgpu::TextureViewDimension::CubeArray,
    };
    let sampled = |sample_type, multisampled| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled,
    };
    Ok(match class {
        ImageClass::Depth { multi } => sampled(wgpu::TextureSampleType::Depth, multi),
        ImageClass::Sampled { kind, multi } => {
            let sample_type = match kind {
                naga::ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                naga::ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                _ => wgpu::TextureSampleType::Float {
                    filterable: filtered && !multi,
                },
            };
            sampled(sample_type, multi)
        }
        ImageClass::Storage { format, access } => wgpu::BindingType::StorageTexture {
            access: storage_access(access),
            format: texture_format(format),
            view_dimension,
        },
        ImageClass::External => return Err("external textures have no binding here".to_owned()),
    })
}

fn storage_access(access: StorageAccess) -> wgpu::StorageTextureAccess {
    if access.contains(StorageAccess::ATOMIC) {
        wgpu::StorageTextureAccess::Atomic
    } else if access.contains(StorageAccess::LOAD | StorageAccess::STORE) {
        wgpu::StorageTextureAccess::ReadWrite
    } else if access.contains(StorageAccess::STORE) {
        wgpu::StorageTextureAccess::WriteOnly
    } else {
        wgpu::StorageTextureAccess::ReadOnly
    }
}

/// wgpu's name for a storage format.
pub fn texture_format(format: StorageFormat) -> wgpu::TextureFormat {
    use StorageFormat as S;
    use wgpu::TextureFormat as T;
    match format {
        S::R8Unorm => T::R8Unorm,
        S::R8Snorm => T::R8Snorm,
        S::R8Uint => T::R8Uint,
        S::R8Sint => T::R8Sint,
        S::R16Uint => T::R16Uint,
        S::R16Sint => T::R16Sint,
        S::R16Float => T::R16Float,
        S::Rg8Unorm => T::Rg8Unorm,
        S::Rg8Snorm => T::Rg8Snorm,
        S::Rg8Uint => T::Rg8Uint,
        S::Rg8Sint => T::Rg8Sint,
        S::R32Uint => T::R32Uint,
        S::R32Sint => T::R32Sint,
        S::R32Float => T::R32Float,
        S::Rg16Uint => T::Rg16Uint,
        S::Rg16Sint => T::Rg16Sint,
        S::Rg16Float => T::Rg16Float,
        S::Rgba8Unorm => T::Rgba8Unorm,
        S::Rgba8Snorm => T::Rgba8Snorm,
        S::Rgba8Uint => T::Rgba8Uint,
        S::Rgba8Sint => T::Rgba8Sint,
        S::Bgra8Unorm => T::Bgra8Unorm,
        S::Rgb10a2Uint => T::Rgb10a2Uint,
        S::Rgb10a2Unorm => T::Rgb10a2Unorm,
        S::Rg11b10Ufloat => T::Rg11b10Ufloat,
        S::R64Uint => T::R64Uint,
        S::Rg32Uint => T::Rg32Uint,
        S::Rg32Sint => T::Rg32Sint,
        S::Rg32Float => T::Rg32Float,
        S::Rgba16Uint => T::Rgba16Uint,
        S::Rgba16Sint => T::Rgba16Sint,
        S::Rgba16Float => T::Rgba16Float,
        S::Rgba32Uint => T::Rgba32Uint,
        S::Rgba32Sint => T::Rgba32Sint,
        S::Rgba32Float => T::Rgba32Float,
        S::R16Unorm => T::R16Unorm,
        S::R16Snorm => T::R16Snorm,
        S::Rg16Unorm => T::Rg16Unorm,
        S::Rg16Snorm => T::Rg16Snorm,
        S::Rgba16Unorm => T::Rgba16Unorm,
        S::Rgba16Snorm => T::Rgba16Snorm,
    }
}

/// The layouts of all bind groups up to the highest that is used; `None` for one that is not.
pub fn group_layouts(
    device: &wgpu::Device,
    resources: &[Resource],
    label: &str,
) -> Vec<Option<wgpu::BindGroupLayout>> {
    let groups = resources.iter().map(|r| r.group + 1).max().unwrap_or(0);
    (0..groups)
        .map(|group| {
            let entries: Vec<_> = resources
                .iter()
                .filter(|resource| resource.group == group)
                .map(|resource| resource.entry)
                .collect();
            (!entries.is_empty()).then(|| {
                device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some(label),
                    entries: &entries,
                })
            })
        })
        .collect()
}
