//! Somebody's renderer: a shader, a picture, and a frame of analysis, build and dispatch.

use vrcs::{Analyser, Pass, PassOptions, Source, View, analyse::Frame, plan::Binding};
use vrcs_passes::{Options, options::Mode};

pub const SIZE: [u32; 2] = [64, 48];

pub fn shader() -> Source {
    Source::new(
        "fill.wgsl",
        "@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(1) var<uniform> level: vec4<f32>;
         @compute @workgroup_size(8, 8)
         fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             if any(id.xy >= textureDimensions(picture)) { return; }
             textureStore(picture, id.xy, vec4(level.x, vec2<f32>(id.xy % 2u), 1.0));
         }",
    )
}

pub fn texture_of(
    device: &wgpu::Device,
    descriptor: &wgpu::TextureDescriptor,
) -> (wgpu::Texture, wgpu::TextureView) {
    let texture = device.create_texture(descriptor);
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        array_layer_count: Some(1),
        ..Default::default()
    });
    (texture, view)
}

pub fn picture(size: [u32; 2]) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }
}

pub fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    picture: &wgpu::TextureView,
    level: wgpu::BindingResource,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(picture),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: level,
            },
        ],
    })
}

pub fn options(mode: Mode) -> PassOptions<'static> {
    PassOptions {
        rewrite: Options {
            mode,
            ..Options::default()
        },
        ..PassOptions::default()
    }
}

/// A device with certain limits and no features.
pub fn device_with(limits: wgpu::Limits) -> (wgpu::Device, wgpu::Queue) {
    let adapter = vrcs::check::gpu::adapters().swap_remove(0);
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: limits,
        ..Default::default()
    };
    pollster::block_on(adapter.request_device(&descriptor)).expect("a device")
}

/// Draws a frame by analysis, build and dispatch.
pub struct Drawn {
    pub view: View,
    pub analyser: Analyser,
    pub pass: Pass,
    pub group: wgpu::BindGroup,
}

pub fn level(gpu_device: &wgpu::Device) -> wgpu::Buffer {
    gpu_device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl Drawn {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2]) -> Drawn {
        let (texture, target) = texture_of(device, &picture(size));
        let pass = Pass::new(device, &shader(), &options(Mode::List)).expect("a pass");
        let view = View::of_size(device, queue, size).expect("a view");
        let analyser = Analyser::of_colour(device, &view, &texture).expect("an analyser");
        let level = level(device);
        let layout = pass.bind_group_layout(0).expect("a group");
        let group = group(device, layout, &target, level.as_entire_binding());
        Drawn {
            view,
            analyser,
            pass,
            group,
        }
    }

    /// What a renderer does when its window changes.
    pub fn resize(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2]) {
        let (_, target) = texture_of(device, &picture(size));
        let extent = [size[0], size[1], 1];
        self.view.set_extent(queue, extent).expect("an extent");
        let resources = [(Binding::Colour, wgpu::BindingResource::TextureView(&target))];
        self.analyser.bind(&self.view, &resources).expect("bound");
        let level = level(device);
        let layout = self.pass.bind_group_layout(0).expect("a group");
        self.group = group(device, layout, &target, level.as_entire_binding());
    }

    /// What it does when the picture's format changes: the shader names the format, and the analysis reads another form of colour.
    pub fn reformat(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: wgpu::TextureFormat,
        size: [u32; 2],
    ) {
        let descriptor = wgpu::TextureDescriptor {
            format,
            ..picture(size)
        };
        let (texture, target) = texture_of(device, &descriptor);
        let name = match format {
            wgpu::TextureFormat::Rgba16Float => "rgba16float",
            _ => "rgba8unorm",
        };
        let text = shader().text().replace("rgba8unorm", name);
        let source = Source::new("fill.wgsl", text);
        self.pass = Pass::new(device, &source, &options(Mode::List)).expect("a pass");
        let extent = [size[0], size[1], 1];
        self.view.set_extent(queue, extent).expect("an extent");
        self.analyser = Analyser::of_colour(device, &self.view, &texture).expect("an analyser");
        let level = level(device);
        let layout = self.pass.bind_group_layout(0).expect("a group");
        self.group = group(device, layout, &target, level.as_entire_binding());
    }

    pub fn record(&self, queue: &wgpu::Queue, compute: &mut wgpu::ComputePass, frame: &Frame) {
        self.analyser
            .record(queue, compute, &self.view, frame)
            .expect("a frame");
        self.view.build_in(compute).expect("no coverage");
        compute.set_bind_group(0, &self.group, &[]);
        self.pass
            .dispatch(compute, &self.view)
            .expect("a view for it");
    }
}
