//! The demo's pictures.

use std::path::{Path, PathBuf};

use image::{Rgba, RgbaImage, imageops};

use super::DemoError;
use crate::{Rate, atomic, build::cpu::Coordinates, sri::Sri};

/// The colour of a rate in overlays: warm where shading is dense, cool where it is sparse.
pub fn rate_color(rate: Rate) -> [u8; 3] {
    match rate {
        Rate::R1X1 => [226, 60, 45],
        Rate::R2X1 => [245, 170, 40],
        Rate::R1X2 => [240, 225, 70],
        Rate::R2X2 => [60, 175, 90],
        Rate::R2X4 | Rate::R4X2 => [40, 140, 200],
        _ => [90, 70, 190],
    }
}

/// Writes all pictures; their paths.
pub(super) fn write(
    out: &Path,
    size: [u32; 2],
    full: &[u8],
    variable: &[u8],
    sri: &Sri,
    coordinates: &Coordinates,
) -> Result<Vec<PathBuf>, DemoError> {
    std::fs::create_dir_all(out).map_err(|error| DemoError::Write {
        path: out.display().to_string(),
        why: error.to_string(),
    })?;
    let [width, height] = size;
    let pixel = |bytes: &[u8], x: u32, y: u32| {
        let at = (y * width + x) as usize * 4;
        [bytes[at], bytes[at + 1], bytes[at + 2]]
    };
    let opaque = |[r, g, b]: [u8; 3]| Rgba([r, g, b, 255]);
    let rates = RgbaImage::from_fn(width, height, |x, y| {
        let tint = rate_color(sri.rate(x / 2, y / 2, coordinates.options.largest));
        let under = pixel(full, x, y);
        opaque(std::array::from_fn(|i| {
            ((u16::from(tint[i]) * 11 + u16::from(under[i]) * 9) / 20) as u8
        }))
    });
    let difference = RgbaImage::from_fn(width, height, |x, y| {
        let (a, b) = (pixel(full, x, y), pixel(variable, x, y));
        opaque(std::array::from_fn(|i| {
            a[i].abs_diff(b[i]).saturating_mul(16)
        }))
    });
    let full = RgbaImage::from_fn(width, height, |x, y| opaque(pixel(full, x, y)));
    let variable = RgbaImage::from_fn(width, height, |x, y| opaque(pixel(variable, x, y)));
    let pictures = [
        ("overview.png", side_by_side(&[&full, &rates, &variable])),
        ("full.png", full),
        ("variable.png", variable),
        ("rates.png", rates),
        ("primaries.png", primaries(size, coordinates)),
        ("difference.png", difference),
    ];
    pictures
        .into_iter()
        .map(|(name, picture)| {
            let path = out.join(name);
            save(&picture, &path)?;
            Ok(path)
        })
        .collect()
}

/// Pictures of one size in a row, at half their size.
fn side_by_side(pictures: &[&RgbaImage]) -> RgbaImage {
    let (width, height) = (
        pictures[0].width().div_ceil(2),
        pictures[0].height().div_ceil(2),
    );
    let mut row = RgbaImage::new(width * pictures.len() as u32, height);
    for (index, picture) in pictures.iter().enumerate() {
        let half = imageops::resize(*picture, width, height, imageops::FilterType::Triangle);
        imageops::replace(&mut row, &half, i64::from(width) * index as i64, 0);
    }
    row
}

/// Primaries and duplicates, in the slides' manner: tiles in which every pixel is its own primary are yellow.
fn primaries(size: [u32; 2], coordinates: &Coordinates) -> RgbaImage {
    let [width, height] = size;
    let map = coordinates.map();
    let [tile_width, tile_height] = coordinates.options.tile;
    RgbaImage::from_fn(width, height, |x, y| {
        let tile = y / tile_height * coordinates.layout.tiles[0] + x / tile_width;
        let is_edge = x % tile_width == 0 || y % tile_height == 0;
        let index = y * width + x;
        let color = if coordinates.header(tile).is_identity() {
            [235, 200, 60]
        } else if map[index as usize] == index {
            [70, 150, 230]
        } else {
            [38, 44, 58]
        };
        let shown = match is_edge {
            true => color.map(|c: u8| c / 2),
            false => color,
        };
        Rgba([shown[0], shown[1], shown[2], 255])
    })
}

/// Writes a picture.
fn save(picture: &RgbaImage, path: &Path) -> Result<(), DemoError> {
    let wrong = |why: String| DemoError::Write {
        path: path.display().to_string(),
        why,
    };
    let mut png = std::io::Cursor::new(Vec::new());
    picture
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|error| wrong(error.to_string()))?;
    atomic::write(path, png.get_ref()).map_err(|error| wrong(error.to_string()))
}
