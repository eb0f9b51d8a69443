//! What a texel means to each interface.
//!
//! D3D12 and Vulkan KHR read a code, `(log2 W << 2) | log2 H`. Vulkan NV, OpenGL and NVAPI read an *index* into a palette
//! that the application programs for each viewport; with [`PALETTE`] as that palette, an index means the same in all three,
//! and is the value of the Vulkan and NVAPI enumeration (NVIDIA Adaptive Shading Overview, GDC 2019, "VRS and MSAA modes"
//! and the slides on Vulkan, OpenGL and DX12).

use super::Samples;
use crate::rate::Rate;

/// How texels are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// `D3D12_SHADING_RATE`, in a texture of `DXGI_FORMAT_R8_UINT`.
    D3d12,
    /// `VK_KHR_fragment_shading_rate`, in an image of `VK_FORMAT_R8_UINT`: `W = 2^((texel / 4) & 3)`, `H = 2^(texel & 3)`.
    Khr,
    /// Indices into [`PALETTE`]: `VK_NV_shading_rate_image`, `GL_NV_shading_rate_image` (`R8UI`), NVAPI.
    Nv,
    /// As [`Encoding::Nv`], and where the content asks for full rate, every sample of a pixel is shaded, up to 2, 4, 8 or 16
    /// of them: the hybrid of coarse shading and selective supersampling that neither D3D12 nor Vulkan KHR has. Never
    /// more than the target has samples; with one sample it is full rate.
    NvSupersampled(Samples),
}

impl Encoding {
    /// The texel for a rate that the device supports.
    pub fn encode(self, rate: Rate, samples: Samples) -> u8 {
        match self {
            // the code is that of D3D12 and Vulkan KHR
            Encoding::D3d12 | Encoding::Khr => rate.code(),
            Encoding::Nv => palette_index(Shading::Coarse(rate)),
            Encoding::NvSupersampled(most) => match (rate, most.min(samples)) {
                (Rate::R1X1, times) if times > Samples::X1 => {
                    palette_index(Shading::Supersampled(times))
                }
                _ => palette_index(Shading::Coarse(rate)),
            },
        }
    }

    /// What a texel asks for; `None` if it means nothing.
    pub fn decode(self, texel: u8) -> Option<Shading> {
        match self {
            Encoding::D3d12 | Encoding::Khr => Rate::from_code(texel).map(Shading::Coarse),
            Encoding::Nv | Encoding::NvSupersampled(_) => {
                PALETTE.get(usize::from(texel)).map(|entry| entry.shading)
            }
        }
    }
}

/// What a palette entry asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Nothing is shaded: the tile is culled.
    Cull,
    /// Each pixel is shaded so many times: 2, 4, 8 or 16.
    Supersampled(Samples),
    /// Once for each coarse pixel; 1x1 is once for each pixel.
    Coarse(Rate),
}

/// An entry of the palette, with its names and numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PaletteEntry {
    /// What it asks for.
    pub shading: Shading,
    /// `VkShadingRatePaletteEntryNV`, which NVAPI's `NV_PIXEL_SHADING_RATE` has too: the entry's index.
    pub vulkan: u8,
    /// OpenGL's token, for `glShadingRateImagePaletteNV`.
    pub gl: u32,
    /// `VkFragmentShadingRateNV`: what a texel of a *KHR* attachment may hold with `VK_NV_fragment_shading_rate_enums`.
    pub enums: u8,
}

const fn entry(shading: Shading, vulkan: u8, gl: u32, enums: u8) -> PaletteEntry {
    PaletteEntry {
        shading,
        vulkan,
        gl,
        enums,
    }
}

/// The palette to program, entry by entry, for texels of [`Encoding::Nv`].
///
/// Vulkan and NVAPI count 2x1 before 1x2 and 4x2 before 2x4; OpenGL's tokens and the codes of D3D12 and Vulkan KHR go the other
/// way round.
#[rustfmt::skip]
pub const PALETTE: [PaletteEntry; 12] = [
    entry(Shading::Cull,                         0, 0x9564, 15),
    entry(Shading::Supersampled(Samples::X16),   1, 0x956F, 14),
    entry(Shading::Supersampled(Samples::X8),    2, 0x956E, 13),
    entry(Shading::Supersampled(Samples::X4),    3, 0x956D, 12),
    entry(Shading::Supersampled(Samples::X2),    4, 0x956C, 11),
    entry(Shading::Coarse(Rate::R1X1),           5, 0x9565,  0),
    entry(Shading::Coarse(Rate::R2X1),           6, 0x9567,  4),
    entry(Shading::Coarse(Rate::R1X2),           7, 0x9566,  1),
    entry(Shading::Coarse(Rate::R2X2),           8, 0x9568,  5),
    entry(Shading::Coarse(Rate::R4X2),           9, 0x956A,  9),
    entry(Shading::Coarse(Rate::R2X4),          10, 0x9569,  6),
    entry(Shading::Coarse(Rate::R4X4),          11, 0x956B, 10),
];

/// The index of a shading in [`PALETTE`].
///
/// Supersampling once is full rate.
pub fn palette_index(shading: Shading) -> u8 {
    match shading {
        Shading::Cull => 0,
        Shading::Supersampled(Samples::X16) => 1,
        Shading::Supersampled(Samples::X8) => 2,
        Shading::Supersampled(Samples::X4) => 3,
        Shading::Supersampled(Samples::X2) => 4,
        Shading::Supersampled(Samples::X1) => 5,
        Shading::Coarse(Rate::R2X1) => 6,
        Shading::Coarse(Rate::R1X2) => 7,
        Shading::Coarse(Rate::R2X2) => 8,
        Shading::Coarse(Rate::R4X2) => 9,
        Shading::Coarse(Rate::R2X4) => 10,
        Shading::Coarse(Rate::R4X4) => 11,
        Shading::Coarse(_) => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_of_the_palette_stands_at_its_own_index() {
        for (index, entry) in PALETTE.iter().enumerate() {
            assert_eq!(usize::from(entry.vulkan), index);
            assert_eq!(palette_index(entry.shading), entry.vulkan, "{entry:?}");
        }
        let mut tokens: Vec<u32> = PALETTE.iter().map(|entry| entry.gl).collect();
        tokens.sort_unstable();
        assert_eq!(tokens, (0x9564..=0x956F).collect::<Vec<_>>());
    }

    #[test]
    fn the_entries_of_coarse_rates_hold_the_code_that_a_khr_attachment_holds() {
        for entry in PALETTE {
            match entry.shading {
                Shading::Coarse(rate) => assert_eq!(entry.enums, rate.code()),
                _ => assert_eq!(Rate::from_code(entry.enums), None),
            }
        }
    }

    #[test]
    fn what_is_encoded_decodes_to_what_it_was() {
        for rate in Rate::ALL {
            for encoding in [Encoding::D3d12, Encoding::Khr, Encoding::Nv] {
                let texel = encoding.encode(rate, Samples::X1);
                assert_eq!(encoding.decode(texel), Some(Shading::Coarse(rate)));
            }
        }
        assert_eq!(Encoding::Khr.decode(2), None, "1x4");
        assert_eq!(Encoding::Nv.decode(12), None);
    }

    #[test]
    fn only_full_rate_is_supersampled_and_never_more_than_there_are_samples() {
        let texel = |most, rate, samples| Encoding::NvSupersampled(most).encode(rate, samples);
        assert_eq!(texel(Samples::X4, Rate::R1X1, Samples::X8), 3);
        assert_eq!(texel(Samples::X16, Rate::R1X1, Samples::X2), 4);
        assert_eq!(texel(Samples::X16, Rate::R1X1, Samples::X1), 5);
        for rate in Rate::ALL.into_iter().filter(|&rate| rate != Rate::R1X1) {
            let plain = Encoding::Nv.encode(rate, Samples::X4);
            assert_eq!(texel(Samples::X16, rate, Samples::X4), plain);
        }
    }
}
