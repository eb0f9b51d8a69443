//! What follows the analysis on the GPU, over words of rates: the application's own rates and the rates of half the resolution.
//!
//! Does: `shaders/own.wgsl`, in place, then `shaders/half.wgsl`.
//! Needs: a [`Plan`], and the caller's resources for [`Plan::later`].
//! Guarantees: the words of [`own`](super::own) and [`half`](super::half); nothing is made for what the plan does not have.

use bytemuck::{Pod, Zeroable};

use super::{
    gpu::{kind, layout_of, pipeline_of},
    half::{self, HalfResolution},
    inputs::Frame,
    own,
    resources::{BindError, Resources, given},
};
use crate::{
    kernel::shader,
    limits::LimitError,
    object::ObjectOptions,
    plan::{Binding, Plan},
    sri::SriLayout,
};

#[derive(Clone, Debug)]
struct Kernel {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// What is bound after the parameters: where, and what.
    bindings: Vec<(u32, Binding)>,
}

/// The pipelines.
#[derive(Clone, Debug, Default)]
pub(super) struct After {
    own: Option<Kernel>,
    half: Option<Kernel>,
    has_plain: bool,
}

#[derive(Debug)]
struct BoundKernel {
    params: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// The pipelines' bindings.
#[derive(Debug, Default)]
pub(super) struct BoundAfter {
    /// One for the rates, and one for those without the extra half rate.
    own: Vec<BoundKernel>,
    half: Option<BoundKernel>,
}

#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct HalfParams {
    quads: [u32; 2],
    pitch: u32,
    half_pitch: u32,
}

impl Kernel {
    fn new(
        device: &wgpu::Device,
        plan: &Plan,
        source: crate::kernel::Source,
        defs: &[(&str, u32)],
        entry: &str,
        bindings: Vec<(u32, Binding)>,
        objects: &ObjectOptions,
    ) -> Result<Kernel, LimitError> {
        let colour = plan.scene.colour;
        let params = (0, kind(Binding::Params, colour));
        let is_half = bindings.iter().any(|&(_, b)| b == Binding::HalfRates);
        let others = bindings.iter().map(|&(at, binding)| match binding {
            // what the one writes the other reads
            Binding::Rates if is_half => (at, kind(Binding::PreviousRates, colour)),
            _ => (at, kind(binding, colour)),
        });
        let entries = std::iter::once(params).chain(others);
        let layout = layout_of(device, entries, &objects.name(entry));
        Ok(Kernel {
            pipeline: pipeline_of(device, &layout, source, defs, entry, objects)?,
            layout,
            bindings,
        })
    }

    fn bind(
        &self,
        device: &wgpu::Device,
        bytes: usize,
        resources: Resources,
        label: &str,
    ) -> Result<BoundKernel, BindError> {
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut entries = vec![wgpu::BindGroupEntry {
            binding: 0,
            resource: params.as_entire_binding(),
        }];
        for &(at, binding) in &self.bindings {
            entries.push(wgpu::BindGroupEntry {
                binding: at,
                resource: given(resources, binding)?,
            });
        }
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &self.layout,
            entries: &entries,
        });
        Ok(BoundKernel { params, group })
    }
}

impl After {
    /// How many pipelines there are.
    pub(super) fn pipeline_count(&self) -> usize {
        usize::from(self.own.is_some()) + usize::from(self.half.is_some())
    }

    pub(super) fn new(
        device: &wgpu::Device,
        plan: &Plan,
        objects: &ObjectOptions,
    ) -> Result<After, LimitError> {
        let own = plan.pass("own.wgsl").map(|pass| {
            let has = |name: &str| pass.effects.contains(&name);
            let all = [
                (1, Binding::Rates, true),
                (2, Binding::Reasons, has("REASONS")),
                (3, Binding::Ids, has("IDS")),
                (4, Binding::Depth, has("DISTANCE")),
                (5, Binding::Flags, has("FLAGS")),
            ];
            let bindings = all.into_iter().filter(|&(.., is_there)| is_there);
            let bindings = bindings.map(|(at, binding, _)| (at, binding)).collect();
            let defs: Vec<(&str, u32)> = pass.effects.iter().map(|&name| (name, 1)).collect();
            Kernel::new(
                device,
                plan,
                shader!("own.wgsl"),
                &defs,
                "own_rates",
                bindings,
                objects,
            )
        });
        let half = plan.settings.half_resolution.map(|kind| {
            let defs: &[(&str, u32)] = match kind {
                HalfResolution::Code => &[],
                HalfResolution::Footprint => &[("FOOTPRINT", 1)],
            };
            let bindings = vec![(1, Binding::Rates), (2, Binding::HalfRates)];
            Kernel::new(
                device,
                plan,
                shader!("half.wgsl"),
                defs,
                "half_resolution",
                bindings,
                objects,
            )
        });
        Ok(After {
            own: own.transpose()?,
            half: half.transpose()?,
            has_plain: plan.bindings.contains(&Binding::PlainRates),
        })
    }

    pub(super) fn bind(
        &self,
        device: &wgpu::Device,
        resources: Resources,
        label: &str,
    ) -> Result<BoundAfter, BindError> {
        let bind = |kernel: &Option<Kernel>, bytes| {
            let kernel = kernel.as_ref();
            kernel
                .map(|kernel| kernel.bind(device, bytes, resources, label))
                .transpose()
        };
        let mut own = Vec::new();
        if let Some(kernel) = &self.own {
            own.push(kernel.bind(device, size_of::<own::Params>(), resources, label)?);
            // the same kernel over the other rates
            let plain = resources
                .iter()
                .find(|given| given.0 == Binding::PlainRates);
            if let (true, Some((_, plain))) = (self.has_plain, plain) {
                let others = resources.iter().filter(|given| given.0 != Binding::Rates);
                let rates = (Binding::Rates, plain.clone());
                let all: Vec<_> = others.cloned().chain([rates]).collect();
                own.push(kernel.bind(device, size_of::<own::Params>(), &all, label)?);
            }
        }
        Ok(BoundAfter {
            own,
            half: bind(&self.half, size_of::<HalfParams>())?,
        })
    }

    pub(super) fn set_frame(
        &self,
        queue: &wgpu::Queue,
        bound: &BoundAfter,
        plan: &Plan,
        frame: &Frame,
    ) {
        let own = plan.settings.own.clone().unwrap_or_default();
        for (index, bound) in bound.own.iter().enumerate() {
            let largest = plan.settings.largest;
            let params =
                own::Params::new(&own, largest, frame.size, index == 0).placed_at(frame.origin);
            queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
        }
        if let Some(bound) = &bound.half {
            let layout = SriLayout::new(frame.size[0], frame.size[1]);
            let [width, height] = half::size_of(frame.size);
            let params = HalfParams {
                quads: [layout.width, layout.height],
                pitch: layout.pitch / 4,
                half_pitch: SriLayout::new(width, height).pitch / 4,
            };
            queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
        }
    }

    pub(super) fn record(&self, pass: &mut wgpu::ComputePass, bound: &BoundAfter, size: [u32; 2]) {
        // a word is four quads, 8 pixels of the picture and 16 of it at half the resolution
        let own = bound.own.iter().map(|bound| (&self.own, bound, [128, 16]));
        let half = bound
            .half
            .iter()
            .map(|bound| (&self.half, bound, [256, 32]));
        for (kernel, bound, [width, height]) in own.chain(half) {
            if let Some(kernel) = kernel {
                pass.set_pipeline(&kernel.pipeline);
                pass.set_bind_group(0, &bound.group, &[]);
                pass.dispatch_workgroups(size[0].div_ceil(width), size[1].div_ceil(height), 1);
            }
        }
    }
}
