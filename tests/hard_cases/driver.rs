//! The analysis on the tests' driver.

use vrcs::{
    Plan, Scene,
    analyse::{Analysis, Frame, Settings},
    check::gpu::Gpu,
    plan::{Binding, ColourForm},
    sri::{Sri, SriLayout},
};

/// The analysis as compiled for this driver: for pictures of any size.
pub struct Kernel<'g> {
    gpu: &'g Gpu,
    analysis: Analysis,
}

impl<'g> Kernel<'g> {
    /// Compiles it for pictures of a form, with materials if the settings ask for them.
    pub fn new(gpu: &'g Gpu, colour: ColourForm, settings: &Settings) -> Result<Self, String> {
        let scene = Scene {
            colour,
            materials: settings.materials.is_some(),
            ..Scene::default()
        };
        let plan = Plan::new(&scene, settings).map_err(|error| error.to_string())?;
        let analysis = Analysis::new(&gpu.device, &plan).map_err(|error| error.to_string())?;
        Ok(Kernel { gpu, analysis })
    }

    /// The rates of a picture of codes.
    pub fn of_codes(&self, size: [u32; 2], codes: &[[u8; 4]]) -> Result<Sri, String> {
        let format = wgpu::TextureFormat::Rgba8Unorm;
        self.run(size, (format, codes.as_flattened()), None)
    }

    /// The rates of a plain picture with smoothness and Rf0 as floats.
    pub fn of_materials(&self, size: [u32; 2], values: &[[f32; 2]]) -> Result<Sri, String> {
        let plain = vec![[128u8; 4]; values.len()];
        let bytes: Vec<u8> = values
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let picture = (wgpu::TextureFormat::Rgba8Unorm, plain.as_flattened());
        self.run(size, picture, Some(&bytes))
    }

    /// The rates of a picture of linear light, in a texture of halves or floats.
    pub fn of_linear(
        &self,
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
        self.run(size, (format, &bytes), None)
    }

    fn run(
        &self,
        size: [u32; 2],
        (format, bytes): (wgpu::TextureFormat, &[u8]),
        materials: Option<&[u8]>,
    ) -> Result<Sri, String> {
        let Kernel { gpu, analysis } = self;
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
}
