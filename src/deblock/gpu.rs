//! The deblocker on the GPU: `shaders/deblock.wgsl`, recorded into the caller's encoder or pass.

use std::sync::{Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};

use super::{
    Counters, DeblockError, DepthKind, Options, Packing, Picture, Way, Weights, luma_pitch,
};
use crate::analyse::params::linear_code;
use crate::{
    build::primary::Order,
    home::Home,
    kernel::{self, shader},
    object::ObjectOptions,
    scope,
    slots::Slots,
    sri::SriLayout,
    view::View,
};

/// The kernel's parameters, as in `shaders/deblock.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    extent: [u32; 2],
    rates_pitch: u32,
    luma_pitch: u32,
    phase: u32,
    picture_pitch: u32,
    inverse_depth: [f32; 2],
    tolerance: f32,
    white_log2: i32,
    origin: [u32; 2],
}

/// The pixels of a workgroup: 16×16 quads.
const GROUP: [u32; 2] = [32, 32];

/// The pipelines that deblock one kind of picture.
#[derive(Debug)]
pub struct Deblocker {
    home: Home,
    label: String,
    options: Options,
    way: Way,
    layout: wgpu::BindGroupLayout,
    filter: wgpu::ComputePipeline,
    give_back: Option<wgpu::ComputePipeline>,
    /// Linear light of codes, if luma is written from any.
    codes: Option<wgpu::Buffer>,
}

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
    home: Home,
    room: [u32; 2],
    /// The least of the sizes of depth and surfaces.
    beside: [u32; 2],
    picture_pitch: u32,
    rates: wgpu::Buffer,
    luma_size: u64,
    params: Slots,
    group: wgpu::BindGroup,
    give_back: Option<wgpu::BindGroup>,
    counters: Option<wgpu::Buffer>,
    /// What was set.
    set: Mutex<Option<Set>>,
}

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Set {
    extent: [u32; 2],
    /// Where the extent lies in the picture, and in depth and surfaces.
    origin: [u32; 2],
    /// The order of primaries.
    order: Order,
}

impl Deblocker {
    /// Makes the pipelines. `adapter` tells whether the device reads and writes the picture's format in one shader; without it,
    /// only what WebGPU guarantees is used.
    ///
    /// # Errors
    /// If the device does not store the format, the options contradict themselves, or the device has too little.
    pub fn new(
        device: &wgpu::Device,
        adapter: Option<&wgpu::Adapter>,
        options: Options,
    ) -> Result<Deblocker, DeblockError> {
        Deblocker::with(device, adapter, options, &ObjectOptions::default())
    }

    /// The same, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`Deblocker::new`].
    pub fn with(
        device: &wgpu::Device,
        adapter: Option<&wgpu::Adapter>,
        options: Options,
        objects: &ObjectOptions,
    ) -> Result<Deblocker, DeblockError> {
        check(&options)?;
        let way = way(device, adapter, options.picture)?;
        let label = objects.name("deblock");
        let layout = layout(device, &options, way, &label);
        let defs = defs(&options, way);
        let source = shader!("deblock.wgsl");
        let module = match options.depth {
            // a loop that is counted is not unrolled: four copies of three dozen loads of depth take some drivers seconds to compile
            Some(_) => kernel::shader_module(device, source, &defs)?,
            // SAFETY: no loop of this kernel has more rounds than a constant says
            None => unsafe { kernel::trusted_module(device, source, &defs) }?,
        };
        let unzeroed = kernel::compilation_options;
        let pipeline =
            |entry| kernel::pipeline(device, &layout, &module, entry, unzeroed(), objects);
        Ok(Deblocker {
            home: Home::of(device),
            options,
            way,
            filter: pipeline("filter_quads"),
            give_back: (way == Way::Scratch).then(|| pipeline("return_quads")),
            layout,
            codes: codes(device, &options, &label),
            label,
        })
    }

    /// The options.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// How the picture is read and written; its `Display` says why.
    pub fn way(&self) -> Way {
        self.way
    }

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
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&format!("{} scratch", self.label)),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Sets the extent of the picture and the order of the primaries for what is [recorded](Deblocker::record) from now on and submitted
    /// after it, where the rates are no view's. `order` is 0 where the first pixel of a group is always its primary, else 1 + the
    /// frame's number modulo 4: the one that the coordinates of this frame were built with. An order alone uploads nothing.
    ///
    /// # Errors
    /// If an input is smaller than the extent, or the extent has no pixels.
    pub fn set_frame(
        &self,
        queue: &wgpu::Queue,
        bound: &mut Bound,
        extent: [u32; 2],
        order: u32,
    ) -> Result<(), DeblockError> {
        let order = match order {
            0 => Order::Fixed,
            1..=4 => Order::Rotating(order - 1),
            _ => return Err(DeblockError::Options("the order of primaries is 0 to 4")),
        };
        let origin = [0; 2];
        let set = Set {
            extent,
            origin,
            order,
        };
        self.set(queue, bound, set)
    }

    fn set(&self, queue: &wgpu::Queue, bound: &Bound, now: Set) -> Result<(), DeblockError> {
        if self.home != bound.home {
            return Err(DeblockError::Device);
        }
        let mut set = bound.set.lock().unwrap_or_else(PoisonError::into_inner);
        // the parameters of every order are there at once
        let is_there = |before: Set| {
            Set {
                order: now.order,
                ..before
            } == now
        };
        if !set.is_some_and(is_there) {
            self.fit(bound, now)?;
            bound
                .params
                .write(queue, |order| self.params(bound, Set { order, ..now }));
        }
        *set = Some(now);
        Ok(())
    }

    /// Whether everything that is bound has room for an extent.
    fn fit(&self, bound: &Bound, set: Set) -> Result<(), DeblockError> {
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

    fn params(&self, bound: &Bound, set: Set) -> Params {
        let Set { extent, order, .. } = set;
        let depth = self.options.depth;
        Params {
            extent,
            rates_pitch: SriLayout::new(extent[0], extent[1]).pitch / 4,
            luma_pitch: luma_pitch(extent[0]) / 4,
            phase: order.code(),
            picture_pitch: bound.picture_pitch,
            inverse_depth: depth.and_then(|d| d.kind.to_inverse()).unwrap_or_default(),
            tolerance: depth.map_or(0.0, |d| (-f32::from(d.tolerance as u16)).exp2()),
            white_log2: self.options.luma.map_or(0, |luma| luma.white_log2),
            origin: set.origin,
        }
    }

    /// Records the filter of a picture that was shaded over a view into a compute pass of the caller's, for the view's extent and
    /// [order](View::order) of primaries as they are now. Counters go on from where they are. Where the view is not
    /// [enabled](View::set_enabled) there is nothing to deblock: nothing is recorded, and a luma stays as it was.
    ///
    /// # Errors
    /// [`DeblockError::Stale`] if the picture is not bound to this view's effective rates as they are now; other errors if an input is
    /// smaller than the view. Nothing is recorded then.
    pub fn record_view(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::ComputePass,
        bound: &Bound,
        view: &View,
    ) -> Result<(), DeblockError> {
        if self.home != *view.home() {
            return Err(DeblockError::Device);
        }
        if view.effective() != Some(&bound.rates) {
            return Err(DeblockError::Stale);
        }
        if !view.is_enabled() {
            return Ok(());
        }
        let [width, height, _] = view.extent();
        let set = Set {
            extent: [width, height],
            origin: view.origin(),
            order: view.order(),
        };
        self.set(queue, bound, set)?;
        self.record_in(pass, bound)
    }

    /// Records the filter, with a pass of its own; counters start at 0.
    ///
    /// # Errors
    /// As [`record_in`](Deblocker::record_in).
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bound: &Bound,
    ) -> Result<(), DeblockError> {
        self.ready(bound)?;
        if let Some(counters) = &bound.counters {
            encoder.clear_buffer(counters, 0, None);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&self.label),
            timestamp_writes: None,
        });
        self.record_in(&mut pass, bound)
    }

    /// Records the filter into a compute pass of the caller's. Counters go on from where they are. Sets pipelines and bind group 0.
    ///
    /// # Errors
    /// [`DeblockError::NoFrame`] if [`set_frame`](Deblocker::set_frame) was not called, [`DeblockError::Device`] if the picture was bound by
    /// the deblocker of another device; nothing is recorded then.
    pub fn record_in(
        &self,
        pass: &mut wgpu::ComputePass,
        bound: &Bound,
    ) -> Result<(), DeblockError> {
        let _span = tracing::trace_span!("vrcs deblock").entered();
        let Set { extent, order, .. } = self.ready(bound)?;
        let [x, y] = [0, 1].map(|axis| extent[axis].div_ceil(GROUP[axis]));
        let offset = bound.params.offset(order);
        pass.push_debug_group(&self.label);
        pass.set_pipeline(&self.filter);
        pass.set_bind_group(0, &bound.group, &[offset]);
        pass.dispatch_workgroups(x, y, 1);
        if let (Some(pipeline), Some(group)) = (&self.give_back, &bound.give_back) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[offset]);
            pass.dispatch_workgroups(x, y, 1);
        }
        pass.pop_debug_group();
        Ok(())
    }

    /// What was set.
    fn ready(&self, bound: &Bound) -> Result<Set, DeblockError> {
        if self.home != bound.home {
            return Err(DeblockError::Device);
        }
        let set = bound.set.lock().unwrap_or_else(PoisonError::into_inner);
        set.ok_or(DeblockError::NoFrame)
    }
}

impl Bound {
    /// The buffer of the [`Counters`], if they are kept: to be copied and mapped by the caller.
    pub fn counters(&self) -> Option<&wgpu::Buffer> {
        self.counters.as_ref()
    }
}

/// Whether the luma's values are display-encoded, and linear light is looked up.
fn has_codes(options: &Options) -> bool {
    options.luma.is_some_and(|luma| luma.transfer.is_some())
}

/// Linear light of the 256 codes.
fn codes(device: &wgpu::Device, options: &Options, label: &str) -> Option<wgpu::Buffer> {
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

fn check(options: &Options) -> Result<(), DeblockError> {
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
fn way(
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

fn defs(options: &Options, way: Way) -> Vec<(&'static str, u32)> {
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

fn layout(
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
