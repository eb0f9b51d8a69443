//! Pictures in, grey pictures out.

use std::path::Path;

use image::{DynamicImage, ImageEncoder};

use crate::{
    analyse::{
        Colour,
        luma::{Luma, from_srgb},
    },
    cli::{Failure, files},
    picture,
};

/// A picture that is analysed.
pub(super) struct Picture(DynamicImage);

impl Picture {
    /// Reads a picture, whatever its name ends in.
    pub(super) fn read(path: &Path) -> Result<Picture, Failure> {
        let bytes = files::read_bytes(path)?;
        let name = files::display_name(path);
        let picture =
            picture::decode(&bytes).map_err(|why| Failure::Outside(format!("{name}: {why}")))?;
        Ok(Picture(picture))
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.0.width(), self.0.height()]
    }

    /// Whether the values are linear light, as in EXR and HDR, rather than encoded for a display.
    fn is_linear(&self) -> bool {
        matches!(
            self.0,
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
        )
    }

    /// The pixels as the analysis takes them. Eight and sixteen bits are taken for sRGB, floats for linear light.
    pub(super) fn pixels(&self) -> Pixels {
        if self.is_linear() {
            return Pixels::Linear(self.0.to_rgba32f().pixels().map(|pixel| pixel.0).collect());
        }
        match self.0 {
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => {
                let rgb = self.0.to_rgb16();
                let linear = rgb.pixels().map(|pixel| {
                    let [r, g, b] = pixel
                        .0
                        .map(|code| from_srgb(f64::from(code) / 65535.0) as f32);
                    [r, g, b, 1.0]
                });
                Pixels::Linear(linear.collect())
            }
            _ => Pixels::Codes(self.0.to_rgba8().pixels().map(|pixel| pixel.0).collect()),
        }
    }

    /// The luma, of linear light.
    pub(super) fn luma(&self) -> Luma {
        let [width, height] = self.size();
        match self.pixels() {
            Pixels::Codes(codes) => Luma::from_rgba8(width, height, codes.as_flattened()),
            Pixels::Linear(values) => {
                let rgb: Vec<f32> = values.iter().flat_map(|v| [v[0], v[1], v[2]]).collect();
                Luma::from_linear(width, height, &rgb)
            }
            Pixels::Root(codes) => {
                let grey = codes.iter().flat_map(|&code| {
                    let root = f32::from(code) / 255.0;
                    [root * root; 3]
                });
                Luma::from_linear(width, height, &grey.collect::<Vec<f32>>())
            }
        }
    }

    /// The picture for a display, as RGB.
    pub(super) fn for_display(&self) -> image::RgbImage {
        match self.is_linear() {
            true => {
                let linear = self.0.to_rgb32f();
                image::RgbImage::from_fn(self.0.width(), self.0.height(), |x, y| {
                    image::Rgb(linear.get_pixel(x, y).0.map(encode))
                })
            }
            false => self.0.to_rgb8(),
        }
    }
}

/// A picture's pixels, row by row.
pub(super) enum Pixels {
    /// Of eight bits.
    Codes(Vec<[u8; 4]>),
    /// Of linear light.
    Linear(Vec<[f32; 4]>),
    /// √luma of eight bits.
    Root(Vec<u8>),
}

impl Pixels {
    /// Whether both are of one kind.
    pub(super) fn is_like(&self, other: &Pixels) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// As an input.
    pub(super) fn colour(&self) -> Colour<'_> {
        match self {
            Pixels::Codes(codes) => Colour::Codes(codes),
            Pixels::Linear(values) => Colour::Linear(values),
            Pixels::Root(codes) => Colour::SqrtLuma(codes),
        }
    }
}

/// Linear light to an sRGB byte (IEC 61966-2-1). What is no number is black.
fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = match linear <= 0.003_130_8 {
        true => linear * 12.92,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    };
    (encoded * 255.0).round() as u8
}

/// A grey PNG of eight bits.
pub(super) fn grey_png([width, height]: [u32; 2], value: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let pixels: Vec<u8> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| value(x, y))
        .collect();
    png(&pixels, [width, height], image::ExtendedColorType::L8)
}

/// A PNG of bytes that are as many as the size and colours need.
pub(super) fn png(
    pixels: &[u8],
    [width, height]: [u32; 2],
    colours: image::ExtendedColorType,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    match encoder.write_image(pixels, width, height, colours) {
        Ok(()) => bytes,
        Err(error) => unreachable!("memory takes every byte: {error}"),
    }
}
