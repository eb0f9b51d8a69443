//! Rows of the runtime's own stages, each against kernels that only move what it has to move: the fastest of several shapes.

use vrcs_passes::options::Mode;
use wgpu::BindingResource::TextureView;

use super::{
    BenchError, Lab, Row,
    floors::{Floor, Floors},
    own,
    stage::{self, Content, copies, texture, whole},
    timer::Contender,
};
use crate::{
    Plan, Scene, View,
    analyse::{
        Analysis, Frame, Settings,
        gpu::BoundAnalysis,
        params::luma_pitch,
        settings::{Granularity, Motion, Smoothing},
    },
    attach::{
        AdditionalRates, AttachOptions, Encoding, Samples, Support, Tile,
        gpu::{Attacher, BoundAttacher},
    },
    build::{BuildOptions, Modes},
    check::gpu::{Gpu, by_construction},
    deblock::{self, Deblocker, Packing, Picture, PictureInput},
    plan::{Binding, ColourForm},
    sri::{Sri, SriLayout},
};

/// Half the pixels coarse, by quads.
const COARSE: f64 = 0.5;

/// What runs beside a renderer's passes where the previous picture is had as √luma. Everything is there in as many copies as more than
/// 200 MB take, and rotated.
pub(super) struct Machinery {
    pub(super) size: [u32; 2],
    frame: Frame,
    pub(super) lumas: Vec<wgpu::Buffer>,
    by_luma: (Analysis, Vec<BoundAnalysis>),
    pub(super) views: Vec<View>,
    pub(super) primaries: f64,
    deblocker: Deblocker,
    deblocked: Vec<deblock::Bound>,
    pub(super) pictures: Vec<wgpu::TextureView>,
}

/// The analysis where it is had as colour, with motion, and an attachment's image is wanted too.
pub(super) struct Colours {
    frame: Frame,
    pub(super) colours: Vec<wgpu::TextureView>,
    pub(super) motions: Vec<wgpu::TextureView>,
    by_colour: (Analysis, Vec<BoundAnalysis>),
    attacher: (Attacher, Vec<BoundAttacher>),
}

fn of<T>(all: &[T], round: usize) -> &T {
    &all[round % all.len()]
}

/// Rates that are written and not looked at.
fn rates(gpu: &Gpu, size: [u32; 2]) -> wgpu::Buffer {
    let bytes = SriLayout::new(size[0], size[1]).bytes() as usize;
    gpu.buffer("rates", &vec![0; bytes], wgpu::BufferUsages::STORAGE)
}

fn settings() -> Settings {
    Settings {
        smoothing: Smoothing::None,
        // from the same estimates as the rates, in the same pass
        attachment: Granularity::Quad,
        ..Settings::default()
    }
}

impl Machinery {
    pub(super) fn new(lab: &Lab, size: [u32; 2]) -> Result<Machinery, BenchError> {
        let Lab { bench, gpu, .. } = lab;
        let device = &gpu.device;
        let [width, height] = size;
        let frame = Frame::of_size(size);
        let row = luma_pitch(width) / 4;
        let bytes = u64::from(row) * u64::from(height) * 4;
        let lumas: Vec<wgpu::Buffer> = (0..copies(bench, bytes) as u64)
            .map(|seed| {
                let words = stage::words([row, height], Content::Picture, seed);
                let storage = wgpu::BufferUsages::STORAGE;
                gpu.buffer("luma", bytemuck::cast_slice(&words), storage)
            })
            .collect();
        let scene = Scene {
            colour: ColourForm::SqrtLuma,
            ..Scene::default()
        };
        let scratch: Vec<wgpu::Buffer> = lumas.iter().map(|_| rates(gpu, size)).collect();
        let given = lumas.iter().zip(&scratch).map(|(luma, scratch)| {
            vec![
                (Binding::Rates, scratch.as_entire_binding()),
                (Binding::Colour, luma.as_entire_binding()),
            ]
        });
        let by_luma = analysis(gpu, &scene, &settings(), &frame, given.collect())?;

        // half the quads coarse: each has one primary of four
        let primaries = 1.0 - 0.75 * COARSE;
        let views = (0..stage::VIEWS)
            .map(|seed| view(gpu, size, primaries, seed))
            .collect::<Result<Vec<View>, BenchError>>()?;
        let options = deblock::Options {
            coverage: false,
            ..deblock::Options::new(Picture::R32Uint(Packing::Rgba8Unorm))
        };
        let deblocker = Deblocker::new(device, None, options).map_err(own)?;
        let count = copies(bench, u64::from(width) * u64::from(height) * 4);
        let pictures: Vec<wgpu::TextureView> = (0..count as u64)
            .map(|seed| {
                let format = wgpu::TextureFormat::R32Uint;
                whole(&texture(gpu, size, format, Content::Picture, 500 + seed))
            })
            .collect();
        let deblocked = pictures
            .iter()
            .enumerate()
            .map(|(index, picture)| {
                let inputs = deblock::Inputs {
                    picture: PictureInput::Texture(picture),
                    rates: of(&views, index).sri(),
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
            lumas,
            by_luma,
            views,
            primaries,
            deblocker,
            deblocked,
            pictures,
        })
    }

    fn analyse(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let (analysis, bound) = &self.by_luma;
        analysis.record(pass, of(bound, round), &self.frame);
    }

    fn build(&self, pass: &mut wgpu::ComputePass, round: usize) {
        by_construction(of(&self.views, round).build_in(pass));
    }

    fn deblock(&self, pass: &mut wgpu::ComputePass, round: usize) {
        by_construction(self.deblocker.record_in(pass, of(&self.deblocked, round)));
    }

    fn path(&self, pass: &mut wgpu::ComputePass, round: usize) {
        self.analyse(pass, round);
        self.build(pass, round);
        self.deblock(pass, round);
    }
}

impl Colours {
    pub(super) fn new(lab: &Lab, size: [u32; 2]) -> Result<Colours, BenchError> {
        let Lab { bench, gpu, .. } = lab;
        let [width, height] = size;
        let frame = Frame::of_size(size);
        let count = copies(bench, u64::from(width) * u64::from(height) * 8);
        let pictures = |format, content| -> Vec<wgpu::TextureView> {
            let made = (0..count as u64).map(|seed| texture(gpu, size, format, content, seed));
            made.map(|texture| whole(&texture)).collect()
        };
        let colours = pictures(wgpu::TextureFormat::Rgba8Unorm, Content::Picture);
        let motions = pictures(wgpu::TextureFormat::Rg16Float, Content::Motion);
        let moving = Settings {
            motion: Some(Motion::default()),
            ..settings()
        };
        let scene = Scene {
            motion: true,
            attachment: true,
            ..Scene::default()
        };
        let scratch: Vec<[wgpu::Buffer; 2]> = (0..count)
            .map(|_| [rates(gpu, size), rates(gpu, size)])
            .collect();
        let given = (0..count)
            .map(|i| {
                vec![
                    (Binding::Rates, scratch[i][0].as_entire_binding()),
                    (Binding::Attachment, scratch[i][1].as_entire_binding()),
                    (Binding::Colour, TextureView(&colours[i])),
                    (Binding::Motion, TextureView(&motions[i])),
                ]
            })
            .collect();
        let by_colour = analysis(gpu, &scene, &moving, &frame, given)?;
        let attacher = Attacher::new(
            &gpu.device,
            AttachOptions {
                tile: Tile::T8,
                encoding: Encoding::D3d12,
                support: Support::d3d12(AdditionalRates::Yes),
                samples: Samples::X1,
            },
        )
        .map_err(own)?;
        let bound = scratch
            .iter()
            .map(|[_, attached]| {
                let image = attacher.buffer(&gpu.device, size);
                let mut bound = attacher.bind(&gpu.device, attached, &image).map_err(own)?;
                attacher
                    .set_size(&gpu.queue, &mut bound, size)
                    .map_err(own)?;
                Ok(bound)
            })
            .collect::<Result<Vec<_>, BenchError>>()?;
        Ok(Colours {
            frame,
            colours,
            motions,
            by_colour,
            attacher: (attacher, bound),
        })
    }

    fn rates(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let (analysis, bound) = &self.by_colour;
        analysis.record(pass, of(bound, round), &self.frame);
    }

    fn analyse(&self, pass: &mut wgpu::ComputePass, round: usize) {
        self.rates(pass, round);
        let (attacher, bound) = &self.attacher;
        attacher.record(pass, of(bound, round));
    }

    fn path(&self, machinery: &Machinery, pass: &mut wgpu::ComputePass, round: usize) {
        self.analyse(pass, round);
        machinery.build(pass, round);
        machinery.deblock(pass, round);
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
    let analysis = Analysis::new(&gpu.device, &plan).map_err(own)?;
    let bound = given
        .iter()
        .map(|resources| {
            let bound = analysis.bind(&gpu.device, resources).map_err(own)?;
            analysis.set_frame(&gpu.queue, &bound, frame).map_err(own)?;
            Ok(bound)
        })
        .collect::<Result<Vec<_>, BenchError>>()?;
    Ok((analysis, bound))
}

/// A view for both lists, with quads coarse at random.
fn view(gpu: &Gpu, size: [u32; 2], primaries: f64, seed: u64) -> Result<View, BenchError> {
    let options = BuildOptions {
        modes: Modes::NONE.with(Mode::Tiled).with(Mode::List),
        ..BuildOptions::default()
    };
    let view = View::new(&gpu.device, &gpu.queue, [size[0], size[1], 1], options).map_err(own)?;
    let sri: Sri = stage::random(size, primaries, seed);
    view.write_sri(&gpu.queue, &sri).map_err(own)?;
    Ok(view)
}

/// Each stage against its floors.
pub(super) fn stages(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let machinery = Machinery::new(lab, lab.bench.size)?;
    let colours = Colours::new(lab, lab.bench.size)?;
    let floors = Floors::new(lab, &machinery, &colours);
    let mut rows = Vec::new();
    let with = |stages: Vec<Contender<'_>>, floors: &'_ [Floor]| {
        let count = stages.len();
        let mut contenders = stages;
        for floor in floors {
            contenders.push(Contender::new(floor.name, |pass, round| {
                floor.record(pass, round)
            }));
        }
        let all = contenders.len();
        let measured = lab.measure(&contenders)?;
        let floor = measured.shortest(count..all).1;
        Ok::<_, BenchError>((measured, floor))
    };

    let stages = vec![
        Contender::new("analysis", |pass, round| colours.analyse(pass, round)),
        Contender::new("rates alone", |pass, round| colours.rates(pass, round)),
    ];
    let (measured, floor) = with(stages, &floors.read)?;
    let name = "stage, analysis of colour and motion, with attachment";
    rows.push(Row::ratio(name, measured.of(0) / floor, 1.25, measured));

    let stages = vec![
        Contender::new("analysis", |pass, round| machinery.analyse(pass, round)),
        Contender::new("reads and writes", |pass, round| {
            floors.luma.record(pass, round)
        }),
    ];
    let (measured, floor) = with(stages, std::slice::from_ref(&floors.empty))?;
    let goal = (1.25e3 * floor).max(12.0);
    rows.push(Row::microseconds(
        "stage, analysis of √luma",
        1e3 * measured.of(0),
        goal,
        measured,
    ));

    let stage = Contender::new("build", |pass, round| machinery.build(pass, round));
    let (measured, floor) = with(vec![stage], &floors.build)?;
    let name = "stage, coordinate build, both lists";
    rows.push(Row::ratio(name, measured.of(0) / floor, 1.25, measured));

    let stage = Contender::new("deblock", |pass, round| machinery.deblock(pass, round));
    let (measured, floor) = with(vec![stage], &floors.copy)?;
    let name = "stage, deblock, half the quads coarse";
    rows.push(Row::ratio(name, measured.of(0) / floor, 1.25, measured));
    Ok(rows)
}

/// All that a frame adds to a renderer's passes.
pub(super) fn together(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let machinery = Machinery::new(lab, lab.bench.size)?;
    let colours = Colours::new(lab, lab.bench.size)?;
    let luma = [Contender::new("√luma path", |pass, round| {
        machinery.path(pass, round)
    })];
    let colour = [Contender::new("colour and motion path", |pass, round| {
        colours.path(&machinery, pass, round);
    })];
    let mut rows = Vec::new();
    for (contenders, goal) in [(&luma, 45.0), (&colour, 85.0)] {
        let measured = lab.measure(contenders)?;
        let name = format!("all machinery, {}", contenders[0].name);
        rows.push(Row::microseconds(
            name,
            1e3 * measured.of(0),
            goal,
            measured,
        ));
    }
    Ok(rows)
}

/// The cost over resolution: a + b · megapixels.
pub(super) fn resolutions(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let mut points = Vec::new();
    let mut all: Option<super::Measured> = None;
    // 720p to 8K where the bench's size is 4K
    for (numerator, denominator) in [(1, 3), (1, 2), (2, 3), (1, 1), (2, 1)] {
        let size = bench
            .size
            .map(|side| (side * numerator / denominator).max(16));
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.iter().any(|&side| side > limit) {
            continue;
        }
        let machinery = Machinery::new(lab, size)?;
        let name = format!("{}x{}", size[0], size[1]);
        let contender = Contender::new(name, |pass, round| machinery.path(pass, round));
        let measured = lab.measure(&[contender])?;
        let megapixels = f64::from(size[0]) * f64::from(size[1]) / 1e6;
        points.push([megapixels, 1e3 * measured.of(0)]);
        all = Some(match all {
            Some(before) => before.and(measured),
            None => measured,
        });
    }
    let Some(all) = all else {
        return Err(own("no size fits this device"));
    };
    let [a, b] = fit(&points);
    let worst = points
        .iter()
        .map(|&[x, y]| ((a + b * x) / y - 1.0).abs())
        .fold(0.0, f64::max);
    // analysis, build, its end, deblock
    let dispatches = 4.0;
    let name = format!("resolution, {a:.1} + {b:.2} · megapixels µs, the largest misfit");
    let line = Row::ratio(name, worst, 0.1, all.clone());
    let constant = Row::microseconds("resolution, a for each dispatch", a / dispatches, 10.0, all);
    Ok(vec![
        // where no line fits, its constant means nothing
        match worst <= 0.1 {
            true => constant,
            false => Row {
                name: "resolution, a for each dispatch: void, no line fits".to_owned(),
                ..constant.unjudged()
            },
        },
        line,
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
