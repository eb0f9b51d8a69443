//! The files that shaders lie in.

use std::{
    io,
    path::{Path, PathBuf},
};

/// Every file of a folder and the folders in it, by name. Hidden ones are left out, and those for which `is_left_out` holds.
///
/// # Errors
/// If a folder cannot be read.
pub fn files(folder: &Path, is_left_out: &dyn Fn(&Path) -> bool) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            let inner = entry.path();
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if is_hidden || is_left_out(&inner) {
                continue;
            }
            // links to folders may lead in circles
            match entry.file_type()? {
                kind if kind.is_dir() => folders.push(inner),
                _ if inner.is_file() => found.push(inner),
                _ => {}
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The files beside a shader that it imports by name: `#import "file.wgsl"`.
pub fn imported_by_name(path: &Path, text: &str) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    text.lines()
        .filter(|line| line.trim_start().starts_with('#') && line.contains("import"))
        .filter_map(|line| line.split('"').nth(1))
        .map(|name| folder.join(name))
        .collect()
}
