//! What does not fit is refused in one line that says which, and leaves nothing behind.

use super::*;

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
