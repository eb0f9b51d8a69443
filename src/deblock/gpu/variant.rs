//! What the options make of the kernel: how the picture is reached, what is defined, what is bound.

use crate::{
    analyse::params::linear_code,
    deblock::{DeblockError, DepthKind, Options, Packing, Picture, Way, Weights},
    kernel::{self, shader},
};

/// Whether the luma's values are display-encoded, and linear light is looked up.
fn has_codes(options: &Options) -> bool {
    options.luma.is_some_and(|luma| luma.transfer.is_some())
}

/// Linear light of the 256 codes.
pub(super) fn codes(device: &wgpu::Device, options: &Options, label: &str) -> Option<wgpu::Buffer> {
    let transfer = options.luma?.transfer?;
    let words: Vec<u32> = (0..=255).map(|code| linear_code(code, transfer)).collect();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&format!("{label} codes")),
        size: 1024,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: true,
    });
    if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
        mapped.copy_from_slice(bytemuck::cast_slice(&words));
    }
    buffer.unmap();
    Some(buffer)
}

pub(super) fn check(options: &Options) -> Result<(), DeblockError> {
    if let Some(depth) = options.depth {
        depth.check().map_err(DeblockError::Options)?;
    }
    if let Some(luma) = options.luma
        && !(-64..=64).contains(&luma.white_log2)
    {
        return Err(DeblockError::Options(
            "white has to be a power of two from -64 to 64",
        ));
    }
    match options.picture {
        Picture::R32Uint(packing) if packing.words() != 1 => Err(DeblockError::Options(
            "a texel of r32uint holds one word: rgba8unorm or rg11b10ufloat",
        )),
        _ => Ok(()),
    }
}

/// Chooses the way.
pub(super) fn way(
    device: &wgpu::Device,
    adapter: Option<&wgpu::Adapter>,
    picture: Picture,
) -> Result<Way, DeblockError> {
    use wgpu::{TextureFormat as T, TextureFormatFeatureFlags as Flags};
    let Picture::Texture(format) = picture else {
        return Ok(Way::InPlace);
    };
    let refuse = |why| Err(DeblockError::Format { format, why });
    if !matches!(
        format,
        T::Rgba8Unorm | T::Rgba16Float | T::Rgba32Float | T::Rg11b10Ufloat
    ) {
        return refuse(
            "is not supported; the formats are rgba8unorm, rgba16float, rgba32float and rg11b10ufloat, or r32uint and buffers of packed \
             pixels",
        );
    }
    let features = device.features();
    let is_asked = features.contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
    let known = match adapter.filter(|_| is_asked) {
        Some(adapter) => adapter.get_texture_format_features(format),
        None => format.guaranteed_format_features(features),
    };
    if known.flags.contains(Flags::STORAGE_READ_WRITE) {
        return Ok(Way::InPlace);
    }
    match known.flags.contains(Flags::STORAGE_WRITE_ONLY) {
        true => Ok(Way::Scratch),
        false => refuse(
            "is not stored by this device; pack it into an r32uint texture or a storage buffer (`Packing`), or request \
             TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES and give the adapter",
        ),
    }
}

/// The passes of a deblocker with these options, where the picture is read and written in place.
pub(crate) fn planned(options: &Options) -> Vec<crate::plan::PlannedPass> {
    let defs = defs(options, Way::InPlace);
    vec![kernel::planned(shader!("deblock.wgsl"), &defs)]
}

pub(super) fn defs(options: &Options, way: Way) -> Vec<(&'static str, u32)> {
    let packed = |packing| match packing {
        Packing::Rgba8Unorm => vec!["PACKED_RGBA8", "ONE_WORD"],
        Packing::Rg11b10Ufloat => vec!["PACKED_RG11B10", "ONE_WORD"],
        Packing::Rgba16Float => vec!["TWO_WORDS"],
        Packing::Rgba32Float => vec!["FOUR_WORDS"],
    };
    let mut names = match options.picture {
        Picture::Texture(format) => vec![
            match way {
                Way::InPlace => "IN_PLACE",
                Way::Scratch => "SCRATCH",
            },
            match format {
                wgpu::TextureFormat::Rgba8Unorm => "RGBA8",
                wgpu::TextureFormat::Rgba16Float => "RGBA16",
                wgpu::TextureFormat::Rgba32Float => "RGBA32",
                _ => "RG11B10",
            },
        ],
        Picture::R32Uint(packing) => [vec!["R32UINT"], packed(packing)].concat(),
        Picture::Buffer(packing) => [vec!["BUFFER"], packed(packing)].concat(),
    };
    if let Some(depth) = options.depth {
        names.push("DEPTH");
        if depth.kind == DepthKind::Linear {
            names.push("LINEAR");
        }
    }
    if options.surfaces {
        names.push("SURFACES");
    }
    if let Some(luma) = options.luma {
        names.push("LUMA");
        if luma.transfer.is_some() {
            names.push("LUMA_CODES");
        }
        if luma.weights == Weights::Rec709 {
            names.push("REC709");
        }
    }
    if options.counters {
        names.push("COUNTERS");
    }
    if options.depth.is_none() && !options.surfaces && !options.counters {
        names.push("BY_QUADS");
    }
    if options.coverage {
        names.push("SPLITS");
    }
    names.into_iter().map(|name| (name, 1)).collect()
}

pub(super) fn layout(
    device: &wgpu::Device,
    options: &Options,
    way: Way,
    label: &str,
) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let sampled = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let stored = |access, format| wgpu::BindingType::StorageTexture {
        access,
        format,
        view_dimension: wgpu::TextureViewDimension::D2,
    };
    let float = wgpu::TextureSampleType::Float { filterable: false };
    let mut bindings = vec![
        (
            0,
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: None,
            },
        ),
        (1, storage(true)),
    ];
    use wgpu::StorageTextureAccess::{ReadWrite, WriteOnly};
    match (options.picture, way) {
        (Picture::Texture(format), Way::InPlace) => bindings.push((2, stored(ReadWrite, format))),
        (Picture::Texture(format), Way::Scratch) => {
            bindings.push((2, sampled(float)));
            bindings.push((3, stored(WriteOnly, format)));
        }
        (Picture::R32Uint(_), _) => {
            bindings.push((2, stored(ReadWrite, wgpu::TextureFormat::R32Uint)));
        }
        (Picture::Buffer(_), _) => bindings.push((2, storage(false))),
    }
    let optional = [
        (4, options.depth.is_some(), sampled(float)),
        (5, options.surfaces, sampled(wgpu::TextureSampleType::Uint)),
        (6, options.luma.is_some(), storage(false)),
        (7, options.counters, storage(false)),
        (8, has_codes(options), storage(true)),
    ];
    bindings.extend(
        optional
            .into_iter()
            .filter(|&(_, is_declared, _)| is_declared)
            .map(|(binding, _, ty)| (binding, ty)),
    );
    let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
        .into_iter()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}
