//! Every rewritten golden shader as SPIR-V, held against `spirv-val`.
//!
//! Without `spirv-val` on the machine the test passes over it; `tests/run.sh` installs it and sets
//! `VRCS_REQUIRE_TOOLS`, so that it cannot be passed over there.

#![cfg(feature = "spirv")]

use std::{
    io::Write,
    path::Path,
    process::{Command, Stdio},
};

use vrcs_passes::{
    Entries, Options, Source,
    emit::{self, Form},
    input, rewrite,
};

fn spirv_val() -> Option<Command> {
    let there = Command::new("spirv-val").arg("--version").output().is_ok();
    assert!(
        there || std::env::var_os("VRCS_REQUIRE_TOOLS").is_none(),
        "spirv-val is not installed: it comes with the package spirv-tools"
    );
    there.then(|| Command::new("spirv-val"))
}

#[test]
fn rewritten_shaders_are_valid_spirv() {
    if spirv_val().is_none() {
        eprintln!("skipped: spirv-val is not installed (package spirv-tools)");
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tried = 0;
    for folder in [root.join("tests/rewritten"), root.join("../tests/shaders")] {
        for entry in std::fs::read_dir(&folder).expect("shaders") {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|extension| extension != "wgsl") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a shader");
            let before = text.split("// ---- becomes ----").next().unwrap_or(&text);
            let source = Source::new(path.display().to_string(), before);
            let (module, info) = input::wgsl(&source).expect("a valid shader");
            let rewritten = rewrite(&module, &info, Entries::PerPixel, &Options::default())
                .unwrap_or_else(|refusal| panic!("{}: {refusal}", path.display()));
            for name in rewritten.manifest.entries.iter().map(|entry| &entry.name) {
                validate(&rewritten, name, &path);
                tried += 1;
            }
        }
    }
    assert!(tried > 20, "only {tried} shaders were tried");
}

fn validate(rewritten: &vrcs_passes::Rewritten, entry: &str, path: &Path) {
    // overrides are given their defaults, or 8 where they have none
    let constants = rewritten
        .module
        .overrides
        .iter()
        .filter(|(_, item)| item.init.is_none())
        .filter_map(|(_, item)| Some((item.name.clone()?, 8.0)))
        .collect();
    let form = Form {
        entry: Some(entry.to_owned()),
        constants,
        ..Form::default()
    };
    let written = emit::spirv(&rewritten.module, &rewritten.info, &form).expect("SPIR-V");
    assert_eq!(written.output.entries.len(), 1);
    let bytes = written.bytes;
    let mut child = spirv_val()
        .expect("spirv-val")
        .args(["--target-env", "vulkan1.1", "-"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("spirv-val starts");
    child
        .stdin
        .take()
        .expect("its input")
        .write_all(&bytes)
        .expect("its input takes SPIR-V");
    let output = child.wait_with_output().expect("spirv-val ends");
    assert!(
        output.status.success(),
        "{} {entry}: {}",
        path.display(),
        String::from_utf8_lossy(&output.stdout)
    );
}
