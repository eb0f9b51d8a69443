//! The shading-rate image: one byte for each quad of 2×2 pixels.
//!
//! On the GPU it is a storage buffer of packed words, four quads in each, its rows padded to 256 bytes, so that it can be
//! copied to and from textures; 8-bit formats have no storage usage under wgpu's default limits.

use crate::rate::Rate;

/// Bytes to which rows are padded: `COPY_BYTES_PER_ROW_ALIGNMENT`.
pub const ROW_ALIGNMENT: u32 = 256;

/// The form of a shading-rate image for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SriLayout {
    /// Quads across: half the picture's width, rounded up.
    pub width: u32,
    /// Quads down: half the picture's height, rounded up.
    pub height: u32,
    /// Bytes from row to row, a multiple of [`ROW_ALIGNMENT`].
    pub pitch: u32,
}

impl SriLayout {
    /// The form for a picture of `width` × `height` pixels.
    pub fn new(width: u32, height: u32) -> SriLayout {
        let quads = width.div_ceil(2);
        SriLayout {
            width: quads,
            height: height.div_ceil(2),
            pitch: quads.max(1).next_multiple_of(ROW_ALIGNMENT),
        }
    }

    /// The size in bytes.
    pub fn bytes(&self) -> u64 {
        u64::from(self.pitch) * u64::from(self.height.max(1))
    }
}

/// A shading-rate image in memory.
#[derive(Clone, PartialEq, Eq)]
pub struct Sri {
    layout: SriLayout,
    codes: Vec<u8>,
}

impl Sri {
    /// An image for a picture of `width` × `height` pixels, the same rate everywhere.
    pub fn uniform(width: u32, height: u32, rate: Rate) -> Sri {
        Sri::from_fn(width, height, |_, _| rate.code())
    }

    /// An image whose bytes are given by a function of the quad's column and row. Bytes that are no code of a rate
    /// stand for full rate.
    pub fn from_fn(width: u32, height: u32, mut code: impl FnMut(u32, u32) -> u8) -> Sri {
        let layout = SriLayout::new(width, height);
        let mut codes = vec![0; layout.bytes() as usize];
        for y in 0..layout.height {
            for x in 0..layout.width {
                codes[(y * layout.pitch + x) as usize] = code(x, y);
            }
        }
        Sri { layout, codes }
    }

    /// Its form.
    pub fn layout(&self) -> SriLayout {
        self.layout
    }

    /// Its bytes, as they go to the GPU.
    pub fn bytes(&self) -> &[u8] {
        &self.codes
    }

    /// The byte of a quad; full rate outside the image.
    pub fn code(&self, x: u32, y: u32) -> u8 {
        match x < self.layout.width && y < self.layout.height {
            true => self.codes[(y * self.layout.pitch + x) as usize],
            false => Rate::R1X1.code(),
        }
    }

    /// The rate that holds for a quad, no coarser than `largest` on either axis: a rate 4 wide or 4 high holds only
    /// where all four quads of the aligned 4×4 block agree, else it falls to 2.
    pub fn rate(&self, x: u32, y: u32, largest: Rate) -> Rate {
        let asked = Rate::from_code_or_full(self.code(x, y));
        let (left, top) = (x & !1, y & !1);
        let agreed = (0..4)
            .all(|i| Rate::from_code_or_full(self.code(left + (i & 1), top + (i >> 1))) == asked);
        let holds = match agreed {
            true => asked,
            false => asked.meet(Rate::R2X2),
        };
        holds.meet(largest)
    }
}

impl std::fmt::Debug for Sri {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "Sri {}x{} quads", self.layout.width, self.layout.height)?;
        for y in 0..self.layout.height {
            for x in 0..self.layout.width {
                write!(f, "{:x}", self.code(x, y))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_padded_so_that_a_texture_copy_can_take_them() {
        assert_eq!(
            SriLayout::new(1, 1),
            SriLayout {
                width: 1,
                height: 1,
                pitch: 256
            }
        );
        assert_eq!(
            SriLayout::new(515, 1081),
            SriLayout {
                width: 258,
                height: 541,
                pitch: 512
            }
        );
    }

    #[test]
    fn a_4_wide_rate_holds_only_where_its_block_agrees() {
        let mut sri = Sri::uniform(8, 8, Rate::R4X4);
        assert_eq!(sri.rate(0, 0, Rate::R4X4), Rate::R4X4);
        sri.codes[1] = Rate::R4X2.code();
        assert_eq!(sri.rate(0, 0, Rate::R4X4), Rate::R2X2);
        assert_eq!(sri.rate(1, 0, Rate::R4X4), Rate::R2X2);
        assert_eq!(sri.rate(2, 0, Rate::R4X4), Rate::R4X4, "the next block");
    }

    #[test]
    fn a_block_that_runs_over_the_edge_does_not_agree() {
        let sri = Sri::uniform(6, 4, Rate::R4X2);
        assert_eq!(sri.rate(0, 0, Rate::R4X4), Rate::R4X2);
        assert_eq!(sri.rate(2, 0, Rate::R4X4), Rate::R2X2);
    }

    #[test]
    fn the_largest_rate_caps_each_axis() {
        let sri = Sri::uniform(8, 8, Rate::R4X2);
        assert_eq!(sri.rate(0, 0, Rate::R2X2), Rate::R2X2);
        assert_eq!(sri.rate(0, 0, Rate::R1X2), Rate::R1X2);
        assert_eq!(sri.rate(0, 0, Rate::R1X1), Rate::R1X1);
    }

    #[test]
    fn bytes_that_are_no_code_mean_full_rate() {
        let sri = Sri::from_fn(4, 4, |_, _| 0xff);
        assert_eq!(sri.rate(0, 0, Rate::R4X4), Rate::R1X1);
    }
}
