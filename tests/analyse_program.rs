//! `vrcs analyse` as a user runs it.

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
    assert_eq!(json["k"], 2.13);
    assert_eq!(json["width"], 70);
    assert_eq!(json["attachment"]["tile"], 16);
}

#[test]
fn k_is_refitted_to_the_picture_itself() {
    let folder = folder();
    let input = at(&folder, "in.png");
    let k_of = |picture: RgbImage| -> f64 {
        picture.save(&input).expect("a picture");
        let output = vrcs(&[&input, "--refit-k", "--json"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        json["k"].as_f64().expect("a number")
    };
    // white noise is rougher than nature, a ramp smoother; 2.13 is nature's
    let rough = k_of(RgbImage::from_fn(64, 64, |x, y| {
        let h = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
        image::Rgb([((h ^ h >> 15).wrapping_mul(0x2c1b_3c6d) >> 24) as u8; 3])
    }));
    let smooth = k_of(RgbImage::from_fn(64, 64, |x, _| {
        image::Rgb([x as u8 * 3; 3])
    }));
    assert!(rough < 2.13 && 2.13 < smooth, "{rough} {smooth}");
    RgbImage::from_pixel(8, 8, image::Rgb([9; 3]))
        .save(&input)
        .expect("a picture");
    assert_error(
        &vrcs(&[&input, "--refit-k"]),
        1,
        &["refitted", "no differences"],
        &folder,
    );
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
        match image {
            DynamicImage::ImageRgb32F(linear) if name.ends_with(".exr") => {
                save_exr(&input, &linear)
            }
            image => image.save(&input).expect("a picture"),
        }
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
    save_exr(&input, &image);
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

// a tile is judged by its own pixels: a line that its quads see is none of its error, unless they are asked
#[test]
fn the_attachment_is_by_tiles_or_by_quads_and_supersamples_for_nv_alone() {
    let folder = folder();
    let input = at(&folder, "in.png");
    let picture = RgbImage::from_fn(64, 64, |x, y| match (x, y) {
        (_, 48..) => image::Rgb([if (x + y) % 2 == 0 { 0 } else { 255 }; 3]),
        (21, _) => image::Rgb([190; 3]),
        _ => image::Rgb([150; 3]),
    });
    picture.save(&input).expect("a picture");
    let (by_quads, tiles) = (at(&folder, "quads.toml"), at(&folder, "tiles.png"));
    std::fs::write(&by_quads, "attachment = \"quad\"\n").expect("settings");
    let texels = |more: &[&str]| -> [u8; 2] {
        let mut arguments = vec![input.as_str(), "--attachment-output", &tiles];
        arguments.extend_from_slice(more);
        let output = vrcs(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let tiles = grey(&tiles);
        [(1, 0), (1, 3)].map(|(x, y)| tiles.get_pixel(x, y).0[0])
    };
    for more in [&[][..], &["--cpu"]] {
        let with = |set: &[&'static str]| [set, more].concat();
        assert_eq!(texels(&with(&["--attachment", "khr"])), [5, 0]);
        let quads = [&["--settings", &by_quads, "--attachment", "khr"], more].concat();
        assert_eq!(texels(&quads), [1, 0], "1x2, beside the line");
        // 2x2 is 8 in the palette, four samples 3; at two samples 4
        let four = ["--attachment", "nv", "--supersample", "4", "--samples", "4"];
        assert_eq!(texels(&with(&four)), [8, 3]);
        let two = ["--attachment", "nv", "--supersample", "4", "--samples", "2"];
        assert_eq!(texels(&with(&two)), [8, 4]);
    }
    let output = vrcs(&[
        &input,
        "--attachment",
        "khr",
        "--supersample",
        "4",
        "--attachment-output",
        &tiles,
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("--supersample needs --attachment nv"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn the_gpu_and_the_cpu_write_the_same_files() {
    let folder = folder();
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let sets: [&[&str]; 5] = [
        &[],
        &["--estimator", "gdc", "--largest", "4x4"],
        &[
            "--norm",
            "linf",
            "--smoothing",
            "limit",
            "--granularity",
            "8",
        ],
        &["--luma-source", "root", "--derivatives", "sub-sampled"],
        &["--estimator", "sobel", "--difference", "rgb", "--k", "3"],
    ];
    for set in sets {
        let files = [["a.png", "a-why.png"], ["b.png", "b-why.png"]]
            .map(|names| names.map(|n| at(&folder, n)));
        let mut shares = Vec::new();
        for (names, more) in files.iter().zip([&[][..], &["--cpu"]]) {
            let mut arguments = vec![
                input.as_str(),
                "--json",
                "-o",
                &names[0],
                "--reasons",
                &names[1],
            ];
            arguments.extend_from_slice(set);
            arguments.extend_from_slice(more);
            let output = vrcs(&arguments);
            assert!(output.status.success(), "{set:?}: {}", text(&output.stderr));
            shares.push(text(&output.stdout));
        }
        assert_eq!(shares[0], shares[1], "{set:?}");
        for (gpu, cpu) in files[0].iter().zip(&files[1]) {
            assert_eq!(grey(gpu), grey(cpu), "{set:?}");
        }
    }
}

#[test]
fn the_frame_before_is_fetched_along_motion_and_what_was_hidden_is_fine() {
    let folder = folder();
    let size = [64u32, 32];
    // stripes from column 32 on; this frame, all has moved 16 pixels to the left
    let before = RgbImage::from_fn(64, 32, |x, _| match (x >= 32, x % 2) {
        (true, 0) => Rgb([20, 20, 20]),
        (true, _) => Rgb([230, 230, 230]),
        (false, _) => Rgb([120, 120, 120]),
    });
    let names = [
        "now.png",
        "before.png",
        "motion.exr",
        "depth.exr",
        "depth0.exr",
        "sri.png",
        "why.png",
    ];
    let [now, old, motion, depth, depth0, sri, why] = names.map(|name| at(&folder, name));
    before.save(&old).expect("a picture");
    RgbImage::new(64, 32).save(&now).expect("a picture");
    let count = 64 * 32;
    // so slow across that no blur hides it, were it not for its scale
    exr(
        &motion,
        size,
        &[("v.X", vec![-16.0; count]), ("v.Y", vec![0.0; count])],
    );
    exr(&depth, size, &[("Z", vec![0.5; count])]);
    // the lower half was covered by something near
    exr(
        &depth0,
        size,
        &[(
            "Z",
            (0..count)
                .map(|i| if i < count / 2 { 0.5 } else { 0.9 })
                .collect(),
        )],
    );
    let arguments = [
        now.as_str(),
        "--previous",
        &old,
        "--motion",
        &motion,
        "--depth",
        &depth,
        "--previous-depth",
        &depth0,
        "-o",
        &sri,
        "--reasons",
        &why,
    ];
    let mut seen = Vec::new();
    for more in [&[][..], &["--cpu"]] {
        let all: Vec<&str> = arguments
            .iter()
            .copied()
            .chain(more.iter().copied())
            .collect();
        let output = vrcs(&all);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let (rates, why) = (grey(&sri), grey(&why));
        assert_eq!(*rates.get_pixel(4, 3), Luma([5]), "plain");
        assert_eq!(*why.get_pixel(28, 3), Luma([4]), "it came from outside");
        assert_eq!(*why.get_pixel(4, 12), Luma([5]), "it was hidden");
        assert_eq!(*rates.get_pixel(4, 12), Luma([0]));
        seen.push((rates, why));
    }
    assert_eq!(seen[0], seen[1]);
}

#[test]
fn motion_of_the_camera_comes_from_depth_and_matrices() {
    let folder = folder();
    let names = ["now.png", "depth.exr", "still.json", "fast.json", "sri.png"];
    let [now, depth, still, fast, sri] = names.map(|name| at(&folder, name));
    picture().save(&now).expect("a picture");
    exr(&depth, [70, 37], &[("Z", vec![0.5; 70 * 37])]);
    let unit = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
    // a step of 0.4 in a picture that is 2 wide: 14 pixels
    let moved = "[[1,0,0,0.4],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
    for (path, before) in [(&still, unit), (&fast, moved)] {
        let json =
            format!("{{\"view_projection\": {unit}, \"previous_view_projection\": {before}}}");
        std::fs::write(path, json).expect("a file");
    }
    for (matrices, wanted) in [(&still, 1), (&fast, 5)] {
        let output = vrcs(&[&now, "--depth", &depth, "--matrices", matrices, "-o", &sri]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(
            *grey(&sri).get_pixel(25, 5),
            Luma([wanted]),
            "stripes across"
        );
    }
}

#[test]
fn inputs_that_do_not_fit_are_one_line_that_says_which() {
    let folder = folder();
    let names = [
        "in.png",
        "small.exr",
        "odd.exr",
        "text.exr",
        "bad.json",
        "flat.json",
        "good.exr",
        "typo.toml",
        "tiles.toml",
        "stated.toml",
        "small.png",
        "out.png",
    ];
    let names = names.map(|name| at(&folder, name));
    let [
        input,
        small,
        odd,
        text_file,
        bad,
        flat,
        good,
        typo,
        tiles,
        stated,
        small_png,
        out,
    ] = names;
    RgbImage::new(4, 4).save(&small_png).expect("a picture");
    picture().save(&input).expect("a picture");
    exr(
        &small,
        [4, 4],
        &[("X", vec![0.0; 16]), ("Y", vec![0.0; 16])],
    );
    exr(&odd, [70, 37], &[("Q", vec![0.0; 70 * 37])]);
    exr(&good, [70, 37], &[("Z", vec![0.0; 70 * 37])]);
    std::fs::write(&text_file, "no picture").expect("a file");
    std::fs::write(&bad, "{\n\"view_projection\": 3}").expect("a file");
    let zero = "[[0,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
    std::fs::write(
        &flat,
        format!("{{\"view_projection\": {zero}, \"previous_view_projection\": {zero}}}"),
    )
    .expect("a file");
    let input = input.as_str();
    std::fs::write(&typo, "[content]\ntreshold = 0.1\n").expect("a file");
    std::fs::write(&tiles, "[reprojection]\nfetch = \"tile\"\n").expect("a file");
    std::fs::write(&stated, "[own.ids]\nrates = { 1 = \"2x2\" }\n").expect("a file");
    let cases: [(&[&str], i32, &[&str]); 18] = [
        (&["--motion", &small], 3, &["small.exr", "4x4", "70x37"]),
        (&["--motion", &odd], 3, &["odd.exr", "Q", "X and Y"]),
        (
            &["--motion", &text_file],
            3,
            &["text.exr", "cannot be read"],
        ),
        (&["--depth", &good], 2, &["--previous and --motion"]),
        (
            &["--depth", &good, "--previous-depth", &good],
            2,
            &["--previous"],
        ),
        (&["--depth", &good, "--matrices", &bad], 3, &["bad.json:2"]),
        (
            &["--depth", &good, "--matrices", &flat],
            3,
            &["flat.json", "no inverse"],
        ),
        (&["--estimator", "wicked"], 2, &["--motion"]),
        (&["--white", "3"], 2, &["power of two"]),
        (&["--k", "0.5"], 2, &["factor k", "from 1 to 15"]),
        (&["--settings", &typo], 3, &["typo.toml:2", "treshold"]),
        (&["--settings", &tiles], 2, &["--previous"]),
        (&["--settings", &stated], 2, &["--ids"]),
        (&["--ids", input], 2, &["own.ids"]),
        (
            &["--materials", &small_png],
            3,
            &["small.png", "4x4", "70x37"],
        ),
        (&["--previous-rates", input], 3, &["in.png", "35x19"]),
        (&["--plain-output", &out], 2, &["extra half rate"]),
        (&["--resolution-scale", "0"], 2, &["above 0"]),
    ];
    for (options, status, words) in cases {
        let mut arguments = vec![input];
        arguments.extend_from_slice(options);
        // clap's own errors have a usage line, and are told apart by their status
        let output = vrcs(&arguments);
        match text(&output.stderr).contains("For more information") {
            true => assert!(text(&output.stderr).contains(words[0]), "{options:?}"),
            false => assert_error(&output, status, words, &folder),
        }
    }
}

/// A file beside the picture, the settings, what is asked for, and a quad with its code and reason.
type Known = (
    &'static str,
    &'static str,
    &'static [&'static str],
    [u32; 2],
    [u8; 2],
);

/// Everything that the analysis can be given, by the names that `everything_the_library_is_given_has_a_file` writes.
const KNOWN: &[Known] = &[
    (
        "transparents make stripes coarse",
        "",
        &["--after", "plain.png"],
        [25, 5],
        [5, 0],
    ),
    (
        "a mirror is at full rate",
        "",
        &["--materials", "mirror.png"],
        [4, 4],
        [0, 6],
    ),
    (
        "noise asks for the extra half rate",
        "[half-rate]\ntolerance = 0.0\n",
        &["--noise", "white.png"],
        [4, 4],
        [4, 8],
    ),
    (
        "a material states its rate",
        "[own.ids]\ncombiner = \"override\"\nrates = { 255 = \"2x1\" }\n",
        &["--ids", "white.png"],
        [25, 5],
        [4, 11],
    ),
    (
        "a head-up display is masked",
        "",
        &["--mask", "white.png"],
        [4, 4],
        [0, 7],
    ),
    (
        "particles state their rate",
        "[own.particles]\nrate = \"2x2\"\n",
        &["--flags", "particles.png"],
        [25, 5],
        [5, 11],
    ),
    (
        "what was coarse may stay coarse",
        "stability = \"compensate\"\n",
        &["--previous-rates", "coarse.png", "--threshold", "1.5"],
        [25, 5],
        [5, 0],
    ),
    (
        "a later blur hides stripes",
        "",
        &["--blur", "blur.exr"],
        [25, 5],
        [5, 0],
    ),
    (
        "a lens out of focus hides them",
        "[lens]\nfocus = 1.0\ninfinity = 20.0\nmost = 20.0\n",
        &["--depth", "far.exr"],
        [25, 5],
        [5, 0],
    ),
    (
        "what is far may be coarse",
        "[own.distance]\nsteps = [[10.0, \"2x2\"]]\n",
        &["--depth", "far.exr"],
        [25, 5],
        [5, 11],
    ),
    (
        "tiles are fetched by the camera",
        "[reprojection]\nfetch = \"tile\"\n",
        &[
            "--previous",
            "in.png",
            "--depth",
            "half.exr",
            "--matrices",
            "still.json",
        ],
        [30, 5],
        [1, 1],
    ),
    (
        "a motion that is no number is missing",
        "",
        &["--motion", "none.exr"],
        [25, 5],
        [1, 12],
    ),
    (
        "the synopsis: what was hidden by what can be seen",
        "",
        &[
            "--previous",
            "in.png",
            "--motion",
            "post.exr",
            "--depth",
            "post_depth.exr",
        ],
        [8, 5],
        [0, 5],
    ),
    (
        "foveation follows the dynamic resolution",
        "[foveation]\nfalloff = [[0.0, 15.0]]\n",
        &["--resolution-scale", "0.5", "--threshold", "0.9"],
        [25, 5],
        [5, 0],
    ),
];

#[test]
fn everything_the_library_is_given_has_a_file() {
    let folder = folder();
    let size = [70u32, 37];
    let count = 70 * 37;
    let input = at(&folder, "in.png");
    picture().save(&input).expect("a picture");
    let fill = |name: &str, colour: [u8; 3]| {
        let path = at(&folder, name);
        RgbImage::from_pixel(70, 37, Rgb(colour))
            .save(path)
            .expect("a picture");
    };
    fill("plain.png", [120; 3]);
    fill("mirror.png", [255, 255, 0]);
    fill("white.png", [255; 3]);
    fill("particles.png", [8; 3]);
    image::GrayImage::from_pixel(35, 19, Luma([5]))
        .save(at(&folder, "coarse.png"))
        .expect("a picture");
    let whole = |name: &str, channels: &[(&str, f32)]| {
        let channels: Vec<(&str, Vec<f32>)> = channels
            .iter()
            .map(|&(name, value)| (name, vec![value; count]))
            .collect();
        exr(&at(&folder, name), size, &channels);
    };
    whole("blur.exr", &[("blur", 20.0)]);
    whole("far.exr", &[("Z", 0.002)]);
    whole("half.exr", &[("Z", 0.5)]);
    whole("none.exr", &[("X", f32::NAN), ("Y", 0.0)]);
    // a post at rest before a wall that moves six pixels to the left
    let at_post = |i: usize| (20..30).contains(&(i % 70));
    let by = |post: f32, wall: f32| -> Vec<f32> {
        let of = |i| if at_post(i) { post } else { wall };
        (0..count).map(of).collect()
    };
    let vectors = [("X", by(0.0, -6.0)), ("Y", vec![0.0; count])];
    exr(&at(&folder, "post.exr"), size, &vectors);
    exr(&at(&folder, "post_depth.exr"), size, &[("Z", by(0.8, 0.1))]);
    let unit = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
    let cameras = format!("{{\"view_projection\": {unit}, \"previous_view_projection\": {unit}}}");
    std::fs::write(at(&folder, "still.json"), cameras).expect("a file");
    for (what, settings, files, [x, y], wanted) in KNOWN {
        let settings_file = at(&folder, "settings.toml");
        std::fs::write(&settings_file, settings).expect("a file");
        let outputs = ["sri.png", "why.png", "half.png", "luma.png"].map(|name| at(&folder, name));
        let mut seen = Vec::new();
        for more in [&[][..], &["--cpu"]] {
            let mut arguments = vec![
                input.clone(),
                "--settings".to_owned(),
                settings_file.clone(),
            ];
            let options = ["-o", "--reasons", "--half-output", "--luma-output"];
            for (option, path) in options.iter().zip(&outputs) {
                arguments.extend([(*option).to_owned(), path.clone()]);
            }
            arguments.extend(files.iter().map(|&name| match name.contains('.') {
                true if !name.starts_with(|c: char| c.is_ascii_digit()) => at(&folder, name),
                _ => name.to_owned(),
            }));
            arguments.extend(more.iter().map(|&option| option.to_owned()));
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let output = vrcs(&arguments);
            assert!(output.status.success(), "{what}: {}", text(&output.stderr));
            let pictures = outputs.each_ref().map(grey);
            let found = [0, 1].map(|i| pictures[i].get_pixel(*x, *y).0[0]);
            assert_eq!(found, *wanted, "{what}: rate and reason of quad {x},{y}");
            assert_eq!(pictures[2].dimensions(), (18, 10), "{what}");
            assert_eq!(pictures[3].dimensions(), (70, 37), "{what}");
            seen.push(pictures);
        }
        assert!(seen[0] == seen[1], "{what}: a driver and the CPU differ");
    }
}

#[test]
fn a_plan_has_what_its_scene_declares_and_nothing_else() {
    let plan = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_vrcs"))
            .arg("plan")
            .args(arguments)
            .output()
            .expect("the program")
    };
    let bindings = |name: &str| -> usize {
        let output = plan(&[name, "--json"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        json["bindings"].as_array().expect("a list").len()
    };
    // parameters, tables, rates, colour, the rates before
    assert_eq!(bindings("ramps"), 5);
    // and motion, two depths, materials, the colour after transparents
    assert_eq!(bindings("interior"), 10);
    // the whole frame: a scene with surfaces tells them apart in both stages that follow, one without in neither
    for (name, has_surfaces) in [("interior", true), ("ramps", false)] {
        let json = plan(&[name, "--json"]).stdout;
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        for stage in ["build", "deblock"] {
            let effects = &json[stage][0]["effects"];
            let effects = effects.as_array().expect("a list");
            let found = effects.iter().any(|effect| effect == "SURFACES");
            assert_eq!(found, has_surfaces, "{name}, {stage}: {effects:?}");
        }
        assert!(json["rewritten"].as_array().expect("a list").len() > 1);
    }
    // what is printed is what the report says, and what runs
    for scene in SceneName::ALL {
        for preset in presets() {
            let shown = text(&plan(&[scene.name(), "--preset", preset.name]).stdout);
            let found = realise(scene, &preset.setting, false).expect("a preset");
            for line in found.lines(scene) {
                assert!(shown.lines().any(|shown| shown == line), "{line}: {shown}");
            }
            // no mask that no scene supplies is bound
            assert!(!shown.contains("flags"), "{shown}");
        }
    }
    assert_error(
        &plan(&["text", "--preset", "Best"]),
        2,
        &["Best", "Balanced"],
        &tempfile::tempdir().expect("a folder"),
    );
    let folder = folder();
    let scene = at(&folder, "scene.toml");
    std::fs::write(&scene, "colour = \"sqrt-luma\"\n").expect("a file");
    assert_eq!(bindings(&scene), 4);
    let shown = text(&plan(&[&scene, "--size", "3840x2160"]).stdout);
    assert!(shown.contains("buffer rates: 2211840 bytes"), "{shown}");
    std::fs::write(&scene, "motion = true\nmotoin = true\n").expect("a file");
    assert_error(&plan(&[&scene]), 3, &["scene.toml:2", "motoin"], &folder);
    std::fs::write(&scene, "blur = true\n").expect("a file");
    assert!(
        plan(&[&scene]).status.success(),
        "a blur without motion is left out"
    );
    assert_error(&plan(&["hall"]), 2, &["hall", "interior"], &folder);
    // a renderer's own settings: what they ask for is planned, and nothing that the declaration would serve besides
    let settings = at(&folder, "mine.toml");
    let with_settings = |text: &str| {
        std::fs::write(&settings, text).expect("a file");
        plan(&[&scene, "--settings", &settings, "--json"])
    };
    std::fs::write(
        &scene,
        "motion = true\nmaterials = true\nprevious-rates = true\n",
    )
    .expect("a file");
    let all = bindings(&scene);
    let output = with_settings("[content]\nthreshold = 0.1\n");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    // parameters, tables, rates, colour
    assert_eq!(
        (json["bindings"].as_array().expect("a list").len(), all),
        (4, 7)
    );
    assert_error(
        &with_settings("[foveation]\n[motion]\nblur = { standalone = { error = 0.2 } }\n"),
        1,
        &[
            "scene.toml with",
            "mine.toml",
            "foveation",
            "motion alone decides",
        ],
        &folder,
    );
    assert_error(
        &with_settings("[content]\nthreshhold = 1\n"),
        3,
        &["mine.toml:2"],
        &folder,
    );
    assert_error(
        &plan(&["ramps", "--settings", &settings]),
        2,
        &["ramps", "--preset"],
        &folder,
    );
}
