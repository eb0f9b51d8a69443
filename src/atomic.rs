//! Files that are written whole or not at all: first beside their place, then renamed into it.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// A file that is about to appear; dropped, it never does.
#[derive(Debug)]
pub struct Pending {
    path: PathBuf,
    temporary: tempfile::NamedTempFile,
}

impl Pending {
    /// Writes a file beside its place.
    ///
    /// # Errors
    /// If the folder cannot be written to.
    pub fn new(path: &Path, bytes: &[u8]) -> io::Result<Pending> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut temporary = tempfile::Builder::new()
            .prefix(".vrcs-")
            .tempfile_in(folder)?;
        temporary.write_all(bytes)?;
        temporary.flush()?;
        make_readable(path, temporary.path());
        Ok(Pending {
            path: path.to_owned(),
            temporary,
        })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If it cannot be renamed.
    pub fn appear(self) -> io::Result<()> {
        self.temporary
            .persist(&self.path)
            .map(|_| ())
            .map_err(|error| error.error)
    }
}

/// Writes a file whole.
///
/// # Errors
/// If the folder cannot be written to.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    Pending::new(path, bytes)?.appear()
}

/// Temporary files are private; what the user gets is as readable as what it replaces, or as any other file.
fn make_readable(path: &Path, temporary: &Path) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(path).map_or(0o644, |m| m.permissions().mode() & 0o777);
        // a file that stays private is still written
        let _ = std::fs::set_permissions(temporary, std::fs::Permissions::from_mode(mode));
    }
    #[cfg(not(unix))]
    let _ = (path, temporary);
}
