//! Luma of a picture (Yang et al., *Visually Lossless Content and Motion Adaptive Shading in Games*, I3D 2019, Eq. 25).

/// Luma of each pixel, linear, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Luma {
    width: u32,
    height: u32,
    values: Vec<f64>,
}

/// The weights of red, green and blue (Eq. 25), of linear light.
pub const WEIGHTS: [f64; 3] = [0.299, 0.587, 0.114];

/// sRGB-encoded, 0 to 1, to linear light, exactly (IEC 61966-2-1).
pub fn from_srgb(encoded: f64) -> f64 {
    match encoded <= 0.04045 {
        true => encoded / 12.92,
        false => ((encoded + 0.055) / 1.055).powf(2.4),
    }
}

impl Luma {
    /// From 8-bit RGBA, display-encoded, row by row.
    ///
    /// # Panics
    /// If there are not four bytes for each pixel.
    pub fn from_rgba8(width: u32, height: u32, bytes: &[u8]) -> Luma {
        assert_eq!(bytes.len(), width as usize * height as usize * 4);
        let linear: Vec<f64> = (0..256)
            .map(|code| from_srgb(f64::from(code) / 255.0))
            .collect();
        let values = bytes
            .chunks_exact(4)
            .map(|pixel| {
                (0..3)
                    .map(|channel| WEIGHTS[channel] * linear[usize::from(pixel[channel])])
                    .sum()
            })
            .collect();
        Luma {
            width,
            height,
            values,
        }
    }

    /// From 16-bit RGB, display-encoded, row by row.
    ///
    /// # Panics
    /// If there are not three values for each pixel.
    pub fn from_srgb16(width: u32, height: u32, values: &[u16]) -> Luma {
        Luma::from_channels(width, height, values, |value| {
            from_srgb(f64::from(value) / 65535.0)
        })
    }

    /// From linear RGB, row by row. What is no number stays none, so that its surroundings are shaded at full rate.
    ///
    /// # Panics
    /// If there are not three values for each pixel.
    pub fn from_linear(width: u32, height: u32, values: &[f32]) -> Luma {
        Luma::from_channels(width, height, values, f64::from)
    }

    fn from_channels<T: Copy>(
        width: u32,
        height: u32,
        values: &[T],
        linear: impl Fn(T) -> f64,
    ) -> Luma {
        assert_eq!(values.len(), width as usize * height as usize * 3);
        let values = values
            .chunks_exact(3)
            .map(|pixel| {
                (0..3)
                    .map(|channel| WEIGHTS[channel] * linear(pixel[channel]))
                    .sum()
            })
            .collect();
        Luma {
            width,
            height,
            values,
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The luma of a pixel; outside the picture, that of the nearest pixel inside.
    pub fn at(&self, x: i64, y: i64) -> f64 {
        let x = x.clamp(0, i64::from(self.width) - 1) as usize;
        let y = y.clamp(0, i64::from(self.height) - 1) as usize;
        self.values[y * self.width as usize + x]
    }
}
