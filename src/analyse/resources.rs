//! What a caller binds to the analysis: looked at when it is bound, and held against each frame.
//!
//! *Refuses*: what a plan has and the caller did not give, what is of another kind, and frames that are larger than what is bound.

use super::{
    half,
    inputs::{Frame, FrameError},
    params, tiles,
};
use crate::{
    plan::{Binding, ColourForm, Plan},
    sri::SriLayout,
};

/// The caller's resources, one for each [`Binding`] that the plan has; parameters and tables are the analysis's own.
pub type Resources<'a> = &'a [(Binding, wgpu::BindingResource<'a>)];

/// What a caller gave does not do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// A binding that the plan has and the caller did not give.
    #[error("the plan binds {}, which is not given", .0.name())]
    Missing(Binding),
    /// A buffer where a texture is bound, or the other way round.
    #[error("the plan binds {} as a {wanted}, and something else was given", .binding.name())]
    Kind {
        /// Which.
        binding: Binding,
        /// `texture` or `buffer`.
        wanted: &'static str,
    },
    /// A texture that no shader may read, or a buffer that none may bind.
    #[error("what is given as {} needs the usage `{usage}`", .binding.name())]
    Usage {
        /// Which.
        binding: Binding,
        /// The usage.
        usage: &'static str,
    },
    /// A texture with more samples than one.
    #[error("the texture of {} has {samples} samples a pixel: resolve it first", .binding.name())]
    Samples {
        /// Which.
        binding: Binding,
        /// Its samples.
        samples: u32,
    },
    /// wgpu does not bind it for another reason: a format of another kind, an aspect or a dimension that a shader does not read here, an
    /// offset that is not aligned, another device.
    #[error("wgpu does not bind what was given: {0}")]
    Refused(String),
}

/// How large what is bound is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Room {
    /// A texture's width and height. (Of a view of a smaller mip level, the texture's own.)
    Texels([u32; 2]),
    /// A buffer's bytes.
    Bytes(u64),
}

/// Finds what is given for a binding.
pub(super) fn given<'a>(
    resources: Resources<'a>,
    binding: Binding,
) -> Result<wgpu::BindingResource<'a>, BindError> {
    let found = resources.iter().find(|(given, _)| *given == binding);
    found
        .map(|(_, resource)| resource.clone())
        .ok_or(BindError::Missing(binding))
}

/// The sizes of all that the caller gave and the plan has.
pub(super) fn rooms(plan: &Plan, resources: Resources) -> Result<Vec<(Binding, Room)>, BindError> {
    let own = [Binding::Params, Binding::Tables, Binding::Optics];
    let bindings = plan.bindings.iter().chain(&plan.later).copied();
    bindings
        .filter(|binding| !own.contains(binding))
        .map(|binding| {
            let resource = given(resources, binding)?;
            Ok((binding, room(plan.scene.colour, binding, &resource)?))
        })
        .collect()
}

fn room(
    colour: ColourForm,
    binding: Binding,
    resource: &wgpu::BindingResource,
) -> Result<Room, BindError> {
    match (binding.is_storage_buffer(colour), resource) {
        (true, wgpu::BindingResource::Buffer(part)) => {
            if !part.buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
                let usage = "STORAGE";
                return Err(BindError::Usage { binding, usage });
            }
            let rest = part.buffer.size().saturating_sub(part.offset);
            Ok(Room::Bytes(part.size.map_or(rest, |size| size.get())))
        }
        (false, wgpu::BindingResource::TextureView(view)) => {
            let texture = view.texture();
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            if !texture.usage().contains(usage) {
                let usage = "TEXTURE_BINDING";
                return Err(BindError::Usage { binding, usage });
            }
            match texture.sample_count() {
                1 => Ok(Room::Texels([texture.width(), texture.height()])),
                samples => Err(BindError::Samples { binding, samples }),
            }
        }
        (true, _) => Err(BindError::Kind {
            binding,
            wanted: "buffer",
        }),
        (false, _) => Err(BindError::Kind {
            binding,
            wanted: "texture",
        }),
    }
}

/// Whether what is bound has room for a frame.
pub(super) fn check(
    plan: &Plan,
    rooms: &[(Binding, Room)],
    frame: &Frame,
) -> Result<(), FrameError> {
    frame.check()?;
    for &(binding, room) in rooms {
        let what = binding.name();
        match room {
            Room::Texels(got) => {
                let wanted = texels(plan, binding, frame);
                if got[0] < wanted[0] || got[1] < wanted[1] {
                    return Err(FrameError::Texture { what, got, wanted });
                }
            }
            Room::Bytes(got) => {
                let wanted = bytes(binding, frame);
                if got < wanted {
                    return Err(FrameError::Buffer { what, got, wanted });
                }
            }
        }
    }
    Ok(())
}

/// The least size of a texture.
fn texels(plan: &Plan, binding: Binding, frame: &Frame) -> [u32; 2] {
    let (origin, size) = match binding {
        Binding::Materials if plan.settings.has_materials_before() => {
            (frame.previous_origin, frame.previous_size)
        }
        Binding::Colour | Binding::After | Binding::PreviousDepth => {
            (frame.previous_origin, frame.previous_size)
        }
        _ => (frame.origin, frame.size),
    };
    [0, 1].map(|axis| origin[axis].saturating_add(size[axis]))
}

/// The least size of a buffer.
fn bytes(binding: Binding, frame: &Frame) -> u64 {
    let rates = |[width, height]: [u32; 2]| SriLayout::new(width, height).bytes();
    match binding {
        Binding::Colour | Binding::After | Binding::SqrtLuma => {
            let [width, height] = frame.previous_size;
            u64::from(params::luma_pitch(width)) * u64::from(height)
        }
        Binding::PreviousRates => rates(frame.previous_size),
        Binding::HalfRates => rates(half::size_of(frame.size)),
        Binding::TileData => tiles::data_bytes(frame.previous_size),
        _ => rates(frame.size),
    }
}
