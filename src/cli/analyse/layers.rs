//! What belongs to a picture, from files: motion, depth, the width of a blur, matrices, bytes of pixels, rates.
//!
//! Motion vectors are two channels of an EXR, in pixels, from where a surface was to where it is, y down: the channels `X` and
//! `Y`, `U` and `V`, or `R` and `G`, under any layer's name. Depth is one channel, 0 to 1: `Z`, `depth`, `R` or `Y`; a blur's width, in
//! pixels, `blur`, `coc`, or the same. Bytes are pictures of eight bits a channel, taken as they are.

use std::{io::Cursor, path::Path};

use exr::prelude::{ReadChannels, ReadLayers};
use glam::DMat4;
use image::{DynamicImage, ImageReader};
use serde::Deserialize;

use crate::{
    Rate,
    analyse::Cameras,
    cli::{Failure, files},
    sri::{Sri, SriLayout},
};

/// One channel: its name without its layer's, in capitals, and its values row by row.
struct Channel {
    name: String,
    values: Vec<f32>,
}

fn read(path: &Path, size: [u32; 2]) -> Result<Vec<Channel>, Failure> {
    let bytes = files::read_bytes(path)?;
    let name = files::display_name(path);
    let outside = |why: String| Failure::Outside(format!("{name}: {why}"));
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| {
            outside(format!(
                "the EXR cannot be read: {}",
                error.to_string().replace('\n', " ")
            ))
        })?;
    let layer = image.layer_data;
    let found = [layer.size.x() as u32, layer.size.y() as u32];
    if found != size {
        return Err(outside(format!(
            "it has {}x{} pixels, and its picture {}x{}",
            found[0], found[1], size[0], size[1]
        )));
    }
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let name = channel.name.to_string();
        let short = name.rsplit('.').next().unwrap_or_default();
        Channel {
            name: short.to_uppercase(),
            values: channel.sample_data.values_as_f32().collect(),
        }
    });
    Ok(channels.collect())
}

fn pick(path: &Path, channels: &[Channel], sets: &[&[&str]]) -> Result<Vec<Vec<f32>>, Failure> {
    let get = |name: &&str| channels.iter().find(|channel| channel.name == *name);
    let found = sets
        .iter()
        .find_map(|set| set.iter().map(get).collect::<Option<Vec<_>>>());
    match found {
        Some(found) => Ok(found
            .into_iter()
            .map(|channel| channel.values.clone())
            .collect()),
        None => {
            let has: Vec<&str> = channels
                .iter()
                .map(|channel| channel.name.as_str())
                .collect();
            let wanted: Vec<String> = sets.iter().map(|set| set.join(" and ")).collect();
            Err(Failure::Outside(format!(
                "{}: it has the channels {}; {} were looked for",
                files::display_name(path),
                has.join(", "),
                wanted.join(", or ")
            )))
        }
    }
}

/// Motion vectors of a picture of a size.
pub(super) fn motion(path: &Path, size: [u32; 2]) -> Result<Vec<[f32; 2]>, Failure> {
    let channels = read(path, size)?;
    let found = pick(path, &channels, &[&["X", "Y"], &["U", "V"], &["R", "G"]])?;
    Ok(found[0]
        .iter()
        .zip(&found[1])
        .map(|(&x, &y)| [x, y])
        .collect())
}

/// One number for each pixel of a picture of a size: depth, or the width of a blur.
pub(super) fn number(path: &Path, size: [u32; 2]) -> Result<Vec<f32>, Failure> {
    let channels = read(path, size)?;
    let names: [&[&str]; 6] = [&["Z"], &["DEPTH"], &["BLUR"], &["COC"], &["R"], &["Y"]];
    let mut found = pick(path, &channels, &names)?;
    Ok(found.swap_remove(0))
}

/// A picture of eight bits a channel, of a size.
fn deep_as_bytes(path: &Path, size: [u32; 2]) -> Result<DynamicImage, Failure> {
    let bytes = files::read_bytes(path)?;
    let name = files::display_name(path);
    let outside = |why: String| Failure::Outside(format!("{name}: {why}"));
    let picture = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| outside(error.to_string()))?
        .decode()
        .map_err(|error| outside(format!("it cannot be read: {error}").replace('\n', " ")))?;
    let found = [picture.width(), picture.height()];
    if found != size {
        return Err(outside(format!(
            "it has {}x{} pixels, and {}x{} are wanted",
            found[0], found[1], size[0], size[1]
        )));
    }
    match picture {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => Ok(picture),
        _ => Err(outside("it has no eight bits a channel".to_owned())),
    }
}

/// A byte for each pixel of a picture of a size: its grey, or its red.
pub(super) fn bytes(path: &Path, size: [u32; 2]) -> Result<Vec<u8>, Failure> {
    let rgba = deep_as_bytes(path, size)?.into_rgba8();
    Ok(rgba.pixels().map(|pixel| pixel.0[0]).collect())
}

/// Smoothness and Rf0 of a picture of a size: red and green.
pub(super) fn materials(path: &Path, size: [u32; 2]) -> Result<Vec<[u8; 2]>, Failure> {
    let picture = deep_as_bytes(path, size)?;
    if !picture.color().has_color() {
        return Err(Failure::Outside(format!(
            "{}: it is grey; smoothness is red, and Rf0 green",
            files::display_name(path)
        )));
    }
    let rgb = picture.into_rgb8();
    Ok(rgb.pixels().map(|pixel| [pixel.0[0], pixel.0[1]]).collect())
}

/// Rates of a picture of a size, as `-o` writes them.
pub(super) fn rates(path: &Path, [width, height]: [u32; 2]) -> Result<Sri, Failure> {
    let layout = SriLayout::new(width, height);
    let codes = bytes(path, [layout.width, layout.height])?;
    let at = |x: u32, y: u32| codes[(y * layout.width + x) as usize];
    if let Some(&code) = codes.iter().find(|&&code| Rate::from_code(code).is_none()) {
        return Err(Failure::Outside(format!(
            "{}: {code} is no code of a rate",
            files::display_name(path)
        )));
    }
    Ok(Sri::from_fn(width, height, at))
}

/// The matrices' file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    view_projection: [[f64; 4]; 4],
    previous_view_projection: [[f64; 4]; 4],
}

/// The world to clip space, now and before: four rows of four numbers each, for column vectors.
pub(super) fn matrices(path: &Path) -> Result<Cameras, Failure> {
    let text = files::read_text(path)?;
    let name = files::display_name(path);
    let file: File = serde_json::from_str(&text).map_err(|error| {
        let why = error.to_string();
        let why = why.split(" at line").next().unwrap_or_default();
        Failure::Outside(format!("{name}:{}: {why}", error.line()))
    })?;
    let both = [file.view_projection, file.previous_view_projection]
        .map(|rows| DMat4::from_cols_array_2d(&rows).transpose());
    match both.iter().all(|m| m.is_finite() && m.determinant() != 0.0) {
        true => Ok(Cameras {
            now: both[0],
            before: both[1],
        }),
        false => Err(Failure::Outside(format!("{name}: a matrix has no inverse"))),
    }
}
