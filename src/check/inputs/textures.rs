//! Textures, from chance or from files, and how they are written.

use fastrand::Rng;
use half::f16;

use super::{Gpu, InputError, MadeKind, Maker, why_unread};
use crate::dispatch::reflect::Resource;

/// Texels of a 1-D texture at most: WebGPU's default limit.
const MOST_IN_A_LINE: u32 = 2048;

impl Maker<'_> {
    pub(super) fn texture(
        &self,
        resource: &Resource,
        format: wgpu::TextureFormat,
        view_dimension: wgpu::TextureViewDimension,
        storage: Option<bool>,
        rng: &mut Rng,
    ) -> Result<MadeKind, InputError> {
        let [width, height] = self.size;
        let mut size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let mut dimension = wgpu::TextureDimension::D2;
        match view_dimension {
            wgpu::TextureViewDimension::D1 => {
                // a line that holds a picture row by row, with any usual stride, as far as devices go
                dimension = wgpu::TextureDimension::D1;
                size.width = (width * height * 4).min(MOST_IN_A_LINE);
                size.height = 1;
            }
            wgpu::TextureViewDimension::D2 => {}
            wgpu::TextureViewDimension::D2Array => size.depth_or_array_layers = self.layers,
            wgpu::TextureViewDimension::D3 => {
                dimension = wgpu::TextureDimension::D3;
                size.depth_or_array_layers = self.layers;
            }
            wgpu::TextureViewDimension::Cube | wgpu::TextureViewDimension::CubeArray => {
                let side = width.min(height).min(16);
                size = wgpu::Extent3d {
                    width: side,
                    height: side,
                    depth_or_array_layers: 6,
                };
            }
        }
        let from_file = match self.settings.files.get(&resource.name) {
            Some(path) => Some(read_picture(path, format)?),
            None => None,
        };
        if let Some(picture) = &from_file {
            size.width = picture.width;
            size.height = picture.height;
        }
        let levels = match (storage, dimension) {
            (None, wgpu::TextureDimension::D2) if from_file.is_none() => {
                size.max_mips(dimension).min(4)
            }
            _ => 1,
        };
        let usage = match storage {
            Some(_) => wgpu::TextureUsages::STORAGE_BINDING,
            None => wgpu::TextureUsages::TEXTURE_BINDING,
        };
        let texture = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&resource.name),
            size,
            mip_level_count: levels,
            sample_count: 1,
            dimension,
            format,
            usage: usage | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut initial = Vec::new();
        for level in 0..levels {
            let level_size = texture.size().mip_level_size(level, dimension);
            let texels = level_size.width * level_size.height * level_size.depth_or_array_layers;
            let mut bytes: Vec<u8> = match &from_file {
                Some(picture) => picture.texels.clone(),
                None => (0..texels)
                    .flat_map(|_| self.texel(format, storage == Some(true), rng))
                    .collect(),
            };
            if self.breadth > 0 && from_file.is_none() && storage != Some(true) {
                let rows = level_size.height * level_size.depth_or_array_layers;
                make_plain_patches(&mut bytes, [level_size.width, rows], rng);
            }
            write_texture(self.gpu, &texture, level, &bytes);
            if level == 0 {
                initial = bytes;
            }
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(view_dimension),
            ..wgpu::TextureViewDescriptor::default()
        });
        Ok(MadeKind::Texture {
            texture,
            view,
            initial,
        })
    }

    /// A float that reaches over the picture, to either side of 0; one in eight lies so far below that a place added to it is lost, so
    /// `if depth[i] < f32(id.x) + depth[i]` is not taken for a condition of the ids alone. (Far above, it might count a loop.)
    pub(super) fn reaching(&self, rng: &mut Rng) -> f32 {
        let near = (rng.f32() * 2.0 - 1.0) * self.reach as f32;
        match rng.u8(0..8) {
            0 => near.abs() * -((1 << 25) as f32),
            _ => near,
        }
    }

    /// A texel: poison, or something that a shader can read; floats as far from 0 as `reach`, if it is not 0.
    fn texel(&self, format: wgpu::TextureFormat, poison: bool, rng: &mut Rng) -> Vec<u8> {
        use wgpu::TextureFormat as F;
        let bytes = format.block_copy_size(None).unwrap_or(4) as usize;
        let components = usize::from(format.components());
        let float = |rng: &mut Rng| match poison {
            true => 2.0 + rng.f32(),
            false if self.reach > 0 => self.reaching(rng),
            false => match self.end(rng) {
                Some(end) => f32::from(end),
                // below 0 and above 1 as in buffers: distances, speeds
                None => rng.f32() * (1.0 + 2.0 * self.breadth as f32) - self.breadth as f32,
            },
        };
        match format {
            F::R16Float | F::Rg16Float | F::Rgba16Float => (0..components)
                .flat_map(|_| f16::from_f32(float(rng).max(f16::MIN.into())).to_le_bytes())
                .collect(),
            F::R32Float | F::Rg32Float | F::Rgba32Float => (0..components)
                .flat_map(|_| float(rng).to_le_bytes())
                .collect(),
            // exponents 8 to 15 of 31: no NaN, no infinity
            F::Rg11b10Ufloat => {
                let part = |rng: &mut Rng, mantissa: u32| {
                    rng.u32(8..16) << mantissa | rng.u32(0..1 << mantissa)
                };
                let bits = part(rng, 6) | part(rng, 6) << 11 | part(rng, 5) << 22;
                bits.to_le_bytes().to_vec()
            }
            F::R32Uint | F::Rg32Uint | F::Rgba32Uint | F::R32Sint | F::Rg32Sint | F::Rgba32Sint => {
                (0..components)
                    .flat_map(|_| {
                        match poison {
                            true => rng.u32(0x4000_0000..0x7fff_ffff),
                            false => rng.u32(0..8),
                        }
                        .to_le_bytes()
                    })
                    .collect()
            }
            F::Depth16Unorm if !poison => {
                let end = self.end(rng).map(|end| u16::from(end) * u16::MAX);
                end.unwrap_or_else(|| rng.u16(..)).to_le_bytes().to_vec()
            }
            _ => (0..bytes)
                .map(|_| match poison {
                    true => rng.u8(1..0x7f),
                    false => rng.u8(..),
                })
                .collect(),
        }
    }
}

/// Writes a level of a texture, all layers.
pub fn write_texture(gpu: &Gpu, texture: &wgpu::Texture, level: u32, bytes: &[u8]) {
    let size = texture.size().mip_level_size(level, texture.dimension());
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size.width * texel),
            rows_per_image: Some(size.height),
        },
        size,
    );
}
/// Makes a quarter of a picture plain, in patches of 16 by 16 texels: shaders that work by tiles ask whether one is the same throughout.
fn make_plain_patches(bytes: &mut [u8], [width, rows]: [u32; 2], rng: &mut Rng) {
    const SIDE: u32 = 16;
    let texel = bytes.len() / (width * rows).max(1) as usize;
    let at = |x: u32, y: u32| (y * width + x) as usize * texel;
    for top in (0..rows).step_by(SIDE as usize) {
        for left in (0..width).step_by(SIDE as usize) {
            if rng.u8(0..4) > 0 {
                continue;
            }
            let first = bytes[at(left, top)..at(left, top) + texel].to_vec();
            for y in top..rows.min(top + SIDE) {
                for x in left..width.min(left + SIDE) {
                    bytes[at(x, y)..at(x, y) + texel].copy_from_slice(&first);
                }
            }
        }
    }
}

struct Picture {
    width: u32,
    height: u32,
    texels: Vec<u8>,
}

/// Reads a picture in the form of a texture format.
fn read_picture(
    path: &std::path::Path,
    format: wgpu::TextureFormat,
) -> Result<Picture, InputError> {
    use wgpu::TextureFormat as F;
    let wrong = |why: String| InputError::File {
        path: path.display().to_string(),
        why,
    };
    let bytes = std::fs::read(path).map_err(|error| wrong(why_unread(&error)))?;
    let picture = crate::picture::decode(&bytes).map_err(wrong)?;
    let (width, height) = (picture.width(), picture.height());
    let components = usize::from(format.components());
    let floats = picture.to_rgba32f();
    let texels = match format {
        F::Rgba16Float | F::Rg16Float | F::R16Float => floats
            .pixels()
            .flat_map(|p| {
                p.0[..components]
                    .iter()
                    .flat_map(|&v| f16::from_f32(v).to_le_bytes())
                    .collect::<Vec<_>>()
            })
            .collect(),
        F::Rgba32Float | F::Rg32Float | F::R32Float => floats
            .pixels()
            .flat_map(|p| {
                p.0[..components]
                    .iter()
                    .flat_map(|v| v.to_le_bytes())
                    .collect::<Vec<_>>()
            })
            .collect(),
        F::Rgba8Unorm => picture.to_rgba8().into_raw(),
        F::Depth16Unorm => picture
            .to_luma16()
            .into_raw()
            .into_iter()
            .flat_map(u16::to_le_bytes)
            .collect(),
        other => {
            return Err(wrong(format!(
                "a picture does not fit a texture of format {other:?}"
            )));
        }
    };
    Ok(Picture {
        width,
        height,
        texels,
    })
}
