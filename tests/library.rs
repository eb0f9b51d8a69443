//! What the library never does, read off its own text: it makes no device, submits, polls, prints or exits.

use std::path::{Path, PathBuf};

/// What is behind the feature `cli`: the program, and what it is made of.
const PROGRAM: [&str; 11] = [
    "atomic.rs",
    "bench",
    "check",
    "cli",
    "demo",
    "main.rs",
    "metrics",
    "scenes",
    "tradeoff",
    "web",
    "tests.rs",
];

/// Calls that belong to the renderer or the program.
const FORBIDDEN: [&str; 9] = [
    ".submit(",
    ".poll(",
    "request_device(",
    "request_adapter(",
    "println!(",
    "print!(",
    "eprint!(",
    "process::exit",
    "pollster",
];

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of ours") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .unwrap_or_default();
        if PROGRAM.contains(&name) {
            continue;
        }
        match path.is_dir() {
            true => collect(&path, files),
            false => files.push(path),
        }
    }
}

#[test]
fn the_library_leaves_device_queue_and_terminal_to_its_user() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    collect(&root.join("src"), &mut files);
    collect(&root.join("passes/src"), &mut files);
    assert!(files.len() > 80, "{} files", files.len());
    for file in files {
        // a build script's output is how it speaks to cargo
        if file.ends_with("passes/src/build/mod.rs") || file.ends_with("passes/src/build/rust.rs") {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a text");
        let code = text
            .split("#[cfg(test)]\nmod tests")
            .next()
            .unwrap_or_default()
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        for (number, line) in code.enumerate() {
            for forbidden in FORBIDDEN {
                assert!(
                    !line.contains(forbidden),
                    "{}, about line {number}: `{forbidden}` in `{line}`",
                    file.display()
                );
            }
        }
    }
}
