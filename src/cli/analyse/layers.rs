//! Motion, depth and matrices from files.
//!
//! Motion vectors are two channels of an EXR, in pixels, from where a surface was to where it is, y down: the channels `X` and
//! `Y`, `U` and `V`, or `R` and `G`, under any layer's name. Depth is one channel, 0 to 1: `Z`, `depth`, `R` or `Y`.

use std::{io::Cursor, path::Path};

use exr::prelude::{ReadChannels, ReadLayers};
use glam::DMat4;
use serde::Deserialize;

use crate::cli::{Failure, files};

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

/// Depth of a picture of a size.
pub(super) fn depth(path: &Path, size: [u32; 2]) -> Result<Vec<f32>, Failure> {
    let channels = read(path, size)?;
    let mut found = pick(path, &channels, &[&["Z"], &["DEPTH"], &["R"], &["Y"]])?;
    Ok(found.swap_remove(0))
}

/// The matrices' file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    view_projection: [[f64; 4]; 4],
    previous_view_projection: [[f64; 4]; 4],
}

/// The world to clip space, now and before: four rows of four numbers each, for column vectors.
pub(super) fn matrices(path: &Path) -> Result<[DMat4; 2], Failure> {
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
        true => Ok(both),
        false => Err(Failure::Outside(format!("{name}: a matrix has no inverse"))),
    }
}
