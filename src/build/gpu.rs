//! The coordinate builder on the GPU: `shaders/build.wgsl`, recorded into the caller's own pass.

use bytemuck::{Pod, Zeroable};
use vrcs_passes::options::FullTiles;

use super::{BuildOptions, CoordLayout};
use crate::{
    kernel::{self, shader},
    sri::SriLayout,
};

/// The kernel's parameters, as in `shaders/build.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Params {
    extent: [u32; 2],
    tiles_per_row: u32,
    entries: u32,
    entries_per_tile: u32,
    full: u32,
    largest: u32,
    sri_pitch: u32,
}

/// The pipeline that builds coordinate buffers with given options.
#[derive(Debug)]
pub struct Builder {
    options: BuildOptions,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// The bindings of a builder to one shading-rate image and one coordinate buffer.
#[derive(Debug)]
pub struct BoundBuilder {
    params: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl Builder {
    /// Makes the pipeline.
    pub fn new(device: &wgpu::Device, options: BuildOptions) -> Builder {
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
            label: Some("vrcs build"),
            entries: &[
                buffer(0, wgpu::BufferBindingType::Uniform),
                buffer(1, wgpu::BufferBindingType::Storage { read_only: true }),
                buffer(2, wgpu::BufferBindingType::Storage { read_only: false }),
            ],
        });
        let module = kernel::shader_module(
            device,
            shader!("build.wgsl"),
            &[
                ("TILE_WIDTH", options.tile[0]),
                ("TILE_HEIGHT", options.tile[1]),
            ],
        );
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("vrcs build"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("vrcs build"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("build"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Builder {
            options,
            layout,
            pipeline,
        }
    }

    /// The options.
    pub fn options(&self) -> &BuildOptions {
        &self.options
    }

    /// Binds a shading-rate image and a coordinate buffer.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        sri: &wgpu::Buffer,
        coords: &wgpu::Buffer,
    ) -> BoundBuilder {
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vrcs build params"),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("vrcs build"),
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
                    resource: coords.as_entire_binding(),
                },
            ],
        });
        BoundBuilder { params, group }
    }

    /// Sets the extent of the picture for dispatches that are submitted from now on.
    pub fn set_extent(&self, queue: &wgpu::Queue, bound: &BoundBuilder, extent: [u32; 2]) {
        let layout = CoordLayout::new(extent, &self.options);
        let params = Params {
            extent,
            tiles_per_row: layout.tiles[0],
            entries: layout.entries,
            entries_per_tile: layout.entries_per_tile,
            full: match self.options.full_tiles {
                FullTiles::Promote => layout.entries_per_tile,
                FullTiles::Keep => u32::MAX,
            },
            largest: u32::from(self.options.largest.code()),
            sri_pitch: SriLayout::new(extent[0], extent[1]).pitch / 4,
        };
        queue.write_buffer(&bound.params, 0, bytemuck::bytes_of(&params));
    }

    /// Records the build into a compute pass.
    pub fn record(&self, pass: &mut wgpu::ComputePass, bound: &BoundBuilder, extent: [u32; 2]) {
        let [x, y] = CoordLayout::new(extent, &self.options).tiles;
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bound.group, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}
