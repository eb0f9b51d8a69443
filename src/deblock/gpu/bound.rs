//! A picture and what lies beside it, bound to a deblocker: held against what the options declare, and against the extent.

use std::sync::Mutex;

use super::{Deblocker, Params, Set};
use crate::{
    deblock::{Counters, DeblockError, Picture, Way, luma_pitch},
    flat,
    home::Home,
    scope,
    slots::Slots,
    sri::SriLayout,
    view::View,
};

/// What a deblocker works on.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'i> {
    /// The picture. A texture needs the usages `STORAGE_BINDING` and, where it goes through a scratch texture,
    /// `TEXTURE_BINDING`.
    pub picture: PictureInput<'i>,
    /// The effective rates: a byte for each quad in the form of [`SriLayout`], the low 4 bits the rate's code, bit 7 set where
    /// coverage split the quad's block. A plain shading-rate image will do where nothing is split.
    pub rates: &'i wgpu::Buffer,
    /// Depth, if declared: a depth texture (its depth aspect) or one of 32-bit floats.
    pub depth: Option<&'i wgpu::TextureView>,
    /// Surface numbers, if declared: an unsigned-integer texture.
    pub surfaces: Option<&'i wgpu::TextureView>,
    /// Where the luma goes, if declared: a storage buffer of [`luma_pitch`] times the height.
    pub luma: Option<&'i wgpu::Buffer>,
}

impl<'i> Inputs<'i> {
    /// A picture that is shaded over a view, by the view's effective rates; neither depth nor surfaces nor luma.
    ///
    /// # Errors
    /// If the view keeps no [effective](View::effective) rates.
    pub fn of_view(view: &'i View, picture: PictureInput<'i>) -> Result<Inputs<'i>, DeblockError> {
        Ok(Inputs {
            picture,
            rates: view.effective().ok_or(DeblockError::NoEffectiveRates)?,
            depth: None,
            surfaces: None,
            luma: None,
        })
    }
}

/// A picture to deblock.
#[derive(Clone, Copy, Debug)]
pub enum PictureInput<'i> {
    /// A texture.
    Texture(&'i wgpu::TextureView),
    /// A storage buffer, and pixels from row to row.
    Buffer(&'i wgpu::Buffer, u32),
}

/// A deblocker's bindings to one picture.
///
/// They hold the buffer of rates that they were made with. A [view](View) that outgrows its buffers has others then:
/// [`Deblocker::record_view`] notices, and asks for a new binding.
#[derive(Debug)]
pub struct Bound {
    pub(super) home: Home,
    pub(super) room: [u32; 2],
    /// The least of the sizes of depth and surfaces.
    pub(super) beside: [u32; 2],
    pub(super) picture_pitch: u32,
    pub(super) rates: wgpu::Buffer,
    pub(super) luma_size: u64,
    pub(super) params: Slots,
    pub(super) group: wgpu::BindGroup,
    pub(super) give_back: Option<wgpu::BindGroup>,
    pub(super) counters: Option<wgpu::Buffer>,
    /// What was set.
    pub(super) set: Mutex<Option<Set>>,
}

impl Deblocker {
    /// Binds a picture and its inputs, for [`record_view`](Deblocker::record_view), or for [`set_frame`](Deblocker::set_frame) and
    /// [`record`](Deblocker::record) where the rates are no view's.
    ///
    /// # Errors
    /// If an input that was declared is missing, one that was not is given, wgpu does not bind one (it lacks a usage, or is of another
    /// kind), or the device is another than the deblocker's.
    pub fn bind(&self, device: &wgpu::Device, inputs: &Inputs) -> Result<Bound, DeblockError> {
        if self.home != Home::of(device) {
            return Err(DeblockError::Device);
        }
        let agree = |what, declared: bool, given: bool| match declared == given {
            true => Ok(()),
            false => Err(DeblockError::Inputs(format!(
                "{what} {}",
                match declared {
                    true => "was declared and is missing",
                    false => "was given but not declared in the options",
                }
            ))),
        };
        agree(
            "depth",
            self.options.depth.is_some(),
            inputs.depth.is_some(),
        )?;
        agree("surfaces", self.options.surfaces, inputs.surfaces.is_some())?;
        agree("luma", self.options.luma.is_some(), inputs.luma.is_some())?;
        let (room, picture_pitch) = self.room(inputs)?;
        scope::caught(device, || self.bound(device, inputs, room, picture_pitch))
            .map_err(|error| DeblockError::Refused(scope::in_words(&error)))
    }

    fn bound(
        &self,
        device: &wgpu::Device,
        inputs: &Inputs,
        room: [u32; 2],
        picture_pitch: u32,
    ) -> Bound {
        let name = |part: &str| format!("{} {part}", self.label);
        let params = Slots::new(device, size_of::<Params>(), &name("params"));
        let counters = self.options.counters.then(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&name("counters")),
                size: size_of::<Counters>() as u64,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        });
        let scratch = (self.way == Way::Scratch).then(|| self.scratch(device, room));
        let (from, to) = match (inputs.picture, &scratch) {
            (PictureInput::Texture(view), Some(scratch)) => (
                wgpu::BindingResource::TextureView(view),
                Some(wgpu::BindingResource::TextureView(scratch)),
            ),
            (PictureInput::Texture(view), None) => (wgpu::BindingResource::TextureView(view), None),
            (PictureInput::Buffer(buffer, _), _) => (buffer.as_entire_binding(), None),
        };
        let group = |picture: wgpu::BindingResource, result: Option<wgpu::BindingResource>| {
            let mut entries = vec![
                (0, params.binding()),
                (1, inputs.rates.as_entire_binding()),
                (2, picture),
            ];
            entries.extend(result.map(|result| (3, result)));
            entries.extend(
                inputs
                    .depth
                    .map(|view| (4, wgpu::BindingResource::TextureView(view))),
            );
            entries.extend(
                inputs
                    .surfaces
                    .map(|view| (5, wgpu::BindingResource::TextureView(view))),
            );
            entries.extend(inputs.luma.map(|buffer| (6, buffer.as_entire_binding())));
            entries.extend(
                counters
                    .as_ref()
                    .map(|buffer| (7, buffer.as_entire_binding())),
            );
            entries.extend(
                self.codes
                    .as_ref()
                    .map(|buffer| (8, buffer.as_entire_binding())),
            );
            let entries: Vec<wgpu::BindGroupEntry> = entries
                .into_iter()
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&self.label),
                layout: &self.layout,
                entries: &entries,
            })
        };
        let beside = [inputs.depth, inputs.surfaces].into_iter().flatten();
        let beside = beside.fold([u32::MAX; 2], |least, view| {
            let texture = view.texture();
            [
                least[0].min(texture.width()),
                least[1].min(texture.height()),
            ]
        });
        Bound {
            home: self.home.clone(),
            room,
            beside,
            picture_pitch,
            rates: inputs.rates.clone(),
            luma_size: inputs.luma.map_or(0, wgpu::Buffer::size),
            give_back: to.clone().map(|to| group(to, Some(from.clone()))),
            group: group(from, to),
            params,
            counters,
            set: Mutex::default(),
        }
    }

    /// The largest extent that the picture holds, and the pixels in a row of one in a buffer.
    fn room(&self, inputs: &Inputs) -> Result<([u32; 2], u32), DeblockError> {
        match (self.options.picture, inputs.picture) {
            (Picture::Buffer(packing), PictureInput::Buffer(buffer, pitch)) => {
                let pixels = buffer.size() / 4 / u64::from(packing.words());
                let rows = pixels / u64::from(pitch.max(1));
                Ok(([pitch, u32::try_from(rows).unwrap_or(u32::MAX)], pitch))
            }
            (Picture::Texture(_) | Picture::R32Uint(_), PictureInput::Texture(view)) => {
                let wanted = match self.options.picture {
                    Picture::Texture(format) => format,
                    _ => wgpu::TextureFormat::R32Uint,
                };
                let texture = view.texture();
                match texture.format() == wanted {
                    true => Ok(([texture.width(), texture.height()], 0)),
                    false => Err(DeblockError::Inputs(format!(
                        "the picture is {:?}; {wanted:?} was declared",
                        texture.format()
                    ))),
                }
            }
            _ => Err(DeblockError::Inputs(
                "the picture is a buffer where a texture was declared, or the other way round"
                    .into(),
            )),
        }
    }

    fn scratch(&self, device: &wgpu::Device, size: [u32; 2]) -> wgpu::TextureView {
        let format = match self.options.picture {
            Picture::Texture(format) => format,
            Picture::R32Uint(_) | Picture::Buffer(_) => wgpu::TextureFormat::R32Uint,
        };
        let label = format!("{} scratch", self.label);
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let texture = device.create_texture(&flat::texture(&label, size, format, usage));
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Whether everything that is bound has room for an extent.
    pub(super) fn fit(&self, bound: &Bound, set: Set) -> Result<(), DeblockError> {
        let Set { extent, origin, .. } = set;
        if extent.contains(&0) {
            return Err(DeblockError::Inputs(format!(
                "an extent of {}x{} has no pixels",
                extent[0], extent[1]
            )));
        }
        let sri = SriLayout::new(extent[0], extent[1]);
        let luma_bytes = match self.options.luma {
            Some(_) => u64::from(luma_pitch(extent[0])) * u64::from(extent[1]),
            None => 0,
        };
        let end = [0, 1].map(|axis| origin[axis].saturating_add(extent[axis]));
        let holds = |room: [u32; 2]| end[0] <= room[0] && end[1] <= room[1];
        if !holds(bound.beside) {
            return Err(DeblockError::Inputs(format!(
                "an extent of {}x{} at {origin:?} needs depth and surfaces as large as that, and one of them is {}x{}",
                extent[0], extent[1], bound.beside[0], bound.beside[1]
            )));
        }
        let fits =
            holds(bound.room) && sri.bytes() <= bound.rates.size() && luma_bytes <= bound.luma_size;
        match fits {
            true => Ok(()),
            false => Err(DeblockError::Inputs(format!(
                "an extent of {}x{} at {origin:?} needs a picture as large as that ({}x{} given), {} bytes of rates ({} given) and {luma_bytes} \
                 of luma ({} given)",
                extent[0],
                extent[1],
                bound.room[0],
                bound.room[1],
                sri.bytes(),
                bound.rates.size(),
                bound.luma_size
            ))),
        }
    }
}

impl Bound {
    /// The buffer of the [`Counters`], if they are kept: to be copied and mapped by the caller.
    pub fn counters(&self) -> Option<&wgpu::Buffer> {
        self.counters.as_ref()
    }
}
