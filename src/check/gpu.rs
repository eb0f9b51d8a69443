//! A device for the program and the tests: chosen by name, with what checks need; and blocking reads.
//!
//! Only the program and the tests make devices; the runtime never does.

use std::sync::{Arc, Mutex, PoisonError};

use crate::{
    build::{BuildOptions, gpu::Builder},
    flat,
    object::ObjectOptions,
};

/// A device and its queue.
#[derive(Debug)]
pub struct Gpu {
    /// What the driver says of itself.
    pub info: wgpu::AdapterInfo,
    /// The device.
    pub device: wgpu::Device,
    /// The queue.
    pub queue: wgpu::Queue,
    errors: Arc<Mutex<Vec<String>>>,
    flags: wgpu::InstanceFlags,
    /// Builders that were made before.
    builders: Mutex<Vec<Arc<Builder>>>,
}

/// Why there is no device.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No driver at all.
    #[error(
        "no Vulkan driver was found: on Debian or Ubuntu, `apt-get install mesa-vulkan-drivers` brings a software one"
    )]
    NoDriver,
    /// None of that name.
    #[error("no adapter is called `{wanted}`; there are: {found}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// The names of those that there are.
        found: String,
    },
    /// The driver did not give a device.
    #[error("the driver of {adapter} gives no device: {why}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        why: String,
    },
    /// Something was done that the device does not allow.
    #[error("the device refused: {0}")]
    Refused(String),
    /// The device stopped working.
    #[error("the device was lost: {0}")]
    Lost(String),
}

/// What cannot go wrong where the program records what it made itself: a view and the passes for it, a frame of the view's size.
pub(crate) fn by_construction<E: std::fmt::Display>(recorded: Result<(), E>) {
    if let Err(error) = recorded {
        unreachable!("made for each other: {error}");
    }
}

/// Features that shaders may need, and that are asked for where the driver has them.
fn wanted_features() -> wgpu::Features {
    use wgpu::Features as F;
    F::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
        | F::TEXTURE_FORMAT_16BIT_NORM
        | F::SHADER_F16
        | F::FLOAT32_FILTERABLE
        | F::BGRA8UNORM_STORAGE
        | F::IMMEDIATES
        | F::TEXTURE_BINDING_ARRAY
        | F::STORAGE_RESOURCE_BINDING_ARRAY
        | F::BUFFER_BINDING_ARRAY
        | F::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING
        | F::STORAGE_TEXTURE_ARRAY_NON_UNIFORM_INDEXING
        | F::TIMESTAMP_QUERY
        | F::TIMESTAMP_QUERY_INSIDE_ENCODERS
        | F::SUBGROUP
        | F::PASSTHROUGH_SHADERS
}

/// The adapters that there are. Arguments of indirect dispatches are not validated, unless the environment asks for it
/// (`WGPU_VALIDATION_INDIRECT_CALL`): ours stay within limits by construction.
pub fn adapters() -> Vec<wgpu::Adapter> {
    adapters_with(flags())
}

// the validation layers would be looked for in debug builds, and complain where there are none
fn flags() -> wgpu::InstanceFlags {
    wgpu::InstanceFlags::empty().with_env()
}

fn adapters_with(flags: wgpu::InstanceFlags) -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    descriptor.flags = flags;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()))
}

impl Gpu {
    /// Opens the adapter whose name contains `wanted`, whatever the case; else the one that `WGPU_ADAPTER_NAME` asks
    /// for; else the first that is no software driver, or simply the first.
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub fn open(wanted: Option<&str>) -> Result<Gpu, GpuError> {
        Gpu::open_with(wanted, flags(), wanted_features())
    }

    /// The same, where shaders are compiled as wgpu's users have them: the driver takes no SPIR-V of ours, so that float arithmetic is
    /// left to what its compiler makes of it.
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub fn open_as_compiled(wanted: Option<&str>) -> Result<Gpu, GpuError> {
        let features = wanted_features() - wgpu::Features::PASSTHROUGH_SHADERS;
        Gpu::open_with(wanted, flags(), features)
    }

    /// The same, where wgpu validates the arguments of indirect dispatches, as it does by default.
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub fn open_validating(wanted: Option<&str>) -> Result<Gpu, GpuError> {
        Gpu::open_with(
            wanted,
            flags() | wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL,
            wanted_features(),
        )
    }

    /// Whether wgpu validates the arguments of indirect dispatches.
    pub fn validates_indirect(&self) -> bool {
        self.flags
            .contains(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL)
    }

    fn open_with(
        wanted: Option<&str>,
        flags: wgpu::InstanceFlags,
        features: wgpu::Features,
    ) -> Result<Gpu, GpuError> {
        let adapters = adapters_with(flags);
        if adapters.is_empty() {
            return Err(GpuError::NoDriver);
        }
        let from_env = std::env::var("WGPU_ADAPTER_NAME").ok();
        let wanted = wanted.map(str::to_owned).or(from_env);
        let name_of = |adapter: &wgpu::Adapter| adapter.get_info().name;
        let adapter = match &wanted {
            Some(wanted) => adapters
                .iter()
                .find(|a| name_of(a).to_lowercase().contains(&wanted.to_lowercase()))
                .ok_or_else(|| GpuError::NoSuchAdapter {
                    wanted: wanted.clone(),
                    found: adapters.iter().map(name_of).collect::<Vec<_>>().join(", "),
                })?,
            None => adapters
                .iter()
                .find(|a| a.get_info().device_type != wgpu::DeviceType::Cpu)
                .unwrap_or(&adapters[0]),
        };
        Gpu::from_adapter(adapter, flags, features)
    }

    fn from_adapter(
        adapter: &wgpu::Adapter,
        flags: wgpu::InstanceFlags,
        features: wgpu::Features,
    ) -> Result<Gpu, GpuError> {
        let info = adapter.get_info();
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("vrcs"),
            required_features: adapter.features() & features,
            required_limits: adapter.limits(),
            ..wgpu::DeviceDescriptor::default()
        });
        let (device, queue) = pollster::block_on(request).map_err(|error| GpuError::NoDevice {
            adapter: info.name.clone(),
            why: error.to_string(),
        })?;
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            sink.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(error.to_string());
        }));
        Ok(Gpu {
            info,
            device,
            queue,
            errors,
            flags,
            builders: Mutex::default(),
        })
    }

    /// Whether the adapter is a software driver.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device takes SPIR-V as it is.
    pub fn takes_spirv(&self) -> bool {
        let features = self.device.features();
        features.contains(wgpu::Features::PASSTHROUGH_SHADERS)
            && self.info.backend == wgpu::Backend::Vulkan
    }

    /// The errors since the last call.
    ///
    /// # Errors
    /// The first of them.
    pub fn check(&self) -> Result<(), GpuError> {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        match errors.drain(..).next() {
            Some(error) => Err(GpuError::Refused(error)),
            None => Ok(()),
        }
    }

    /// Makes a buffer that holds `bytes`, padded to a multiple of four.
    pub fn buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (bytes.len() as u64).next_multiple_of(4).max(4),
            usage: usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        self.write(&buffer, bytes);
        buffer
    }

    /// Writes the start of a buffer.
    pub fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) {
        let whole = bytes.len() & !3;
        self.queue.write_buffer(buffer, 0, &bytes[..whole]);
        if whole < bytes.len() {
            let mut last = [0; 4];
            last[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            self.queue.write_buffer(buffer, whole as u64, &last);
        }
    }

    /// Makes a texture that is only read, and holds `bytes`: `size[0]` times `size[1]` texels, row by row, without padding.
    pub fn texture(
        &self,
        label: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        bytes: &[u8],
    ) -> wgpu::TextureView {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = self
            .device
            .create_texture(&flat::texture(label, size, format, usage));
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32 / size[1]),
            rows_per_image: None,
        };
        self.queue
            .write_texture(texture.as_image_copy(), bytes, rows, texture.size());
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Submits commands and reads a picture of four bytes a pixel: row by row, without padding.
    ///
    /// # Errors
    /// If the device refused anything, or was lost.
    pub fn read_rgba8(
        &self,
        mut encoder: wgpu::CommandEncoder,
        picture: &wgpu::Texture,
    ) -> Result<Vec<u8>, GpuError> {
        let row = picture.width() * 4;
        let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture read-back"),
            size: u64::from(pitch) * u64::from(picture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(pitch),
                    rows_per_image: None,
                },
            },
            picture.size(),
        );
        let bytes = self.submit_and_read(encoder, &[&buffer])?;
        let mut pixels = Vec::with_capacity(row as usize * picture.height() as usize);
        for padded in bytes[0].chunks(pitch as usize) {
            pixels.extend_from_slice(&padded[..row as usize]);
        }
        Ok(pixels)
    }

    /// Submits commands and reads buffers back, whole.
    ///
    /// # Errors
    /// If the device refused anything, or was lost.
    pub fn submit_and_read(
        &self,
        mut encoder: wgpu::CommandEncoder,
        buffers: &[&wgpu::Buffer],
    ) -> Result<Vec<Vec<u8>>, GpuError> {
        let staging: Vec<wgpu::Buffer> = buffers
            .iter()
            .map(|buffer| {
                let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("vrcs read-back"),
                    size: buffer.size(),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                });
                encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
                staging
            })
            .collect();
        self.queue.submit([encoder.finish()]);
        self.check()?;
        for buffer in &staging {
            buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        }
        self.wait()?;
        let mut read = Vec::with_capacity(staging.len());
        for buffer in &staging {
            let range = buffer
                .get_mapped_range(..)
                .map_err(|error| GpuError::Lost(error.to_string()))?;
            read.push(range.to_vec());
        }
        self.check()?;
        Ok(read)
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|error| GpuError::Lost(error.to_string()))
    }

    /// A builder with these options, made at the first call.
    ///
    /// # Errors
    /// If the device has too little for it.
    pub fn builder(&self, options: BuildOptions) -> Result<Arc<Builder>, GpuError> {
        let mut known = self.builders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(builder) = known.iter().find(|known| *known.options() == options) {
            return Ok(Arc::clone(builder));
        }
        let made = Builder::new(&self.device, options, &ObjectOptions::default());
        let builder = Arc::new(made.map_err(|error| GpuError::Refused(error.to_string()))?);
        known.push(Arc::clone(&builder));
        Ok(builder)
    }

    /// An encoder.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("vrcs"),
            })
    }
}
