//! Nothing that the library takes is out of the program's reach, and a plan has what its scene declares.

use super::*;

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
