//! What the library never does, read off its own text: it makes no device, submits, polls, prints or exits; and what a user gets wrong
//! is an error, never a panic.

use std::path::{Path, PathBuf};

/// What is behind the feature `cli`: the program, and what it is made of.
const PROGRAM: [&str; 12] = [
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
    "tests",
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

/// What panics.
const PANICS: [&str; 6] = [
    "panic!(",
    "unreachable!(",
    "todo!(",
    "unimplemented!(",
    ".unwrap()",
    ".expect(",
];

/// Where something may panic all the same: how often, and why no user can bring it about.
const OWN_INVARIANTS: [(&str, usize, &str); 23] = [
    (
        "src/kernel.rs",
        2,
        "kernels of ours compose: `tests/compose.rs` composes each",
    ),
    (
        "passes/src/prelude/mod.rs",
        2,
        "texts of ours, parsed by the tests of every mode",
    ),
    (
        "passes/src/instrument/mod.rs",
        2,
        "a text of ours; the walk has found the resources",
    ),
    ("passes/src/instrument/subgroups.rs", 1, "a text of ours"),
    (
        "passes/src/examples.rs",
        2,
        "examples of ours, which a test rewrites each",
    ),
    (
        "passes/src/ir/import.rs",
        4,
        "the prelude's own functions and variables",
    ),
    (
        "passes/src/ir/build.rs",
        1,
        "vectors have two to four components",
    ),
    (
        "passes/src/inline.rs",
        1,
        "naga accepted the module before a helper moved into its caller",
    ),
    (
        "passes/src/deep.rs",
        1,
        "a thread that ends without a panic has an outcome",
    ),
    (
        "passes/src/manifest.rs",
        1,
        "plain data without maps of other keys than text",
    ),
    ("passes/src/build/rust.rs", 1, "text in memory"),
    ("passes/src/detail.rs", 1, "the plan lists samples alone"),
    (
        "passes/src/analysis/walk/calls.rs",
        2,
        "naga's validator has typed the call",
    ),
    (
        "passes/src/analysis/walk/control.rs",
        2,
        "the walk's own targets of jumps",
    ),
    (
        "passes/src/instrument/address.rs",
        5,
        "the walk has resolved the access",
    ),
    (
        "passes/src/transform/mod.rs",
        1,
        "the plan chose the entry points",
    ),
    (
        "passes/src/transform/settled.rs",
        1,
        "only conditions are settled",
    ),
    (
        "passes/src/transform/specialise.rs",
        7,
        "the analysis numbered the statements, and followed the same pointers",
    ),
    (
        "passes/src/transform/recompute.rs",
        2,
        "the plan found the term computable",
    ),
    (
        "passes/src/transform/copies.rs",
        6,
        "the plan found the store's address",
    ),
    (
        "passes/src/transform/regions/entry.rs",
        1,
        "imported where a region is masked",
    ),
    (
        "passes/src/transform/regions/mod.rs",
        2,
        "naga's validator has typed the expression",
    ),
    (
        "passes/src/transform/regions/room.rs",
        3,
        "naga's validator has laid out the types",
    ),
];

/// The files of the library, with the text of their code: no comments, no tests.
fn code() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    collect(&root.join("src"), &mut files);
    collect(&root.join("passes/src"), &mut files);
    assert!(files.len() > 80, "{} files", files.len());
    let read = |file: PathBuf| {
        let text = std::fs::read_to_string(&file).expect("a text");
        let code = text.split("#[cfg(test)]\nmod tests").next();
        let lines = code.unwrap_or_default().lines();
        let lines = lines.filter(|line| !line.trim_start().starts_with("//"));
        let name = file.strip_prefix(root).expect("a file of ours");
        let name = name.to_string_lossy().replace('\\', "/");
        (name, lines.collect::<Vec<_>>().join("\n"))
    };
    files.into_iter().map(read).collect()
}

#[test]
fn the_library_panics_over_nothing_that_a_user_can_bring_about() {
    for (file, code) in code() {
        let found = code
            .lines()
            .filter(|line| PANICS.iter().any(|panics| line.contains(panics)));
        let found: Vec<&str> = found.collect();
        let allowed = OWN_INVARIANTS.iter().find(|(name, _, _)| *name == file);
        let (most, why) = allowed.map_or((0, ""), |(_, most, why)| (*most, *why));
        assert_eq!(
            found.len(),
            most,
            "{file} ({why}): what a user can bring about is an error with what to do, and what no user can is listed in this test: {found:#?}"
        );
        // a twin in memory takes slices, and says what becomes of one that is too short
        let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(&file));
        let asserts = code.lines().any(|line| {
            let line = line.trim_start();
            line.starts_with("assert!(") || line.starts_with("assert_eq!(")
        });
        let is_documented = text.expect("a text").contains("# Panics");
        assert!(
            !asserts || is_documented,
            "{file} asserts, and no doc of it has `# Panics`"
        );
    }
}

#[test]
fn the_library_leaves_device_queue_and_terminal_to_its_user() {
    for (file, code) in code() {
        // a build script's output is how it speaks to cargo
        if file.ends_with("passes/src/build/mod.rs") || file.ends_with("passes/src/build/rust.rs") {
            continue;
        }
        for (number, line) in code.lines().enumerate() {
            for forbidden in FORBIDDEN {
                assert!(
                    !line.contains(forbidden),
                    "{file}, about line {number}: `{forbidden}` in `{line}`"
                );
            }
        }
    }
}
