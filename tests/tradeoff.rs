//! `vrcs tradeoff` and `vrcs demo SCENE` as a user runs them, tiny, and the promise of the preset Exact, bit for bit.

mod common;

use std::{
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    time::Duration,
};

use serde_json::Value;
use vrcs::{
    scenes::SceneName,
    tradeoff::{bench::Bench, realise::realise, setting::presets},
};

fn vrcs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_vrcs"))
        .args(arguments)
        .output()
        .expect("the program")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The data inside the page.
fn data_of(page: &str) -> Value {
    let start = "<script id=\"data\" type=\"application/json\">";
    let from = page.find(start).expect("data") + start.len();
    let to = from + page[from..].find("</script>").expect("its end");
    serde_json::from_str(&page[from..to]).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn share(value: &Value) {
    assert!((0.0..=1.0).contains(&number(value)), "{value}");
}

/// What every point has to be like.
fn check_point(point: &Value) {
    for key in ["primary_share", "retired_share", "average_rate"] {
        share(&point[key]);
    }
    for key in ["flip_mean", "flip_p99", "flips"] {
        share(&point["error"][key]);
    }
    let time = &point["time"];
    for key in ["full_ms", "variable_ms", "control_ms"] {
        assert!(number(&time[key]) > 0.0, "{key}: {point}");
    }
    let passes = time["passes"].as_array().expect("passes");
    assert!(passes.len() >= 3, "{time}");
}

fn points(scene: &Value) -> &Vec<Value> {
    scene["points"].as_array().expect("points")
}

fn preset<'s>(scene: &'s Value, name: &str) -> &'s Value {
    let found = points(scene).iter().find(|point| point["preset"] == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

struct Tiny {
    folder: tempfile::TempDir,
}

impl Tiny {
    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vrcs"));
        command
            .args(["tradeoff", "landscape", "--quick", "--size", "66x38"])
            .args(["--frames", "2", "--out"])
            .arg(self.out());
        command
    }

    fn run(&self) -> Output {
        let output = self.command().output().expect("the program");
        assert!(output.status.success(), "{}", text(&output.stderr));
        output
    }

    /// Runs until the first batch is timed, and ends the program there.
    fn run_a_part(&self) {
        let mut child = self
            .command()
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program");
        let report = self.out().join("report.html");
        while !report.exists() {
            let ended = child.try_wait().expect("the program");
            assert!(ended.is_none(), "it ended before it was interrupted");
            std::thread::sleep(Duration::from_millis(20));
        }
        child.kill().expect("an interruption");
        child.wait().expect("its end");
    }
}

#[test]
fn a_quick_study_is_whole_and_goes_on_where_it_was_interrupted() {
    let tiny = Tiny {
        folder: tempfile::tempdir().expect("a folder"),
    };
    tiny.run_a_part();
    let part = data_of(&read(&tiny.out(), "report.html"));
    let there = points(&part["scenes"][0]).clone();
    assert!(there.len() >= 3, "what was finished is in the report");
    let unfinished = part["unfinished"].as_str().expect("it is said");
    assert!(unfinished.contains("not finished"), "{unfinished}");

    let output = tiny.run();
    let table = text(&output.stdout);
    let steps = text(&output.stderr);
    assert!(steps.contains(" landscape: truth"), "{steps}");
    assert!(steps.lines().all(|line| line.contains('/')), "{steps}");
    for word in ["Exact", "Balanced", "Fast", "equal", "report.html"] {
        assert!(table.contains(word), "{word}: {table}");
    }

    let page = read(&tiny.out(), "report.html");
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!outside.contains("http"), "the page needs no network");
    let data = data_of(&page);
    assert!(data["unfinished"].is_null());
    let scene = &data["scenes"][0];
    points(scene).iter().for_each(check_point);
    for (before, after) in there.iter().zip(points(scene)) {
        assert_eq!(before["time"], after["time"], "not measured again");
    }
    let exact = preset(scene, "Exact");
    assert_eq!(exact["identical"], true, "Exact gives up nothing");
    assert!(exact["error"]["psnr"].is_null() && number(&exact["error"]["flip_mean"]) == 0.0);
    let fast = preset(scene, "Fast");
    assert_eq!(fast["identical"], false, "Fast gives up something");
    assert!(number(&fast["primary_share"]) < number(&preset(scene, "Balanced")["primary_share"]));
    check_chosen(scene);
    let with_pictures = points(scene).iter().filter(|p| p["pictures"].is_object());
    assert!(with_pictures.clone().count() >= 6, "presets and more");
    for point in with_pictures.chain([fast]) {
        let kinds: &[&str] = match point["identical"] == true {
            true => &["rates"],
            false => &["variable", "flip", "rates", "reasons"],
        };
        for kind in kinds {
            let uri = point["pictures"][*kind].as_str().expect(kind);
            assert!(uri.starts_with("data:image/png;base64,"), "{kind}");
        }
    }
    assert!(exact["pictures"]["skipped"].is_string(), "the sky");
    assert!(page.len() < 1 << 20, "{} bytes", page.len());
    assert!(points(scene).iter().any(|point| point["peer"] == true));
    let effects: Vec<&str> = scene["effects"]
        .as_array()
        .expect("effects")
        .iter()
        .filter_map(|effect| effect["name"].as_str())
        .collect();
    assert_eq!(
        effects,
        [
            "motion",
            "ids and depth",
            "grain",
            "sky",
            "hysteresis",
            "deblocking"
        ]
    );
    check_truth(&scene["truth"]["curve"]);
    let peers = scene["truth"]["peers"].as_array().expect("peers");
    assert_eq!(peers.len(), 6, "all that look at the picture");
    let verdict = data["summary"]["verdict"].as_array().expect("a verdict");
    assert_eq!(verdict.len(), 2, "on t and on l");

    let csv = read(&tiny.out(), "points.csv");
    let columns = csv.lines().next().expect("names").split(',').count();
    assert_eq!(csv.lines().count(), points(scene).len() + 1);
    assert!(
        columns > 30 && csv.starts_with("scene,name,preset"),
        "{csv}"
    );
    let plot = read(&tiny.out(), "plot.svg");
    assert!(plot.starts_with("<svg") && plot.ends_with("</svg>\n"));
    assert!(
        plot.matches("<title>").count() == points(scene).len(),
        "{plot}"
    );
    let json: Value = serde_json::from_str(&read(&tiny.out(), "study.json")).expect("JSON");
    assert_eq!(points(&json["scenes"][0]).len(), points(scene).len());

    let chosen = read(&tiny.out(), "presets.toml");
    for preset in ["Exact", "Balanced", "Fast"] {
        assert!(
            chosen.contains(&format!("[landscape.{preset}]")),
            "{chosen}"
        );
    }
    shown_by_plan_and_demo(&tiny.out().join("presets.toml"), scene);

    // an interruption in the middle of the last times
    let journal = read(&tiny.out(), "points.jsonl");
    let kept = journal.rfind("\"found\":{\"times\"").expect("times") + 60;
    std::fs::write(tiny.out().join("points.jsonl"), &journal[..kept]).expect("cut");
    tiny.run();
    let again = data_of(&read(&tiny.out(), "report.html"));
    let (before, after) = (points(scene), points(&again["scenes"][0]));
    assert_eq!(before.len(), after.len());
    let same = before
        .iter()
        .zip(after)
        .filter(|(a, b)| a["time"] == b["time"]);
    assert!(same.count() >= 16, "all but the cut batch are taken up");
    let seen = |of: &Value| of["error"].clone();
    assert!(before.iter().zip(after).all(|(a, b)| seen(a) == seen(b)));
    let lines = read(&tiny.out(), "points.jsonl");
    assert_eq!(
        lines.lines().count(),
        journal.lines().count() + 1,
        "the cut line stays, and what followed it is whole"
    );
}

/// A scene's own presets give up no more than the general ones, and lose no time.
fn check_chosen(scene: &Value) {
    let chosen = scene["chosen"].as_array().expect("presets");
    assert_eq!(chosen.len(), 3, "{chosen:?}");
    for chosen in chosen {
        let name = chosen["preset"].as_str().expect("a name");
        let own = &points(scene)[number(&chosen["point"]) as usize];
        let general = preset(scene, name);
        let flip = |point: &Value| number(&point["error"]["flip_mean"]);
        assert!(flip(own) <= flip(general), "{name}");
        let high = number(&own["time"]["share"]["high"]);
        assert!(high < 1.0 || own["name"] == "full rate", "{name}: {high}");
        assert!(
            !chosen["because"].as_array().expect("reasons").is_empty(),
            "{name}"
        );
    }
}

/// What was chosen can be looked at without being measured again.
fn shown_by_plan_and_demo(file: &Path, scene: &Value) {
    let file = file.display().to_string();
    for chosen in scene["chosen"].as_array().expect("presets") {
        let name = chosen["preset"].as_str().expect("a name");
        let shown = vrcs(&["plan", "landscape", "--preset", name, "--presets", &file]);
        assert!(shown.status.success(), "{}", text(&shown.stderr));
        let shown = text(&shown.stdout);
        for line in chosen["plan"].as_array().expect("a plan") {
            let line = line.as_str().expect("a line");
            assert!(shown.lines().any(|s| s == line), "{line}: {shown}");
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().display().to_string();
    let demo = [
        "demo",
        "landscape",
        "--presets",
        &file,
        "--size",
        "66x38",
        "--out",
        &out,
    ];
    let output = vrcs(&demo);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = data_of(&read(folder.path(), "report.html"));
    let chosen = scene["chosen"].as_array().expect("presets");
    let balanced = chosen.iter().find(|c| c["preset"] == "Balanced");
    let at = number(&balanced.expect("a preset")["point"]) as usize;
    assert_eq!(
        points(&shown["scenes"][0])[0]["setting"],
        points(scene)[at]["setting"]
    );
    let elsewhere = vrcs(&["plan", "text", "--presets", &file]);
    assert_eq!(elsewhere.status.code(), Some(2));
    let error = text(&elsewhere.stderr);
    assert!(
        error.contains("[text.Balanced]") && error.lines().count() == 1,
        "{error}"
    );
}

/// More tolerance never means finer rates, of the analysis or of the truth; and there is room for both kinds of error.
fn check_truth(curve: &Value) {
    let curve = curve.as_array().expect("a curve");
    assert!(curve.len() > 4);
    for pair in curve.windows(2) {
        assert!(number(&pair[0]["t"]) < number(&pair[1]["t"]));
        for key in ["rate", "true_rate"] {
            assert!(number(&pair[0][key]) >= number(&pair[1][key]), "{key}");
        }
    }
    for at in curve {
        let wrong = number(&at["too_coarse"]) + number(&at["too_fine"]);
        assert!((0.0..=1.0).contains(&wrong), "{at}");
    }
}

#[test]
fn the_demo_shows_one_point_in_the_same_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().display().to_string();
    let output = vrcs(&[
        "demo",
        "ramps",
        "--size",
        "66x40",
        "--threshold",
        "0.2",
        "--out",
        &out,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let data = data_of(&read(folder.path(), "report.html"));
    assert_eq!(points(&data["scenes"][0]).len(), 1);
    let point = &points(&data["scenes"][0])[0];
    check_point(point);
    assert_eq!(point["setting"]["threshold"], 0.2);
    assert!(point["pictures"]["rates"].is_string());
}

#[test]
fn exact_is_bit_identical_where_it_skips_something() {
    let gpu = common::gpu();
    let [exact, _, fast] = presets();
    for scene in [SceneName::Landscape, SceneName::Foliage] {
        let bench = Bench::new(&gpu, scene, [90, 58], common::seed()).expect("a bench");
        let look = bench.look(&exact.setting, 3).expect("a look");
        assert!(look.identical, "{scene}");
        let last = bench.show(&exact.setting, 3).expect("a frame");
        let statistics = last.left.statistics;
        assert!(statistics.sky_pixels > 0, "{scene}: {statistics:?}");
        assert_eq!(statistics.duplicates(), 0, "{scene}");
        // and the comparison can fail
        let coarse = bench.look(&fast.setting, 3).expect("a look");
        assert!(!coarse.identical, "{scene}");
        assert!(coarse.error.flip_mean > 0.0 && coarse.error.ssim < 1.0);
    }
}

#[test]
fn exact_runs_the_authors_passes_where_nothing_is_empty() {
    let [exact, ..] = presets();
    let found = realise(SceneName::Text, &exact.setting, false).expect("a setting");
    assert!(found.build.is_none());
}

#[test]
fn bad_input_gets_one_clear_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    let nothing = write("nothing.toml", "[base]\nthreshold = 0.1\n");
    let unknown = write("unknown.toml", "[vary]\nthreshhold = [0.1]\n");
    let broken = write("broken.toml", "[vary]\nthreshold = [0.1\n");
    let pass = write("pass.toml", "[vary]\nfull_rate = [[\"shadow\"]]\n");
    let base = write(
        "base.toml",
        "[base]\nnorm = \"l9\"\n[vary]\nthreshold = [0.1]\n",
    );
    let unsuited = write("unsuited.toml", "[vary]\nestimator = [\"wicked\"]\n");
    let missing = folder.path().join("missing.toml").display().to_string();
    let out = folder.path().join("out").display().to_string();
    for (arguments, status, word) in [
        (vec!["interiour"], 2, "interior, foliage"),
        (vec!["--frames", "0"], 2, "one frame"),
        (vec!["--sweep", &nothing], 2, "tries nothing"),
        (vec!["--sweep", &unknown], 2, "threshhold"),
        (vec!["--sweep", &broken], 2, "line "),
        (vec!["--sweep", &missing], 3, "no such file"),
        (vec!["--sweep", &base], 2, "`norm`"),
        (vec!["--sweep", &pass], 2, "`full_rate`"),
        (
            vec!["text", "--sweep", &unsuited],
            2,
            "text declares no motion",
        ),
        (vec!["text", "--quick", "--size", "999999x4"], 2, "at most"),
        (vec!["text", "--quick", "--size", "16384x16384"], 3, "GiB"),
        (vec!["--adapter", "no such"], 2, "no adapter"),
    ] {
        let all: Vec<&str> = ["tradeoff", "--out", &out]
            .into_iter()
            .chain(arguments)
            .collect();
        let output = vrcs(&all);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{all:?}: {error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{all:?}: {error}");
        assert!(error.contains(word), "{all:?}: {error}");
        assert!(output.stdout.is_empty());
    }
    assert!(!Path::new(&out).exists(), "nothing is left behind");
    // a file stands where the folder would be: said at once, not after minutes of work
    let inside = format!("{missing}/out").replace("missing", "nothing");
    let output = vrcs(&["tradeoff", "text", "--quick", "--out", &inside]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(
        error.contains("nothing.toml/out") && error.lines().count() == 1,
        "{error}"
    );
}
