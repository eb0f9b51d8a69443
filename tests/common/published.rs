//! Shaders that others have published in crates. Their text is fetched when a test wants it, and is never part of this
//! repository.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// The unpacked source of a crate; `None` if the machine is told to stay offline.
///
/// # Panics
/// If the crate cannot be fetched.
pub fn crate_source(name: &str, version: &str) -> Option<PathBuf> {
    let folder = format!("{name}-{version}");
    if let Some(found) = unpacked(&folder) {
        return Some(found);
    }
    if std::env::var_os("VRCS_OFFLINE").is_some() {
        eprintln!("skipped: {folder} is not here, and VRCS_OFFLINE is set");
        return None;
    }
    // `cargo info` unpacks a crate into the registry's cache without its dependencies
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args([
            "info",
            "--registry",
            "crates-io",
            &format!("{name}@{version}"),
        ])
        .current_dir(std::env::temp_dir())
        .output()
        .expect("cargo");
    let found = unpacked(&folder);
    assert!(
        found.is_some(),
        "{folder} could not be fetched (set VRCS_OFFLINE to pass over it): {}",
        String::from_utf8_lossy(&output.stderr)
    );
    found
}

fn unpacked(folder: &str) -> Option<PathBuf> {
    let home = match std::env::var_os("CARGO_HOME") {
        Some(home) => PathBuf::from(home),
        None => Path::new(&std::env::var_os("HOME")?).join(".cargo"),
    };
    std::fs::read_dir(home.join("registry/src"))
        .ok()?
        .filter_map(|registry| Some(registry.ok()?.path().join(folder)))
        .find(|path| path.is_dir())
}
