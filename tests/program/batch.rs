//! `vrcs rewrite` of many files, and of files that change.

use std::process::{Command, Stdio};

use crate::{names, shaders, status, stderr, stdout, vrcs};

#[test]
fn a_batch_goes_on_after_a_failure_and_skips_what_has_not_changed() {
    let folder = shaders();
    let arguments = ["rewrite", "in", "-o", "out/", "-D", "SCALE=2.0"];
    let first = vrcs(&arguments, folder.path());
    assert_eq!(status(&first), 1, "two are at fault");
    assert_eq!(stdout(&first), "");
    let said = stderr(&first);
    for expected in [
        "in/refused.wgsl:3:",
        "VRCS016",
        "in/wrong.wgsl:",
        "note: in/vertex.wgsl is passed by",
        "2 rewritten, 0 unchanged, 1 passed by, 2 failed",
    ] {
        assert!(said.contains(expected), "no `{expected}` in\n{said}");
    }
    let out = folder.path().join("out");
    assert_eq!(names(&out), [".vrcs.json", "a.json", "a.wgsl", "deep"]);
    assert_eq!(names(&out.join("deep")), ["b.json", "b.wgsl"]);

    // again: the same text in the same order, nothing is done anew
    let again = vrcs(&arguments, folder.path());
    let said = stderr(&again);
    assert!(
        said.contains("0 rewritten, 2 unchanged, 1 passed by, 2 failed"),
        "{said}"
    );
    // what a shader imports counts, and what it was written as, and what lies there
    let count = |arguments: &[&str]| {
        let said = stderr(&vrcs(arguments, folder.path()));
        said.lines().last().unwrap_or_default().to_owned()
    };
    std::fs::write(out.join("a.wgsl"), "changed by hand").expect("a file");
    assert!(count(&arguments).starts_with("1 rewritten, 1 unchanged"));
    let module = folder.path().join("in/lib/noise.wgsl");
    let text = std::fs::read_to_string(&module).expect("a module");
    std::fs::write(&module, text + "// changed\n").expect("a module");
    assert!(!count(&arguments).starts_with("0 rewritten"));
    assert!(count(&arguments).starts_with("0 rewritten, 2 unchanged"));
    let other = [&arguments[..], &["--max-rate", "4x4"]].concat();
    assert!(count(&other).starts_with("2 rewritten, 0 unchanged"));
    let forced = [&other[..], &["--force"]].concat();
    assert!(count(&forced).starts_with("2 rewritten, 0 unchanged"));
}

#[test]
fn a_batch_is_the_same_every_time() {
    let folder = shaders();
    let run = |out: &str| {
        let output = vrcs(
            &["rewrite", "in", "-o", out, "-D", "SCALE=2.0", "--json"],
            folder.path(),
        );
        let report = stdout(&output).replace(out, "OUT/");
        let text = std::fs::read(folder.path().join(out).join("deep/b.wgsl")).expect("a shader");
        (report, stderr(&output), text)
    };
    let (one, two) = (run("one/"), run("two/"));
    assert_eq!(one, two);
    assert_eq!(one.1, "", "with --json all is on standard output");
    let report: serde_json::Value = serde_json::from_str(&one.0).expect("JSON");
    let statuses: Vec<_> = report
        .as_array()
        .expect("a list")
        .iter()
        .map(|shader| {
            (
                shader["shader"].as_str().unwrap_or(""),
                shader["status"].as_str().unwrap_or(""),
            )
        })
        .collect();
    assert_eq!(
        statuses,
        [
            ("in/a.wgsl", "rewritten"),
            ("in/deep/b.wgsl", "rewritten"),
            ("in/refused.wgsl", "refused"),
            ("in/vertex.wgsl", "nothing-per-pixel"),
            ("in/wrong.wgsl", "invalid"),
        ]
    );
    let refused = &report[2]["findings"][0];
    assert_eq!(refused["code"], "VRCS016");
    assert_eq!(refused["places"][0]["line"], 3);
    assert_eq!(
        report[4]["findings"][0]["places"][0]["file"],
        "in/wrong.wgsl"
    );
}

#[test]
fn a_batch_that_makes_no_sense_is_refused() {
    let folder = shaders();
    std::fs::write(folder.path().join("in/a.comp"), "").expect("a file");
    for (arguments, message) in [
        (&["rewrite", "in"][..], "`-o DIR/`"),
        (
            &["rewrite", "in", "-o", "out/", "--manifest", "m.json"],
            "leave --manifest out",
        ),
        (&["rewrite", "in", "-o", "in"], "is the shader itself"),
        (&["rewrite", "in", "-o", "out/"], "would both be written to"),
        (
            &["rewrite", "good/main.wgsl", "in/a.comp", "-o", "x.wgsl"],
            "cannot be one shader",
        ),
        (
            &["rewrite", "good/main.wgsl", "--json"],
            "cannot both go to standard output",
        ),
        (
            &["rewrite", "good/main.wgsl", "-D", "=3"],
            "is not NAME=VALUE",
        ),
        (&["rewrite", "-", "--watch"], "cannot be watched"),
    ] {
        let output = vrcs(arguments, folder.path());
        assert_eq!(status(&output), 2, "{arguments:?}: {}", stderr(&output));
        assert!(
            stderr(&output).contains(message),
            "{arguments:?}: {}",
            stderr(&output)
        );
    }
}

#[test]
fn watching_rewrites_what_changes() {
    use std::time::{Duration, Instant};
    let folder = shaders();
    let mut child = Command::new(env!("CARGO_BIN_EXE_vrcs"))
        .args(["rewrite", "in/a.wgsl", "-o", "a.out.wgsl", "--watch"])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let out = folder.path().join("a.out.wgsl");
    let wait_for = |wanted: &str| {
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(20) {
            if std::fs::read_to_string(&out).is_ok_and(|text| text.contains(wanted)) {
                return true;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    };
    let first = wait_for("f32(");
    // a change in the moment of the start is not promised to be seen
    std::thread::sleep(Duration::from_millis(300));
    let path = folder.path().join("in/a.wgsl");
    let text = std::fs::read_to_string(&path).expect("a shader");
    std::fs::write(&path, text.replace("f32(id.x)", "0.125")).expect("a shader");
    let second = wait_for("0.125");
    child.kill().expect("it runs until it is ended");
    let _ = child.wait();
    assert!(first && second, "first {first}, second {second}");
}
