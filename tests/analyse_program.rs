//! `vrcs analyse` as a user runs it.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use image::{DynamicImage, ImageFormat, Luma, Rgb, Rgb32FImage, RgbImage};

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

#[test]
fn a_plain_picture_is_coarse_everywhere() {
    let folder = folder();
    let input = at(&folder, "in.png");
    RgbImage::from_pixel(64, 32, Rgb([90, 90, 90]))
        .save(&input)
        .expect("a picture");
    let output = vrcs(&[&input]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(said.contains("2x2 100.0 %"), "{said}");
    assert!(said.contains("25.0 % of the invocations"), "{said}");
}

#[test]
fn the_files_hold_codes_of_quads_and_texels_of_tiles() {
    let folder = folder();
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let (sri, tiles, overlay) = (
        at(&folder, "sri.png"),
        at(&folder, "tiles.png"),
        at(&folder, "overlay.png"),
    );
    for (kind, coarse, striped) in [("d3d12", 5, 1), ("khr", 5, 1), ("nv", 8, 7)] {
        let output = vrcs(&[
            &input,
            "-o",
            &sri,
            "--attachment",
            kind,
            "--tile",
            "8",
            "--attachment-output",
            &tiles,
            "--overlay",
            &overlay,
        ]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let sri = grey(&sri);
        assert_eq!(sri.dimensions(), (35, 19));
        assert_eq!(*sri.get_pixel(4, 4), Luma([5]), "2x2");
        assert_eq!(*sri.get_pixel(30, 4), Luma([1]), "1x2");
        let tiles = grey(&tiles);
        assert_eq!(tiles.dimensions(), (9, 5));
        assert_eq!(*tiles.get_pixel(0, 0), Luma([coarse]), "{kind}");
        assert_eq!(*tiles.get_pixel(8, 4), Luma([striped]), "{kind}");
        let shown = image::open(&overlay).expect("a picture");
        assert_eq!((shown.width(), shown.height()), (70, 37));
    }
}

#[test]
fn json_has_shares_that_sum_to_one() {
    let folder = folder();
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let tiles = at(&folder, "tiles.png");
    let output = vrcs(&[
        &input,
        "--json",
        "--attachment",
        "khr",
        "--attachment-output",
        &tiles,
    ]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for rates in [&json["rates"], &json["attachment"]["rates"]] {
        let shares = rates.as_object().expect("an object");
        assert_eq!(shares.len(), 7);
        let sum: f64 = shares
            .values()
            .map(|share| share.as_f64().expect("a share"))
            .sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
    assert_eq!(json["width"], 70);
    assert_eq!(json["attachment"]["tile"], 16);
}

#[test]
fn every_format_can_be_read_and_means_the_same() {
    let folder = folder();
    let picture = picture();
    // linear light of the same picture
    let linear = Rgb32FImage::from_fn(picture.width(), picture.height(), |x, y| {
        Rgb(picture
            .get_pixel(x, y)
            .0
            .map(|code| vrcs::analyse::luma::from_srgb(f64::from(code) / 255.0) as f32))
    });
    let deep = DynamicImage::ImageRgb8(picture.clone()).to_rgb16();
    let files = [
        ("in.png", DynamicImage::ImageRgb8(picture.clone())),
        ("deep.png", DynamicImage::ImageRgb16(deep)),
        ("in.exr", DynamicImage::ImageRgb32F(linear.clone())),
        ("in.hdr", DynamicImage::ImageRgb32F(linear)),
        ("in.jpg", DynamicImage::ImageRgb8(picture)),
    ];
    let mut found = Vec::new();
    for (name, image) in files {
        let input = at(&folder, name);
        image.save(&input).expect("a picture");
        let output = vrcs(&[&input, "--json"]);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{name}: {}",
            text(&output.stderr)
        );
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        found.push((name, json["rates"].clone()));
    }
    // JPEG rings beside the stripes; all others are the same picture
    for (name, rates) in &found[1..4] {
        assert_eq!(*rates, found[0].1, "{name}");
    }
}

#[test]
fn a_pixel_that_is_no_number_is_shaded_at_full_rate() {
    let folder = folder();
    let input = at(&folder, "in.exr");
    let mut image = Rgb32FImage::from_pixel(64, 64, Rgb([0.2, 0.2, 0.2]));
    image.put_pixel(20, 20, Rgb([f32::NAN, 0.2, 0.2]));
    image.put_pixel(40, 40, Rgb([f32::INFINITY, 0.2, 0.2]));
    DynamicImage::ImageRgb32F(image)
        .save_with_format(&input, ImageFormat::OpenExr)
        .expect("a picture");
    let sri = at(&folder, "sri.png");
    let output = vrcs(&[&input, "-o", &sri]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let sri = grey(&sri);
    assert_eq!(*sri.get_pixel(10, 10), Luma([0]));
    assert_eq!(*sri.get_pixel(20, 20), Luma([0]));
    assert_eq!(*sri.get_pixel(0, 0), Luma([5]));
    assert_eq!(*sri.get_pixel(31, 31), Luma([5]));
}

#[test]
fn errors_are_one_line_and_leave_nothing_behind() {
    let folder = folder();
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let text_file = at(&folder, "text.png");
    std::fs::write(&text_file, "no picture").expect("a file");
    let broken = at(&folder, "broken.png");
    let whole = std::fs::read(&input).expect("a file");
    std::fs::write(&broken, &whole[..60]).expect("a file");
    let missing = at(&folder, "missing.png");
    let out = at(&folder, "sri.png");
    let nowhere = at(&folder, "none/sri.png");

    assert_error(&vrcs(&[&missing]), 3, &[&missing, "no such file"], &folder);
    assert_error(
        &vrcs(&[&text_file]),
        3,
        &[&text_file, "no picture"],
        &folder,
    );
    assert_error(
        &vrcs(&[&broken, "-o", &out]),
        3,
        &[&broken, "cannot be read"],
        &folder,
    );
    assert_error(&vrcs(&[&input, "-o", &input]), 2, &["overwrite"], &folder);
    assert_error(
        &vrcs(&[&input, "-o", &out, "--overlay", &out]),
        2,
        &["one file"],
        &folder,
    );
    assert_error(
        &vrcs(&[&input, "--threshold", "NaN"]),
        2,
        &["threshold"],
        &folder,
    );
    // the first output is fine, the second is not: neither appears
    let failed = vrcs(&[&input, "-o", &out, "--overlay", &nowhere]);
    assert_error(&failed, 3, &[&nowhere, "no such folder"], &folder);
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_misused_option_says_what_it_takes() {
    let folder = folder();
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let cases: [(&[&str], &str); 4] = [
        (&["--attachment", "khr"], "--attachment-output"),
        (
            &[
                "--tile",
                "12",
                "--attachment",
                "khr",
                "--attachment-output",
                "t.png",
            ],
            "8, 16 or 32",
        ),
        (
            &[
                "--samples",
                "3",
                "--attachment",
                "khr",
                "--attachment-output",
                "t.png",
            ],
            "1, 2, 4, 8 or 16",
        ),
        (&["--largest", "4x1"], "1x1, 1x2, 2x1"),
    ];
    for (options, wanted) in cases {
        let mut arguments = vec![input.as_str()];
        arguments.extend_from_slice(options);
        let output = vrcs(&arguments);
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        let error = text(&output.stderr);
        assert!(error.contains(wanted), "{options:?}: {error}");
    }
}
