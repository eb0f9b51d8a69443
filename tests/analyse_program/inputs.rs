//! What is read besides a picture: the frame before, motion, depth, cameras; on the GPU as on the CPU.

use super::*;

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
