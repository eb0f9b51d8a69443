//! The stage on a device: the inputs as textures and buffers, the kernels of a plan, the results read back.

use crate::{
    analyse::{Analysis, Colour, Inputs, Output, half, tiles},
    check::gpu::{Gpu, GpuError},
    cli::Failure,
    plan::{Binding, Plan},
    sri::{ROW_ALIGNMENT, Sri, SriLayout},
};

/// What the stage found; what was not asked for is at full rate, or empty.
pub(super) struct Found {
    /// The rates of compute passes.
    pub(super) sri: Sri,
    /// Those of the hardware's attachment.
    pub(super) attachment: Sri,
    /// Those without the extra half rate.
    pub(super) plain: Sri,
    /// Those of half the resolution.
    pub(super) half: Option<Sri>,
    /// Why, for each quad, in the form of `sri`.
    pub(super) reasons: Vec<u8>,
    /// √luma of what was analysed, in rows of [`luma_pitch`](crate::analyse::params::luma_pitch).
    pub(super) sqrt_luma: Vec<u8>,
}

impl From<Output> for Found {
    fn from(output: Output) -> Found {
        Found {
            sri: output.sri,
            attachment: output.attachment,
            plain: output.plain,
            half: output.half,
            reasons: output.reasons,
            sqrt_luma: output.sqrt_luma,
        }
    }
}

/// Every buffer that a plan may write, and its bytes.
fn written(inputs: &Inputs) -> [(Binding, u64); 7] {
    let [width, height] = inputs.size;
    let [half_width, half_height] = half::size_of(inputs.size);
    let rates = SriLayout::new(width, height).bytes();
    let [across, down] = inputs.previous_size;
    let luma = u64::from(across.next_multiple_of(ROW_ALIGNMENT)) * u64::from(down);
    [
        (Binding::Rates, rates),
        (Binding::Attachment, rates),
        (Binding::PlainRates, rates),
        (Binding::Reasons, rates),
        (
            Binding::HalfRates,
            SriLayout::new(half_width, half_height).bytes(),
        ),
        (Binding::SqrtLuma, luma),
        (Binding::TileData, tiles::data_bytes(inputs.previous_size)),
    ]
}

/// Runs the plan.
pub(super) fn run(gpu: &Gpu, plan: &Plan, inputs: &Inputs) -> Result<Found, Failure> {
    let most = gpu.device.limits().max_texture_dimension_2d;
    let sides = inputs.size.iter().chain(&inputs.previous_size);
    if let Some(side) = sides.copied().find(|&side| side > most) {
        return Err(Failure::Misused(format!(
            "a side of {side} pixels: {} takes {most}; --cpu takes 16384",
            gpu.info.name
        )));
    }
    let misused = |error: &dyn std::fmt::Display| Failure::Misused(error.to_string());
    let analysis = Analysis::new(&gpu.device, plan).map_err(|error| misused(&error))?;
    let storage = wgpu::BufferUsages::STORAGE;
    let is_bound = |binding| plan.bindings.contains(&binding) || plan.later.contains(&binding);
    let outputs: Vec<(Binding, wgpu::Buffer)> = written(inputs)
        .into_iter()
        .filter(|&(binding, _)| is_bound(binding))
        .map(|(binding, bytes)| {
            let buffer = gpu.buffer(binding.name(), &vec![0; bytes as usize], storage);
            (binding, buffer)
        })
        .collect();
    let roots = [
        (Binding::Colour, Some(inputs.colour)),
        (Binding::After, inputs.after),
    ];
    let mut buffers: Vec<(Binding, wgpu::Buffer)> = Vec::new();
    for (binding, colour) in roots {
        if let Some(Colour::SqrtLuma(codes)) = colour {
            let rows = padded(codes, inputs.previous_size);
            buffers.push((binding, gpu.buffer(binding.name(), &rows, storage)));
        }
    }
    if let Some(rates) = inputs.previous_rates {
        let before = gpu.buffer("rates before", rates.bytes(), storage);
        buffers.push((Binding::PreviousRates, before));
    }
    let views = Views::new(gpu, plan, inputs);
    let mut resources: Vec<(Binding, wgpu::BindingResource)> = Vec::new();
    for (binding, buffer) in outputs.iter().chain(&buffers) {
        resources.push((*binding, buffer.as_entire_binding()));
    }
    for (binding, view) in &views.0 {
        resources.push((*binding, wgpu::BindingResource::TextureView(view)));
    }
    let bound = analysis
        .bind(&gpu.device, &resources)
        .map_err(|error| misused(&error))?;
    let frame = inputs.frame();
    analysis
        .set_frame(&gpu.queue, &bound, &frame)
        .map_err(|error| misused(&error))?;
    let mut encoder = gpu.encoder();
    analysis.record(
        &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        &bound,
        &frame,
    );
    let read = gpu.submit_and_read(
        encoder,
        &outputs.iter().map(|(_, buffer)| buffer).collect::<Vec<_>>(),
    )?;
    let found: Vec<(Binding, Vec<u8>)> = outputs
        .iter()
        .map(|(binding, _)| *binding)
        .zip(read)
        .collect();
    let bytes = |binding| {
        let of = found.iter().find(|(other, _)| *other == binding);
        of.map(|(_, bytes)| bytes.as_slice())
    };
    let image = |binding, size| bytes(binding).map(|bytes| image_of(bytes, size));
    let full = || Sri::uniform(inputs.size[0], inputs.size[1], crate::Rate::R1X1);
    Ok(Found {
        sri: image(Binding::Rates, inputs.size)
            .ok_or_else(|| GpuError::Lost("a buffer was not read".to_owned()))?,
        attachment: image(Binding::Attachment, inputs.size).unwrap_or_else(full),
        plain: image(Binding::PlainRates, inputs.size).unwrap_or_else(full),
        half: image(Binding::HalfRates, half::size_of(inputs.size)),
        reasons: bytes(Binding::Reasons).unwrap_or_default().to_vec(),
        sqrt_luma: bytes(Binding::SqrtLuma).unwrap_or_default().to_vec(),
    })
}

/// An image of rates from a buffer's bytes.
fn image_of(bytes: &[u8], [width, height]: [u32; 2]) -> Sri {
    let layout = SriLayout::new(width, height);
    Sri::from_fn(width, height, |x, y| bytes[(y * layout.pitch + x) as usize])
}

/// Rows padded as √luma is.
fn padded(codes: &[u8], size: [u32; 2]) -> Vec<u8> {
    let pitch = size[0].next_multiple_of(ROW_ALIGNMENT) as usize;
    let mut rows = vec![0; pitch * size[1] as usize];
    for (row, from) in rows
        .chunks_exact_mut(pitch)
        .zip(codes.chunks_exact(size[0] as usize))
    {
        row[..from.len()].copy_from_slice(from);
    }
    rows
}

/// The textures of what is given.
struct Views(Vec<(Binding, wgpu::TextureView)>);

impl Views {
    fn new(gpu: &Gpu, plan: &Plan, inputs: &Inputs) -> Views {
        use wgpu::TextureFormat as F;
        let (now, before) = (inputs.size, inputs.previous_size);
        let floats = |values: &[f32]| bytemuck::cast_slice::<f32, u8>(values).to_vec();
        let colour = |colour: Colour| match colour {
            Colour::Codes(codes) => Some((F::Rgba8Unorm, codes.as_flattened().to_vec())),
            Colour::Linear(values) => Some((F::Rgba32Float, floats(values.as_flattened()))),
            Colour::SqrtLuma(_) => None,
        };
        let float = |values: Option<&[f32]>| values.map(|values| (F::R32Float, floats(values)));
        let byte = |format, values: Option<&[u8]>| values.map(|values| (format, values.to_vec()));
        let motion = inputs.motion.map(<[[f32; 2]]>::as_flattened);
        let surfaces = match plan.settings.has_materials_before() {
            true => before,
            false => now,
        };
        let materials = inputs.materials.map(<[[u8; 2]]>::as_flattened);
        let all = [
            (Binding::Colour, before, colour(inputs.colour)),
            (Binding::After, before, inputs.after.and_then(colour)),
            (
                Binding::Motion,
                now,
                motion.map(|v| (F::Rg32Float, floats(v))),
            ),
            (Binding::Depth, now, float(inputs.depth)),
            (Binding::PreviousDepth, before, float(inputs.previous_depth)),
            (Binding::Blur, now, float(inputs.blur)),
            (Binding::Materials, surfaces, byte(F::Rg8Unorm, materials)),
            (Binding::Noise, now, byte(F::R8Unorm, inputs.noise)),
            (Binding::Ids, now, byte(F::R8Uint, inputs.ids)),
            (Binding::Flags, now, byte(F::R8Uint, inputs.flags)),
        ];
        let there = all.into_iter().filter_map(|(binding, size, made)| {
            made.map(|(format, bytes)| (binding, gpu.texture("given", size, format, &bytes)))
        });
        Views(there.collect())
    }
}
