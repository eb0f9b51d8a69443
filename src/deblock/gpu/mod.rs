//! The deblocker on the GPU: `shaders/deblock.wgsl`, recorded into the caller's encoder or pass.
//!
//! - `bound`: what it works on, held against what was declared and against the picture's size;
//! - `variant`: what the options make of the kernel: its way to the picture, definitions, bindings;
//! - here: the pipelines, what is set from frame to frame, and what is recorded.

mod bound;
mod variant;

use std::sync::PoisonError;

use bytemuck::{Pod, Zeroable};

use super::{DeblockError, Options, Way, luma_pitch};
use crate::{
    build::primary::Order,
    home::Home,
    kernel::{self, shader},
    object::ObjectOptions,
    sri::SriLayout,
    view::View,
};

pub use bound::{Bound, Inputs, PictureInput};
pub(crate) use variant::planned;

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
        variant::check(&options)?;
        let way = variant::way(device, adapter, options.picture)?;
        let label = objects.name("deblock");
        let layout = variant::layout(device, &options, way, &label);
        let defs = variant::defs(&options, way);
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
            codes: variant::codes(device, &options, &label),
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
