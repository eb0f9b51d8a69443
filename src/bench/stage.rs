//! What is measured on: rotated inputs, shading rates of a given share, views.
//!
//! *Guarantees*: the same seed makes the same content. Pictures are as renderers make them: smooth, with as much noise in one place as
//! there is little in another, so that analyses find rates of all kinds.

use std::sync::OnceLock;

use vrcs_passes::{
    Options, Source,
    options::{FullTiles, Mode},
};

use super::{Bench, BenchError, Lab, own};
use crate::{
    Pass, PassOptions, Rate, View,
    build::{BuildOptions, Modes, statistics::Statistics},
    check::gpu::Gpu,
    flat,
    sri::Sri,
};

/// A shader's inputs and outputs, in as many copies as are rotated.
pub(super) struct Inputs {
    pub(super) surfaces: Vec<wgpu::TextureView>,
    pub(super) pictures: Vec<wgpu::TextureView>,
    pub(super) frame: wgpu::Buffer,
    pub(super) lights: wgpu::Buffer,
}

/// How many copies of something of `bytes` bytes are rotated.
pub(super) fn copies(bench: &Bench, bytes: u64) -> usize {
    (bench.rotated.div_ceil(bytes.max(1)) as usize).clamp(2, 32)
}

/// Random words, the same in every run; made once, since a debug build takes its time.
fn random_words() -> &'static [u32] {
    static WORDS: OnceLock<Vec<u32>> = OnceLock::new();
    WORDS.get_or_init(|| {
        let mut random = fastrand::Rng::with_seed(17);
        (0..1 << 20).map(|_| random.u32(..)).collect()
    })
}

/// What a texture holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Bytes, four to a pixel: ramps under noise of an amplitude that changes from place to place.
    Picture,
    /// Two halves between 0 and 1 to a pixel.
    Motion,
}

/// A picture's bytes at a place: the same on all channels, but for the noise.
fn shade(x: u32, y: u32, seed: u32, random: u32) -> u32 {
    let ramp = ((x * 2 + y * 3 + seed * 37) / 16) & 0x1ff;
    let base = if ramp > 255 { 511 - ramp } else { ramp };
    let mask = [0, 0x0101_0101, 0x0707_0707, 0x3f3f_3f3f][((x / 160 + y / 90) & 3) as usize];
    // the mean of both, byte by byte: none carries into the next
    let noise = random & mask;
    let base = base * 0x0101_0101;
    (base & noise) + ((base ^ noise) >> 1 & 0x7f7f_7f7f)
}

/// The words of a content, row by row.
pub(super) fn words(size: [u32; 2], content: Content, seed: u64) -> Vec<u32> {
    let random = random_words();
    let shift = seed as u32 * 7919;
    let mut words = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let at = (y * size[0] + x + shift + y / 64 * 977) as usize % random.len();
            words.push(match content {
                Content::Picture => shade(x, y, seed as u32, random[at]),
                Content::Motion => random[at] & 0x3bff_3bff,
            });
        }
    }
    words
}

/// A texture of four bytes a pixel, with a content.
pub(super) fn texture(
    gpu: &Gpu,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    content: Content,
    seed: u64,
) -> wgpu::Texture {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST;
    let texture = gpu
        .device
        .create_texture(&flat::texture("vrcs bench", size, format, usage));
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&words(size, content, seed)),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size[0] * 4),
            rows_per_image: None,
        },
        texture.size(),
    );
    texture
}

/// A whole texture, to be bound.
pub(super) fn whole(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl Inputs {
    pub(super) fn new(bench: &Bench, gpu: &Gpu, lights: u32) -> Inputs {
        let [width, height] = bench.size;
        let count = copies(bench, u64::from(width) * u64::from(height) * 4);
        let texture = |seed| {
            let format = wgpu::TextureFormat::Rgba8Unorm;
            let made = self::texture(gpu, bench.size, format, Content::Picture, seed);
            whole(&made)
        };
        let frame = [width, height, lights, 0];
        let mut random = fastrand::Rng::with_seed(7);
        let places: Vec<f32> = (0..lights.max(64) * 4)
            .map(|_| random.f32() * 4.0)
            .collect();
        let storage = wgpu::BufferUsages::STORAGE;
        Inputs {
            surfaces: (0..count as u64).map(texture).collect(),
            pictures: (0..count as u64).map(|seed| texture(1000 + seed)).collect(),
            frame: gpu.buffer(
                "frame",
                bytemuck::cast_slice(&frame),
                wgpu::BufferUsages::UNIFORM,
            ),
            lights: gpu.buffer("lights", bytemuck::cast_slice(&places), storage),
        }
    }

    /// The groups of the heavy shaders.
    pub(super) fn groups(&self, gpu: &Gpu, layout: &wgpu::BindGroupLayout) -> Vec<wgpu::BindGroup> {
        let both = self.surfaces.iter().zip(&self.pictures);
        both.map(|(surface, picture)| {
            let resources = [
                self.frame.as_entire_binding(),
                wgpu::BindingResource::TextureView(surface),
                self.lights.as_entire_binding(),
                wgpu::BindingResource::TextureView(picture),
            ];
            group(gpu, layout, &(0..).zip(resources).collect::<Vec<_>>())
        })
        .collect()
    }
}

/// A bind group of numbered resources.
pub(super) fn group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    resources: &[(u32, wgpu::BindingResource)],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = resources
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("vrcs bench"),
        layout,
        entries: &entries,
    })
}

/// The author's shader as it is.
pub(super) struct Original {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
}

/// Compiles a text as the author would.
pub(super) fn original(gpu: &Gpu, text: &str, entry: &str) -> Original {
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
    compiled(gpu, &module, entry)
}

/// Compiles a kernel of the benchmark's own without any checks, as fast as it can be.
pub(super) fn unchecked(gpu: &Gpu, text: &'static str, entry: &str) -> Original {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    };
    let checks = wgpu::ShaderRuntimeChecks::unchecked();
    // SAFETY: the texts are this benchmark's own floors; they compare what they index by with the size that the bench binds, and their
    // loops run to constants
    let module = unsafe { gpu.device.create_shader_module_trusted(descriptor, checks) };
    compiled(gpu, &module, entry)
}

fn compiled(gpu: &Gpu, module: &wgpu::ShaderModule, entry: &str) -> Original {
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
    let layout = pipeline.get_bind_group_layout(0);
    Original { pipeline, layout }
}

/// The rewritten shader.
pub(super) fn rewritten(gpu: &Gpu, text: &str, rewrite: Options) -> Result<Pass, BenchError> {
    let source = Source::new("bench.wgsl", text);
    let options = PassOptions {
        rewrite,
        ..PassOptions::default()
    };
    Pass::new(&gpu.device, &source, &options).map_err(own)
}

/// The layout of a rewritten shader's own group.
pub(super) fn layout_of(pass: &Pass) -> Result<&wgpu::BindGroupLayout, BenchError> {
    pass.bind_group_layout(0)
        .ok_or_else(|| own("no bind group"))
}

/// Views built from rates, to be rotated, and their share of primaries and of waves that stay.
pub(super) struct Built {
    views: Vec<View>,
    pub(super) primaries: f64,
    pub(super) waves: f64,
}

impl Built {
    /// The view of a round.
    pub(super) fn view(&self, round: usize) -> &View {
        &self.views[round % self.views.len()]
    }
}

/// Builds views, one from the rates of each seed. Two of them have more than 100 MB of lists at 4K.
pub(super) fn built(
    lab: &Lab,
    sri: impl Fn(u64) -> Sri,
    largest: Rate,
    full_tiles: FullTiles,
) -> Result<Built, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let options = BuildOptions {
        largest,
        full_tiles,
        statistics: true,
        modes: Modes::NONE
            .with(Mode::Tiled)
            .with(Mode::List)
            .with(Mode::Classified),
        ..BuildOptions::default()
    };
    let mut built = Built {
        views: Vec::new(),
        primaries: 0.0,
        waves: 0.0,
    };
    let [width, height] = bench.size;
    for seed in 0..VIEWS {
        let view = View::new(&gpu.device, &gpu.queue, [width, height, 1], options).map_err(own)?;
        view.write_sri(&gpu.queue, &sri(seed)).map_err(own)?;
        let mut encoder = gpu.encoder();
        view.build(&mut encoder).map_err(own)?;
        let Some(buffer) = view.statistics() else {
            return Err(own("statistics are asked for"));
        };
        let bytes = gpu.submit_and_read(encoder, &[buffer])?;
        let statistics = Statistics::read(&bytes[0]);
        built.primaries += statistics.primary_share() / VIEWS as f64;
        built.waves += (1.0 - statistics.retired_share()) / VIEWS as f64;
        built.views.push(view);
    }
    Ok(built)
}

/// Views that are rotated.
pub(super) const VIEWS: u64 = 2;

/// Rates at random by quad, so that `share` of the pixels are primaries: the worst case for caches and waves.
pub(super) fn random(size: [u32; 2], share: f64, seed: u64) -> Sri {
    let mut random = fastrand::Rng::with_seed(11 + seed);
    let coarse = (1.0 - share) / 0.75;
    Sri::from_fn(size[0], size[1], |_, _| match random.f64() < coarse {
        true => Rate::R2X2.code(),
        false => Rate::R1X1.code(),
    })
}

/// Rates as pictures have them: wide coarse areas, wide fine ones, mixed along their borders.
pub(super) fn natural(size: [u32; 2], seed: u64) -> Sri {
    Sri::from_fn(size[0], size[1], |x, y| {
        let (u, v) = (f64::from(x) / 97.0 + seed as f64, f64::from(y) / 71.0);
        let field = (u.sin() * v.cos() + (0.31 * u + 0.7 * v).sin()) / 2.0;
        let rate = match field {
            f if f < -0.1 => Rate::R2X2,
            f if f < 0.0 => Rate::R2X1,
            f if f < 0.1 => Rate::R1X2,
            _ => Rate::R1X1,
        };
        rate.code()
    })
}
