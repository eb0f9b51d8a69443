//! `vrcs demo`: the pictures that it draws, and what it tells of them.

use crate::{folder, status, stderr, stdout, vrcs};

#[test]
fn the_demo_draws_and_tells() {
    let folder = folder();
    let output = vrcs(
        &["demo", "--out", "pictures", "--size", "160x90"],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for row in [
        "primaries",
        "waves retired",
        "deblocker",
        "PSNR, deblocked",
        "laws held            7 of 7",
    ] {
        assert!(text.contains(row), "no `{row}` in\n{text}");
    }
    let whole = (160, 90);
    for (name, size) in [
        ("full", whole),
        ("variable", whole),
        ("deblocked", whole),
        ("rates", whole),
        ("classes", whole),
        ("primaries", whole),
        ("difference", whole),
        // windows of 112 pixels, as high as the picture, at four times their size, with lines of 4 between
        ("zoom", (3 * 448 + 8, 360)),
        ("primaries_zoom", (2 * 448 + 4, 360)),
    ] {
        let path = folder.path().join("pictures").join(format!("{name}.png"));
        let picture = image::open(&path).expect("a picture");
        assert_eq!((picture.width(), picture.height()), size, "{name}");
    }
}
