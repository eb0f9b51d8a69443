//! The examples run, and the README shows what they are: no line in it that was not compiled and run.

use std::{path::Path, process::Command};

/// The program of an example. `cargo test --workspace` has built it beside this test, which `tests/run.sh` says by `VRCS_EXAMPLES_BUILT`;
/// whoever runs this test alone has Cargo build it, for which it compiles much of the workspace anew, with other features.
fn command(name: &str) -> Command {
    if std::env::var_os("VRCS_EXAMPLES_BUILT").is_some() {
        let this = std::env::current_exe().expect("this test's own path");
        let target = this.ancestors().nth(2).expect("target/debug/deps");
        return Command::new(target.join("examples").join(name));
    }
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--offline", "--example", name]);
    cargo
}

/// Runs an example and gives what it printed.
fn run(name: &str) -> String {
    let output = command(name)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("a program that starts");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}:\n{printed}\n{told}");
    printed
}

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).expect("a file of the repository")
}

/// The README's fenced blocks of a language.
fn blocks(language: &str) -> Vec<String> {
    let readme = read("README.md");
    let opening = format!("```{language}\n");
    let parts = readme.split(&opening).skip(1);
    parts
        .map(|part| part.split("```").next().unwrap_or_default().to_owned())
        .collect()
}

/// Lines without their indentation, empty ones left out.
fn lines(text: &str) -> Vec<&str> {
    text.lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect()
}

#[test]
fn an_existing_pass_becomes_variable_rate() {
    let printed = run("existing_pass");
    assert!(printed.contains("PSNR"), "{printed}");
}

#[test]
fn deferred_passes_share_a_view() {
    let printed = run("deferred");
    assert!(printed.contains("composite"), "{printed}");
}

#[test]
fn rays_scale_with_the_pixels_that_share_them() {
    let printed = run("ray_scaling");
    assert!(printed.contains("10.000 at full rate"), "{printed}");
}

#[test]
fn the_hardware_gets_its_image() {
    let printed = run("hardware_attachment");
    assert!(
        printed.contains("D3D12") && printed.contains("Vulkan"),
        "{printed}"
    );
}

#[test]
fn tiles_are_classified() {
    let printed = run("classify");
    assert!(printed.contains("expensive"), "{printed}");
}

/// The README's diff is that of the two files, and ten lines are all that is new.
#[test]
fn the_readme_shows_what_changes_in_an_existing_pass() {
    let before = read("examples/existing_pass/plain.rs");
    let after = read("examples/existing_pass/variable.rs");
    let body = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| !line.starts_with("//!"));
        lines
            .filter(|line| !line.trim().is_empty())
            .map(str::to_owned)
            .collect()
    };
    let (before, after) = (body(&before), body(&after));
    let shown = blocks("diff").concat();
    let side = |other: char| -> Vec<String> {
        let lines = shown.lines().filter(|line| !line.starts_with(other));
        lines
            .map(|line| line.get(1..).unwrap_or_default().to_owned())
            .filter(|line| !line.trim().is_empty())
            .collect()
    };
    assert_eq!(side('+'), before, "the README's old side");
    assert_eq!(side('-'), after, "the README's new side");
    let added = shown.lines().filter(|line| line.starts_with('+')).count();
    assert!(added <= 10, "{added} lines are new");
}

/// Each snippet of Rust stands, line by line, in a file that is compiled and run.
#[test]
fn the_readmes_rust_was_compiled() {
    let sources = [
        "examples/existing_pass/variable.rs",
        "examples/deferred/main.rs",
        "examples/build_time/build.rs",
        "examples/build_time/src/main.rs",
        "passes/examples/rewrite.rs",
    ]
    .map(read);
    let snippets = blocks("rust");
    assert!(!snippets.is_empty());
    for snippet in snippets {
        let wanted = lines(&snippet);
        let is_there = sources.iter().any(|source| {
            let source = lines(source);
            source
                .windows(wanted.len())
                .any(|window| window == wanted.as_slice())
        });
        assert!(is_there, "not in any example:\n{snippet}");
    }
}
