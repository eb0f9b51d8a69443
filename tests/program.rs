//! The program as a user meets it: what it writes, what it says when something is wrong, and how it ends.

mod common;

use std::{
    io::Write,
    path::Path,
    process::{Command, Output, Stdio},
};

fn vrcs(arguments: &[&str], folder: &Path) -> Output {
    vrcs_with_input(arguments, folder, "")
}

fn vrcs_with_input(arguments: &[&str], folder: &Path, input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_vrcs"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // a program that reads nothing closes its input
    let _ = child
        .stdin
        .take()
        .expect("its input")
        .write_all(input.as_bytes());
    child.wait_with_output().expect("the program ends")
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("it was not killed")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("text")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("text")
}

/// A folder with a good shader and some bad ones.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "good.wgsl",
        &std::fs::read_to_string(common::shader_path("plain")).expect("a shader"),
    );
    write("bad.wgsl", "this is not WGSL");
    write("fragment.wgsl", "@fragment fn main() {}");
    write(
        "nothing.wgsl",
        "@compute @workgroup_size(8, 8) fn main() {}",
    );
    write(
        "groups.wgsl",
        "@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
         @group(1) @binding(0) var b: texture_2d<f32>;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             textureStore(a, id.xy, textureLoad(b, id.xy, 0));
         }",
    );
    folder
}

/// The files in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn rewrite_writes_a_shader_and_its_manifest() {
    let folder = folder();
    let output = vrcs(
        &[
            "rewrite",
            "good.wgsl",
            "-o",
            "out.wgsl",
            "--manifest",
            "out.json",
            "--mode",
            "tiled",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    let text = std::fs::read_to_string(folder.path().join("out.wgsl")).expect("a shader");
    naga::front::wgsl::parse_str(&text).expect("WGSL");
    let json = std::fs::read_to_string(folder.path().join("out.json")).expect("a manifest");
    let manifest: vrcs_passes::manifest::Manifest =
        serde_json::from_str(&json).expect("a manifest");
    let entry = &manifest.entries[0];
    assert_eq!(entry.name, "main");
    assert_eq!(entry.workgroup_size, [16, 16, 1]);
    assert_eq!(entry.dispatch.groups([61, 47, 1]), [4, 3, 1]);
    assert_eq!((entry.bindings[0].group, entry.bindings[1].binding), (1, 1));
}

#[test]
fn rewrite_reads_and_writes_streams() {
    let folder = folder();
    let good = std::fs::read_to_string(folder.path().join("good.wgsl")).expect("a shader");
    let output = vrcs_with_input(&["rewrite", "-", "-o", "-"], folder.path(), &good);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    naga::front::wgsl::parse_str(&stdout(&output))
        .expect("WGSL, and nothing else, on standard output");
    let again = vrcs(&["rewrite", "good.wgsl"], folder.path());
    assert_eq!(stdout(&again), stdout(&output));
}

/// Expects a failure: its status, a message in one piece, and no file that was not there before.
fn assert_refused(arguments: &[&str], expected: i32, message: &str) {
    let folder = folder();
    let before = names(folder.path());
    let output = vrcs(arguments, folder.path());
    let said = stderr(&output);
    assert_eq!(status(&output), expected, "{arguments:?}: {said}");
    assert!(said.contains(message), "{arguments:?} said: {said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(said.matches("error").count(), 1, "{said}");
    assert_eq!(stdout(&output), "", "{arguments:?}");
    assert_eq!(
        names(folder.path()),
        before,
        "{arguments:?} left a file behind"
    );
}

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
        &[&with("groups.wgsl")[..], &["--max-bind-groups", "2"]].concat(),
        1,
        "the shader uses all 2 bind groups",
    );
}

#[test]
fn outputs_that_make_no_sense_are_refused() {
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "good.wgsl"],
        2,
        "is the shader itself",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "./good.wgsl"],
        2,
        "is the shader itself",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "x", "--manifest", "x"],
        2,
        "cannot go to the same place",
    );
    assert_refused(
        &["rewrite", "good.wgsl", "-o", "no/such/folder/x.wgsl"],
        3,
        "no/such/folder/x.wgsl",
    );
    assert_refused(
        &[
            "rewrite",
            "good.wgsl",
            "-o",
            "out.wgsl",
            "--manifest",
            "no/such/folder/x.json",
        ],
        3,
        "no/such/folder/x.json",
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
fn check_tells_what_held() {
    let folder = folder();
    let output = vrcs(
        &[
            "check",
            "good.wgsl",
            "--cases",
            "20",
            "--seed",
            "5",
            "--size",
            "40x30",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("main: passed"), "{text}");
    for law in [
        "identity",
        "off",
        "replication",
        "locality",
        "contract",
        "partition",
        "builder",
    ] {
        assert!(text.contains(law), "{text}");
    }
    assert!(text.contains("40x30, 20 cases, seed 5"), "{text}");
}

#[test]
fn check_never_passes_what_could_not_have_failed() {
    let folder = folder();
    std::fs::write(
        folder.path().join("constant.wgsl"),
        "@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             textureStore(a, id.xy, vec4(1.0));
         }",
    )
    .expect("a file");
    let output = vrcs(&["check", "constant.wgsl", "--cases", "4"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stdout(&output).contains("main: inconclusive: `a` is the same everywhere"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn check_ends_a_shader_that_does_not_end() {
    let folder = folder();
    std::fs::write(
        folder.path().join("endless.wgsl"),
        "@group(0) @binding(0) var a: texture_storage_2d<rgba8unorm, write>;
         @group(0) @binding(1) var<uniform> turns: u32;
         @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
             var sum = id.x;
             for (var i = 0u; i < 60000u; i++) { sum = sum * 747796405u + i + turns; }
             textureStore(a, id.xy, vec4(f32(sum & 255u)));
         }",
    )
    .expect("a file");
    let output = vrcs(
        &[
            "check",
            "endless.wgsl",
            "--cases",
            "4",
            "--time-limit",
            "1",
            "--size",
            "1024x1024",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 1);
    assert!(
        stdout(&output).contains("took longer than 1 s"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn settings_lie_beside_the_shader() {
    let folder = folder();
    std::fs::copy(
        common::shader_path("guarded"),
        folder.path().join("guarded.wgsl"),
    )
    .expect("a copy");
    std::fs::write(
        folder.path().join("guarded.toml"),
        "size = [24, 20]\ncases = 18\n[set]\nborder = 3\n",
    )
    .expect("a file");
    let output = vrcs(&["check", "guarded.wgsl", "--seed", "1"], folder.path());
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(
        stdout(&output).contains("24x20, 18 cases"),
        "{}",
        stdout(&output)
    );
    std::fs::write(folder.path().join("guarded.toml"), "sizes = [24, 20]\n").expect("a file");
    let output = vrcs(&["check", "guarded.wgsl"], folder.path());
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("guarded.toml"),
        "{}",
        stderr(&output)
    );
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
        "PSNR",
        "laws held            7 of 7",
    ] {
        assert!(text.contains(row), "no `{row}` in\n{text}");
    }
    for name in ["full", "variable", "rates", "primaries", "difference"] {
        let path = folder.path().join("pictures").join(format!("{name}.png"));
        let picture = image::open(&path).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (160, 90));
    }
}
