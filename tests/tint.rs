//! Rewritten text is accepted by Tint wherever Tint accepts the author's text.

#[path = "common/browser.rs"]
mod browser;
mod common;

use std::{collections::BTreeMap, path::Path};

use vrcs_passes::{Entries, Options, Source, emit, input, rewrite};

/// All shaders of the tests that are rewritten.
fn shaders() -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut shaders = BTreeMap::new();
    for folder in [
        "tests/shaders",
        "tests/barrier_shaders",
        "passes/tests/rewritten",
        "shaders",
    ] {
        for entry in std::fs::read_dir(root.join(folder)).expect("shaders") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a shader");
            let before = text
                .split("// ---- becomes ----")
                .next()
                .unwrap_or_default()
                .to_owned();
            // kernels of the runtime are composed, and not rewritten
            if !before.contains("#{") && !before.contains("#define_import_path") {
                let name = path
                    .strip_prefix(root)
                    .expect("a shader of ours")
                    .display()
                    .to_string();
                shaders.insert(name, before);
            }
        }
    }
    shaders
}

#[test]
fn tint_accepts_what_is_rewritten() {
    let mut texts = BTreeMap::new();
    for (name, before) in shaders() {
        let source = Source::new(name.clone(), before.clone());
        let (module, info) = input::wgsl(&source).expect("a valid shader");
        let rewritten = rewrite(&module, &info, Entries::PerPixel, &Options::default())
            .unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
        let text = emit::wgsl(&rewritten.module, &rewritten.info).expect("text");
        texts.insert(format!("{name} before"), before);
        texts.insert(format!("{name} after"), text);
    }
    let Some(found) = browser::tint(&texts) else {
        return;
    };
    assert_eq!(found.len(), texts.len());
    let mut accepted = 0;
    for (name, messages) in &found {
        let Some(name) = name.strip_suffix(" before") else {
            continue;
        };
        let after = &found[&format!("{name} after")];
        if messages.is_empty() {
            assert!(
                after.is_empty(),
                "{name}: {after:?}\n{}",
                texts[&format!("{name} after")]
            );
            accepted += 1;
        } else {
            println!("Tint does not accept {name} as it was: {messages:?}");
        }
    }
    assert!(
        accepted > 25,
        "only {accepted} shaders were accepted before they were rewritten"
    );
}

#[test]
fn tint_is_asked_in_earnest() {
    let texts = BTreeMap::from([
        ("wrong".to_owned(), "fn f() { x }".to_owned()),
        ("right".to_owned(), "fn f() { }".to_owned()),
    ]);
    if let Some(found) = browser::tint(&texts) {
        assert!(!found["wrong"].is_empty());
        assert!(found["right"].is_empty());
    }
}
