//! The picture with its rates on it.

use super::picture::{Picture, png};
use crate::{Rate, sri::Sri};

/// The colour of a rate, and its name; full rate leaves the picture as it is.
fn colour(rate: Rate) -> Option<([u8; 3], &'static str)> {
    match rate {
        Rate::R1X2 => Some(([60, 110, 255], "blue")),
        Rate::R2X1 => Some(([40, 200, 90], "green")),
        Rate::R2X2 => Some(([255, 210, 40], "yellow")),
        Rate::R2X4 => Some(([190, 80, 255], "violet")),
        Rate::R4X2 => Some(([255, 130, 30], "orange")),
        Rate::R4X4 => Some(([255, 50, 50], "red")),
        _ => None,
    }
}

/// What a rate looks like in the overlay.
pub(super) fn colour_name(rate: Rate) -> &'static str {
    colour(rate).map_or("plain", |(_, name)| name)
}

/// Draws the overlay, as a PNG: the picture, grey, under the colours of its rates; where the rate is full, the picture in its
/// own colours.
pub(super) fn draw(picture: &Picture, sri: &Sri) -> Vec<u8> {
    let mut image = picture.for_display();
    for (x, y, pixel) in image.enumerate_pixels_mut() {
        let rate = Rate::from_code_or_full(sri.code(x / 2, y / 2));
        if let Some((colour, _)) = colour(rate) {
            let [r, g, b] = pixel.0.map(u32::from);
            let grey = (r * 77 + g * 150 + b * 29) >> 8;
            pixel.0 = colour.map(|channel| ((u32::from(channel) * 6 + grey * 10) / 16) as u8);
        }
    }
    let size = [image.width(), image.height()];
    png(image.as_raw(), size, image::ExtendedColorType::Rgb8)
}
