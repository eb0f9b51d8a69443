//! Shaders rewritten while the crate is built: no rewriter at run time, and constants that the compiler checks.
//!
//! Draws `shaders/light.wgsl` at full rate and at 2×2, and checks what comes out: at 1×1 every pixel is what the original
//! draws, at 2×2 every block is one of its own four pixels.

use std::process::ExitCode;

use vrcs::{Pass, PassOptions, Rate, View, build::BuildOptions, sri::Sri};

/// What `build.rs` wrote.
mod shaders {
    include!(concat!(env!("OUT_DIR"), "/vrcs.rs"));
}
use shaders::light::{self, bindings, shade};

/// Not a multiple of a tile, so that the last tiles are cut.
const SIZE: [u32; 2] = [200, 120];
/// Rows of a texture copy are this long, at least.
const PITCH: u32 = 1024;

fn main() -> ExitCode {
    match pollster::block_on(run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn run() -> Result<(), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::default();
    let adapter = instance.request_adapter(&Default::default()).await?;
    let (device, queue) = adapter.request_device(&Default::default()).await?;
    println!("adapter       {}", adapter.get_info().name);

    let light = Pass::prewritten(
        &device,
        light::TEXT,
        light::MANIFEST,
        &PassOptions::default(),
    )?;
    let scene = Scene::new(&device, &queue, &light)?;
    let extent = [SIZE[0], SIZE[1], 1];
    let view = View::new(&device, &queue, extent, BuildOptions::default())?;
    let groups = shade::ENTRY.groups(extent);
    println!(
        "entry point   {}, {} x {} groups of {} x {}",
        shade::ENTRY.name,
        groups[0],
        groups[1],
        shade::ENTRY.workgroup_size[0],
        shade::ENTRY.workgroup_size[1]
    );

    let full = scene.draw(&device, &queue, &light, &view, Rate::R1X1)?;
    let coarse = scene.draw(&device, &queue, &light, &view, Rate::R2X2)?;
    let pixel = |picture: &[u32], x: u32, y: u32| picture[(y * SIZE[0] + x) as usize];
    let mut blocks = 0;
    for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
        let (left, top) = (x & !1, y & !1);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (left + i, top + j));
        let shown = pixel(&coarse, x, y);
        if shown != pixel(&coarse, left, top) {
            return Err(format!("({x}, {y}) differs from its block").into());
        }
        if corners.iter().all(|&(x, y)| pixel(&full, x, y) != shown) {
            return Err(format!("({x}, {y}) is none of its block's pixels").into());
        }
        blocks += u32::from((x, y) == (left, top));
    }
    let mut colors = full.clone();
    colors.sort_unstable();
    colors.dedup();
    if colors.len() < 100 || full == coarse {
        return Err("the picture is too plain to tell anything".into());
    }
    println!("at 2x2        {blocks} of {} pixels shaded", full.len());
    println!("checked       every block is one of its own pixels");
    Ok(())
}

/// What the shader draws with.
struct Scene {
    picture: wgpu::Texture,
    bind_group: wgpu::BindGroup,
    readback: wgpu::Buffer,
}

impl Scene {
    fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        light: &Pass,
    ) -> Result<Scene, Box<dyn std::error::Error>> {
        let picture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: SIZE[0],
                height: SIZE[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: u64::from(bindings::FRAME_SIZE),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut bytes = vec![0; bindings::FRAME_SIZE as usize];
        bytes[0..4].copy_from_slice(&SIZE[0].to_le_bytes());
        bytes[4..8].copy_from_slice(&SIZE[1].to_le_bytes());
        bytes[8..12].copy_from_slice(&0.7_f32.to_le_bytes());
        queue.write_buffer(&frame, 0, &bytes);
        let layout = light
            .bind_group_layout(bindings::PICTURE.group)
            .ok_or("the shader has no such group")?;
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("light"),
            layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: bindings::PICTURE.binding,
                    resource: wgpu::BindingResource::TextureView(
                        &picture.create_view(&Default::default()),
                    ),
                },
                wgpu::BindGroupEntry {
                    binding: bindings::FRAME.binding,
                    resource: frame.as_entire_binding(),
                },
            ],
        });
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(PITCH * SIZE[1]),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Scene {
            picture,
            bind_group,
            readback,
        })
    }

    /// Draws at one rate everywhere, and reads the picture back.
    fn draw(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        light: &Pass,
        view: &View,
        rate: Rate,
    ) -> Result<Vec<u32>, Box<dyn std::error::Error>> {
        view.write_sri(queue, &Sri::uniform(SIZE[0], SIZE[1], rate))?;
        let mut encoder = device.create_command_encoder(&Default::default());
        view.build(&mut encoder)?;
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_bind_group(bindings::PICTURE.group, &self.bind_group, &[]);
            light.dispatch(&mut pass, view)?;
        }
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.readback,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(PITCH),
                    rows_per_image: None,
                },
            },
            self.picture.size(),
        );
        queue.submit([encoder.finish()]);
        self.readback.map_async(wgpu::MapMode::Read, .., |_| {});
        device.poll(wgpu::PollType::wait_indefinitely())?;
        let pixels = {
            let bytes = self.readback.get_mapped_range(..)?;
            bytes
                .chunks_exact(PITCH as usize)
                .flat_map(|row| row.chunks_exact(4).take(SIZE[0] as usize))
                .map(|p| u32::from_le_bytes([p[0], p[1], p[2], p[3]]))
                .collect()
        };
        self.readback.unmap();
        Ok(pixels)
    }
}
