//! The analysis on the tests' driver.

use vrcs::{
    Plan, Scene,
    analyse::{Analysis, Frame, Settings, settings::Materials},
    check::gpu::Gpu,
    plan::{Binding, ColourForm},
    sri::{Sri, SriLayout},
};

/// The kernel's rates of a picture of codes.
pub fn of_codes(
    gpu: &Gpu,
    size: [u32; 2],
    codes: &[[u8; 4]],
    settings: &Settings,
) -> Result<Sri, String> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let bytes = codes.as_flattened();
    run(
        gpu,
        size,
        ColourForm::Codes,
        (format, bytes),
        settings,
        None,
    )
}

/// The kernel's rates of a plain picture with smoothness and Rf0 as floats.
pub fn of_materials(gpu: &Gpu, size: [u32; 2], values: &[[f32; 2]]) -> Result<Sri, String> {
    let plain = vec![[128u8; 4]; values.len()];
    let settings = Settings {
        materials: Some(Materials::default()),
        ..Settings::default()
    };
    let bytes: Vec<u8> = values
        .as_flattened()
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let picture = (wgpu::TextureFormat::Rgba8Unorm, plain.as_flattened());
    run(
        gpu,
        size,
        ColourForm::Codes,
        picture,
        &settings,
        Some(&bytes),
    )
}

/// The kernel's rates of a picture of linear light, by the default settings, in a texture of halves or floats.
pub fn of_linear(
    gpu: &Gpu,
    size: [u32; 2],
    picture: &[[f32; 4]],
    format: wgpu::TextureFormat,
) -> Result<Sri, String> {
    let values = picture.as_flattened();
    let bytes: Vec<u8> = match format {
        wgpu::TextureFormat::Rgba16Float => values
            .iter()
            .flat_map(|&value| half::f16::from_f32(value).to_le_bytes())
            .collect(),
        _ => values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect(),
    };
    run(
        gpu,
        size,
        ColourForm::Linear,
        (format, &bytes),
        &Settings::default(),
        None,
    )
}

fn run(
    gpu: &Gpu,
    size: [u32; 2],
    colour: ColourForm,
    (format, bytes): (wgpu::TextureFormat, &[u8]),
    settings: &Settings,
    materials: Option<&[u8]>,
) -> Result<Sri, String> {
    let scene = Scene {
        colour,
        materials: materials.is_some(),
        ..Scene::default()
    };
    let plan = Plan::new(&scene, settings).map_err(|error| error.to_string())?;
    let analysis = Analysis::new(&gpu.device, &plan).expect("a device for it");
    let view = gpu.texture("colour", size, format, bytes);
    let surfaces = materials
        .map(|bytes| gpu.texture("materials", size, wgpu::TextureFormat::Rg32Float, bytes));
    let layout = SriLayout::new(size[0], size[1]);
    let poison = vec![0xa5; layout.bytes() as usize];
    let out = gpu.buffer("rates", &poison, wgpu::BufferUsages::STORAGE);
    let mut resources = vec![
        (Binding::Rates, out.as_entire_binding()),
        (Binding::Colour, wgpu::BindingResource::TextureView(&view)),
    ];
    if let Some(surfaces) = &surfaces {
        let surfaces = wgpu::BindingResource::TextureView(surfaces);
        resources.push((Binding::Materials, surfaces));
    }
    let bound = analysis
        .bind(&gpu.device, &resources)
        .map_err(|error| error.to_string())?;
    let frame = Frame::of_size(size);
    analysis
        .set_frame(&gpu.queue, &bound, &frame)
        .expect("a frame that fits");
    let mut encoder = gpu.encoder();
    analysis.record(
        &mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()),
        &bound,
        &frame,
    );
    let read = gpu
        .submit_and_read(encoder, &[&out])
        .map_err(|error| error.to_string())?;
    Ok(Sri::from_fn(size[0], size[1], |x, y| {
        read[0][(y * layout.pitch + x) as usize]
    }))
}
