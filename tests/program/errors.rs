//! What the program says when something is wrong, and the code that it ends with.

use std::process::Command;

use crate::{assert_refused, folder, status, stderr, vrcs};

#[test]
fn bad_input_is_refused_with_one_clear_message() {
    let out = ["-o", "out.wgsl"];
    let with = |shader| [&["rewrite", shader], &out[..]].concat();
    assert_refused(&with("bad.wgsl"), 1, "bad.wgsl:1:1");
    assert_refused(
        &with("fragment.wgsl"),
        1,
        "the module has no compute entry point",
    );
    assert_refused(&with("nothing.wgsl"), 1, "stores nothing at an address");
    assert_refused(
        &with("missing.wgsl"),
        3,
        "missing.wgsl: there is no such file",
    );
    assert_refused(
        &[&with("good.wgsl")[..], &["--entry", "mian"]].concat(),
        1,
        "no compute entry point is called `mian`",
    );
    assert_refused(
        &[&with("groups.wgsl")[..], &["--place", "1:0"]].concat(),
        1,
        "cannot be binding 0 of group 1: that is `b`",
    );
    assert_refused(
        &[&with("groups.wgsl")[..], &["--place", "7:0"]].concat(),
        1,
        "there is no bind group 7",
    );
    assert_refused(
        &[&with("groups.wgsl")[..], &["--max-storage-buffers", "0"]].concat(),
        1,
        "uses 0 storage buffers; with the coordinate buffer that makes 1",
    );
    assert_refused(
        &[&with("groups.wgsl")[..], &["--place", "1"]].concat(),
        2,
        "is not GROUP:BINDING",
    );
}

#[test]
fn binary_files_are_no_shaders() {
    let folder = folder();
    std::fs::write(folder.path().join("picture.wgsl"), [0xff, 0xd8, 0xff, 0xe0]).expect("a file");
    let output = vrcs(&["rewrite", "picture.wgsl"], folder.path());
    assert_eq!(status(&output), 3);
    assert!(
        stderr(&output).contains("picture.wgsl: it is not text"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_slip_of_a_finger_gets_a_suggestion() {
    let folder = folder();
    for (arguments, wanted) in [
        (
            &["rewrite", "godo.wgsl"][..],
            "godo.wgsl: there is no such file; did you mean good.wgsl?",
        ),
        (
            &["rewrite", "something_else.wgsl"],
            "something_else.wgsl: there is no such file\n",
        ),
        (
            &["check", "good.wgsl", "--set", "pictrue=1", "--cases", "1"],
            "nothing called `pictrue`; did you mean `picture`?",
        ),
        (
            &[
                "check",
                "good.wgsl",
                "--input",
                "picture=no.png",
                "--cases",
                "1",
            ],
            "no.png: there is no such file",
        ),
    ] {
        let output = vrcs(arguments, folder.path());
        assert!(stderr(&output).contains(wanted), "{}", stderr(&output));
    }
}

#[test]
fn misuse_is_told_apart() {
    let folder = folder();
    for arguments in [
        &["rewrite"][..],
        &["rewrite", "good.wgsl", "--mode", "sideways"],
        &["rewrite", "good.wgsl", "--wave", "33"],
        &["check", "good.wgsl", "--size", "64"],
        &["check", "good.wgsl", "--set", "width"],
        &["check", "good.wgsl", "--set", "nothing=1", "--cases", "1"],
        &["demo", "--threshold", "-1"],
        &["frobnicate"],
    ] {
        let output = vrcs(arguments, folder.path());
        assert_eq!(status(&output), 2, "{arguments:?}: {}", stderr(&output));
    }
    assert_eq!(status(&vrcs(&["--help"], folder.path())), 0);
    assert_eq!(status(&vrcs(&["--version"], folder.path())), 0);
}

#[test]
fn without_a_driver_the_package_is_named() {
    let folder = folder();
    let output = Command::new(env!("CARGO_BIN_EXE_vrcs"))
        .args(["demo", "--out", "pictures"])
        .current_dir(folder.path())
        .env("VK_DRIVER_FILES", "/nowhere.json")
        .env("VK_ICD_FILENAMES", "/nowhere.json")
        .output()
        .expect("the program runs");
    assert_eq!(status(&output), 3);
    let said = stderr(&output);
    let error = said.lines().last().expect("a line");
    assert!(
        error.contains("apt-get install mesa-vulkan-drivers"),
        "{said}"
    );
    assert!(!folder.path().join("pictures").exists());
}

#[test]
fn a_misspelt_command_or_flag_gets_a_suggestion() {
    let folder = folder();
    for (arguments, expected) in [
        (&["rewrit", "good.wgsl"][..], "'rewrite'"),
        (&["rewrite", "good.wgsl", "--outpt", "x.wgsl"], "'--output'"),
    ] {
        let output = vrcs(arguments, folder.path());
        assert_eq!(status(&output), 2);
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
}

/// Shaders from anywhere do not make the program panic or overflow.
#[test]
fn hostile_shaders_are_refused_in_one_piece() {
    let folder = folder();
    for (name, text) in [
        ("deep.wgsl", "fn f() { ".to_owned() + &"(".repeat(200_000)),
        (
            "sum.wgsl",
            format!("const A = 1{};", " + 1".repeat(300_000)),
        ),
        (
            "deep.comp",
            format!("#version 450\nvoid main() {{ {} }}", "{".repeat(200_000)),
        ),
        ("empty.spv", String::new()),
        ("empty.wgsl", String::new()),
        ("endless.wgsl", "/*".to_owned()),
        ("if.wgsl", "#ifdef A\n".repeat(10_000)),
    ] {
        std::fs::write(folder.path().join(name), text).expect("a file");
        let output = vrcs(&["rewrite", name], folder.path());
        assert_eq!(status(&output), 1, "{name}: {}", stderr(&output));
        assert!(
            stderr(&output).contains("error"),
            "{name}: {}",
            stderr(&output)
        );
    }
}
