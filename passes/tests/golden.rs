//! What becomes of a shader, before and after, on one screen each.
//!
//! `rewritten/*.wgsl` hold a shader, a line `// ---- becomes ----`, and the shader that it becomes; `refused/*.wgsl` hold a shader,
//! a line `// ---- is refused ----`, and what the author is told. What every rewritten shader shares (the prelude) is left out
//! of all but `rewritten/whole.wgsl`. A first line `// options: {..}` sets [`Options`]. `VRCS_BLESS=1 cargo test -p vrcs-passes --test golden` writes the second halves anew.

use std::path::{Path, PathBuf};

use vrcs_passes::{Color, Entries, Options, Source, emit, input, rewrite};

/// Functions, types and variables of the prelude.
const PRELUDE: [&str; 32] = [
    "struct VrcsParams",
    "const VRCS_",
    "var<uniform> vrcs_params",
    "var<storage> vrcs_coords",
    "var<private> vrcs_pixel",
    "var<private> vrcs_tile",
    "var<private> vrcs_copies",
    "fn vrcs_is_inside",
    "fn vrcs_is_shaded",
    "fn vrcs_each_in_domain",
    "fn vrcs_is_whole",
    "fn vrcs_holds_throughout",
    "fn vrcs_members",
    "fn vrcs_take",
    "fn vrcs_flip",
    "fn vrcs_divided",
    "fn vrcs_word_of",
    "fn vrcs_class_",
    "fn vrcs_together",
    "fn vrcs_relative",
    "fn vrcs_place",
    "fn vrcs_prefix",
    "fn vrcs_tile_",
    "fn vrcs_header",
    "fn vrcs_is_identity",
    "fn vrcs_primaries",
    "fn vrcs_group",
    "fn vrcs_change_pixel",
    "var<private> vrcs_on",
    "var<private> vrcs_lane",
    "fn vrcs_duplicate",
    "fn vrcs_delta",
];

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests")
        .join(folder);
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the folder of golden files")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_name()
        .expect("a name")
        .to_string_lossy()
        .into_owned()
}

/// The options that a shader's first line sets, as JSON over the defaults.
fn options(shader: &str) -> Options {
    let line = shader.lines().next().unwrap_or_default();
    let Some(json) = line.strip_prefix("// options: ") else {
        return Options::default();
    };
    let set: serde_json::Value = serde_json::from_str(json).expect("options as JSON");
    let mut all = serde_json::to_value(Options::default()).expect("options");
    for (name, value) in set.as_object().expect("an object") {
        assert!(all.get(name).is_some(), "there is no option `{name}`");
        all[name] = value.clone();
    }
    serde_json::from_value(all).expect("options that fit")
}

/// Holds the second half of each file against what `make` gives for the first.
fn compare(folder: &str, line: &str, make: impl Fn(&str, &str) -> String) {
    let mut wrong = Vec::new();
    for path in files(folder) {
        let text = std::fs::read_to_string(&path).expect("a golden file");
        let (before, expected) = text.split_once(line).unwrap_or((&text, ""));
        let before = before.trim_end();
        let got = make(&name(&path), before);
        if got.trim() == expected.trim() {
            continue;
        }
        if std::env::var_os("VRCS_BLESS").is_some() {
            let blessed = format!("{before}\n\n{line}\n\n{}\n", got.trim());
            std::fs::write(&path, blessed).expect("a golden file is writable");
        } else {
            wrong.push(format!("{}:\n{got}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Leaves out what all rewritten shaders share, and blank lines in a row.
fn without_prelude(text: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let is_binding_of_ours = line.starts_with("@group")
            && lines
                .peek()
                .is_some_and(|next| PRELUDE.iter().any(|item| next.starts_with(item)));
        if is_binding_of_ours {
            continue;
        }
        if PRELUDE.iter().any(|item| line.starts_with(item)) {
            if line.ends_with('{') {
                for inside in lines.by_ref() {
                    if inside == "}" {
                        break;
                    }
                }
            }
            continue;
        }
        if line.is_empty() && kept.last().is_none_or(|last| last.is_empty()) {
            continue;
        }
        kept.push(line);
    }
    kept.join("\n")
}

#[test]
fn shaders_become_what_is_written_beside_them() {
    compare("rewritten", "// ---- becomes ----", |name, before| {
        let source = Source::new(name, before);
        let (module, info) = input::wgsl(&source).expect("a valid shader");
        let rewritten = rewrite(&module, &info, Entries::PerPixel, &options(before))
            .unwrap_or_else(|refusal| panic!("{}", refusal.render(&source, Color::Never)));
        let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("text");
        let mut warnings: String = rewritten
            .warnings
            .iter()
            .map(|(_, warning)| warning.render(&source, Color::Never))
            .flat_map(|text| {
                text.lines()
                    .map(|l| format!("// {l}").trim_end().to_owned() + "\n")
                    .collect::<Vec<_>>()
            })
            .collect();
        if !warnings.is_empty() {
            warnings.push('\n');
        }
        match name {
            "whole.wgsl" => text,
            _ => warnings + &without_prelude(&text),
        }
    });
}

#[test]
fn authors_are_told_why_their_shader_is_refused() {
    compare("refused", "// ---- is refused ----", |name, before| {
        let source = Source::new(name, before);
        let (module, info) =
            input::wgsl(&source).unwrap_or_else(|invalid| panic!("{name}: {}", invalid.rendered));
        match rewrite(&module, &info, Entries::PerPixel, &options(before)) {
            Ok(rewritten) => format!("It was not refused:\n{:?}", rewritten.manifest),
            Err(refusal) => refusal.render(&source, Color::Never),
        }
    });
}
