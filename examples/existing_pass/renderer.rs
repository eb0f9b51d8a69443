//! The rest of the renderer: what is there before and after, and does not change.

use crate::support;
pub use crate::support::Outcome;

/// A device, a picture, and what the lighting shader binds.
pub struct Renderer {
    gpu: support::Gpu,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub size: [u32; 2],
    pub picture: wgpu::Texture,
    pub layout: wgpu::BindGroupLayout,
    pub group: wgpu::BindGroup,
    frame: wgpu::Buffer,
}

impl Renderer {
    pub fn new(size: [u32; 2]) -> Outcome<Renderer> {
        let gpu = support::Gpu::open()?;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("lighting"),
                entries: &[
                    entry(
                        0,
                        wgpu::BindingType::Buffer {
                            ty: wgpu::BufferBindingType::Uniform,
                            has_dynamic_offset: false,
                            min_binding_size: None,
                        },
                    ),
                    entry(
                        1,
                        wgpu::BindingType::StorageTexture {
                            access: wgpu::StorageTextureAccess::WriteOnly,
                            format: wgpu::TextureFormat::Rgba8Unorm,
                            view_dimension: wgpu::TextureViewDimension::D2,
                        },
                    ),
                ],
            });
        let picture = gpu.texture(size, wgpu::TextureFormat::Rgba8Unorm);
        let frame = gpu.uniform(16);
        let view = picture.create_view(&Default::default());
        let group = gpu.group(
            &layout,
            &[
                (0, frame.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&view)),
            ],
        );
        Ok(Renderer {
            device: gpu.device.clone(),
            queue: gpu.queue.clone(),
            gpu,
            size,
            picture,
            layout,
            group,
            frame,
        })
    }

    /// Sets the frame's uniforms.
    pub fn begin_frame(&self, frame: u32) -> wgpu::CommandEncoder {
        let time = frame as f32 / 60.0;
        let words = [self.size[0], self.size[1], time.to_bits(), 0];
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.queue.write_buffer(&self.frame, 0, &bytes);
        self.gpu.encoder()
    }

    pub fn end_frame(&self, encoder: wgpu::CommandEncoder) {
        self.gpu.submit(encoder);
    }

    pub fn read(&self) -> Outcome<Vec<u8>> {
        self.gpu.read_texture(&self.picture)
    }

    /// Prints how much of the last frame was shaded.
    pub fn report(&self, view: &vrcs::View) -> Outcome {
        let share = support::share_of_primaries(&self.gpu, view)?;
        println!("shaded     {:.1} % of the pixels", 100.0 * share);
        Ok(())
    }

    /// A pipeline of the lighting's bind group and a text with one entry point.
    pub fn compute_pipeline(&self, text: &str) -> wgpu::ComputePipeline {
        let module = self
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
        let layout = self
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&self.layout)],
                immediate_size: 0,
            });
        self.device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: Some(&layout),
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                cache: None,
            })
    }
}
