//! Pictures from files: PNG, JPEG and Radiance HDR by the crate `image`, OpenEXR by the crate `exr`.
//!
//! `image` could read OpenEXR too, but only through a version of `exr` that rests on the crate `paste`, which nobody maintains.
//! A picture is the EXR's display window, as in `image`; what its first layer with colours does not cover is black and
//! transparent. Values are taken as they are: EXR and HDR hold linear light. Refuses what has no pixels, more than
//! [`LARGEST`] of them, no channels `R`, `G` and `B`, or is no picture.

use std::io::Cursor;

use exr::prelude::{ReadChannels, ReadLayers};
use image::{DynamicImage, ImageError, ImageReader, Rgba, Rgba32FImage};

/// The most pixels of an EXR: what a file says of itself is not believed without a bound. 16,384 in either direction.
const LARGEST: usize = 1 << 28;

/// A picture from the bytes of a file, told by what is in them.
///
/// # Errors
///
/// Says in one line why the bytes are no picture.
pub(crate) fn decode(bytes: &[u8]) -> Result<DynamicImage, String> {
    let picture = match bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        true => decode_exr(bytes)?,
        false => decode_other(bytes)?,
    };
    match picture.width() == 0 || picture.height() == 0 {
        true => Err("the picture has no pixels".to_owned()),
        false => Ok(picture),
    }
}

fn unreadable(why: impl std::fmt::Display) -> String {
    let why = why.to_string().replace(['\n', '\r'], " ");
    format!("the picture cannot be read: {why}")
}

fn decode_other(bytes: &[u8]) -> Result<DynamicImage, String> {
    let reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(unreadable)?;
    match reader.decode() {
        Ok(picture) => Ok(picture),
        Err(ImageError::Unsupported(_)) => {
            Err("it is no picture that can be read: PNG, JPEG, EXR and Radiance HDR can".to_owned())
        }
        Err(error) => Err(unreadable(error)),
    }
}

fn decode_exr(bytes: &[u8]) -> Result<DynamicImage, String> {
    let meta =
        exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
    let window = meta
        .headers
        .first()
        .ok_or_else(|| unreadable("it has no layer"))?
        .shared_attributes
        .display_window;
    for size in meta
        .headers
        .iter()
        .map(|header| header.layer_size)
        .chain([window.size])
    {
        if size.area() > LARGEST {
            return Err(unreadable(format!(
                "{}x{} pixels are more than {LARGEST}",
                size.x(),
                size.y()
            )));
        }
    }
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![Rgba([0.0; 4]); size.area()]),
            |(width, pixels): &mut (usize, Vec<Rgba<f32>>), at, (r, g, b, a)| {
                pixels[at.y() * *width + at.x()] = Rgba([r, g, b, a]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| match error {
            exr::error::Error::Invalid(_) => {
                unreadable(format!("{error} (the channels R, G and B are looked for)"))
            }
            other => unreadable(other),
        })?;
    let layer = read.layer_data;
    let offset = layer.attributes.layer_position - window.position;
    let (width, pixels) = layer.channel_data.pixels;
    let mut picture = Rgba32FImage::new(window.size.x() as u32, window.size.y() as u32);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let [x, y] =
            [x as i32 - offset.x(), y as i32 - offset.y()].map(|at| usize::try_from(at).ok());
        if let (Some(x), Some(y)) = (x.filter(|&x| x < width), y)
            && let Some(value) = pixels.get(y * width + x)
        {
            *pixel = *value;
        }
    }
    Ok(picture.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{
        Encoding, Image, IntegerBounds, Layer, LayerAttributes, SpecificChannels, Vec2,
        WritableImage,
    };

    /// An EXR of 3x2 pixels, whose values are their places, at a place in a window.
    fn exr(window: IntegerBounds, position: Vec2<i32>) -> Vec<u8> {
        let channels =
            SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 7.5f32));
        let mut attributes = LayerAttributes::named("main");
        attributes.layer_position = position;
        let mut image = Image::from_layer(Layer::new(
            (3, 2),
            attributes,
            Encoding::SMALL_LOSSLESS,
            channels,
        ));
        image.attributes.display_window = window;
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("a buffer");
        bytes.into_inner()
    }

    #[test]
    fn an_exr_is_its_display_window() {
        let window = IntegerBounds::new((0, 0), (4, 4));
        let picture = decode(&exr(window, Vec2(1, -1)))
            .expect("a picture")
            .to_rgba32f();
        assert_eq!(picture.dimensions(), (4, 4));
        // the layer's second row is the picture's first, one pixel to the right
        assert_eq!(picture.get_pixel(3, 0).0, [2.0, 1.0, 7.5, 1.0]);
        assert_eq!(picture.get_pixel(0, 0).0, [0.0; 4]);
        assert_eq!(picture.get_pixel(1, 1).0, [0.0; 4]);
    }

    #[test]
    fn what_is_no_picture_is_refused_in_one_line() {
        let window = IntegerBounds::new((0, 0), (3, 2));
        let good = exr(window, Vec2(0, 0));
        let cut = &good[..good.len() / 2];
        let vast = exr(IntegerBounds::new((0, 0), (1 << 20, 1 << 20)), Vec2(0, 0));
        for bytes in [&b"no picture"[..], &[], cut, &vast] {
            let why = decode(bytes).expect_err("no picture");
            assert!(!why.contains('\n'), "{why}");
        }
    }
}
