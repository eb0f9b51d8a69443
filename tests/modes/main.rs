//! The modes as a renderer uses them: a [`Pass`] recorded over a [`View`], its indirect dispatch made by the build, on the
//! driver at hand. The shader shows where each pixel was shaded, so the picture is the effective map, and is held against the CPU
//! twin's.

#[path = "../common/mod.rs"]
mod common;
mod depth;
mod given;
mod maps;
mod user;

use vrcs::{
    build::{
        BuildOptions, Modes,
        cpu::{self, Coordinates, Frame},
        primary::Order,
    },
    check::{coordinates::SampleTextures, gpu::Gpu},
    coverage::cpu::Samples,
    dispatch::{Pass, PassOptions},
    sri::Sri,
    view::View,
};
use vrcs_passes::{
    Options, Source,
    options::{Mode, Sky},
};

/// What no shader here writes.
const POISON: u32 = 0xa5a5_a5a5;

/// A shader that gives a word for each pixel.
struct Shader {
    pass: Pass,
}

impl Shader {
    fn new(gpu: &Gpu, name: &str, text: &str, rewrite: Options) -> Shader {
        let options = PassOptions {
            rewrite,
            ..PassOptions::default()
        };
        let source = Source::new(name, text);
        let pass = Pass::new(&gpu.device, &source, &options)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        Shader { pass }
    }

    /// Records frame `number` of a view and gives the words that its pixels have afterwards.
    fn draw(&self, gpu: &Gpu, view: &View, number: u32, rays: u32) -> Vec<u32> {
        let [width, height, _] = view.extent();
        let poison = vec![POISON; (width * height) as usize];
        let result = gpu.buffer(
            "result",
            bytemuck::cast_slice(&poison),
            wgpu::BufferUsages::STORAGE,
        );
        let frame = gpu.buffer(
            "frame",
            bytemuck::cast_slice(&[width, height, number, rays]),
            wgpu::BufferUsages::UNIFORM,
        );
        let layout = self.pass.bind_group_layout(0).expect("the shader's group");
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &[&result, &frame]
                .into_iter()
                .enumerate()
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding: binding as u32,
                    resource: buffer.as_entire_binding(),
                })
                .collect::<Vec<_>>(),
        });
        let mut encoder = gpu.encoder();
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            view.build_in(&mut pass).expect("covered");
            pass.set_bind_group(0, &group, &[]);
            self.pass.dispatch(&mut pass, view).expect("a view for it");
        }
        let read = gpu.submit_and_read(encoder, &[&result]).expect("a frame");
        bytemuck::pod_collect_to_vec::<u8, u32>(&read[0])
    }
}

/// How a shader is rewritten for a mode, with the largest rate and tile of a build.
fn rewrite(mode: Mode, sky: Sky, options: &BuildOptions) -> Options {
    use vrcs::Rate;
    use vrcs_passes::options::MaxRate;
    Options {
        mode,
        sky,
        tile: options.tile,
        wave: options.wave,
        max_rate: match options.largest.is_within(Rate::R2X2) {
            true => MaxRate::R2x2,
            false => MaxRate::R4x4,
        },
        ..Options::default()
    }
}

/// A view of a frame, and what its CPU twin makes.
struct Scene<'s> {
    extent: [u32; 2],
    options: BuildOptions,
    sri: &'s Sri,
    samples: Option<&'s Samples>,
    order: Order,
}

impl Scene<'_> {
    fn twin(&self) -> Coordinates {
        let frame = Frame {
            order: self.order,
            samples: self.samples,
            ..Frame::default()
        };
        cpu::build_frame(self.sri, self.extent, &self.options, &frame)
    }

    fn view(&self, gpu: &Gpu) -> View {
        let [width, height] = self.extent;
        let options = BuildOptions {
            modes: Modes::ALL,
            ..self.options
        };
        let mut view =
            View::new(&gpu.device, &gpu.queue, [width, height, 1], options).expect("a view");
        self.fill(gpu, &mut view);
        view
    }

    /// Gives a view of the extent this frame's inputs.
    fn fill(&self, gpu: &Gpu, view: &mut View) {
        view.write_sri(&gpu.queue, self.sri).expect("rates");
        if let Some(samples) = self.samples {
            let textures = SampleTextures::new(gpu, &self.options.coverage, samples);
            view.cover(&gpu.queue, &textures.get()).expect("coverage");
        }
        if let Order::Rotating(frame) = self.order {
            view.rotate(frame);
        }
    }
}
