//! The hardware-VRS image on the CPU: the oracle of the kernel, and a way for those without a GPU.

use super::{AttachOptions, AttachmentLayout, Shading};
use crate::{rate::Rate, sri::Sri};

/// A hardware-VRS image in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    options: AttachOptions,
    layout: AttachmentLayout,
    texels: Vec<u8>,
}

impl Attachment {
    /// Its form.
    pub fn layout(&self) -> AttachmentLayout {
        self.layout
    }

    /// Its bytes, as they are copied to a texture; what pads a row is 0.
    pub fn bytes(&self) -> &[u8] {
        &self.texels
    }

    /// The texel of a tile; `None` outside the image.
    pub fn texel(&self, x: u32, y: u32) -> Option<u8> {
        let is_inside = x < self.layout.width && y < self.layout.height;
        is_inside.then(|| self.texels[(y * self.layout.pitch + x) as usize])
    }

    /// What the hardware does at a pixel when this image alone decides.
    ///
    /// Beyond the image the hardware shades at full rate.
    pub fn shading_at(&self, x: u32, y: u32) -> Shading {
        let side = self.options.tile.side();
        self.texel(x / side, y / side)
            .and_then(|texel| self.options.encoding.decode(texel))
            .unwrap_or(Shading::Coarse(Rate::R1X1))
    }
}

/// Makes the image for a picture of a size in pixels from its rates.
///
/// Quads that the shading-rate image lacks count as full rate.
pub fn attach(sri: &Sri, size: [u32; 2], options: &AttachOptions) -> Attachment {
    let layout = AttachmentLayout::new(size, options.tile);
    let mut texels = vec![0; layout.bytes() as usize];
    for y in 0..layout.height {
        for x in 0..layout.width {
            let asked = finest(sri, size, options.tile.side() / 2, [x, y]);
            texels[(y * layout.pitch + x) as usize] = options.texel(asked);
        }
    }
    Attachment {
        options: options.clone(),
        layout,
        texels,
    }
}

/// The finest rate of a tile's quads inside the picture, per axis.
fn finest(sri: &Sri, size: [u32; 2], quads: u32, [x, y]: [u32; 2]) -> Rate {
    let [width, height] = size.map(|side| side.div_ceil(2));
    let rows = y * quads..((y + 1) * quads).min(height);
    let columns = x * quads..((x + 1) * quads).min(width);
    rows.flat_map(|y| columns.clone().map(move |x| (x, y)))
        .map(|(x, y)| Rate::from_code_or_full(sri.code(x, y)))
        .fold(Rate::R4X4, Rate::meet)
}
