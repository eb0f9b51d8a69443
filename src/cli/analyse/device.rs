//! The stage on a device: the inputs as textures and buffers, the kernels of a plan, the results read back.

use crate::{
    analyse::{Analysis, Colour, Inputs},
    check::gpu::{Gpu, GpuError},
    cli::Failure,
    plan::{Binding, ColourForm, Plan},
    sri::{ROW_ALIGNMENT, Sri, SriLayout},
};

/// What the stage found.
pub(super) struct Found {
    /// The rates of compute passes.
    pub(super) sri: Sri,
    /// Those of the hardware's attachment.
    pub(super) attachment: Sri,
    /// Why, for each quad, in the form of `sri`.
    pub(super) reasons: Vec<u8>,
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
    let analysis = Analysis::new(&gpu.device, plan);
    let storage = wgpu::BufferUsages::STORAGE;
    let layout = SriLayout::new(inputs.size[0], inputs.size[1]);
    let outputs = ["rates", "attachment", "reasons"]
        .map(|name| gpu.buffer(name, &vec![0; layout.bytes() as usize], storage));
    let luma = match inputs.colour {
        Colour::SqrtLuma(codes) => {
            gpu.buffer("sqrt luma", &padded(codes, inputs.previous_size), storage)
        }
        _ => gpu.buffer("sqrt luma", &[0; 4], storage),
    };
    let views = Views::new(gpu, inputs);
    let mut resources = vec![
        (Binding::Rates, outputs[0].as_entire_binding()),
        (Binding::Attachment, outputs[1].as_entire_binding()),
        (Binding::Reasons, outputs[2].as_entire_binding()),
    ];
    if plan.scene.colour == ColourForm::SqrtLuma {
        resources.push((Binding::Colour, luma.as_entire_binding()));
    }
    for (binding, view) in &views.0 {
        resources.push((*binding, wgpu::BindingResource::TextureView(view)));
    }
    let bound = analysis
        .bind(&gpu.device, &resources)
        .map_err(|error| Failure::Misused(error.to_string()))?;
    let frame = inputs.frame();
    analysis.set_frame(&gpu.queue, &bound, &frame);
    let mut encoder = gpu.encoder();
    analysis.record(
        &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        &bound,
        &frame,
    );
    let read = gpu.submit_and_read(encoder, &outputs.each_ref().map(|buffer| buffer))?;
    let [rates, attachment, reasons]: [Vec<u8>; 3] = read
        .try_into()
        .map_err(|_| Failure::from(GpuError::Lost("a buffer was not read".to_owned())))?;
    let image = |bytes: &[u8]| {
        Sri::from_fn(inputs.size[0], inputs.size[1], |x, y| {
            bytes[(y * layout.pitch + x) as usize]
        })
    };
    Ok(Found {
        sri: image(&rates),
        attachment: image(&attachment),
        reasons,
    })
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

struct Views(Vec<(Binding, wgpu::TextureView)>);

impl Views {
    fn new(gpu: &Gpu, inputs: &Inputs) -> Views {
        use wgpu::TextureFormat as F;
        let floats = bytemuck::cast_slice::<f32, u8>;
        let (now, before) = (inputs.size, inputs.previous_size);
        let mut all = Vec::new();
        let mut add = |binding, size, format, bytes: &[u8]| {
            all.push((binding, texture(gpu, size, format, bytes)));
        };
        match inputs.colour {
            Colour::Codes(codes) => {
                add(Binding::Colour, before, F::Rgba8Unorm, codes.as_flattened())
            }
            Colour::Linear(values) => {
                add(
                    Binding::Colour,
                    before,
                    F::Rgba32Float,
                    floats(values.as_flattened()),
                );
            }
            Colour::SqrtLuma(_) => {}
        }
        if let Some(motion) = inputs.motion {
            add(
                Binding::Motion,
                now,
                F::Rg32Float,
                floats(motion.as_flattened()),
            );
        }
        if let (Some(depth), Some(previous)) = (inputs.depth, inputs.previous_depth) {
            add(Binding::Depth, now, F::R32Float, floats(depth));
            add(
                Binding::PreviousDepth,
                before,
                F::R32Float,
                floats(previous),
            );
        }
        Views(all)
    }
}

fn texture(
    gpu: &Gpu,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    bytes: &[u8],
) -> wgpu::TextureView {
    let extent = wgpu::Extent3d {
        width,
        height,
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
    let rows = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(bytes.len() as u32 / height),
        rows_per_image: None,
    };
    gpu.queue
        .write_texture(texture.as_image_copy(), bytes, rows, extent);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
