//! Pictures of a scene in memory.

use super::stage::Stage;
use crate::check::gpu::{Gpu, GpuError};

/// Records a copy of the finished picture; [`read`] gives its pixels.
pub fn copy(stage: &Stage, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) -> wgpu::Buffer {
    let [width, height] = stage.size();
    let pitch = pitch(width);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture read-back"),
        size: u64::from(pitch) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let picture = stage.picture();
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
    buffer
}

/// Submits what has been recorded, and reads copied pictures: RGBA, row by row.
///
/// # Errors
/// If the device fails.
pub fn read(
    gpu: &Gpu,
    encoder: wgpu::CommandEncoder,
    size: [u32; 2],
    copies: &[&wgpu::Buffer],
) -> Result<Vec<Vec<u8>>, GpuError> {
    let row = size[0] as usize * 4;
    let padded = gpu.submit_and_read(encoder, copies)?;
    Ok(padded
        .iter()
        .map(|bytes| {
            bytes
                .chunks(pitch(size[0]) as usize)
                .flat_map(|padded| &padded[..row])
                .copied()
                .collect()
        })
        .collect())
}

fn pitch(width: u32) -> u32 {
    (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
