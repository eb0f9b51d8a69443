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

/// The scene as it was shaded: RGBA, row by row.
pub(super) struct Shaded<'s> {
    pub(super) full: &'s [u8],
    pub(super) variable: &'s [u8],
    pub(super) deblocked: &'s [u8],
}

/// Writes all pictures; their paths.
pub(super) fn write(
    out: &Path,
    size: [u32; 2],
    shaded: &Shaded,
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
        let under = pixel(shaded.full, x, y);
        opaque(std::array::from_fn(|i| {
            ((u16::from(tint[i]) * 11 + u16::from(under[i]) * 9) / 20) as u8
        }))
    });
    let difference = RgbaImage::from_fn(width, height, |x, y| {
        let (a, b) = (pixel(shaded.full, x, y), pixel(shaded.variable, x, y));
        opaque(std::array::from_fn(|i| {
            a[i].abs_diff(b[i]).saturating_mul(16)
        }))
    });
    let picture = |bytes| RgbaImage::from_fn(width, height, |x, y| opaque(pixel(bytes, x, y)));
    let [full, variable, deblocked] = [shaded.full, shaded.variable, shaded.deblocked].map(picture);
    let window = busiest(size, shaded);
    let zoomed = beside(&[&full, &variable, &deblocked].map(|whole| zoom(whole, window)));
    let mapped = primaries(size, coordinates);
    let close = beside(&[&full, &mapped].map(|whole| zoom(whole, window)));
    let pictures = [
        ("overview.png", side_by_side(&[&full, &rates, &variable])),
        ("full.png", full),
        ("variable.png", variable),
        ("rates.png", rates),
        ("deblocked.png", deblocked),
        ("zoom.png", zoomed),
        ("primaries.png", mapped),
        ("primaries_zoom.png", close),
        ("classes.png", classes(size, coordinates, shaded.full)),
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

/// The side of the windows that are shown at four times their size.
const WINDOW: [u32; 2] = [112, 96];
const ZOOM: u32 = 4;

/// A part of a picture: left, top, width and height.
type Window = [u32; 4];

/// Where the deblocker changed most, and so has most to show.
fn busiest(size: [u32; 2], shaded: &Shaded) -> Window {
    let [width, height] = [0, 1].map(|axis| WINDOW[axis].min(size[axis]));
    let change = |x: u32, y: u32| {
        let at = ((y * size[0] + x) * 4) as usize;
        (at..at + 3)
            .map(|i| u64::from(shaded.variable[i].abs_diff(shaded.deblocked[i])))
            .sum::<u64>()
    };
    // windows half of which overlap; of each, every second pixel
    let across = (0..=size[0] - width).step_by(width.div_ceil(2) as usize);
    let windows = across.flat_map(|left| {
        (0..=size[1] - height)
            .step_by(height.div_ceil(2) as usize)
            .map(move |top| [left, top, width, height])
    });
    let busy = |&[left, top, width, height]: &Window| {
        (top..top + height)
            .step_by(2)
            .flat_map(|y| (left..left + width).map(move |x| (x, y)))
            .map(|(x, y)| change(x, y))
            .sum::<u64>()
    };
    windows.max_by_key(busy).unwrap_or([0, 0, width, height])
}

/// A window of a picture, every pixel a square.
fn zoom(whole: &RgbaImage, [left, top, width, height]: Window) -> RgbaImage {
    RgbaImage::from_fn(width * ZOOM, height * ZOOM, |x, y| {
        *whole.get_pixel(left + x / ZOOM, top + y / ZOOM)
    })
}

/// Pictures of one size in a row, with white lines between.
fn beside(pictures: &[RgbaImage]) -> RgbaImage {
    let (width, height) = pictures[0].dimensions();
    let gap = 4;
    let count = pictures.len() as u32;
    let white = Rgba([255; 4]);
    let mut row = RgbaImage::from_pixel(width * count + gap * (count - 1), height, white);
    for (index, picture) in (0..).zip(pictures) {
        imageops::replace(&mut row, picture, i64::from((width + gap) * index), 0);
    }
    row
}

/// The colour of a tile's class.
fn class_color(coordinates: &Coordinates, tile: u32) -> [u8; 3] {
    let header = coordinates.header(tile);
    let at = [
        tile % coordinates.layout.tiles[0],
        tile / coordinates.layout.tiles[0],
    ];
    // quads of the tile that are in the picture
    let quads: u32 = [0, 1]
        .map(|axis| {
            let side = coordinates.options.tile[axis];
            (coordinates.extent[axis] - at[axis] * side)
                .min(side)
                .div_ceil(2)
        })
        .iter()
        .product();
    // a tile all of whose quads share
    let is_coarse = header.count() == quads;
    match (header.is_identity(), header.count()) {
        (true, _) => [235, 200, 60],
        (false, 0) => [60, 90, 150],
        _ if is_coarse => [60, 175, 90],
        _ => [200, 90, 150],
    }
}

/// The class of each tile over the picture: identity yellow (as in the slides), uniformly 2x2 green, mixed magenta, nothing to do
/// blue.
fn classes(size: [u32; 2], coordinates: &Coordinates, full: &[u8]) -> RgbaImage {
    let [width, height] = size;
    let [tile_width, tile_height] = coordinates.options.tile;
    RgbaImage::from_fn(width, height, |x, y| {
        let tile = y / tile_height * coordinates.layout.tiles[0] + x / tile_width;
        let color = class_color(coordinates, tile);
        let is_edge = x % tile_width == 0 || y % tile_height == 0;
        let at = ((y * width + x) * 4) as usize;
        let shown: [u8; 3] = std::array::from_fn(|i| {
            let mixed = (u16::from(color[i]) * 13 + u16::from(full[at + i]) * 7) / 20;
            (mixed / if is_edge { 2 } else { 1 }) as u8
        });
        Rgba([shown[0], shown[1], shown[2], 255])
    })
}

/// Primaries and duplicates, in the slides' manner ("VRCS 16x16 Tile Debug"): tiles in which every pixel is its own primary are yellow,
/// those that are one rate throughout green.
fn primaries(size: [u32; 2], coordinates: &Coordinates) -> RgbaImage {
    let [width, height] = size;
    let map = coordinates.map();
    let [tile_width, tile_height] = coordinates.options.tile;
    RgbaImage::from_fn(width, height, |x, y| {
        let tile = y / tile_height * coordinates.layout.tiles[0] + x / tile_width;
        let is_edge = x % tile_width == 0 || y % tile_height == 0;
        let index = y * width + x;
        let header = coordinates.header(tile);
        let is_primary = map[index as usize] == index;
        let color = match (header.is_identity(), header.is_uniform(), is_primary) {
            (true, ..) => [235, 200, 60],
            (_, true, true) => [80, 200, 120],
            (_, true, false) => [30, 66, 44],
            (_, _, true) => [70, 150, 230],
            (_, _, false) => [38, 44, 58],
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
