//! A deferred renderer: three passes share what is built once, each with the rates that suit it; the deblocker ends the frame.
//!
//! - One analysis of the last frame writes two shading-rate images: with the extra half rate for what later passes blur over
//!   (occlusion, lighting), and without it for the composite, which is what shows.
//! - Occlusion and lighting share one [`View`], so one coordinate buffer. Surface numbers keep its groups inside one surface.
//! - The deblocker takes the half-pixel offset out of what was shaded coarsely, and stops at surfaces.
//!
//! Writes `out/deferred_full.png` and `out/deferred_variable.png`.

#[path = "../support/mod.rs"]
mod support;

use support::{Gpu, Outcome, whole};
use vrcs::{
    Analyser, Pass, PassOptions, Scene, Source, View,
    analyse::{
        Frame,
        settings::{Granularity, HalfRate, Settings},
    },
    build::BuildOptions,
    coverage::{Coverage, Textures},
    deblock::{self, Deblocker, Picture, PictureInput},
    plan::{Binding, ColourForm},
};
use wgpu::{BindingResource::TextureView, TextureFormat};

const SIZE: [u32; 2] = [640, 360];
const FRAMES: u32 = 4;

fn main() -> Outcome {
    let gpu = Gpu::open()?;
    let full = Renderer::new(&gpu)?.draw(&gpu, false)?;
    let variable = Renderer::new(&gpu)?.draw(&gpu, true)?;
    let decibels = support::psnr(&full, &variable);
    println!("PSNR       {decibels:.1} dB against full rate");
    support::save("deferred_full", SIZE, &full)?;
    support::save("deferred_variable", SIZE, &variable)?;
    match full != variable && decibels > 35.0 {
        true => Ok(()),
        false => Err("the picture is not what it should be".into()),
    }
}

/// A pass and its bind group.
struct Shaded {
    pass: Pass,
    group: wgpu::BindGroup,
}

struct Renderer {
    frame: wgpu::Buffer,
    gbuffer: wgpu::ComputePipeline,
    gbuffer_group: wgpu::BindGroup,
    /// Occlusion and lighting.
    inner: View,
    /// The composite.
    outer: View,
    analyser: Analyser,
    occlude: Shaded,
    light: Shaded,
    composite: Shaded,
    deblocker: Deblocker,
    deblocked: deblock::Bound,
    picture: wgpu::Texture,
}

impl Renderer {
    fn new(gpu: &Gpu) -> Outcome<Renderer> {
        let device = &gpu.device;
        let texture = |format| gpu.texture(SIZE, format);
        let surface = texture(TextureFormat::Rgba16Float);
        let surfaces = texture(TextureFormat::R32Uint);
        let occlusion = texture(TextureFormat::Rgba16Float);
        let lit = texture(TextureFormat::Rgba16Float);
        let picture = texture(TextureFormat::Rgba16Float);
        let frame = gpu.uniform(16);

        // rasterised in a real renderer
        let gbuffer = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("G-buffer"),
            layout: None,
            module: &device.create_shader_module(wgpu::include_wgsl!("gbuffer.wgsl")),
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let gbuffer_group = gpu.group(
            &gbuffer.get_bind_group_layout(0),
            &[
                (0, TextureView(&whole(&surface))),
                (1, TextureView(&whole(&surfaces))),
            ],
        );

        let extent = [SIZE[0], SIZE[1], 1];
        let built = BuildOptions {
            coverage: Coverage {
                surfaces: true,
                ..Coverage::default()
            },
            effective: true,
            ..BuildOptions::default()
        };
        let numbers = whole(&surfaces);
        let covered = || -> Outcome<View> {
            let mut view = View::new(device, &gpu.queue, extent, built)?;
            let textures = Textures {
                surfaces: Some(&numbers),
                ..Textures::default()
            };
            view.cover(&gpu.queue, &textures)?;
            Ok(view)
        };
        let (inner, outer) = (covered()?, covered()?);

        // the last frame was shown as it is stored: codes as they leave, so linear is not what they are, but near enough for a look
        let scene = Scene {
            colour: ColourForm::Linear,
            attachment: true,
            ..Scene::default()
        };
        let settings = Settings {
            half_rate: Some(HalfRate::default()),
            // of quads, as compute passes read it
            attachment: Granularity::Quad,
            ..Settings::default()
        };
        let analyser = Analyser::new(
            device,
            &inner,
            &scene,
            &settings,
            &[
                (Binding::Colour, TextureView(&whole(&picture))),
                (Binding::Attachment, outer.sri().as_entire_binding()),
            ],
        )?;

        let source = Source::new("shade.wgsl", include_str!("shade.wgsl"));
        let shaded =
            |entry, read: &[(u32, &wgpu::Texture)], to: &wgpu::Texture| -> Outcome<Shaded> {
                let options = PassOptions {
                    entry: Some(entry),
                    label: Some(entry),
                    ..PassOptions::default()
                };
                let pass = Pass::new(device, &source, &options)?;
                let layout = pass.bind_group_layout(0).ok_or("no bind group")?;
                let views: Vec<_> = read
                    .iter()
                    .map(|(binding, it)| (*binding, whole(it)))
                    .collect();
                let target = whole(to);
                let mut resources = vec![(0, frame.as_entire_binding()), (4, TextureView(&target))];
                resources.extend(
                    views
                        .iter()
                        .map(|(binding, view)| (*binding, TextureView(view))),
                );
                let group = gpu.group(layout, &resources);
                Ok(Shaded { pass, group })
            };
        let occlude = shaded("occlude", &[(1, &surface)], &occlusion)?;
        let light = shaded("light", &[(1, &surface), (2, &occlusion)], &lit)?;
        let composite = shaded("composite", &[(1, &surface), (3, &lit)], &picture)?;

        let options = deblock::Options {
            surfaces: true,
            ..deblock::Options::new(Picture::Texture(picture.format()))
        };
        let deblocker = Deblocker::new(device, None, options)?;
        let shown = whole(&picture);
        let inputs = deblock::Inputs {
            surfaces: Some(&numbers),
            ..deblock::Inputs::of_view(&outer, PictureInput::Texture(&shown))?
        };
        let deblocked = deblocker.bind(device, &inputs)?;
        Ok(Renderer {
            frame,
            gbuffer,
            gbuffer_group,
            inner,
            outer,
            analyser,
            occlude,
            light,
            composite,
            deblocker,
            deblocked,
            picture,
        })
    }

    /// Draws frames, each analysed by what the one before left, and reads the last.
    fn draw(mut self, gpu: &Gpu, is_variable: bool) -> Outcome<Vec<u8>> {
        self.inner.set_enabled(&gpu.queue, is_variable);
        self.outer.set_enabled(&gpu.queue, is_variable);
        for number in 0..FRAMES {
            let time = number as f32 / 60.0;
            let words = [SIZE[0], SIZE[1], time.to_bits(), 0];
            gpu.queue
                .write_buffer(&self.frame, 0, bytemuck::cast_slice(&words));
            let mut encoder = gpu.encoder();
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.gbuffer);
            pass.set_bind_group(0, &self.gbuffer_group, &[]);
            pass.dispatch_workgroups(SIZE[0].div_ceil(8), SIZE[1].div_ceil(8), 1);

            let frame = Frame::numbered(SIZE, number);
            self.analyser
                .record(&gpu.queue, &mut pass, &self.inner, &frame)?;
            self.inner.build_in(&mut pass)?;
            self.outer.build_in(&mut pass)?;
            for (shaded, view) in [
                (&self.occlude, &self.inner),
                (&self.light, &self.inner),
                (&self.composite, &self.outer),
            ] {
                pass.set_bind_group(0, &shaded.group, &[]);
                shaded.pass.dispatch(&mut pass, view)?;
            }
            self.deblocker
                .record_view(&gpu.queue, &mut pass, &self.deblocked, &self.outer)?;
            drop(pass);
            gpu.submit(encoder);
        }
        if is_variable {
            for (name, view) in [("lighting", &self.inner), ("composite", &self.outer)] {
                let share = support::share_of_primaries(gpu, view)?;
                println!("{name:10} {:.1} % of the pixels shaded", 100.0 * share);
            }
        }
        Ok(support::to_bytes(&gpu.read_texture(&self.picture)?))
    }
}
