//! Rows of the runtime's own stages, each against a kernel that only moves what it has to move.

use vrcs_passes::options::Mode;
use wgpu::BindingResource::TextureView;

use super::{
    Bench, BenchError, Row, own, parts,
    stage::{self, copies, group, noise, whole},
    timer::{Contender, measure},
};
use crate::{
    Plan, Rate, Scene, View,
    analyse::{
        Analysis, Frame, Settings,
        gpu::BoundAnalysis,
        params::luma_pitch,
        settings::{Motion, Smoothing},
    },
    attach::{
        AdditionalRates, AttachOptions, Encoding, Samples, Support, Tile,
        gpu::{Attacher, BoundAttacher},
    },
    build::{BuildOptions, Modes},
    check::gpu::Gpu,
    deblock::{self, Deblocker, Packing, Picture, PictureInput},
    plan::{Binding, ColourForm},
    sri::{Sri, SriLayout},
};

const FLOORS: &str = include_str!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/shaders/bench/floors.wgsl"
));

/// Half the pixels coarse, by quads.
const COARSE: f64 = 0.5;

/// Everything that runs beside a renderer's passes, on rotated inputs of one size.
struct Machinery {
    size: [u32; 2],
    frame: Frame,
    colours: Vec<wgpu::TextureView>,
    motions: Vec<wgpu::TextureView>,
    by_colour: (Analysis, Vec<BoundAnalysis>),
    by_luma: (Analysis, Vec<BoundAnalysis>),
    attacher: (Attacher, BoundAttacher),
    view: View,
    primaries: f64,
    deblocker: Deblocker,
    deblocked: Vec<deblock::Bound>,
}

impl Machinery {
    fn new(bench: &Bench, gpu: &Gpu, size: [u32; 2]) -> Result<Machinery, BenchError> {
        let device = &gpu.device;
        let [width, height] = size;
        let count = copies(bench, u64::from(width) * u64::from(height) * 8);
        let pictures = |format, seed: u64| -> Vec<wgpu::TextureView> {
            let made = (0..count as u64).map(|i| whole(&noise(gpu, size, format, seed + i)));
            made.collect()
        };
        let colours = pictures(wgpu::TextureFormat::Rgba8Unorm, 0);
        let motions = pictures(wgpu::TextureFormat::Rg16Float, 100);
        let sri = SriLayout::new(width, height);
        let rates = || {
            let empty = vec![0; sri.bytes() as usize];
            gpu.buffer("rates", &empty, wgpu::BufferUsages::STORAGE)
        };
        let (scratch, attached) = (rates(), rates());

        let settings = Settings {
            smoothing: Smoothing::None,
            ..Settings::default()
        };
        let frame = Frame::of_size(size);
        let moving = Settings {
            motion: Some(Motion::default()),
            ..settings.clone()
        };
        let scene = Scene {
            motion: true,
            attachment: true,
            ..Scene::default()
        };
        let given = (0..count)
            .map(|i| {
                vec![
                    (Binding::Rates, scratch.as_entire_binding()),
                    (Binding::Attachment, attached.as_entire_binding()),
                    (Binding::Colour, TextureView(&colours[i])),
                    (Binding::Motion, TextureView(&motions[i])),
                ]
            })
            .collect();
        let by_colour = analysis(gpu, &scene, &moving, &frame, given)?;
        let lumas: Vec<wgpu::Buffer> = (0..count)
            .map(|seed| {
                let mut random = fastrand::Rng::with_seed(seed as u64);
                let words = luma_pitch(width) / 4 * height;
                let bytes: Vec<u32> = (0..words).map(|_| random.u32(..)).collect();
                let storage = wgpu::BufferUsages::STORAGE;
                gpu.buffer("luma", bytemuck::cast_slice(&bytes), storage)
            })
            .collect();
        let scene = Scene {
            colour: ColourForm::SqrtLuma,
            ..Scene::default()
        };
        let given = lumas
            .iter()
            .map(|luma| {
                vec![
                    (Binding::Rates, scratch.as_entire_binding()),
                    (Binding::Colour, luma.as_entire_binding()),
                ]
            })
            .collect();
        let by_luma = analysis(gpu, &scene, &settings, &frame, given)?;

        let attacher = Attacher::new(
            device,
            AttachOptions {
                tile: Tile::T8,
                encoding: Encoding::D3d12,
                support: Support::d3d12(AdditionalRates::Yes),
                samples: Samples::X1,
            },
        );
        let image = attacher.buffer(device, size);
        let bound = attacher.bind(device, &attached, &image);
        attacher.set_size(&gpu.queue, &bound, size);

        let (view, primaries) = view(gpu, size)?;
        let options = deblock::Options::new(Picture::R32Uint(Packing::Rgba8Unorm));
        let deblocker = Deblocker::new(device, None, options).map_err(own)?;
        let deblocked = (0..count as u64)
            .map(|seed| {
                let picture = noise(gpu, size, wgpu::TextureFormat::R32Uint, 500 + seed);
                let inputs = deblock::Inputs {
                    picture: PictureInput::Texture(&whole(&picture)),
                    rates: view.sri(),
                    depth: None,
                    surfaces: None,
                    luma: None,
                };
                let mut bound = deblocker.bind(device, &inputs).map_err(own)?;
                deblocker
                    .set_frame(&gpu.queue, &mut bound, size, 0)
                    .map_err(own)?;
                Ok(bound)
            })
            .collect::<Result<Vec<_>, BenchError>>()?;
        Ok(Machinery {
            size,
            frame,
            colours,
            motions,
            by_colour,
            by_luma,
            attacher: (attacher, bound),
            view,
            primaries,
            deblocker,
            deblocked,
        })
    }

    fn analyse_colour(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let (analysis, bound) = &self.by_colour;
        analysis.record(pass, &bound[round % bound.len()], &self.frame);
        self.attacher.0.record(pass, &self.attacher.1, self.size);
    }

    fn analyse_luma(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let (analysis, bound) = &self.by_luma;
        analysis.record(pass, &bound[round % bound.len()], &self.frame);
    }

    fn deblock(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let bound = &self.deblocked[round % self.deblocked.len()];
        self.deblocker.record_in(pass, bound);
    }

    fn by_luma_path(&self, pass: &mut wgpu::ComputePass, round: usize) {
        self.analyse_luma(pass, round);
        self.view.build_in(pass);
        self.deblock(pass, round);
    }

    fn by_colour_path(&self, pass: &mut wgpu::ComputePass, round: usize) {
        self.analyse_colour(pass, round);
        self.view.build_in(pass);
        self.deblock(pass, round);
    }
}

/// An analysis, bound to each rotated set of inputs.
fn analysis(
    gpu: &Gpu,
    scene: &Scene,
    settings: &Settings,
    frame: &Frame,
    given: Vec<Vec<(Binding, wgpu::BindingResource)>>,
) -> Result<(Analysis, Vec<BoundAnalysis>), BenchError> {
    let plan = Plan::new(scene, settings).map_err(own)?;
    let analysis = Analysis::new(&gpu.device, &plan);
    let bound = given
        .iter()
        .map(|resources| {
            let bound = analysis.bind(&gpu.device, resources).map_err(own)?;
            analysis.set_frame(&gpu.queue, &bound, frame);
            Ok(bound)
        })
        .collect::<Result<Vec<_>, BenchError>>()?;
    Ok((analysis, bound))
}

/// A view for both lists, half its pixels coarse, and its share of primaries.
fn view(gpu: &Gpu, size: [u32; 2]) -> Result<(View, f64), BenchError> {
    let options = BuildOptions {
        modes: Modes::NONE.with(Mode::Tiled).with(Mode::List),
        ..BuildOptions::default()
    };
    let view = View::new(&gpu.device, &gpu.queue, [size[0], size[1], 1], options).map_err(own)?;
    // half the quads coarse: each has one primary of four
    let primaries = 1.0 - 0.75 * COARSE;
    let mut random = fastrand::Rng::with_seed(3);
    let sri = Sri::from_fn(size[0], size[1], |_, _| match random.f64() < COARSE {
        true => Rate::R2X2.code(),
        false => Rate::R1X1.code(),
    });
    view.write_sri(&gpu.queue, &sri).map_err(own)?;
    Ok((view, primaries))
}

/// A floor's pipeline, and its bind groups.
struct Floor {
    pipeline: wgpu::ComputePipeline,
    groups: Vec<wgpu::BindGroup>,
    shape: [u32; 2],
}

impl Floor {
    fn record(&self, pass: &mut wgpu::ComputePass, round: usize) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.groups[round % self.groups.len()], &[]);
        pass.dispatch_workgroups(self.shape[0], self.shape[1], 1);
    }
}

/// Makes a floor from the resources of each rotated copy.
fn floor(
    gpu: &Gpu,
    entry: &str,
    shape: [u32; 2],
    given: Vec<Vec<(u32, wgpu::BindingResource)>>,
) -> Floor {
    let stage::Original { pipeline, layout } = stage::original(gpu, FLOORS, entry);
    Floor {
        groups: given
            .iter()
            .map(|resources| group(gpu, &layout, resources))
            .collect(),
        pipeline,
        shape,
    }
}

/// Each stage against its floor.
pub(super) fn stages(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let machinery = Machinery::new(bench, gpu, bench.size)?;
    let floors = Floors::new(gpu, &machinery);
    let mut rows = Vec::new();
    let mut against = |name: &str, stage: Contender, floor: &Floor| -> Result<(), BenchError> {
        let contenders = [
            stage,
            Contender::new("floor", |pass, round| floor.record(pass, round)),
        ];
        let times = measure(gpu, bench.rounds, &contenders)?;
        let parts = parts(&contenders, &times);
        let row = match name.contains("√luma") {
            true => Row::microseconds(
                name,
                1e3 * times[0].median,
                (1.25e3 * times[1].median).max(12.0),
                parts,
            ),
            false => Row::ratio(name, times[0].median / times[1].median, 1.25, parts),
        };
        rows.push(row);
        Ok(())
    };
    let machinery = &machinery;
    against(
        "stage, analysis of colour and motion, with attachment",
        Contender::new("analysis", |pass, round| {
            machinery.analyse_colour(pass, round)
        }),
        &floors.read,
    )?;
    against(
        "stage, analysis of √luma",
        Contender::new("analysis", |pass, round| {
            machinery.analyse_luma(pass, round)
        }),
        &floors.empty,
    )?;
    against(
        "stage, coordinate build, both lists",
        Contender::new("build", |pass, _| machinery.view.build_in(pass)),
        &floors.build,
    )?;
    against(
        "stage, deblock, half the quads coarse",
        Contender::new("deblock", |pass, round| machinery.deblock(pass, round)),
        &floors.copy,
    )?;
    Ok(rows)
}

/// The floors of all stages.
struct Floors {
    read: Floor,
    empty: Floor,
    build: Floor,
    copy: Floor,
}

impl Floors {
    fn new(gpu: &Gpu, machinery: &Machinery) -> Floors {
        let [width, height] = machinery.size;
        let sri = SriLayout::new(width, height);
        let uniform = |words: u32| {
            let frame = [width, height, words, 0];
            let usage = wgpu::BufferUsages::UNIFORM;
            gpu.buffer("floor", bytemuck::cast_slice(&frame), usage)
        };
        let sri_words = sri.bytes() / 4;
        // the primaries' words in both lists, spread over the words of rates
        let primaries = machinery.primaries * f64::from(width) * f64::from(height);
        let per_word = (2.0 * primaries / sri_words as f64).round() as u32;
        let traffic = uniform(per_word);
        let pitch = uniform(sri.pitch / 4);
        let out = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("floor"),
            size: (sri_words * u64::from(per_word.max(1)) * 4).max(16),
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let target = whole(&noise(
            gpu,
            machinery.size,
            wgpu::TextureFormat::Rgba8Unorm,
            900,
        ));
        let words = sri_words.div_ceil(64) as u32;
        let screen = [width.div_ceil(64), height.div_ceil(32)];
        let both = machinery.colours.iter().zip(&machinery.motions);
        let read = both.map(|(colour, motion)| {
            vec![
                (1, TextureView(colour)),
                (2, TextureView(motion)),
                (3, out.as_entire_binding()),
            ]
        });
        let copy = machinery.colours.iter().map(|colour| {
            vec![
                (0, pitch.as_entire_binding()),
                (1, TextureView(colour)),
                (4, machinery.view.sri().as_entire_binding()),
                (5, TextureView(&target)),
            ]
        });
        let moved = vec![
            (0, traffic.as_entire_binding()),
            (3, out.as_entire_binding()),
            (4, machinery.view.sri().as_entire_binding()),
        ];
        let nothing = vec![(3, out.as_entire_binding())];
        Floors {
            read: floor(gpu, "read_pictures", screen, read.collect()),
            empty: floor(gpu, "empty", screen, vec![nothing]),
            build: floor(
                gpu,
                "build_traffic",
                [words.min(1024), words.div_ceil(1024)],
                vec![moved],
            ),
            copy: floor(
                gpu,
                "copy_coarse",
                [width.div_ceil(16), height.div_ceil(16)],
                copy.collect(),
            ),
        }
    }
}

/// All that a frame adds to a renderer's passes.
pub(super) fn together(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let machinery = Machinery::new(bench, gpu, bench.size)?;
    let contenders = [
        Contender::new("√luma path", |pass, round| {
            machinery.by_luma_path(pass, round)
        }),
        Contender::new("colour and motion path", |pass, round| {
            machinery.by_colour_path(pass, round);
        }),
    ];
    let times = measure(gpu, bench.rounds, &contenders)?;
    let parts = parts(&contenders, &times);
    let row = |index: usize, goal| {
        let name = format!("all machinery, {}", contenders[index].name);
        let part = vec![parts[index].clone()];
        Row::microseconds(name, 1e3 * times[index].median, goal, part)
    };
    Ok(vec![row(0, 45.0), row(1, 85.0)])
}

/// The cost over resolution: a + b · megapixels.
pub(super) fn resolutions(bench: &Bench, gpu: &Gpu) -> Result<Vec<Row>, BenchError> {
    let mut points = Vec::new();
    let mut all = Vec::new();
    // 720p to 8K where the bench's size is 4K
    for (numerator, denominator) in [(1, 3), (1, 2), (2, 3), (1, 1), (2, 1)] {
        let size = bench
            .size
            .map(|side| (side * numerator / denominator).max(16));
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|&side| side > limit) {
            continue;
        }
        let machinery = Machinery::new(bench, gpu, size)?;
        let contenders = [Contender::new(
            format!("{}x{}", size[0], size[1]),
            |pass, round| machinery.by_luma_path(pass, round),
        )];
        let times = measure(gpu, bench.rounds, &contenders)?;
        all.extend(parts(&contenders, &times));
        let megapixels = f64::from(size[0]) * f64::from(size[1]) / 1e6;
        points.push([megapixels, 1e3 * times[0].median]);
    }
    let [a, b] = fit(&points);
    let worst = points
        .iter()
        .map(|&[x, y]| ((a + b * x) / y - 1.0).abs())
        .fold(0.0, f64::max);
    // analysis, build, its end, deblock
    let dispatches = 4.0;
    Ok(vec![
        Row::ratio(
            format!("resolution, {a:.1} + {b:.2} · megapixels µs, the largest misfit"),
            worst,
            0.1,
            all.clone(),
        ),
        Row::microseconds("resolution, a for each dispatch", a / dispatches, 10.0, all),
    ])
}

/// The line a + b · x with the least squared relative distances.
fn fit(points: &[[f64; 2]]) -> [f64; 2] {
    let mut sums = [0.0; 5];
    for &[x, y] in points {
        let weight = 1.0 / (y * y);
        for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, x * y]) {
            *sum += weight * term;
        }
    }
    let [n, x, y, xx, xy] = sums;
    let determinant = n * xx - x * x;
    match determinant.abs() > 0.0 {
        true => [
            (y * xx - x * xy) / determinant,
            (n * xy - x * y) / determinant,
        ],
        false => [0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    use super::fit;

    #[test]
    fn a_line_is_found_again() {
        let points = [1.0, 2.0, 8.0, 33.0].map(|x| [x, 20.0 + 1.5 * x]);
        let [a, b] = fit(&points);
        assert!((a - 20.0).abs() < 1e-9 && (b - 1.5).abs() < 1e-9, "{a} {b}");
    }
}
