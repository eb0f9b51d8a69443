//! Rows of encodings: what it costs to write down which pixels of a tile are shaded, and to go by it in some passes of a frame.
//!
//! *Does*: times a builder and a pass for each encoding of `shaders/bench/encodings.wgsl`, over the same shading rates. *Guarantees*:
//! all passes leave the same picture, or there are no rows. *Needs*: a picture of whole tiles; the height is cut down to one.

use vrcs_passes::options::Mode;

use super::{
    Bench, BenchError, Lab, Measured, Row, own,
    stage::{self, Inputs, group},
    timer::Contender,
};
use crate::{
    Rate, View,
    build::{BuildOptions, LinearDepth, Modes},
    check::gpu::{Gpu, by_construction},
    coverage::{Coverage, Depth, DepthKind, Textures},
    kernel::{self, shader},
    sri::{Sri, SriLayout},
};

/// An encoding: its name, and what its kernels are compiled with.
type Encoding = (&'static str, &'static [(&'static str, u32)]);

const ENCODINGS: [Encoding; 4] = [
    ("32-bit entries", &[("WORDS", 1)]),
    ("11 bits in 16", &[("HALVES", 1)]),
    (
        "4-bit partition, searched",
        &[("PARTITION", 1), ("SEARCH", 1)],
    ),
    ("4-bit partition, unpacked", &[("PARTITION", 1)]),
];
/// Passes of a frame that go by one build.
const PASSES: [u32; 4] = [1, 2, 4, 8];
/// Lights of a pass: one that hardly does anything but read its entry, and one of some weight.
const LIGHTS: [u32; 2] = [4, 64];

/// The kernels of an encoding, bound.
struct Kernels {
    name: &'static str,
    build: wgpu::ComputePipeline,
    shade: wgpu::ComputePipeline,
    built: wgpu::BindGroup,
    shaded: Vec<wgpu::BindGroup>,
    groups: [u32; 2],
}

/// The 15 ways to part four pixels, by how many groups they make, the most first: a nibble for each place, the members of the
/// group that it leads. The two halves of a quad are the first that make two.
fn partings() -> [u32; 16] {
    let mut all = Vec::new();
    // which group each place is in, numbered as they come
    for code in 0..256u32 {
        let of = |place: u32| code >> (2 * place) & 3;
        let is_numbered = (0..4).all(|place| {
            let most = (0..place).map(|before| of(before) + 1).max().unwrap_or(0);
            of(place) <= most
        });
        if !is_numbered {
            continue;
        }
        let mut leads = 0;
        for place in 0..4 {
            let members = (0..4).filter(|&other| of(other) == of(place));
            let members = members.fold(0, |mask, other| mask | 1 << other);
            if (members as u32).trailing_zeros() == place {
                leads |= (members as u32) << (4 * place);
            }
        }
        all.push(leads);
    }
    let groups = |leads: u32| {
        (0..4)
            .filter(|place| leads >> (4 * place) & 15 != 0)
            .count()
    };
    // rows, then columns
    let halves = |leads: u32| match leads {
        0x0c03 => 0,
        0x00a5 => 1,
        _ => 2,
    };
    all.sort_by_key(|&leads| (4 - groups(leads), halves(leads), leads));
    let mut table = [0; 16];
    table[..all.len()].copy_from_slice(&all);
    table
}

impl Kernels {
    fn new(
        gpu: &Gpu,
        &(name, defs): &Encoding,
        size: [u32; 2],
        inputs: &Inputs,
        [frame, sri, partings]: [&wgpu::Buffer; 3],
    ) -> Result<Kernels, BenchError> {
        let source = shader!("bench/encodings.wgsl");
        // SAFETY: every loop runs to a constant, to the number of lights, or to what a tile holds
        let module = unsafe { kernel::trusted_module(&gpu.device, source, defs) }.map_err(own)?;
        let pipeline = |entry: &str| {
            gpu.device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(name),
                    layout: None,
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: kernel::compilation_options(),
                    cache: None,
                })
        };
        let [build, shade] = ["build", "shade"].map(pipeline);
        let tiles = size.map(|side| side / 16);
        // room for the largest: a header and 224 words a tile
        let bytes = vec![0; tiles[0] as usize * tiles[1] as usize * 225 * 4];
        let coords = gpu.buffer(name, &bytes, wgpu::BufferUsages::STORAGE);
        let is_parted = defs.iter().any(|&(def, _)| def == "PARTITION");
        let built = group(
            gpu,
            &build.get_bind_group_layout(0),
            &[
                (0, frame.as_entire_binding()),
                (4, coords.as_entire_binding()),
                (5, sri.as_entire_binding()),
            ],
        );
        let both = inputs.surfaces.iter().zip(&inputs.pictures);
        let shaded = both.map(|(surface, picture)| {
            let mut resources = vec![
                (0, frame.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(surface)),
                (2, inputs.lights.as_entire_binding()),
                (3, wgpu::BindingResource::TextureView(picture)),
                (4, coords.as_entire_binding()),
            ];
            if is_parted {
                resources.push((6, partings.as_entire_binding()));
            }
            group(gpu, &shade.get_bind_group_layout(0), &resources)
        });
        Ok(Kernels {
            name,
            shaded: shaded.collect(),
            build,
            shade,
            built,
            groups: tiles,
        })
    }

    fn record_build(&self, pass: &mut wgpu::ComputePass) {
        let [across, down] = self.groups;
        let together = if self.name.contains("partition") {
            8
        } else {
            4
        };
        pass.set_pipeline(&self.build);
        pass.set_bind_group(0, &self.built, &[]);
        pass.dispatch_workgroups(across.div_ceil(together), down, 1);
    }

    fn record_pass(&self, pass: &mut wgpu::ComputePass, round: usize) {
        let [across, down] = self.groups;
        pass.set_pipeline(&self.shade);
        pass.set_bind_group(0, &self.shaded[round % self.shaded.len()], &[]);
        pass.dispatch_workgroups(across, down, 1);
    }
}

/// Time of build and passes over that of 32-bit entries, for each other encoding; no goal, but the smaller the better.
pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let size = bench.size.map(|side| (side / 16).max(1) * 16);
    let whole = Bench {
        size,
        ..(*bench).clone()
    };
    let mut rows = Vec::new();
    for (what, sri) in [
        ("random, 50 % primary", stage::random(size, 0.5, 0)),
        ("natural", stage::natural(size, 0)),
    ] {
        for lights in LIGHTS {
            let inputs = Inputs::new(&whole, gpu, lights);
            rows.extend(compare(lab, size, &inputs, &sri, lights, what)?);
        }
    }
    Ok(rows)
}

fn compare(
    lab: &Lab,
    size: [u32; 2],
    inputs: &Inputs,
    sri: &Sri,
    lights: u32,
    what: &str,
) -> Result<Vec<Row>, BenchError> {
    let gpu = lab.gpu;
    let [width, height] = size;
    let frame = [
        width,
        height,
        lights,
        SriLayout::new(width, height).pitch / 4,
    ];
    let frame = gpu.buffer(
        "frame",
        bytemuck::cast_slice(&frame),
        wgpu::BufferUsages::UNIFORM,
    );
    let storage = wgpu::BufferUsages::STORAGE;
    let rates = gpu.buffer("rates", sri.bytes(), storage);
    let partings = gpu.buffer("partings", bytemuck::cast_slice(&partings()), storage);
    let kernels: Vec<Kernels> = ENCODINGS
        .iter()
        .map(|encoding| {
            let buffers = [&frame, &rates, &partings];
            Kernels::new(gpu, encoding, size, inputs, buffers)
        })
        .collect::<Result<_, _>>()?;
    gpu.check()?;
    check_pictures(gpu, &kernels, inputs)?;
    let mut contenders = Vec::new();
    for of in &kernels {
        contenders.push(Contender::new(format!("{}, build", of.name), |pass, _| {
            of.record_build(pass)
        }));
        contenders.push(Contender::new(
            format!("{}, a pass", of.name),
            |pass, round| of.record_pass(pass, round),
        ));
    }
    let measured = lab.measure(&contenders)?;
    let frame_of = |index: usize, passes: u32| {
        measured.of(2 * index) + f64::from(passes) * measured.of(2 * index + 1)
    };
    let mut rows = Vec::new();
    for (index, of) in kernels.iter().enumerate().skip(1) {
        for passes in PASSES {
            let parts = [2 * index, 2 * index + 1, 0, 1].map(|part| measured.parts[part].clone());
            let seen = Measured {
                parts: parts.to_vec(),
                drift: measured.drift,
            };
            let name = format!(
                "encodings, {what}, {lights} lights, build and {passes} passes: {} over {}",
                of.name, kernels[0].name
            );
            let value = frame_of(index, passes) / frame_of(0, passes);
            rows.push(Row::ratio(name, value, 1.0, seen).unjudged());
        }
    }
    Ok(rows)
}

/// Every encoding leaves the same picture.
fn check_pictures(gpu: &Gpu, kernels: &[Kernels], inputs: &Inputs) -> Result<(), BenchError> {
    let picture = inputs.pictures[0].texture();
    let mut first = None;
    for of in kernels {
        // what is not written stays as it was cleared
        let bytes = vec![0x5a; (picture.width() * picture.height() * 4) as usize];
        gpu.queue.write_texture(
            picture.as_image_copy(),
            &bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(picture.width() * 4),
                rows_per_image: None,
            },
            picture.size(),
        );
        let mut encoder = gpu.encoder();
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            of.record_build(&mut pass);
            of.record_pass(&mut pass, 0);
        }
        let got = gpu.read_rgba8(encoder, picture)?;
        match &first {
            None => first = Some(got),
            Some(first) if *first == got => {}
            Some(first) => {
                let at = first
                    .iter()
                    .zip(&got)
                    .position(|(a, b)| a != b)
                    .unwrap_or(0)
                    / 4;
                let [x, y] = [at as u32 % picture.width(), at as u32 / picture.width()];
                return Err(own(format!(
                    "{} leaves another picture than {}, first at pixel ({x}, {y})",
                    of.name, kernels[0].name
                )));
            }
        }
    }
    Ok(())
}

/// What is asked of a build.
type Asked = (&'static str, BuildOptions);

/// Microseconds of the coordinate build, by what is asked of it and by the rates; no goals here.
pub(super) fn builds(lab: &Lab) -> Result<Vec<Row>, BenchError> {
    let Lab { bench, gpu, .. } = lab;
    let of = |modes: &[Mode]| BuildOptions {
        modes: modes
            .iter()
            .fold(Modes::NONE, |modes, &mode| modes.with(mode)),
        ..BuildOptions::default()
    };
    let depth = Coverage {
        depth: Some(Depth::new(DepthKind::Linear)),
        ..Coverage::default()
    };
    let asked: [Asked; 8] = [
        ("tiled", of(&[Mode::Tiled])),
        ("list", of(&[Mode::List])),
        ("both", of(&[Mode::Tiled, Mode::List])),
        ("classified", of(&[Mode::Classified])),
        (
            "both, 4x4",
            BuildOptions {
                largest: Rate::R4X4,
                ..of(&[Mode::Tiled, Mode::List])
            },
        ),
        (
            "both, shared by depth",
            BuildOptions {
                coverage: depth,
                ..of(&[Mode::Tiled, Mode::List])
            },
        ),
        // the same, its entries of lists of two words, and of all with linear depth in the spare bits
        (
            "both, shared by depth, which entries carry",
            BuildOptions {
                coverage: depth,
                linear_depth: Some(LinearDepth {
                    near: 0.1,
                    far: 100.0,
                }),
                ..of(&[Mode::Tiled, Mode::List])
            },
        ),
        (
            "everything",
            BuildOptions {
                modes: Modes::ALL,
                effective: true,
                statistics: true,
                ..BuildOptions::default()
            },
        ),
    ];
    let size = bench.size;
    let plane: Vec<f32> = (0..size[0] * size[1])
        .map(|at| 1.0 / (0.02 + (at % size[0]) as f32 * 1e-5 + (at / size[0]) as f32 * 2e-5))
        .collect();
    let format = wgpu::TextureFormat::R32Float;
    let plane = gpu.texture("depth", size, format, bytemuck::cast_slice(&plane));
    let mut rows = Vec::new();
    for (what, sri) in [
        ("random, 50 % primary", stage::random(size, 0.5, 0)),
        ("natural", stage::natural(size, 0)),
        ("all 2x2", Sri::uniform(size[0], size[1], Rate::R2X2)),
        ("all 1x1", Sri::uniform(size[0], size[1], Rate::R1X1)),
    ] {
        let mut views = Vec::new();
        for (name, options) in asked {
            let view = View::new(&gpu.device, &gpu.queue, [size[0], size[1], 1], options);
            let mut view = view.map_err(own)?;
            if options.coverage.depth.is_some() {
                let textures = Textures {
                    depth: Some(&plane),
                    ..Textures::default()
                };
                view.cover(&gpu.queue, &textures).map_err(own)?;
            }
            view.write_sri(&gpu.queue, &sri).map_err(own)?;
            views.push((name, view));
        }
        let contenders: Vec<Contender> = views
            .iter()
            .map(|(name, view)| {
                Contender::new(*name, |pass, _| by_construction(view.build_in(pass)))
            })
            .collect();
        let measured = lab.measure(&contenders)?;
        for (part, (name, _)) in measured.parts.iter().zip(&views) {
            let seen = Measured {
                parts: vec![part.clone()],
                drift: measured.drift,
            };
            let name = format!("build, {what}: {name}");
            let value = part.milliseconds * 1e3;
            rows.push(Row::microseconds(name, value, 0.0, seen).unjudged());
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::partings;

    #[test]
    fn four_pixels_are_parted_in_fifteen_ways() {
        let all = partings();
        assert_eq!(all[15], 0);
        assert_eq!(
            (all[0], all[7], all[8], all[14]),
            (0x8421, 0x0c03, 0x00a5, 0x000f)
        );
        for (code, leads) in all[..15].iter().enumerate() {
            let groups: Vec<u32> = (0..4)
                .map(|place| leads >> (4 * place) & 15)
                .filter(|&members| members != 0)
                .collect();
            assert_eq!(groups.iter().sum::<u32>(), 15, "each pixel in one group");
            let expected = [4, 3, 3, 3, 3, 3, 3, 2, 2, 2, 2, 2, 2, 2, 1][code];
            assert_eq!(groups.len(), expected, "code {code}");
        }
    }
}
