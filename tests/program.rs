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

/// Every command, by what `vrcs --help` lists.
fn commands(folder: &Path) -> Vec<String> {
    let listed = stdout(&vrcs(&["--help"], folder));
    let listed = listed.lines().skip_while(|line| *line != "Commands:");
    let listed = listed.skip(1).take_while(|line| !line.is_empty());
    listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

#[test]
fn a_commands_help_fits_a_screen_has_examples_and_hides_nothing_from_the_long_one() {
    let folder = folder();
    let commands = commands(folder.path());
    assert!(commands.len() >= 12, "{commands:?}");
    for command in std::iter::once("").chain(commands.iter().map(String::as_str)) {
        let asked = |help| {
            let arguments: Vec<&str> = [command, help]
                .into_iter()
                .filter(|argument| !argument.is_empty())
                .collect();
            stdout(&vrcs(&arguments, folder.path()))
        };
        let (short, long) = (asked("-h"), asked("--help"));
        let lines = short.lines().count();
        assert!(lines <= 40, "vrcs {command} -h has {lines} lines:\n{short}");
        let widest = short.lines().map(|line| line.chars().count()).max();
        assert!(widest <= Some(100), "vrcs {command} -h: {widest:?} columns");
        let takes_nothing = ["codes", "adapters"].contains(&command);
        assert!(
            takes_nothing || short.contains("Examples:\n  vrcs "),
            "vrcs {command} -h has no examples:\n{short}"
        );
        for option in short
            .split_whitespace()
            .filter(|word| word.starts_with("--"))
        {
            let name = option.trim_matches(|c: char| !c.is_alphanumeric() && c != '-');
            assert!(long.contains(name), "vrcs {command} --help lacks {name}");
        }
    }
    // what is seldom wanted is in the long help alone
    let long = stdout(&vrcs(&["rewrite", "--help"], folder.path()));
    let short = stdout(&vrcs(&["rewrite", "-h"], folder.path()));
    assert!(long.contains("--max-storage-buffers") && !short.contains("--max-storage-buffers"));
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

/// The manifest of a file.
fn manifest(path: &Path) -> vrcs_passes::manifest::Manifest {
    let json = std::fs::read_to_string(path).expect("a manifest");
    serde_json::from_str(&json).expect("a manifest")
}

/// The JSON on standard output.
fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).expect("JSON, and nothing else, on standard output")
}

/// A folder of shaders, good and bad, with a module that they import.
fn shaders() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    let store = |value: &str| {
        format!(
            "@group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8) fn shade(@builtin(global_invocation_id) id: vec3<u32>) {{
    textureStore(picture, id.xy, vec4({value}));
}}
"
        )
    };
    write("in/a.wgsl", &store("f32(id.x)"));
    write(
        "in/deep/b.wgsl",
        &format!("#import lib::noise\n{}", store("noise::value(id.x)")),
    );
    write(
        "in/lib/noise.wgsl",
        "#define_import_path lib::noise\nfn value(x: u32) -> f32 { return f32(x) * f32(#{SCALE}); }\n",
    );
    write("in/refused.wgsl", &store("subgroupAdd(f32(id.x))"));
    write("in/wrong.wgsl", "fn f(\n");
    write(
        "in/vertex.wgsl",
        "@vertex fn v() -> @builtin(position) vec4<f32> { return vec4(1.0); }",
    );
    write("in/notes.txt", "not a shader");
    write(
        "good/common.wgsl",
        "fn value(x: u32) -> f32 { return f32(x); }\n",
    );
    write("good/main.wgsl", &store("value(id.x)"));
    folder
}

#[test]
fn several_files_are_one_shader() {
    let folder = shaders();
    let files = ["good/common.wgsl", "good/main.wgsl"];
    let output = vrcs(
        &[
            "rewrite",
            files[0],
            files[1],
            "-o",
            "one.wgsl",
            "--manifest",
            "one.json",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let text = std::fs::read_to_string(folder.path().join("one.wgsl")).expect("a shader");
    assert!(text.contains("fn value(") && text.contains("fn vrcs_copy_picture"));
    assert_eq!(
        manifest(&folder.path().join("one.json")).entries[0].name,
        "shade"
    );
    // a message points into the file that it is about
    let output = vrcs(&["rewrite", "good/main.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    let said = stderr(&output);
    assert!(said.contains("good/main.wgsl:3:39"), "{said}");
    assert!(said.contains("give that file first"), "{said}");
}

#[test]
fn imports_and_definitions_are_understood() {
    let folder = shaders();
    let rewrite = |define: &[&str]| {
        let arguments = [&["rewrite", "in/deep/b.wgsl", "-I", "in/lib"], define].concat();
        vrcs(&arguments, folder.path())
    };
    let output = rewrite(&["-D", "SCALE=0.25"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("0.25"), "{}", stdout(&output));
    // a picture in the folder is nobody's module
    std::fs::write(folder.path().join("in/lib/noise.png"), [0x89, 0xff]).expect("writable");
    assert_eq!(status(&rewrite(&["-D", "SCALE=0.25"])), 0);
    // without the definition the module is at fault, in its own line
    let output = rewrite(&[]);
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("noise.wgsl:2:"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["rewrite", "in/deep/b.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("there is no module `lib::noise`"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn check_takes_what_rewrite_takes() {
    let folder = shaders();
    let check = |files: &[&str]| {
        let common = ["--cases", "2", "--size", "16x16", "--seed", "3"];
        vrcs(&[&["check"], files, &common[..]].concat(), folder.path())
    };
    let output = check(&["good/common.wgsl", "good/main.wgsl"]);
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    let output = check(&["in/deep/b.wgsl", "-I", "in/lib", "-D", "SCALE=0.01"]);
    assert_eq!(status(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert_eq!(status(&check(&["in"])), 2);
}

#[test]
fn the_output_language_is_told_by_extension_or_flag() {
    let folder = folder();
    let rewrite = |arguments: &[&str]| {
        vrcs(
            &[&["rewrite", "good.wgsl"], arguments].concat(),
            folder.path(),
        )
    };
    for (file, flag) in [
        ("a.spv", None),
        ("a.hlsl", None),
        ("a.metal", None),
        ("a.comp", None),
        ("b.wgsl", None),
        ("a.txt", Some("--to=glsl-460")),
    ] {
        let arguments: Vec<&str> = ["-o", file, "--manifest", "m.json"]
            .into_iter()
            .chain(flag)
            .collect();
        let output = rewrite(&arguments);
        assert_eq!(status(&output), 0, "{file}: {}", stderr(&output));
        assert!(folder.path().join(file).metadata().expect("a file").len() > 100);
        let manifest = manifest(&folder.path().join("m.json"));
        let written = manifest.output.expect("what was written");
        assert_eq!(written.entries.is_empty(), file == "b.wgsl", "{file}");
    }
    // SPIR-V comes in again, and is not rewritten twice
    let output = vrcs(&["rewrite", "a.spv", "-o", "c.spv"], folder.path());
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    assert!(stderr(&output).contains("VRCS"), "{}", stderr(&output));

    let output = rewrite(&["-o", "a.hsl"]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `.hlsl`?"),
        "{}",
        stderr(&output)
    );
    assert!(stderr(&output).contains(".metal"), "{}", stderr(&output));
    let output = rewrite(&["--to", "mls"]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `msl`?"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["rewrite", "shader.wgls"], folder.path());
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("did you mean `.wgsl`?"),
        "{}",
        stderr(&output)
    );
    let output = rewrite(&["--override", "A=1"]);
    assert_eq!(status(&output), 2, "WGSL keeps its overrides");
}

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
fn explain_tells_what_is_stored_where_and_why() {
    let folder = folder();
    std::fs::write(
        folder.path().join("three.wgsl"),
        "struct View { size: vec2<u32>, stride: u32 }
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(2) var<storage, read_write> depth: array<f32>;
@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size) { return; }
    textureStore(picture, id.xy, vec4(1.0));
    depth[id.y * view.stride + id.x] = f32(id.x);
}
@compute @workgroup_size(8, 8)
fn shuffle(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(picture, id.xy ^ vec2(1u), vec4(0.5));
}
@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    depth[id.x] = depth[id.x + 1u];
}
",
    )
    .expect("a file");
    let output = vrcs(&["explain", "three.wgsl"], folder.path());
    let text = stdout(&output);
    for expected in [
        "three.wgsl: shade: rewritten",
        "remapped   global_invocation_id",
        "domain     not (id.x >= view.size.x)",
        "store      `picture` at three.wgsl:8:",
        "offset: d(address)/dx = (1, 0), d(address)/dy = (0, 1)",
        "offset: d(address)/dx = 1, d(address)/dy = view.stride",
        "three.wgsl: shuffle: rewritten",
        "recomputed: the address does not move evenly; `(1u ^ global_invocation_id.x), ",
        "three.wgsl: count: REFUSED",
    ] {
        assert!(
            text.contains(expected),
            "no `{expected}` in\n{text}{}",
            stderr(&output)
        );
    }
    assert_eq!(status(&output), 1, "one is refused");
    let output = vrcs(
        &["explain", "three.wgsl", "--json", "--entry", "shade"],
        folder.path(),
    );
    assert_eq!(status(&output), 0);
    let report = json(&output);
    assert_eq!(report[0]["entries"][0]["verdict"], "rewritten");
    assert_eq!(report[0]["entries"][0]["stores"][1]["place"]["line"], 9);
    let output = vrcs(&["explain", "three.wgsl", "--entry", "shad"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("did you mean `shade`?"),
        "{}",
        stderr(&output)
    );
    let output = vrcs(&["explain", "bad.wgsl"], folder.path());
    assert_eq!(status(&output), 1);
    assert!(stderr(&output).contains("bad.wgsl:1:1"));
}

/// What every pixel stores for itself is a store, too, and atomics that are weighed are told as such.
#[test]
fn explain_tells_of_full_targets_and_atomics() {
    let folder = folder();
    let shader = "
        @group(0) @binding(0) var picture: texture_storage_2d<r32uint, write>;
        @group(0) @binding(1) var normals: texture_storage_2d<r32uint, write>;
        @group(0) @binding(2) var<storage, read_write> count: atomic<u32>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            textureStore(normals, id.xy, vec4(id.x));
            textureStore(picture, id.xy, vec4(id.y));
            atomicAdd(&count, 1u);
        }";
    std::fs::write(folder.path().join("three.wgsl"), shader).expect("writable");
    let output = vrcs(
        &[
            "explain",
            "three.wgsl",
            "--json",
            "--target",
            "normals=full",
            "--atomics",
            "weight",
        ],
        folder.path(),
    );
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let told = json(&output);
    let stores = told[0]["entries"][0]["stores"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    let how = |target: &str| {
        let of = stores.iter().filter(|store| store["target"] == target);
        of.map(|store| store["how"].to_string()).collect::<Vec<_>>()
    };
    assert_eq!(how("picture"), ["\"offset\""], "{told}");
    assert_eq!(how("normals"), ["\"full\""], "{told}");
    assert_eq!(how("count"), ["\"weighed\""], "{told}");
}

#[test]
fn the_authors_word_stands_in_the_manifest() {
    let folder = folder();
    let shader = "
        @group(0) @binding(0) var<storage, read_write> a: array<u32>;
        @group(0) @binding(1) var<storage, read_write> b: array<u32>;
        @compute @workgroup_size(8, 8)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            b[id.y * 64u + id.x] = a[id.x];
        }";
    std::fs::write(folder.path().join("two.wgsl"), shader).expect("writable");
    let rewrite = |pair: &str| {
        let arguments = [
            "rewrite",
            "two.wgsl",
            "-o",
            "o.wgsl",
            "--manifest",
            "m.json",
            "--distinct",
            pair,
        ];
        vrcs(&arguments, folder.path())
    };
    let output = rewrite("a,b");
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let manifest = std::fs::read_to_string(folder.path().join("m.json")).expect("a manifest");
    assert!(
        manifest.contains("`a` and `b` are never the same memory"),
        "{manifest}"
    );
    let output = rewrite("a,c");
    assert_eq!(status(&output), 1);
    assert!(
        stderr(&output).contains("no resource called `c`"),
        "{}",
        stderr(&output)
    );
    assert_eq!(status(&rewrite("a")), 2);
}

#[test]
fn codes_are_explained() {
    let folder = folder();
    let output = vrcs(&["explain", "VRCS013"], folder.path());
    assert_eq!(status(&output), 0);
    assert!(
        stdout(&output).contains("reads what other invocations"),
        "{}",
        stdout(&output)
    );
    // with an example, and what its author is told
    let said = stdout(&output);
    assert!(said.contains("textureLoad(heights"), "{said}");
    assert!(said.contains("VRCS013.wgsl:5:"), "{said}");
    assert!(said.contains("help:"), "{said}");
    let output = vrcs(&["codes"], folder.path());
    assert_eq!(status(&output), 0);
    assert!(stdout(&output).lines().count() >= vrcs_passes::Code::ALL.len());
    let output = vrcs(&["codes", "--json"], folder.path());
    assert_eq!(
        json(&output).as_array().map(Vec::len),
        Some(vrcs_passes::Code::ALL.len())
    );
    assert_eq!(status(&vrcs(&["explain", "VRCS777"], folder.path())), 2);
}

#[test]
fn completions_and_man_pages_are_made() {
    let folder = folder();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = vrcs(&["completions", shell], folder.path());
        assert_eq!(status(&output), 0);
        assert!(stdout(&output).contains("rewrite"), "{shell}");
    }
    let output = vrcs(&["man", "pages"], folder.path());
    assert_eq!(status(&output), 0);
    let pages = names(&folder.path().join("pages"));
    assert!(pages.contains(&"vrcs.1".to_owned()) && pages.contains(&"vrcs-rewrite.1".to_owned()));
    assert!(
        !pages.iter().any(|page| page.contains("child")),
        "{pages:?}"
    );
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

#[test]
fn no_colours_where_nobody_wants_them() {
    let folder = folder();
    let output = vrcs(&["rewrite", "nothing.wgsl"], folder.path());
    assert!(!stderr(&output).contains('\x1b'));
    assert!(!stdout(&vrcs(&["explain", "good.wgsl"], folder.path())).contains('\x1b'));
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
