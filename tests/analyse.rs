//! The analysis on the GPU makes the same bytes as its integer twin, whatever is compiled into it.

mod common;

use fastrand::Rng;
use vrcs::{
    Plan, Rate, Scene,
    analyse::{
        Analysis, Cameras, Colour, Frame, HalfResolution, Inputs, Lens, Output, OwnRates, half,
        integer,
        own::{DistanceLadder, IdRates, Particles},
        settings::*,
        tiles,
    },
    check::gpu::Gpu,
    plan::{Binding, ColourForm},
    rate::Combiner,
    sri::{Sri, SriLayout},
};

/// Everything that a frame may have, made up.
struct Made {
    size: [u32; 2],
    previous: [u32; 2],
    codes: Vec<[u8; 4]>,
    after_codes: Vec<[u8; 4]>,
    linear: Vec<[f32; 4]>,
    after_linear: Vec<[f32; 4]>,
    sqrt: Vec<u8>,
    motion: Vec<[f32; 2]>,
    depth: Vec<f32>,
    blur: Vec<f32>,
    previous_depth: Vec<f32>,
    rates: Sri,
    materials: Vec<[u8; 2]>,
    noise: Vec<u8>,
    ids: Vec<u8>,
    flags: Vec<u8>,
}

const HARD: [f32; 12] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    -0.0,
    1e-41,
    -1e-7,
    -0.5,
    1.0,
    65504.0,
    1e30,
    0.0,
    0.99999,
];

impl Made {
    fn new(size: [u32; 2], previous: [u32; 2], rng: &mut Rng) -> Made {
        let count = |[w, h]: [u32; 2]| (w * h) as usize;
        let (now, before) = (count(size), count(previous));
        let span = [255, 60, 12, 3][rng.usize(..4)];
        let low = rng.u8(..=255 - span);
        let (sx, sy) = (rng.f64() * 9.0, rng.f64() * 9.0);
        let smooth = rng.bool();
        let codes = |rng: &mut Rng| -> Vec<[u8; 4]> {
            (0..before as u32)
                .map(|i| {
                    let (x, y) = (f64::from(i % previous[0]), f64::from(i / previous[0]));
                    let ramp = (sx * x / 7.0 + sy * y / 7.0) as u32 as u8;
                    std::array::from_fn(|_| match smooth {
                        true => ramp.wrapping_add(rng.u8(..=span / 8)),
                        false => low + rng.u8(..=span),
                    })
                })
                .collect()
        };
        let codes_before = codes(rng);
        let after_codes = codes(rng);
        let linear = |codes: &[[u8; 4]], rng: &mut Rng| -> Vec<[f32; 4]> {
            codes
                .iter()
                .map(|code| match rng.u32(..200) {
                    0 => std::array::from_fn(|_| HARD[rng.usize(..HARD.len())]),
                    _ => {
                        code.map(|c| (f32::from(c) / 255.0).powi(2) * rng.f32().mul_add(0.02, 0.98))
                    }
                })
                .collect()
        };
        let speed = [0.0, 2.0, 20.0][rng.usize(..3)];
        Made {
            size,
            previous,
            linear: linear(&codes_before, rng),
            after_linear: linear(&after_codes, rng),
            sqrt: codes_before.iter().map(|c| c[0]).collect(),
            codes: codes_before,
            after_codes,
            motion: (0..now)
                .map(|_| match rng.u32(..400) {
                    0 => [HARD[rng.usize(..HARD.len())], 0.5],
                    _ => [speed + rng.f32() - 0.5, speed * 0.3 + rng.f32() - 0.5],
                })
                .collect(),
            depth: (0..now)
                .map(|_| {
                    if rng.u32(..300) == 0 {
                        HARD[rng.usize(..HARD.len())]
                    } else {
                        0.3 + rng.f32() * 0.02
                    }
                })
                .collect(),
            blur: (0..now)
                .map(|_| {
                    if rng.u32(..300) == 0 {
                        HARD[rng.usize(..HARD.len())]
                    } else {
                        rng.f32() * 5.0
                    }
                })
                .collect(),
            previous_depth: (0..before)
                .map(|_| {
                    if rng.u32(..100) == 0 {
                        0.9
                    } else {
                        0.3 + rng.f32() * 0.02
                    }
                })
                .collect(),
            rates: Sri::from_fn(previous[0], previous[1], |_, _| match rng.u32(..12) {
                0 => 0xff,
                _ => rng.choice(Rate::ALL).map_or(0, Rate::code),
            }),
            materials: (0..now).map(|_| [rng.u8(..), rng.u8(..)]).collect(),
            noise: (0..now)
                .map(|_| if rng.bool() { 0 } else { rng.u8(..) })
                .collect(),
            ids: (0..now as u32)
                .map(|i| ((i % size[0] / 7 + i / size[0] / 5) % 24) as u8)
                .collect(),
            flags: (0..now)
                .map(|_| if rng.u32(..12) == 0 { rng.u8(..16) } else { 0 })
                .collect(),
        }
    }

    fn inputs<'a>(&'a self, plan: &Plan, frame: &Frame) -> Inputs<'a> {
        let scene = &plan.scene;
        let (colour, after) = match scene.colour {
            ColourForm::Codes => (Colour::Codes(&self.codes), Colour::Codes(&self.after_codes)),
            ColourForm::Linear => (
                Colour::Linear(&self.linear),
                Colour::Linear(&self.after_linear),
            ),
            ColourForm::SqrtLuma => (Colour::SqrtLuma(&self.sqrt), Colour::SqrtLuma(&self.sqrt)),
        };
        Inputs {
            size: frame.size,
            previous_size: frame.previous_size,
            has_history: frame.has_history,
            resolution_scale: frame.resolution_scale,
            cameras: frame.cameras,
            colour,
            after: scene.after_transparents.then_some(after),
            motion: scene.motion.then_some(&self.motion),
            depth: scene.depth.then_some(&self.depth),
            blur: scene.blur.then_some(&self.blur),
            previous_depth: scene.depth.then_some(&self.previous_depth),
            previous_rates: scene.previous_rates.then_some(&self.rates),
            materials: scene.materials.then_some(&self.materials),
            noise: scene.noise.then_some(&self.noise),
            ids: scene.ids.then_some(&self.ids),
            flags: scene.flags.then_some(&self.flags),
        }
    }

    fn texture(
        &self,
        gpu: &Gpu,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        bytes: &[u8],
    ) -> wgpu::TextureView {
        let extent = wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32 / size[1]),
            rows_per_image: None,
        };
        gpu.queue
            .write_texture(texture.as_image_copy(), bytes, layout, extent);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn run(&self, gpu: &Gpu, plan: &Plan, frame: &Frame) -> [Vec<u8>; 6] {
        self.run_with(gpu, &Analysis::new(&gpu.device, plan), frame)
    }

    /// With pipelines that are there already.
    fn run_with(&self, gpu: &Gpu, analysis: &Analysis, frame: &Frame) -> [Vec<u8>; 6] {
        let plan = analysis.plan();
        use wgpu::TextureFormat as F;
        let storage = wgpu::BufferUsages::STORAGE;
        let bytes = SriLayout::new(self.size[0], self.size[1]).bytes() as usize;
        // poisoned: what is not written shows
        let plain = gpu.buffer("plain", &vec![0xa5; bytes], storage);
        let outputs = [0, 1, 2].map(|_| gpu.buffer("out", &vec![0xa5; bytes], storage));
        let luma = gpu.buffer(
            "sqrt luma out",
            &vec![
                0xa5;
                self.previous[0].next_multiple_of(256) as usize * self.previous[1] as usize
            ],
            storage,
        );
        let [half_width, half_height] = half::size_of(self.size);
        let half_bytes = SriLayout::new(half_width, half_height).bytes() as usize;
        let halves = gpu.buffer("half", &vec![0xa5; half_bytes], storage);
        let tile_data = gpu.buffer(
            "tiles",
            &vec![0xa5; tiles::data_bytes(self.previous) as usize],
            storage,
        );
        let pitch = self.previous[0].next_multiple_of(256) as usize;
        let mut rows = vec![0u8; pitch * self.previous[1] as usize];
        for (i, &code) in self.sqrt.iter().enumerate() {
            rows[i / self.previous[0] as usize * pitch + i % self.previous[0] as usize] = code;
        }
        let sqrt = gpu.buffer("sqrt luma", &rows, storage);
        let rates_before = gpu.buffer("rates before", self.rates.bytes(), storage);
        let cast = bytemuck::cast_slice::<f32, u8>;
        let before = |format, bytes: &[u8]| self.texture(gpu, self.previous, format, bytes);
        let now = |format, bytes: &[u8]| self.texture(gpu, self.size, format, bytes);
        let colours = match plan.scene.colour {
            ColourForm::Linear => [
                before(F::Rgba32Float, cast(self.linear.as_flattened())),
                before(F::Rgba32Float, cast(self.after_linear.as_flattened())),
            ],
            _ => [
                before(F::Rgba8Unorm, self.codes.as_flattened()),
                before(F::Rgba8Unorm, self.after_codes.as_flattened()),
            ],
        };
        let views = [
            now(F::Rg32Float, cast(self.motion.as_flattened())),
            now(F::R32Float, cast(&self.depth)),
            before(F::R32Float, cast(&self.previous_depth)),
            now(F::Rg8Unorm, self.materials.as_flattened()),
            now(F::R8Unorm, &self.noise),
            now(F::R8Uint, &self.flags),
            now(F::R32Float, cast(&self.blur)),
            now(F::R8Uint, &self.ids),
        ];
        let view = |i: usize| wgpu::BindingResource::TextureView(&views[i]);
        let colour = |i: usize| match plan.scene.colour {
            ColourForm::SqrtLuma => sqrt.as_entire_binding(),
            _ => wgpu::BindingResource::TextureView(&colours[i]),
        };
        let resources = [
            (Binding::Rates, outputs[0].as_entire_binding()),
            (Binding::Attachment, outputs[1].as_entire_binding()),
            (Binding::Reasons, outputs[2].as_entire_binding()),
            (Binding::Colour, colour(0)),
            (Binding::After, colour(1)),
            (Binding::Motion, view(0)),
            (Binding::Depth, view(1)),
            (Binding::PreviousDepth, view(2)),
            (Binding::PreviousRates, rates_before.as_entire_binding()),
            (Binding::Materials, view(3)),
            (Binding::Noise, view(4)),
            (Binding::Flags, view(5)),
            (Binding::Blur, view(6)),
            (Binding::Ids, view(7)),
            (Binding::HalfRates, halves.as_entire_binding()),
            (Binding::TileData, tile_data.as_entire_binding()),
            (Binding::PlainRates, plain.as_entire_binding()),
            (Binding::SqrtLuma, luma.as_entire_binding()),
        ];
        let bound = analysis
            .bind(&gpu.device, &resources)
            .expect("all that the plan binds");
        analysis.set_frame(&gpu.queue, &bound, frame);
        let mut encoder = gpu.encoder();
        analysis.record(
            &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
            &bound,
            frame,
        );
        let read = gpu
            .submit_and_read(
                encoder,
                &[
                    &outputs[0],
                    &outputs[1],
                    &outputs[2],
                    &luma,
                    &halves,
                    &plain,
                ],
            )
            .expect("rates");
        read.try_into().expect("six buffers")
    }
}

fn settings(rng: &mut Rng, scene: &mut Scene) -> Settings {
    let pick = |rng: &mut Rng| rng.u32(..3) == 0;
    let content = Content {
        norm: [Norm::L2, Norm::L1, Norm::LInf, Norm::Root][rng.usize(..4)],
        pairs: [
            Pairs::All,
            Pairs::Interleaved,
            Pairs::SubSampled,
            Pairs::Quad,
            Pairs::Sobel,
        ][rng.usize(..5)],
        weights: [Weights::Paper, Weights::Rec709][rng.usize(..2)],
        difference: [
            Difference::Luma,
            Difference::LargestChannel,
            Difference::Rgb,
        ][rng.usize(..3)],
        transfer: [Transfer::Srgb, Transfer::Square][rng.usize(..2)],
        form: if pick(rng) {
            Form::Pairwise { sensitivity: 0.07 }
        } else {
            [Form::Window, Form::Window, Form::Absolute][rng.usize(..3)]
        },
        threshold: [0.15, 0.03, 0.6][rng.usize(..3)],
        ambient: [0.05, 0.0][rng.usize(..2)],
        ..Content::default()
    };
    scene.colour = [ColourForm::Codes, ColourForm::Linear, ColourForm::SqrtLuma][rng.usize(..3)];
    scene.motion = rng.bool();
    scene.depth = rng.bool();
    scene.flags = rng.bool();
    scene.noise = rng.bool();
    scene.ids = rng.bool();
    scene.materials = rng.bool();
    // within the eight storage buffers that every device binds
    scene.after_transparents = scene.colour != ColourForm::SqrtLuma && rng.bool();
    scene.previous_rates = rng.bool();
    scene.attachment = true;
    scene.reasons = true;
    scene.sqrt_luma = rng.bool();
    let half_rate = rng.bool().then(|| HalfRate {
        tolerance: 0.3,
        fast: [f64::INFINITY, 2.0][rng.usize(..2)],
    });
    scene.plain_rates = half_rate.is_some() && rng.bool();
    let blur = [
        Blur::Scaled,
        Blur::Linear,
        Blur::Standalone { error: 0.5 },
        Blur::Ladder(Ladder::default()),
    ][rng.usize(..4)];
    let motion = scene.motion.then(|| Motion {
        blur,
        weight: [1.0, 0.5][rng.usize(..2)],
        scale: [1.0, -1.0],
    });
    let is_scaled = scene.motion && matches!(blur, Blur::Scaled | Blur::Linear);
    scene.blur = scene.motion && matches!(blur, Blur::Scaled | Blur::Linear) && rng.bool();
    Settings {
        content,
        later_blur: scene.blur,
        // depths of the frame are around 0.3
        lens: (is_scaled && scene.depth && rng.bool()).then(|| Lens {
            focus: 0.1 / 0.31,
            infinity: [3.0, 100.0][rng.usize(..2)],
            far: [f64::INFINITY, 30.0][rng.usize(..2)],
            reversed_z: rng.bool(),
            ..Lens::default()
        }),
        motion,
        reprojection: (scene.motion && rng.bool()).then(|| Reprojection {
            reversed_z: rng.bool(),
            near_over_far: [0.0, 0.001][rng.usize(..2)],
            ..Reprojection::default()
        }),
        materials: (scene.materials && rng.bool()).then(Materials::default),
        stability: match scene.previous_rates {
            true => [Stability::Hysteresis, Stability::Compensate][rng.usize(..2)],
            false => Stability::None,
        },
        half_rate,
        transparents: scene.after_transparents,
        foveation: pick(rng).then(Foveation::default),
        overshoot: if pick(rng) {
            vec![[0.85, 1.0], [1.0, 0.7]]
        } else {
            Vec::new()
        },
        safe_area: pick(rng).then(SafeArea::default),
        own: pick(rng).then(|| own(rng, scene)),
        half_resolution: [
            None,
            Some(HalfResolution::Code),
            Some(HalfResolution::Footprint),
        ][rng.usize(..3)],
        smoothing: [Smoothing::None, Smoothing::Limit, Smoothing::Conservative][rng.usize(..3)],
        largest: [Rate::R2X2, Rate::R4X2, Rate::R4X4, Rate::R2X4][rng.usize(..4)],
    }
}

/// Own rates of what the scene has.
fn own(rng: &mut Rng, scene: &Scene) -> OwnRates {
    let combiner = |rng: &mut Rng| Combiner::ALL[rng.usize(..6)];
    let rate = |rng: &mut Rng| Rate::ALL[rng.usize(..7)];
    OwnRates {
        ids: scene.ids.then(|| IdRates {
            rates: (0..20).map(|_| rng.bool().then(|| rate(rng))).collect(),
            combiner: combiner(rng),
        }),
        distance: scene.depth.then(|| DistanceLadder {
            // depths of the frame are around 0.3
            steps: [
                (0.1 / 0.315, rate(rng)),
                (0.1 / 0.305, rate(rng)),
                (f64::INFINITY, rate(rng)),
                (1e3, rate(rng)),
            ],
            combiner: combiner(rng),
            reversed_z: rng.bool(),
            far: [f64::INFINITY, 500.0][rng.usize(..2)],
            ..DistanceLadder::default()
        }),
        particles: scene.flags.then(|| Particles {
            rate: rate(rng),
            combiner: combiner(rng),
        }),
    }
}

fn assert_equal(got: &[Vec<u8>; 6], wanted: &Output, plan: &Plan) {
    let layout = wanted.sri.layout();
    for y in 0..layout.height {
        for x in 0..layout.width {
            let at = (y * layout.pitch + x) as usize;
            assert_eq!(
                got[0][at],
                wanted.sri.code(x, y),
                "rate of {x},{y}; {:?}\n{plan}{:?}",
                layout,
                plan.settings
            );
            assert_eq!(
                got[1][at],
                wanted.attachment.code(x, y),
                "attachment {x},{y}\n{plan}{:?}",
                plan.settings
            );
            assert_eq!(
                got[2][at], wanted.reasons[at],
                "reason of {x},{y}\n{plan}{:?}",
                plan.settings
            );
            if plan.scene.plain_rates {
                assert_eq!(
                    got[5][at],
                    wanted.plain.code(x, y),
                    "without half rate {x},{y}\n{plan}{:?}",
                    plan.settings
                );
            }
        }
        // whole words are written, and no others
        for x in layout.width.next_multiple_of(4)..layout.pitch {
            assert_eq!(got[0][(y * layout.pitch + x) as usize], 0xa5);
        }
    }
}

#[test]
fn the_gpu_makes_the_bytes_of_its_integer_twin() {
    let gpu = common::gpu();
    let seed = common::seed();
    let cases = std::env::var("VRCS_CASES")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(10);
    let sizes = [
        [64u32, 32],
        [1, 1],
        [3, 2],
        [67, 35],
        [130, 9],
        [17, 70],
        [8, 4],
        [31, 33],
    ];
    for case in 0..cases {
        let mut rng = Rng::with_seed(seed + case);
        let mut scene = Scene::default();
        let settings = settings(&mut rng, &mut scene);
        let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
        let size = sizes[rng.usize(..sizes.len())];
        let previous = if rng.u32(..3) == 0 {
            [size[0].div_ceil(2) + 1, size[1] + 3]
        } else {
            size
        };
        let frame = Frame {
            size,
            previous_size: previous,
            has_history: rng.u32(..16) > 0,
            resolution_scale: 0.5 + rng.f64() / 2.0,
            cameras: None,
        };
        let made = Made::new(size, previous, &mut rng);
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        let got = made.run(&gpu, &plan, &frame);
        println!("case {case}: {size:?}");
        assert_equal(&got, &wanted, &plan);
        if let Some(half) = &wanted.half {
            let layout = half.layout();
            for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
                let at = (y * layout.pitch + x) as usize;
                assert_eq!(got[4][at], half.code(x, y), "half of {x},{y}\n{plan}");
            }
        }
        if plan.bindings.contains(&Binding::SqrtLuma) {
            let pitch = previous[0].next_multiple_of(256);
            for (x, y) in (0..previous[1]).flat_map(|y| (0..previous[0]).map(move |x| (x, y))) {
                let at = (y * pitch + x) as usize;
                assert_eq!(got[3][at], wanted.sqrt_luma[at], "√luma of {x},{y}");
            }
        }
    }
}

/// An effect, what the scene must declare for it, and inputs under which it has nothing to say.
type Neutral = (
    &'static str,
    fn(&mut Scene),
    fn(&mut Settings),
    fn(&mut Made),
);

/// One row for each effect that a scene declares: with a neutral input its bytes are those of a plan that leaves it out.
const NEUTRAL: &[Neutral] = &[
    (
        "zero motion",
        |scene| scene.motion = true,
        |settings| settings.motion = Some(Motion::default()),
        |made| made.motion.fill([0.0; 2]),
    ),
    (
        "zero motion, reprojected, over one depth",
        |scene| (scene.motion, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.reprojection = Some(Reprojection::default());
        },
        |made| {
            made.motion.fill([0.0; 2]);
            made.depth.fill(0.5);
            made.previous_depth.fill(0.5);
        },
    ),
    (
        "a later blur of no width",
        |scene| (scene.motion, scene.blur) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.later_blur = true;
        },
        |made| {
            made.motion.fill([0.0; 2]);
            made.blur.fill(0.0);
        },
    ),
    (
        "a lens that blurs nothing",
        |scene| (scene.motion, scene.depth) = (true, true),
        |settings| {
            settings.motion = Some(Motion::default());
            settings.lens = Some(Lens {
                infinity: 0.0,
                ..Lens::default()
            });
        },
        |made| made.motion.fill([0.0; 2]),
    ),
    (
        "materials that reflect nothing",
        |scene| scene.materials = true,
        |settings| settings.materials = Some(Materials::default()),
        |made| made.materials.fill([255, 0]),
    ),
    (
        "no noise anywhere",
        |scene| scene.noise = true,
        |settings| settings.half_rate = Some(HalfRate::default()),
        |made| made.noise.fill(0),
    ),
    (
        "no transparents",
        |scene| scene.after_transparents = true,
        |settings| settings.transparents = true,
        |made| made.after_codes.clone_from(&made.codes),
    ),
    (
        "flags that say nothing",
        |scene| scene.flags = true,
        |_| {},
        |made| made.flags.fill(0),
    ),
    (
        "a previous frame at full rate, compensated",
        |scene| scene.previous_rates = true,
        |settings| settings.stability = Stability::Compensate,
        |made| made.rates = Sri::uniform(made.previous[0], made.previous[1], Rate::R1X1),
    ),
    (
        "foveation at full resolution",
        |_| {},
        |settings| settings.foveation = Some(Foveation::default()),
        |_| {},
    ),
    (
        "quality overshoot below 85 %",
        |_| {},
        |settings| settings.overshoot = vec![[0.85, 1.0], [1.0, 1.0]],
        |_| {},
    ),
    (
        "a safe area of no width",
        |_| {},
        |settings| {
            settings.safe_area = Some(SafeArea {
                width: 0,
                ..SafeArea::default()
            });
        },
        |_| {},
    ),
    (
        "own rates of other ids, beyond all distances, without particles",
        |scene| (scene.ids, scene.depth, scene.flags) = (true, true, true),
        |settings| {
            settings.own = Some(OwnRates {
                ids: Some(IdRates {
                    rates: vec![Some(Rate::R4X4); 9],
                    combiner: Combiner::Override,
                }),
                distance: Some(DistanceLadder {
                    steps: [(1e6, Rate::R4X4); 4],
                    ..DistanceLadder::default()
                }),
                particles: Some(Particles::default()),
            });
        },
        |made| {
            made.ids.fill(9);
            made.depth.fill(0.5);
            made.flags.fill(0);
        },
    ),
    (
        "half the resolution",
        |_| {},
        |settings| settings.half_resolution = Some(HalfResolution::Code),
        |_| {},
    ),
];

// fails when an effect is not neutral: with `FACTOR_ONE - min(slow, FACTOR_ONE)` of the materials written as `FACTOR_ONE - 1`, the
// fourth row differs
#[test]
fn a_neutral_input_gives_the_bytes_of_a_plan_that_leaves_the_effect_out() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [46, 38];
    let base = Scene {
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let settings = Settings {
        smoothing: Smoothing::Conservative,
        largest: Rate::R4X2,
        ..Settings::default()
    };
    let without = Plan::new(&base, &settings).expect("a plan");
    let bare = Analysis::new(&gpu.device, &without);
    for (name, declare, ask, quiet) in NEUTRAL {
        let mut made = Made::new(size, size, &mut rng);
        quiet(&mut made);
        let (mut scene, mut with) = (base, settings.clone());
        declare(&mut scene);
        ask(&mut with);
        let frame = Frame::of_size(size);
        let plan = Plan::new(&scene, &with).expect("what it asks for is declared");
        let plain = made.run_with(&gpu, &bare, &frame);
        let neutral = made.run(&gpu, &plan, &frame);
        for (i, output) in ["rates", "attachment", "reasons"].into_iter().enumerate() {
            assert_eq!(plain[i], neutral[i], "{name}: {output}");
        }
        // and nothing of it is there where it is not asked for, whatever is declared
        let declared = Plan::new(&scene, &settings).expect("a plan");
        let flags = usize::from(scene.flags);
        assert_eq!(declared.passes.len(), without.passes.len(), "{name}");
        assert_eq!(
            declared.bindings.len() + declared.later.len(),
            without.bindings.len() + flags,
            "{name}: {declared}"
        );
    }
}

/// Depths of a slanted wall before a far one, by a camera.
fn wall(size: [u32; 2], camera: &glam::DMat4) -> Vec<f32> {
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (f64::from(i % size[0]), f64::from(i / size[0]));
            let z = match x < f64::from(size[0]) * 0.6 {
                true => 3.0 + x * 0.05 + y * 0.02,
                false => 40.0,
            };
            let clip = *camera * glam::DVec4::new(0.0, 0.0, -z, 1.0);
            (clip.z / clip.w) as f32
        })
        .collect()
}

/// Projections with standard and reversed depth.
fn projections() -> [(bool, glam::DMat4); 2] {
    [(false, 0.1, 100.0), (true, 100.0, 0.1)]
        .map(|(reversed, near, far)| (reversed, glam::DMat4::perspective_rh(1.0, 1.6, near, far)))
}

// fails when the sign of y is lost, when w before is not looked at, or when what is flagged moves with the world
#[test]
fn the_camera_moves_pixels_on_the_gpu_as_in_f64_but_for_a_step_of_speed() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [96, 60];
    let steps = [
        glam::DVec3::new(0.05, 0.0, 0.0),
        glam::DVec3::new(0.0, -0.08, 0.3),
        glam::DVec3::new(0.3, 0.1, -0.5),
    ];
    let scene = Scene {
        cameras: true,
        depth: true,
        flags: true,
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let plan = Plan::new(&scene, &settings).expect("a plan");
    assert!(!plan.bindings.contains(&Binding::Motion), "{plan}");
    let analysis = Analysis::new(&gpu.device, &plan);
    let (mut apart, mut coarse) = (0, 0);
    for (reversed_z, projection) in projections() {
        for step in steps {
            let before = projection * glam::DMat4::from_translation(step);
            let mut made = Made::new(size, size, &mut rng);
            for code in &mut made.codes {
                *code = [rng.u8(60..200); 4];
            }
            made.depth = wall(size, &projection);
            made.flags = (0..size[0] * size[1])
                .map(|i| u8::from(i % size[0] < 12))
                .collect();
            let frame = Frame {
                cameras: Some(Cameras {
                    now: projection,
                    before,
                }),
                ..Frame::of_size(size)
            };
            let got = made.run_with(&gpu, &analysis, &frame);
            let inputs = made.inputs(&plan, &frame);
            let vectors =
                vrcs::analyse::reproject::camera_motions(size, &made.depth, &projection, &before);
            // the twin's own, a step slower and a step faster
            let twins = [0.0f32, -1.0 / 16.0, 1.0 / 16.0].map(|more| {
                let near: Vec<[f32; 2]> = vectors
                    .iter()
                    .map(|v| v.map(|v| (v.abs() + more).max(0.0)))
                    .collect();
                let inputs = Inputs {
                    motion: (more != 0.0).then_some(&near[..]),
                    ..inputs
                };
                integer::analyse(&inputs, &settings).expect("inputs").sri
            });
            let layout = twins[0].layout();
            for (x, y) in (0..layout.height).flat_map(|y| (0..layout.width).map(move |x| (x, y))) {
                let code = got[0][(y * layout.pitch + x) as usize];
                apart += usize::from(code != twins[0].code(x, y));
                coarse += usize::from(code != 0);
                for axis in [2, 0] {
                    let of = |twin: &Sri| twin.code(x, y) >> axis & 3;
                    assert!(
                        twins.iter().any(|twin| of(twin) == code >> axis & 3),
                        "{x},{y}: {code}, {step}, reversed {reversed_z}"
                    );
                }
                if x < 5 {
                    let still = twins[0].code(x, y);
                    assert_eq!(code, still, "{x},{y} does not move with the world");
                }
            }
        }
    }
    let all = 6 * 48 * 30;
    println!("{apart} of {all} quads differ, by a step of speed; {coarse} are coarse");
    assert!(apart * 50 < all && coarse * 20 > all, "{apart} {coarse}");
}

#[test]
fn a_camera_that_shows_nothing_or_is_not_given_leaves_full_rate() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [40, 24];
    for (reversed_z, projection) in projections() {
        let mut made = Made::new(size, size, &mut rng);
        made.codes.fill([90; 4]);
        made.depth = wall(size, &projection);
        if let Some(last) = made.depth.last_mut() {
            *last = f32::NAN;
        }
        made.previous_depth.clone_from(&made.depth);
        let scene = Scene {
            cameras: true,
            depth: true,
            attachment: true,
            reasons: true,
            ..Scene::default()
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            reprojection: Some(Reprojection {
                reversed_z,
                near_over_far: 0.001,
                ..Reprojection::default()
            }),
            ..Settings::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let analysis = Analysis::new(&gpu.device, &plan);
        let turned = projection * glam::DMat4::from_rotation_y(std::f64::consts::PI);
        let cases = [
            (None, 0u8),
            (Some(turned), 0),
            (Some(glam::DMat4::ZERO), 0),
            (Some(projection), Rate::R2X2.code()),
        ];
        for (before, wanted) in cases {
            let frame = Frame {
                cameras: before.map(|before| Cameras {
                    now: projection,
                    before,
                }),
                ..Frame::of_size(size)
            };
            let got = made.run_with(&gpu, &analysis, &frame);
            // away from the border, which a rounding may put off the screen
            let layout = SriLayout::new(size[0], size[1]);
            assert_eq!(
                got[0][(5 * layout.pitch + 6) as usize],
                wanted,
                "{before:?}"
            );
            // the last pixel has no depth
            let last = ((layout.height - 1) * layout.pitch + layout.width - 1) as usize;
            assert_eq!(got[0][last], 0, "{before:?}");
        }
    }
}

// cameras without perspective and sides of powers of two: nothing is rounded, so that every byte has to be the twin's
#[test]
fn tiles_are_fetched_by_their_furthest_depth_as_in_the_twin() {
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let sizes = [
        [64u32, 32],
        [16, 16],
        [128, 64],
        [32, 8],
        [8, 64],
        [256, 16],
    ];
    let mut rates = std::collections::BTreeSet::new();
    for case in 0..12 {
        let size = sizes[case % sizes.len()];
        let previous = match rng.u32(..3) {
            0 => size.map(|side| (side / 2).max(8)),
            _ => size,
        };
        let reversed_z = rng.bool();
        let mut made = Made::new(size, previous, &mut rng);
        for (i, depth) in made.depth.iter_mut().enumerate() {
            *depth = [0.25, 0.5, 0.75][(i / 5 + i / 97) % 3];
        }
        if rng.u32(..4) == 0 {
            let at = rng.usize(..made.depth.len());
            made.depth[at] = f32::NAN;
        }
        let now = match reversed_z {
            true => glam::DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 8.0, 0.0),
            false => glam::DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 0.0, 8.0),
        };
        // what is further moves further: a shear
        let mut shear = glam::DMat4::IDENTITY;
        let mut sixteenths = |side: u32| f64::from(rng.i32(-32..=32)) / 32.0 / f64::from(side);
        shear.z_axis.x = sixteenths(size[0]);
        shear.z_axis.y = sixteenths(size[1]);
        let scene = Scene {
            cameras: true,
            depth: true,
            flags: rng.bool(),
            colour: [ColourForm::Codes, ColourForm::Linear, ColourForm::SqrtLuma][rng.usize(..3)],
            attachment: true,
            reasons: true,
            ..Scene::default()
        };
        let settings = Settings {
            content: Content {
                norm: [Norm::L2, Norm::L1, Norm::LInf][rng.usize(..3)],
                form: [Form::Window, Form::Absolute][rng.usize(..2)],
                threshold: [0.15, 0.03, 0.6][rng.usize(..3)],
                ..Content::default()
            },
            motion: Some(Motion::default()),
            reprojection: Some(Reprojection {
                fetch: Fetch::Tile,
                reversed_z,
                ..Reprojection::default()
            }),
            smoothing: [Smoothing::None, Smoothing::Limit, Smoothing::Conservative][rng.usize(..3)],
            largest: [Rate::R2X2, Rate::R4X2, Rate::R4X4, Rate::R2X4][rng.usize(..4)],
            ..Settings::default()
        };
        let plan = Plan::new(&scene, &settings).expect("a plan");
        let frame = Frame {
            previous_size: previous,
            has_history: rng.u32(..12) > 0,
            cameras: Some(Cameras {
                now,
                before: now * shear,
            }),
            ..Frame::of_size(size)
        };
        let wanted =
            integer::analyse(&made.inputs(&plan, &frame), &settings).expect("inputs that fit");
        let got = made.run(&gpu, &plan, &frame);
        println!("case {case}: {size:?}");
        assert_equal(&got, &wanted, &plan);
        rates.extend(wanted.sri.bytes().iter().copied());
    }
    assert!(rates.len() > 2, "{rates:?} tell nothing");
}

#[test]
fn tiles_refuse_what_looks_at_pixels() {
    let scene = Scene {
        cameras: true,
        depth: true,
        materials: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection {
            fetch: Fetch::Tile,
            ..Reprojection::default()
        }),
        materials: Some(Materials::default()),
        ..Settings::default()
    };
    let error = Plan::new(&scene, &settings).expect_err("materials are of pixels");
    assert_eq!(
        error.to_string(),
        "material sensitivity looks at pixels one by one, and the stage goes by tiles (Fetch::Tile)"
    );
}

/// Pictures as nature makes them (amplitudes of 1/f, by octaves), at random, and against the estimator: stripes, chequers, single pixels.
fn picture(kind: u32, size: [u32; 2], rng: &mut Rng) -> Vec<[u8; 4]> {
    let octaves: Vec<(u32, Vec<f32>)> = (0..5)
        .map(|octave| (1 << octave, (0..4096).map(|_| rng.f32() - 0.5).collect()))
        .collect();
    (0..size[0] * size[1])
        .map(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let natural: f32 = octaves
                .iter()
                .map(|(side, values)| {
                    let at = (x / side + y / side * 61) as usize % values.len();
                    values[at] * *side as f32 / 16.0
                })
                .sum();
            let value = match (kind, (x / 13 + y / 11) % 4) {
                (0, _) => 110.0 + natural * 60.0,
                (1, _) => 100.0 + rng.f32() * 40.0,
                (_, 0) => ((x + y) % 2 * 140) as f32,
                (_, 1) => (x / 2 % 2 * 90) as f32 + 20.0,
                (_, 2) => {
                    if rng.u32(..30) == 0 {
                        255.0
                    } else {
                        80.0
                    }
                }
                _ => (x * 3 + y) as f32,
            };
            [value.clamp(0.0, 255.0) as u8; 4]
        })
        .collect()
}

// the kernel against the formulas as they stand in the papers, without the integer twin between them
#[test]
fn the_gpu_equals_the_f64_twin_but_in_the_band_that_it_derives() {
    use vrcs::analyse::exact;
    let gpu = common::gpu();
    let mut rng = Rng::with_seed(common::seed());
    let size = [94, 62];
    let [mut apart, mut may, mut all] = [0; 3];
    for norm in [Norm::L2, Norm::L1, Norm::LInf] {
        for form in [Form::Window, Form::Pairwise { sensitivity: 0.07 }] {
            let settings = Settings {
                content: Content {
                    norm,
                    form,
                    ..Content::default()
                },
                ..Settings::default()
            };
            let scene = Scene::default();
            let plan = Plan::new(&scene, &settings).expect("a plan");
            let analysis = Analysis::new(&gpu.device, &plan);
            for kind in 0..3 {
                let mut made = Made::new(size, size, &mut rng);
                made.codes = picture(kind, size, &mut rng);
                let got = made.run_with(&gpu, &analysis, &Frame::of_size(size));
                let inputs = Inputs::of_colour(size, Colour::Codes(&made.codes));
                let wanted = exact::analyse(&inputs, &settings).expect("inputs");
                let layout = wanted.output.sri.layout();
                for y in 0..layout.height {
                    for x in 0..layout.width {
                        let is_doubtful = wanted.doubtful[(y * layout.width + x) as usize];
                        let same =
                            got[0][(y * layout.pitch + x) as usize] == wanted.output.sri.code(x, y);
                        assert!(same || is_doubtful, "{x},{y}: {norm:?}, {form:?}, {kind}");
                        apart += usize::from(!same);
                        may += usize::from(is_doubtful);
                        all += 1;
                    }
                }
            }
        }
    }
    println!("{apart} of {all} quads differ, of {may} whose errors lie in the derived band");
    assert!(apart * 100 < all && may * 8 < all, "{apart} {may} {all}");
}

#[test]
fn every_plan_is_made_under_wgpus_default_limits() {
    let adapters = vrcs::check::gpu::adapters();
    let adapter = adapters.first().expect("a driver");
    let (device, _queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits::default(),
        ..wgpu::DeviceDescriptor::default()
    }))
    .expect("a device that asks for nothing");
    let seed = common::seed();
    for case in 0..12 {
        let mut rng = Rng::with_seed(seed + case);
        let mut scene = Scene::default();
        let settings = settings(&mut rng, &mut scene);
        let plan = Plan::new(&scene, &settings).expect("settings that the scene serves");
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let analysis = Analysis::new(&device, &plan);
        let error = pollster::block_on(scope.pop());
        assert!(error.is_none(), "{error:?}\n{}", analysis.plan());
    }
}
