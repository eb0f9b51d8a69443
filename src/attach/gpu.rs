//! The hardware-VRS image on the GPU: `shaders/attach.wgsl`, recorded into the caller's own pass.

use bytemuck::{Pod, Zeroable};

use super::{AttachOptions, AttachmentLayout};
use crate::{
    kernel::{self, shader},
    sri::SriLayout,
};

/// The kernel's parameters, as in `shaders/attach.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    quads: [u32; 2],
    tiles: [u32; 2],
    sri_pitch: u32,
    pitch: u32,
    pad: [u32; 2],
    texels: [u8; 16],
}

/// The pixels that a workgroup covers.
const GROUP: [u32; 2] = [128, 32];

/// The pipeline that makes hardware-VRS images with given options.
#[derive(Debug)]
pub struct Attacher {
    options: AttachOptions,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// The bindings of an attacher to one shading-rate image and one buffer for the hardware-VRS image.
#[derive(Debug)]
pub struct BoundAttacher {
    params: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Attacher {
    /// Makes the pipeline.
    pub fn new(device: &wgpu::Device, options: AttachOptions) -> Attacher {
        let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("vrcs attach"),
            entries: &[
                buffer(0, wgpu::BufferBindingType::Uniform),
                buffer(1, wgpu::BufferBindingType::Storage { read_only: true }),
                buffer(2, wgpu::BufferBindingType::Storage { read_only: false }),
            ],
        });
        let module = kernel::shader_module(
            device,
            shader!("attach.wgsl"),
            &[("TILE", options.tile.side())],
        );
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("vrcs attach"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("vrcs attach"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("attach"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Attacher {
            options,
            layout,
            pipeline,
        }
    }

    /// The options.
    pub fn options(&self) -> &AttachOptions {
        &self.options
    }

    /// A buffer for the image of a picture of a size in pixels, to be written here and copied to a texture.
    pub fn buffer(&self, device: &wgpu::Device, size: [u32; 2]) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs attachment"),
            size: AttachmentLayout::new(size, self.options.tile).bytes(),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    /// Binds a shading-rate image, in [`SriLayout`], and a buffer for the hardware-VRS image, in [`AttachmentLayout`].
    pub fn bind(
        &self,
        device: &wgpu::Device,
        sri: &wgpu::Buffer,
        attachment: &wgpu::Buffer,
    ) -> BoundAttacher {
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs attach params"),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs attach"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: params.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: sri.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: attachment.as_entire_binding(),
                },
            ],
        });
        BoundAttacher { params, group }
    }

    /// Sets the size of the picture, in pixels, for dispatches that are submitted from now on.
    pub fn set_size(&self, queue: &wgpu::Queue, bound: &BoundAttacher, size: [u32; 2]) {
        let sri = SriLayout::new(size[0], size[1]);
        let layout = AttachmentLayout::new(size, self.options.tile);
        let params = Params {
            quads: [sri.width, sri.height],
            tiles: [layout.width, layout.height],
            sri_pitch: sri.pitch / 4,
            pitch: layout.pitch / 4,
            pad: [0; 2],
            texels: self.options.table(),
        };
        queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
    }

    /// Records the work into a compute pass. Writes each row's tiles, rounded up to whole words; leaves the rest of its
    /// padding alone.
    pub fn record(&self, pass: &mut wgpu::ComputePass, bound: &BoundAttacher, size: [u32; 2]) {
        let _span = tracing::trace_span!("vrcs attach").entered();
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bound.group, &[]);
        pass.dispatch_workgroups(size[0].div_ceil(GROUP[0]), size[1].div_ceil(GROUP[1]), 1);
    }
}
