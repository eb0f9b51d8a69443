//! What is written: the rates, the attachment, the overlay and the statistics, of pictures in every format.

use super::*;

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
