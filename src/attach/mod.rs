//! The hardware-VRS image: from the rates of quads to one texel for each tile of 8×8, 16×16 or 32×32 pixels.
//!
//! Does: takes the finest rate of each tile's quads, per axis, replaces it by the nearest that the device can shade, and
//! encodes it for D3D12, Vulkan KHR, or the palette of Vulkan NV, OpenGL and NVAPI. The analysis gives all quads of a tile the rate of
//! the tile's own estimate ([`Settings::attachment`](crate::analyse::Settings::attachment)), which is then the finest: of the same
//! tiles, or of tiles that these divide. Of larger tiles, or of quads, it is the finest of several.
//! Needs: a shading-rate image in [`SriLayout`](crate::sri::SriLayout), made from the luma *after* transparents and
//! *without* the extra half rate (Variable-Rate Compute Shaders in DOOM: The Dark Ages, slides "Extra Half Rate
//! Shading" and "Transparencies Can Reduce Solid Shading Rate"): the hardware shades transparents too, and has no deblocker.
//! Guarantees: no texel asks for more than any of its quads, on either axis; a tile that runs over the picture's edge counts
//! the quads inside; a byte that is no code means full rate; rows are padded to 256 bytes, so that the image is one
//! copy from buffer to texture.
//! Refuses: sample counts that are no power of two up to 16.
//!
//! [`gpu::Attacher`] runs in the caller's pass. [`cpu::attach`] is its twin, equal byte for byte.

pub mod cpu;
mod encoding;
pub mod gpu;
mod support;

pub use encoding::{Encoding, PALETTE, PaletteEntry, Shading, palette_index};
pub use support::{AdditionalRates, Samples, Support, UnknownSampleCount};

use crate::{rate::Rate, sri::ROW_ALIGNMENT};

/// The side of the square of pixels that one texel speaks for.
///
/// A device has one or a range: D3D12's `ShadingRateImageTileSize` (NVIDIA 16, AMD 8), Vulkan's
/// `min`/`maxFragmentShadingRateAttachmentTexelSize`, or `shadingRateTexelSize` of `VK_NV_shading_rate_image`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tile {
    /// 8×8 pixels.
    T8,
    /// 16×16 pixels.
    T16,
    /// 32×32 pixels.
    T32,
}

impl Tile {
    /// All sizes.
    pub const ALL: [Tile; 3] = [Tile::T8, Tile::T16, Tile::T32];

    /// The tile with a side in pixels; `None` if there is none.
    pub fn new(side: u32) -> Option<Tile> {
        Tile::ALL.into_iter().find(|tile| tile.side() == side)
    }

    /// The side in pixels: 8, 16 or 32.
    pub const fn side(self) -> u32 {
        match self {
            Tile::T8 => 8,
            Tile::T16 => 16,
            Tile::T32 => 32,
        }
    }
}

/// What to make of rates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttachOptions {
    /// The side of a tile.
    pub tile: Tile,
    /// What a texel means.
    pub encoding: Encoding,
    /// What the device can shade.
    pub support: Support,
    /// Samples for each pixel of the target that is drawn to.
    pub samples: Samples,
}

impl AttachOptions {
    /// The texel for the rate that a tile's quads ask for.
    pub fn texel(&self, asked: Rate) -> u8 {
        let rate = self.support.nearest(asked, self.samples);
        self.encoding.encode(rate, self.samples)
    }

    /// The texels for all 16 numbers that four bits hold, as the kernel looks them up.
    fn table(&self) -> [u8; 16] {
        std::array::from_fn(|code| self.texel(Rate::from_code_or_full(code as u8)))
    }
}

/// The form of an attachment in a buffer: one byte for each tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AttachmentLayout {
    /// Tiles across: the picture's width divided by the tile's side, rounded up.
    pub width: u32,
    /// Tiles down.
    pub height: u32,
    /// Bytes from row to row, a multiple of [`ROW_ALIGNMENT`].
    pub pitch: u32,
}

impl AttachmentLayout {
    /// The form for a picture of `width` × `height` pixels.
    pub fn new([width, height]: [u32; 2], tile: Tile) -> AttachmentLayout {
        let across = width.div_ceil(tile.side());
        AttachmentLayout {
            width: across,
            height: height.div_ceil(tile.side()),
            pitch: across.max(1).next_multiple_of(ROW_ALIGNMENT),
        }
    }

    /// The size in bytes.
    pub fn bytes(&self) -> u64 {
        u64::from(self.pitch) * u64::from(self.height.max(1))
    }

    /// Records the copy of the buffer into a texture of the format `R8Uint`, at least as large as this form.
    pub fn copy_to_texture(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        texture: &wgpu::Texture,
    ) {
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo {
                buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.pitch),
                    rows_per_image: None,
                },
            },
            texture.as_image_copy(),
            wgpu::Extent3d {
                width: self.width,
                height: self.height,
                depth_or_array_layers: 1,
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_covers_the_picture_and_rows_are_padded() {
        let layout = |size, tile| {
            let layout = AttachmentLayout::new(size, tile);
            (layout.width, layout.height, layout.pitch)
        };
        assert_eq!(layout([1, 1], Tile::T32), (1, 1, 256));
        assert_eq!(layout([1920, 1080], Tile::T16), (120, 68, 256));
        assert_eq!(layout([1920, 1080], Tile::T8), (240, 135, 256));
        assert_eq!(layout([3840, 2160], Tile::T8), (480, 270, 512));
        assert_eq!(layout([3840, 2160], Tile::T32), (120, 68, 256));
    }

    #[test]
    fn tiles_are_those_that_hardware_has() {
        for side in 0..64 {
            assert_eq!(
                Tile::new(side).is_some(),
                [8, 16, 32].contains(&side),
                "{side}"
            );
        }
    }
}
