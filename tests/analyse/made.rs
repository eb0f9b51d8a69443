//! A frame of which everything is made up, run by the kernels of a plan; and what they wrote held against the twin's.

use fastrand::Rng;
use vrcs::{
    Plan, Rate,
    analyse::{Analysis, Colour, Frame, Inputs, Output, half, settings::MaterialsOf, tiles},
    check::gpu::Gpu,
    plan::{Binding, ColourForm},
    sri::{Sri, SriLayout},
};

/// Everything that a frame may have, made up.
pub struct Made {
    pub size: [u32; 2],
    pub previous: [u32; 2],
    pub codes: Vec<[u8; 4]>,
    pub after_codes: Vec<[u8; 4]>,
    pub linear: Vec<[f32; 4]>,
    pub after_linear: Vec<[f32; 4]>,
    pub sqrt: Vec<u8>,
    pub motion: Vec<[f32; 2]>,
    pub depth: Vec<f32>,
    pub blur: Vec<f32>,
    pub previous_depth: Vec<f32>,
    pub rates: Sri,
    pub materials: Vec<[u8; 2]>,
    pub previous_materials: Vec<[u8; 2]>,
    pub noise: Vec<u8>,
    pub ids: Vec<u8>,
    pub flags: Vec<u8>,
}

pub const HARD: [f32; 12] = [
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
    pub fn new(size: [u32; 2], previous: [u32; 2], rng: &mut Rng) -> Made {
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
        let floats = |rng: &mut Rng, of: fn(f32) -> f32| -> Vec<f32> {
            (0..now)
                .map(|_| match rng.u32(..300) {
                    0 => HARD[rng.usize(..HARD.len())],
                    _ => of(rng.f32()),
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
            depth: floats(rng, |value| 0.3 + value * 0.02),
            blur: floats(rng, |value| value * 5.0),
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
            previous_materials: (0..before).map(|_| [rng.u8(..), rng.u8(..)]).collect(),
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

    pub fn inputs<'a>(&'a self, plan: &Plan, frame: &Frame) -> Inputs<'a> {
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
            materials: scene.materials.then_some(match of_before(plan) {
                true => &self.previous_materials,
                false => &self.materials,
            }),
            noise: scene.noise.then_some(&self.noise),
            ids: scene.ids.then_some(&self.ids),
            flags: scene.flags.then_some(&self.flags),
        }
    }

    pub fn run(&self, gpu: &Gpu, plan: &Plan, frame: &Frame) -> [Vec<u8>; 6] {
        self.run_with(
            gpu,
            &Analysis::new(&gpu.device, plan).expect("a device for it"),
            frame,
        )
    }

    /// With pipelines that are there already.
    pub fn run_with(&self, gpu: &Gpu, analysis: &Analysis, frame: &Frame) -> [Vec<u8>; 6] {
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
        let before = |format, bytes: &[u8]| gpu.texture("before", self.previous, format, bytes);
        let now = |format, bytes: &[u8]| gpu.texture("now", self.size, format, bytes);
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
            match of_before(plan) {
                true => before(F::Rg8Unorm, self.previous_materials.as_flattened()),
                false => now(F::Rg8Unorm, self.materials.as_flattened()),
            },
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
        analysis
            .set_frame(&gpu.queue, &bound, frame)
            .expect("a frame that fits");
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

/// Whether materials are those of the frame before.
fn of_before(plan: &Plan) -> bool {
    plan.settings
        .materials
        .is_some_and(|materials| materials.of == MaterialsOf::Previous)
}

/// Every byte of the outputs that a plan has.
pub fn assert_equal(got: &[Vec<u8>; 6], wanted: &Output, plan: &Plan) {
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
            if plan.scene.attachment {
                assert_eq!(
                    got[1][at],
                    wanted.attachment.code(x, y),
                    "attachment {x},{y}\n{plan}{:?}",
                    plan.settings
                );
            }
            if plan.scene.reasons {
                assert_eq!(
                    got[2][at], wanted.reasons[at],
                    "reason of {x},{y}\n{plan}{:?}",
                    plan.settings
                );
            }
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
