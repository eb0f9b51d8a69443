//! The program as a user meets it: what it writes, what it says when something is wrong, and how it ends.

#[path = "../common/mod.rs"]
mod common;

mod batch;
mod check;
mod demo;
mod errors;
mod explain;
mod help;
mod rewrite;

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
