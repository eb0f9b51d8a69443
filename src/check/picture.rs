//! A picture of where a check failed.

use image::{ImageFormat, Rgb, RgbImage};

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// Nothing was due.
    Nothing,
    /// It is what it should be.
    Right,
    /// It is not.
    Wrong,
}

/// A PNG of marks, row by row: a square of four for each pixel, lines around tiles, a dot in each primary.
pub(super) fn png(width: u32, tile: [u32; 2], marks: &[Mark], primaries: &[bool]) -> Vec<u8> {
    const SIDE: u32 = 4;
    let height = marks.len() as u32 / width.max(1);
    let mut picture = RgbImage::new(width * SIDE, height * SIDE);
    for (x, y, pixel) in picture.enumerate_pixels_mut() {
        let (px, py) = (x / SIDE, y / SIDE);
        let index = (py * width + px) as usize;
        let on_line = x % (tile[0] * SIDE) == 0 || y % (tile[1] * SIDE) == 0;
        let on_dot =
            primaries[index] && (1..3).contains(&(x % SIDE)) && (1..3).contains(&(y % SIDE));
        *pixel = match marks[index] {
            _ if on_line => Rgb([0, 0, 0]),
            _ if on_dot => Rgb([255, 255, 255]),
            Mark::Nothing => Rgb([128, 128, 128]),
            Mark::Right => Rgb([40, 150, 70]),
            Mark::Wrong => Rgb([215, 40, 40]),
        };
    }
    let mut bytes = std::io::Cursor::new(Vec::new());
    // writing a picture to memory does not fail
    match picture.write_to(&mut bytes, ImageFormat::Png) {
        Ok(()) => bytes.into_inner(),
        Err(_) => Vec::new(),
    }
}
