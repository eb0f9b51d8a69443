//! The analysis on the GPU: `shaders/analyse.wgsl` and `shaders/smooth.wgsl`, recorded into the caller's own pass.
//!
//! *Needs*: the caller's device, textures and buffers; default limits suffice. *Guarantees*: the words of
//! [`integer`](super::integer), on every driver; nothing is compiled, bound or dispatched that the plan does not have.

use std::sync::{Mutex, PoisonError};

use bytemuck::{Pod, Zeroable};

pub use super::resources::{BindError, Resources};
use super::{
    after::{After, BoundAfter},
    analyser::AnalyserError,
    inputs::{Frame, FrameError},
    optics::Optics,
    params::{self, Params},
    resources::{self, Room, given},
    settings::{Granularity, Smoothing},
};
use crate::{
    kernel::{self, shader},
    limits::LimitError,
    object::ObjectOptions,
    plan::{Binding, ColourForm, Plan, REGION},
    scope,
    sri::SriLayout,
};

/// The pipelines of a plan.
#[derive(Clone, Debug)]
pub struct Analysis {
    plan: Plan,
    label: String,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// The same for frames whose size asks for no way around borders, where there is such a kernel.
    whole: Option<wgpu::ComputePipeline>,
    /// What the previous picture's tiles tell.
    tiles: Option<wgpu::ComputePipeline>,
    /// The attachment, where it is of tiles and the rates of quads.
    attachment: Option<wgpu::ComputePipeline>,
    luma: Option<wgpu::ComputePipeline>,
    smoothing: Option<SmoothKernel>,
    after: After,
}

#[derive(Clone, Debug)]
struct SmoothKernel {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// An analysis bound to resources.
#[derive(Debug)]
pub struct BoundAnalysis {
    params: wgpu::Buffer,
    tables: wgpu::Buffer,
    optics: Option<wgpu::Buffer>,
    group: wgpu::BindGroup,
    smooth: Vec<wgpu::BindGroup>,
    /// One for each of `smooth`, and of which rates.
    smooth_params: Vec<(wgpu::Buffer, Binding)>,
    after: BoundAfter,
    rooms: Vec<(Binding, Room)>,
    /// The frame whose parameters are there.
    set: Mutex<Option<Frame>>,
}

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct SmoothParams {
    size: [u32; 2],
    pitch: u32,
    has_reasons: u32,
    step: u32,
    room: [u32; 3],
}

pub(super) fn kind(binding: Binding, colour: ColourForm) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let read = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let write = buffer(wgpu::BufferBindingType::Storage { read_only: false });
    let float = texture(wgpu::TextureSampleType::Float { filterable: false });
    match binding {
        Binding::Params | Binding::Optics => buffer(wgpu::BufferBindingType::Uniform),
        Binding::Tables | Binding::PreviousRates => read,
        Binding::Rates
        | Binding::Attachment
        | Binding::Reasons
        | Binding::SqrtLuma
        | Binding::TileData
        | Binding::PlainRates
        | Binding::HalfRates => write,
        Binding::Colour | Binding::After if colour == ColourForm::SqrtLuma => read,
        Binding::Colour | Binding::After => float,
        Binding::Motion
        | Binding::Blur
        | Binding::Depth
        | Binding::PreviousDepth
        | Binding::Materials
        | Binding::Noise => float,
        Binding::Flags | Binding::Ids => texture(wgpu::TextureSampleType::Uint),
    }
}

pub(super) fn layout_of(
    device: &wgpu::Device,
    entries: impl Iterator<Item = (u32, wgpu::BindingType)>,
    label: &str,
) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = entries
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

pub(super) fn pipeline_of(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    source: kernel::Source,
    defs: kernel::Defs,
    entry: &str,
    objects: &ObjectOptions,
) -> Result<wgpu::ComputePipeline, LimitError> {
    // SAFETY: no loop of these kernels has more rounds than a constant says
    let module = unsafe { kernel::trusted_module(device, source, defs) }?;
    let unzeroed = kernel::compilation_options();
    Ok(kernel::pipeline(
        device, layout, &module, entry, unzeroed, objects,
    ))
}

impl SmoothKernel {
    fn new(
        device: &wgpu::Device,
        plan: &Plan,
        objects: &ObjectOptions,
    ) -> Result<SmoothKernel, LimitError> {
        let mut kinds = vec![Binding::Params, Binding::Tables, Binding::Rates];
        let mut defs = Vec::new();
        if plan.settings.smoothing == Smoothing::Conservative {
            defs.push(("CONSERVATIVE", 1));
        }
        if plan.bindings.contains(&Binding::Reasons) {
            kinds.push(Binding::Reasons);
            defs.push(("REASONS", 1));
        }
        let colour = plan.scene.colour;
        let kinds = kinds.into_iter().map(|binding| kind(binding, colour));
        let layout = layout_of(device, (0..).zip(kinds), &objects.name("smooth"));
        let source = shader!("smooth.wgsl");
        let pipeline = pipeline_of(device, &layout, source, &defs, "smooth_words", objects)?;
        Ok(SmoothKernel { layout, pipeline })
    }
}

impl Analysis {
    /// Makes the pipelines of a plan.
    ///
    /// # Errors
    /// If the device has too little for them.
    pub fn new(device: &wgpu::Device, plan: &Plan) -> Result<Analysis, AnalyserError> {
        Analysis::with(device, plan, &ObjectOptions::default())
    }

    /// The same, with a name for captures and the caller's cache of pipelines.
    ///
    /// # Errors
    /// As [`Analysis::new`].
    pub fn with(
        device: &wgpu::Device,
        plan: &Plan,
        objects: &ObjectOptions,
    ) -> Result<Analysis, AnalyserError> {
        plan.within(device.limits().max_storage_buffers_per_shader_stage)?;
        let colour = plan.scene.colour;
        let entries = plan
            .bindings
            .iter()
            .map(|&binding| (binding.index(), kind(binding, colour)));
        let layout = layout_of(device, entries, &objects.name("analyse"));
        let defs = plan.defs();
        let made = |source, entry| pipeline_of(device, &layout, source, &defs, entry, objects);
        let when =
            |is_there: bool, source, entry| is_there.then(|| made(source, entry)).transpose();
        let is_by_tiles = plan.settings.is_by_tiles();
        let writes_luma = plan.bindings.contains(&Binding::SqrtLuma);
        Ok(Analysis {
            label: objects.name("analyse"),
            tiles: when(is_by_tiles, shader!("tile_data.wgsl"), "tile_data_of")?,
            pipeline: match (is_by_tiles, plan.settings.granularity) {
                (true, _) => made(shader!("tile_rates.wgsl"), "tile_rates"),
                (false, Granularity::Quad) => made(plan.kernel(), "analyse"),
                (false, _) => made(shader!("tiles.wgsl"), "tiles"),
            }?,
            whole: plan
                .is_by_lines()
                .then(|| {
                    let defs = [defs.as_slice(), &[("WHOLE", 1)]].concat();
                    pipeline_of(device, &layout, plan.kernel(), &defs, "analyse", objects)
                })
                .transpose()?,
            attachment: plan
                .has_attachment_of_its_own()
                .then(|| {
                    let (source, defs) = (shader!("tiles.wgsl"), plan.defs_of_attachment());
                    pipeline_of(device, &layout, source, &defs, "tiles", objects)
                })
                .transpose()?,
            luma: when(writes_luma, shader!("write_luma.wgsl"), "write_luma")?,
            smoothing: match plan.settings.smoothing {
                Smoothing::None => None,
                _ => Some(SmoothKernel::new(device, plan, objects)?),
            },
            after: After::new(device, plan, objects)?,
            layout,
            plan: plan.clone(),
        })
    }

    /// An analysis by another plan that differs in numbers alone, such as thresholds, by the same pipelines: nothing is compiled. Nothing
    /// if the plan needs other kernels.
    pub fn another(&self, plan: &Plan) -> Option<Analysis> {
        let alike = Plan {
            settings: plan.settings.clone(),
            ..self.plan.clone()
        };
        let is_alike = alike == *plan
            && self.plan.defs() == plan.defs()
            && self.plan.defs_of_attachment() == plan.defs_of_attachment()
            && self.plan.settings.smoothing == plan.settings.smoothing;
        is_alike.then(|| Analysis {
            plan: plan.clone(),
            ..self.clone()
        })
    }

    /// How many pipelines a frame takes: one for each of the plan's passes.
    pub fn pipeline_count(&self) -> usize {
        let optional = [
            self.tiles.is_some(),
            self.attachment.is_some(),
            self.luma.is_some(),
            self.smoothing.is_some(),
        ];
        let there = optional.into_iter().filter(|&is_there| is_there).count();
        1 + there + self.after.pipeline_count()
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Binds the caller's resources. With smoothing, the analysis writes raw rates to buffers of its own, of the size of the
    /// caller's, and the smoothed ones to the caller's.
    ///
    /// # Errors
    /// If one that the plan has is not given, or cannot be bound.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        resources: Resources,
    ) -> Result<BoundAnalysis, BindError> {
        let rooms = resources::rooms(&self.plan, resources)?;
        scope::caught(device, || self.bound(device, resources, rooms))
            .map_err(|error| BindError::Refused(scope::in_words(&error)))?
    }

    fn bound(
        &self,
        device: &wgpu::Device,
        resources: Resources,
        rooms: Vec<(Binding, Room)>,
    ) -> Result<BoundAnalysis, BindError> {
        let given = |binding| given(resources, binding);
        let buffer = |size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&self.label),
                size,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let params = buffer(size_of::<Params>() as u64, wgpu::BufferUsages::UNIFORM);
        let tables = buffer(params::TABLE_WORDS as u64 * 4, wgpu::BufferUsages::STORAGE);
        let has_optics = self.plan.bindings.contains(&Binding::Optics);
        let optics =
            has_optics.then(|| buffer(size_of::<Optics>() as u64, wgpu::BufferUsages::UNIFORM));
        let smoothed: Vec<Binding> = [Binding::Rates, Binding::Attachment, Binding::PlainRates]
            .into_iter()
            .filter(|binding| self.smoothing.is_some() && self.plan.bindings.contains(binding))
            .collect();
        let mut raw = Vec::new();
        for &binding in &smoothed {
            let room = rooms.iter().find(|(known, _)| *known == binding);
            let Some(&(_, Room::Bytes(size))) = room else {
                return Err(BindError::Missing(binding));
            };
            raw.push((binding, buffer(size, wgpu::BufferUsages::STORAGE)));
        }
        let mut entries = Vec::new();
        for &binding in &self.plan.bindings {
            let own = raw.iter().find(|(known, _)| *known == binding);
            let resource = match (binding, own) {
                (Binding::Params, _) => params.as_entire_binding(),
                (Binding::Tables, _) => tables.as_entire_binding(),
                (Binding::Optics, _) => match &optics {
                    Some(optics) => optics.as_entire_binding(),
                    None => return Err(BindError::Missing(binding)),
                },
                (_, Some((_, buffer))) => buffer.as_entire_binding(),
                (binding, None) => given(binding)?,
            };
            entries.push(wgpu::BindGroupEntry {
                binding: binding.index(),
                resource,
            });
        }
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.layout,
            entries: &entries,
        });
        let mut smooth_params = Vec::new();
        let mut smooth = Vec::new();
        if let Some(kernel) = &self.smoothing {
            for (binding, from) in &raw {
                let bytes = size_of::<SmoothParams>() as u64;
                let params = buffer(bytes, wgpu::BufferUsages::UNIFORM);
                let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
                let mut entries = vec![
                    entry(0, params.as_entire_binding()),
                    entry(1, from.as_entire_binding()),
                    entry(2, given(*binding)?),
                ];
                if self.plan.bindings.contains(&Binding::Reasons) {
                    entries.push(entry(3, given(Binding::Reasons)?));
                }
                smooth.push(device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(&self.label),
                    layout: &kernel.layout,
                    entries: &entries,
                }));
                smooth_params.push((params, *binding));
            }
        }
        Ok(BoundAnalysis {
            params,
            tables,
            optics,
            group,
            smooth,
            smooth_params,
            after: self.after.bind(device, resources, &self.label)?,
            rooms,
            set: Mutex::new(None),
        })
    }

    /// Sets a frame's parameters for what is submitted from now on. What is as it was is not uploaded again: a frame that is like the one
    /// before costs nothing here.
    ///
    /// # Errors
    /// If the frame makes no sense, or is larger than what is bound; the parameters then stay as they are.
    pub fn set_frame(
        &self,
        queue: &wgpu::Queue,
        bound: &BoundAnalysis,
        frame: &Frame,
    ) -> Result<(), FrameError> {
        let mut set = bound.set.lock().unwrap_or_else(PoisonError::into_inner);
        if *set == Some(*frame) {
            return Ok(());
        }
        let origins = [frame.origin, frame.previous_origin];
        if let Some(&origin) = origins.iter().find(|origin| **origin != [0; 2])
            && !self.plan.scene.origin
        {
            return Err(FrameError::NoOrigin(origin));
        }
        resources::check(&self.plan, &bound.rooms, frame)?;
        let before = set.replace(*frame);
        if let Some(buffer) = &bound.optics {
            let optics = Optics::new(&self.plan.settings, frame);
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&optics));
        }
        // from frame to frame it is cameras that move
        let is_still = |before: Frame| {
            before.cameras.is_some() == frame.cameras.is_some()
                && Frame {
                    cameras: frame.cameras,
                    ..before
                } == *frame
        };
        if !before.is_some_and(is_still) {
            let scale = before.map(|before| before.resolution_scale);
            self.write_params(queue, bound, frame, scale != Some(frame.resolution_scale));
        }
        Ok(())
    }

    fn write_params(
        &self,
        queue: &wgpu::Queue,
        bound: &BoundAnalysis,
        frame: &Frame,
        has_new_tables: bool,
    ) {
        let settings = &self.plan.settings;
        let params = Params::new(settings, frame);
        queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
        if has_new_tables {
            let is_sqrt_luma = self.plan.scene.colour == ColourForm::SqrtLuma;
            let tables = params::tables(settings, is_sqrt_luma, frame.resolution_scale);
            queue.write_buffer(&bound.tables, 0, bytemuck::cast_slice(&tables));
        }
        for (buffer, binding) in &bound.smooth_params {
            let layout = SriLayout::new(frame.size[0], frame.size[1]);
            let granularity = match binding {
                Binding::Attachment => settings.granularity_of_attachment(),
                _ => settings.granularity_of_rates(),
            };
            let smooth = SmoothParams {
                size: [layout.width, layout.height],
                pitch: layout.pitch / 4,
                has_reasons: u32::from(*binding == Binding::Rates),
                step: granularity.side().ilog2() - 1,
                room: [0; 3],
            };
            queue.write_buffer(buffer, 0, bytemuck::bytes_of(&smooth));
        }
        self.after.set_frame(queue, &bound.after, &self.plan, frame);
    }

    /// Records the analysis of a frame into a compute pass.
    pub fn record(&self, pass: &mut wgpu::ComputePass, bound: &BoundAnalysis, frame: &Frame) {
        let size = frame.size;
        let [width, height] = self.plan.tile();
        pass.push_debug_group(&self.label);
        pass.set_bind_group(0, &bound.group, &[]);
        if let Some(data) = &self.tiles {
            let [width, height] = frame.previous_size;
            pass.set_pipeline(data);
            pass.dispatch_workgroups(width.div_ceil(REGION[0]), height.div_ceil(REGION[1]), 1);
        }
        let is_whole = size == frame.previous_size && size[0].is_multiple_of(8);
        let whole = self.whole.as_ref().filter(|_| is_whole);
        pass.set_pipeline(whole.unwrap_or(&self.pipeline));
        pass.dispatch_workgroups(size[0].div_ceil(width), size[1].div_ceil(height), 1);
        if let Some(attachment) = &self.attachment {
            pass.set_pipeline(attachment);
            pass.dispatch_workgroups(size[0].div_ceil(REGION[0]), size[1].div_ceil(REGION[1]), 1);
        }
        if let Some(luma) = &self.luma {
            let [width, height] = frame.previous_size;
            pass.set_pipeline(luma);
            pass.dispatch_workgroups(width.div_ceil(64), height.div_ceil(16), 1);
        }
        if let Some(kernel) = &self.smoothing {
            pass.set_pipeline(&kernel.pipeline);
            for group in &bound.smooth {
                pass.set_bind_group(0, group, &[]);
                pass.dispatch_workgroups(size[0].div_ceil(128), size[1].div_ceil(16), 1);
            }
        }
        self.after.record(pass, &bound.after, size);
        pass.pop_debug_group();
    }
}
