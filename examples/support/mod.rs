//! What the examples have in common, and what a renderer has already: a device, textures, a way to look at them.

#![allow(dead_code, reason = "each example uses what it needs")]

use std::path::{Path, PathBuf};

/// What an example ends with.
pub type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// A device with wgpu's default limits: nothing here needs more.
pub struct Gpu {
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

impl Gpu {
    /// Opens the first adapter.
    pub fn open() -> Outcome<Gpu> {
        let instance = wgpu::Instance::default();
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()));
        let adapter = adapter.map_err(|error| {
            format!(
                "there is no driver that wgpu can use: on Debian and Ubuntu, `apt-get install mesa-vulkan-drivers` brings one for the CPU; \
                 elsewhere install Mesa's lavapipe or your GPU's Vulkan driver ({error})"
            )
        })?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;
        println!("adapter    {}", adapter.get_info().name);
        Ok(Gpu {
            adapter,
            device,
            queue,
        })
    }

    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    pub fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.queue.submit([encoder.finish()]);
    }

    /// A texture that shaders store to and read from, full of zeroes.
    pub fn texture(&self, size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// A uniform buffer of `bytes` bytes.
    pub fn uniform(&self, bytes: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: bytes,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A storage buffer of `bytes` bytes, full of zeroes.
    pub fn storage(&self, bytes: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("storage"),
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        })
    }

    /// A bind group of numbered resources.
    pub fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[(u32, wgpu::BindingResource)],
    ) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    /// Reads a buffer back, and waits for it: for a look at the end, not for a frame.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Outcome<Vec<u8>> {
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.submit(encoder);
        copy.map_async(wgpu::MapMode::Read, .., |_| ());
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(copy.get_mapped_range(..)?.to_vec())
    }

    /// Reads a texture of one aspect back: row by row, without padding.
    pub fn read_texture(&self, texture: &wgpu::Texture) -> Outcome<Vec<u8>> {
        let texel = texture
            .format()
            .block_copy_size(None)
            .ok_or("a texture that cannot be copied")?;
        let row = texture.width() * texel;
        let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: u64::from(pitch * texture.height()),
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.encoder();
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(pitch),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.submit(encoder);
        let padded = self.read(&buffer)?;
        let rows = padded.chunks(pitch as usize);
        Ok(rows
            .flat_map(|bytes| &bytes[..row as usize])
            .copied()
            .collect())
    }
}

/// A whole texture, to be bound.
pub fn whole(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

/// Half floats as bytes, 0 to 1 as 0 to 255.
pub fn to_bytes(halves: &[u8]) -> Vec<u8> {
    let values = halves
        .chunks_exact(2)
        .map(|pair| half::f16::from_le_bytes([pair[0], pair[1]]).to_f32());
    values
        .map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8)
        .collect()
}

/// Writes a picture of red, green, blue and alpha to `out/NAME.png` and says so.
pub fn save(name: &str, size: [u32; 2], rgba: &[u8]) -> Outcome<PathBuf> {
    std::fs::create_dir_all("out")?;
    let path = Path::new("out").join(format!("{name}.png"));
    image::save_buffer(&path, rgba, size[0], size[1], image::ColorType::Rgba8)?;
    println!("written    {}", path.display());
    Ok(path)
}

/// The peak signal-to-noise ratio of two pictures of bytes, in dB; infinite where they are the same.
pub fn psnr(a: &[u8], b: &[u8]) -> f64 {
    let squares = a
        .iter()
        .zip(b)
        .map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    let mean = squares.sum::<f64>() / a.len() as f64;
    10.0 * (255.0 * 255.0 / mean).log10()
}

/// The share of pixels that a view's shading rates leave to be shaded, 0 to 1: read back, so for a look at the end.
pub fn share_of_primaries(gpu: &Gpu, view: &vrcs::View) -> Outcome<f64> {
    let [width, height, _] = view.extent();
    let layout = vrcs::sri::SriLayout::new(width, height);
    let bytes = gpu.read(view.sri())?;
    let sri = vrcs::sri::Sri::from_fn(width, height, |x, y| bytes[(y * layout.pitch + x) as usize]);
    let mut sum = 0.0;
    for y in 0..layout.height {
        for x in 0..layout.width {
            let rate = sri.rate(x, y, view.options().largest);
            sum += 1.0 / f64::from(rate.width() * rate.height());
        }
    }
    Ok(sum / f64::from(layout.width * layout.height))
}
