//! `vrcs analyse` and `vrcs plan` as a user runs them.

mod everything;
mod files;
mod inputs;
mod refusals;

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use image::{DynamicImage, Luma, Rgb, Rgb32FImage, RgbImage};
use vrcs::{
    scenes::SceneName,
    tradeoff::{realise::realise, setting::presets},
};

fn vrcs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vrcs"))
        .arg("analyse")
        .args(arguments)
        .output()
        .expect("the program")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn at(folder: &tempfile::TempDir, name: &str) -> String {
    folder.path().join(name).display().to_string()
}

/// Left: plain grey; right: vertical stripes. Not a whole number of tiles.
fn picture() -> RgbImage {
    RgbImage::from_fn(70, 37, |x, _| match (x >= 32, x % 2) {
        (true, 0) => Rgb([20, 20, 20]),
        (true, _) => Rgb([230, 230, 230]),
        (false, _) => Rgb([120, 120, 120]),
    })
}

fn grey(path: impl AsRef<Path>) -> image::GrayImage {
    match image::open(path).expect("a picture") {
        DynamicImage::ImageLuma8(grey) => grey,
        other => panic!("{:?}", other.color()),
    }
}

/// An error is one line that names the file, with a status, and leaves nothing behind.
fn assert_error(output: &Output, status: i32, words: &[&str], folder: &tempfile::TempDir) {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    for word in words {
        assert!(error.contains(word), "{word}: {error}");
    }
    assert!(output.stdout.is_empty());
    let left: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.display().to_string().contains(".vrcs-"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

/// A picture as an EXR.
fn save_exr(path: &str, picture: &Rgb32FImage) {
    let channel = |number: usize| picture.pixels().map(|pixel| pixel.0[number]).collect();
    let size = [picture.width(), picture.height()];
    exr(
        path,
        size,
        &[("R", channel(0)), ("G", channel(1)), ("B", channel(2))],
    );
}

/// An EXR of channels of a layer, row by row.
fn exr(path: &str, size: [u32; 2], channels: &[(&str, Vec<f32>)]) {
    use exr::prelude::*;
    let list: Vec<AnyChannel<FlatSamples>> = channels
        .iter()
        .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone())))
        .collect();
    let layer = Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::named("frame"),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list.into()),
    );
    Image::from_layer(layer)
        .write()
        .to_file(path)
        .expect("an EXR");
}
