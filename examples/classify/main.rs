//! Post-processing by classes of tiles, as Wicked Engine's depth of field does it: tiles where nothing is blurred, where one radius
//! will do, and the rest, each with a shader of its own, dispatched indirectly over its own list.
//!
//! The circle of confusion stands in the picture's alpha. Writes `out/classified.png`.

#[path = "../support/mod.rs"]
mod support;

use support::{Gpu, Outcome, whole};
use vrcs::classify::{Classifier, Options};
use wgpu::BindingResource::TextureView;

const SIZE: [u32; 2] = [512, 288];
/// The number of the shader for each class, and the class's name.
const CLASSES: [(f64, &str); 3] = [(0.0, "early"), (1.0, "cheap"), (2.0, "expensive")];

fn main() -> Outcome {
    let gpu = Gpu::open()?;
    let device = &gpu.device;
    let picture = gpu.texture(SIZE, wgpu::TextureFormat::Rgba8Unorm);
    let result = gpu.texture(SIZE, wgpu::TextureFormat::Rgba8Unorm);
    gpu.queue.write_texture(
        picture.as_image_copy(),
        &shot(),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(SIZE[0] * 4),
            rows_per_image: None,
        },
        picture.size(),
    );

    // the ready-made classes, looking at alpha instead of red
    let options = Options {
        measure: "texel.a".to_owned(),
        ..Options::circle_of_confusion(0.05, 0.1)
    };
    let classifier = Classifier::new(device, options)?;
    let mut lists = classifier.bind(device, &whole(&picture))?;
    classifier.set_extent(&gpu.queue, &mut lists, SIZE)?;

    let (from, to) = (whole(&picture), whole(&result));
    let layout = layout(device);
    let group = gpu.group(&layout, &[(0, TextureView(&from)), (1, TextureView(&to))]);
    let pipelines = CLASSES
        .iter()
        .map(|&(kind, name)| {
            let text = classifier.wgsl(name, 1)? + include_str!("blur.wgsl");
            Ok((
                classifier.class(name)?,
                pipeline(&gpu, &layout, &text, kind),
            ))
        })
        .collect::<Outcome<Vec<_>>>()?;

    let mut encoder = gpu.encoder();
    let mut pass = encoder.begin_compute_pass(&Default::default());
    classifier.record_in(&mut pass, &lists)?;
    for (class, pipeline) in &pipelines {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        lists.dispatch(&mut pass, *class, 1)?;
    }
    drop(pass);
    gpu.submit(encoder);

    let counts = gpu.read(lists.buffer())?;
    let counts: &[u32] = bytemuck::cast_slice(&counts);
    let mut tiles = 0;
    for ((class, _), (_, name)) in pipelines.iter().zip(CLASSES) {
        println!("{name:10} {} tiles", counts[4 + class]);
        tiles += counts[4 + class];
        if counts[4 + class] == 0 {
            return Err(format!("no tile is {name}").into());
        }
    }
    let bytes = gpu.read_texture(&result)?;
    support::save("classified", SIZE, &bytes)?;
    // every pixel is written by exactly one class's shader, with an alpha of 1
    let is_whole = bytes.chunks(4).all(|pixel| pixel[3] == 255);
    match is_whole && tiles == SIZE[0].div_ceil(32) * SIZE[1].div_ceil(32) {
        true => Ok(()),
        false => Err("some tile has no class".into()),
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("depth of field"),
        entries: &[
            entry(
                0,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
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
    })
}

fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    text: &str,
    kind: f64,
) -> wgpu::ComputePipeline {
    let device = &gpu.device;
    let lists = Classifier::lists_layout(device);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("depth of field"),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("depth of field"),
        bind_group_layouts: &[Some(layout), Some(&lists)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("depth of field"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("blur"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("KIND", kind)],
            ..Default::default()
        },
        cache: None,
    })
}

/// A board that runs from sharp through evenly blurred to a step in the blur.
fn shot() -> Vec<u8> {
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    pixels
        .flat_map(|(x, y)| {
            let light = if (x / 12 + y / 12) % 2 == 0 { 220 } else { 40 };
            let blur = match x {
                0..160 => 0,
                160..330 => 120,
                _ => (x - 330) as u8,
            };
            [light, light, light / 2 + 40, blur]
        })
        .collect()
}
