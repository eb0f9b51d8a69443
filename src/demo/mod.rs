//! The demo: a scene at full rate and at variable rate, side by side, with what it saved and what it cost.

mod deblocked;
mod pictures;
mod timing;

use std::path::PathBuf;

use vrcs_passes::{Options, Source, input};

use crate::{
    Rate,
    analyse::{content, luma::Luma},
    build::{
        BuildOptions,
        cpu::{self, Coordinates},
        statistics::Statistics,
    },
    check::{
        self, Job, Report,
        gpu::{Gpu, GpuError, by_construction},
    },
    dispatch::{Pass, PassOptions},
    flat,
    metrics::{self, Shown as Picture},
    sri::Sri,
    view::View,
};
use deblocked::Deblock;
pub use pictures::rate_color;
use timing::Timer;

/// The scene.
pub(crate) const SCENE: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/plaza.wgsl"));

/// What to show.
#[derive(Clone, Debug)]
pub struct Demo {
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Where the pictures go.
    pub out: PathBuf,
    /// How noticeable a difference may be.
    pub sensitivity: content::Sensitivity,
}

/// What was shown.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The driver.
    pub adapter: String,
    /// Width and height.
    pub size: [u32; 2],
    /// How much was shaded.
    pub statistics: Statistics,
    /// The share of quads at each rate.
    pub rates: Vec<(Rate, f64)>,
    /// Milliseconds of the original, of the rewritten shader at full rate, of the coordinate build, and of the rewritten
    /// shader at these rates.
    pub times: Times,
    /// Peak signal-to-noise ratio of the variable-rate picture against the full-rate one, in decibels.
    pub psnr: f64,
    /// The same after deblocking.
    pub psnr_deblocked: f64,
    /// The laws, held on the same shader in small.
    pub laws: Report,
    /// The pictures that were written.
    pub pictures: Vec<PathBuf>,
}

/// Times in milliseconds, medians.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// The original.
    pub original: f64,
    /// The rewritten shader with every rate 1×1.
    pub identity: f64,
    /// The coordinate build.
    pub build: f64,
    /// The rewritten shader at the scene's rates.
    pub variable: f64,
    /// The deblocker.
    pub deblock: f64,
    /// Whether the GPU's own clock was read, rather than the host's.
    pub by_gpu: bool,
}

/// Why the demo could not be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DemoError {
    /// There is no device, or it refused something.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A picture could not be written.
    #[error("{path}: {why}")]
    Write {
        /// The file.
        path: String,
        /// Why.
        why: String,
    },
    /// Something of this crate's own went wrong.
    #[error("{0}")]
    Own(String),
}

/// The parameters of the scene, as in its `Frame`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    size: [u32; 2],
    time: f32,
    padding: u32,
}

/// The scene on a device.
struct Stage<'g> {
    gpu: &'g Gpu,
    size: [u32; 2],
    original: wgpu::ComputePipeline,
    rewritten: Pass,
    view: View,
    picture: wgpu::Texture,
    group: wgpu::BindGroup,
}

impl Demo {
    /// Runs the demo. `progress` is told what comes next.
    ///
    /// # Errors
    /// If there is no device, or a picture cannot be written.
    pub fn run(&self, gpu: &Gpu, progress: &mut dyn FnMut(&str)) -> Result<Shown, DemoError> {
        progress("making pipelines");
        let mut stage = Stage::new(gpu, self.size)?;
        progress("shading at full rate");
        let full = stage.shade_original()?;
        let [width, height] = self.size;
        let luma = Luma::from_rgba8(width, height, &full);
        let sri = content::analyse(&luma, &self.sensitivity);
        progress("shading at variable rate");
        let (variable, coordinates) = stage.shade(&sri)?;
        progress("deblocking");
        let deblock = Deblock::new(&stage, &sri, &coordinates)?;
        let deblocked = stage.deblock(&deblock)?;
        progress("measuring");
        let times = stage.times(&sri, &deblock)?;
        progress("holding the laws");
        let laws = laws(gpu)?;
        progress("writing pictures");
        let shaded = pictures::Shaded {
            full: &full,
            variable: &variable,
            deblocked: &deblocked,
        };
        let pictures = pictures::write(&self.out, self.size, &shaded, &sri, &coordinates)?;
        let psnr = |picture: &[u8]| {
            let of = |rgba| Picture::new(self.size, rgba);
            metrics::psnr(of(&full), of(picture))
        };
        Ok(Shown {
            adapter: gpu.info.name.clone(),
            size: self.size,
            statistics: coordinates.statistics(),
            rates: shares(&sri),
            times,
            psnr: psnr(&variable),
            psnr_deblocked: psnr(&deblocked),
            laws,
            pictures,
        })
    }
}

fn own(error: impl std::fmt::Display) -> DemoError {
    DemoError::Own(error.to_string())
}

/// The share of quads at each rate.
fn shares(sri: &Sri) -> Vec<(Rate, f64)> {
    let layout = sri.layout();
    let quads = f64::from(layout.width * layout.height);
    [Rate::R1X1, Rate::R1X2, Rate::R2X1, Rate::R2X2]
        .into_iter()
        .map(|rate| {
            let count = (0..layout.height)
                .flat_map(|y| (0..layout.width).map(move |x| (x, y)))
                .filter(|&(x, y)| sri.rate(x, y, Rate::R2X2) == rate)
                .count();
            (rate, count as f64 / quads)
        })
        .collect()
}

/// Holds the laws on the scene's shader, in small.
fn laws(gpu: &Gpu) -> Result<Report, DemoError> {
    let source = Source::new("plaza.wgsl", SCENE);
    let (module, info) = input::wgsl(&source).map_err(own)?;
    let mut job = Job::new("plaza");
    job.cases = 32;
    job.settings.set.insert("time".to_owned(), vec![1.0]);
    check::check(gpu, &source, &module, &info, &job, &mut |_| {}).map_err(own)
}

impl<'g> Stage<'g> {
    fn new(gpu: &'g Gpu, size: [u32; 2]) -> Result<Stage<'g>, DemoError> {
        let source = Source::new("plaza.wgsl", SCENE);
        let (module, info) = input::wgsl(&source).map_err(own)?;
        let options = PassOptions {
            label: Some("plaza, variable rate"),
            rewrite: Options::default(),
            ..PassOptions::default()
        };
        let rewritten =
            Pass::from_module(&gpu.device, &module, &info, &source, &options).map_err(own)?;
        let Some(layout) = rewritten.bind_group_layout(0) else {
            return Err(own("the scene has no bind group"));
        };
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("plaza"),
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            });
        let shader = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("plaza"),
                source: wgpu::ShaderSource::Wgsl(SCENE.into()),
            });
        let original = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("plaza"),
                layout: Some(&pipeline_layout),
                module: &shader,
                entry_point: Some("plaza"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        let usage = wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let picture = gpu
            .device
            .create_texture(&flat::texture("picture", size, format, usage));
        let frame = Frame {
            size,
            time: 1.0,
            padding: 0,
        };
        let frame = gpu.buffer(
            "frame",
            bytemuck::bytes_of(&frame),
            wgpu::BufferUsages::UNIFORM,
        );
        let view_of_picture = picture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("plaza"),
            layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: frame.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&view_of_picture),
                },
            ],
        });
        let view = View::new(
            &gpu.device,
            &gpu.queue,
            [size[0], size[1], 1],
            BuildOptions::default(),
        )
        .map_err(own)?;
        gpu.check()?;
        Ok(Stage {
            gpu,
            size,
            original,
            rewritten,
            view,
            picture,
            group,
        })
    }

    fn record_original(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.original);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1);
    }

    fn record_rewritten(&self, pass: &mut wgpu::ComputePass) {
        pass.set_bind_group(0, &self.group, &[]);
        by_construction(self.rewritten.dispatch(pass, &self.view));
    }

    /// The picture of the original shader, RGBA, row by row.
    fn shade_original(&self) -> Result<Vec<u8>, DemoError> {
        let mut encoder = self.gpu.encoder();
        self.record_original(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        );
        self.read(encoder)
    }

    /// The picture of the rewritten shader at given rates, and the coordinates that it was shaded by.
    fn shade(&mut self, sri: &Sri) -> Result<(Vec<u8>, Coordinates), DemoError> {
        self.view.write_sri(&self.gpu.queue, sri).map_err(own)?;
        let mut encoder = self.gpu.encoder();
        self.view.build(&mut encoder).map_err(own)?;
        self.record_rewritten(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        );
        let picture = self.read(encoder)?;
        Ok((
            picture,
            cpu::build(sri, self.size, &BuildOptions::default()),
        ))
    }

    /// The picture that was shaded last, deblocked.
    fn deblock(&self, deblock: &Deblock) -> Result<Vec<u8>, DemoError> {
        let mut encoder = self.gpu.encoder();
        deblock.record(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()));
        self.read(encoder)
    }

    fn read(&self, encoder: wgpu::CommandEncoder) -> Result<Vec<u8>, DemoError> {
        Ok(self.gpu.read_rgba8(encoder, &self.picture)?)
    }

    /// Measures each part, in turn, so that all see the same machine.
    fn times(&mut self, sri: &Sri, deblock: &Deblock) -> Result<Times, DemoError> {
        let mut timer = Timer::new(self.gpu);
        let identity = Sri::uniform(self.size[0], self.size[1], Rate::R1X1);
        let mut samples: [Vec<f64>; 5] = Default::default();
        // a software driver takes its time; a GPU has to warm up
        let rounds = if self.gpu.is_software() { 3 } else { 30 };
        for round in 0..rounds + 1 {
            self.view
                .write_sri(&self.gpu.queue, &identity)
                .map_err(own)?;
            let original = timer.time(self.gpu, |pass| self.record_original(pass))?;
            timer.time(self.gpu, |pass| by_construction(self.view.build_in(pass)))?;
            let at_full_rate = timer.time(self.gpu, |pass| self.record_rewritten(pass))?;
            self.view.write_sri(&self.gpu.queue, sri).map_err(own)?;
            let build = timer.time(self.gpu, |pass| by_construction(self.view.build_in(pass)))?;
            let variable = timer.time(self.gpu, |pass| self.record_rewritten(pass))?;
            let deblocked = timer.time(self.gpu, |pass| deblock.record(pass))?;
            if round > 0 {
                for (samples, time) in
                    samples
                        .iter_mut()
                        .zip([original, at_full_rate, build, variable, deblocked])
                {
                    samples.push(time);
                }
            }
        }
        let [original, identity, build, variable, deblock] = samples.map(timing::median);
        Ok(Times {
            original,
            identity,
            build,
            variable,
            deblock,
            by_gpu: timer.by_gpu(),
        })
    }
}
