//! Files in and out: `-` is standard input or output; what is written is written whole or not at all.

use std::{
    io::{Read, Write},
    path::Path,
};

use super::Failure;
use crate::atomic::Pending;

/// Whether a path stands for standard input or output.
pub(crate) fn is_stream(path: &Path) -> bool {
    path == Path::new("-")
}

/// Reads a shader's text.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    String::from_utf8(read_bytes(path)?).map_err(|_| unreadable(path, "it is not text"))
}

/// Reads a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = match is_stream(path) {
        true => std::io::stdin().read_to_end(&mut bytes),
        false => std::fs::File::open(path).and_then(|mut file| file.read_to_end(&mut bytes)),
    };
    match read {
        Ok(_) => Ok(bytes),
        Err(error) => {
            let why = match error.kind() {
                std::io::ErrorKind::NotFound => match nearest(path) {
                    Some(near) => format!("there is no such file; did you mean {near}?"),
                    None => "there is no such file".to_owned(),
                },
                std::io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
                _ => error.to_string(),
            };
            Err(unreadable(path, &why))
        }
    }
}

/// The file beside a path whose name it is most likely a misspelling of.
fn nearest(path: &Path) -> Option<String> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let stem = |path: &Path| Some(path.file_stem()?.to_str()?.to_owned());
    // a folder of thousands is not searched for a slip of a finger
    let files = std::fs::read_dir(folder).ok()?.take(1000).flatten();
    let mut files: Vec<_> = files.map(|file| file.path()).collect();
    files.sort_by_key(|file| (file.extension() != path.extension(), file.clone()));
    // without the extension, which names have in common
    let stems: Vec<String> = files.iter().filter_map(|file| stem(file)).collect();
    let near = vrcs_passes::near::nearest(&stem(path)?, stems.iter().map(String::as_str))?;
    let found = files
        .iter()
        .find(|file| stem(file).as_deref() == Some(near))?;
    Some(
        path.with_file_name(found.file_name()?)
            .display()
            .to_string(),
    )
}

fn unreadable(path: &Path, why: &str) -> Failure {
    let name = match is_stream(path) {
        true => "standard input".to_owned(),
        false => path.display().to_string(),
    };
    Failure::Outside(format!("{name}: {why}"))
}

/// What a text is called in messages.
pub(crate) fn display_name(path: &Path) -> String {
    match is_stream(path) {
        true => "<stdin>".to_owned(),
        false => path.display().to_string(),
    }
}

/// Whether two paths lead to one file. A file that does not exist is compared by its folder and name.
pub(crate) fn is_same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        path.canonicalize().ok().or_else(|| {
            let folder = match path.parent() {
                Some(parent) if !parent.as_os_str().is_empty() => parent.canonicalize().ok()?,
                _ => std::env::current_dir().ok()?,
            };
            Some(folder.join(path.file_name()?))
        })
    };
    if is_stream(a) || is_stream(b) {
        return false;
    }
    a == b || matches!((resolved(a), resolved(b)), (Some(a), Some(b)) if a == b)
}

/// Writes a file beside its place; [`Pending::appear`] puts it there.
pub(crate) fn prepare(path: &Path, bytes: &[u8]) -> Result<Pending, Failure> {
    if path.is_dir() {
        return Err(Failure::Outside(format!(
            "{}: it is a folder",
            path.display()
        )));
    }
    Pending::new(path, bytes).map_err(|error| unwritable(path, &error))
}

/// Tells why a file cannot be written.
pub(crate) fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    let why = match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such folder".to_owned(),
        std::io::ErrorKind::PermissionDenied => "the folder cannot be written to".to_owned(),
        std::io::ErrorKind::StorageFull => "the disk is full".to_owned(),
        _ => error.to_string(),
    };
    Failure::Outside(format!("{}: {why}", path.display()))
}

/// Writes bytes to standard output.
pub(crate) fn to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(bytes)
        .and_then(|()| stdout.flush())
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::BrokenPipe => Failure::Outside(String::new()),
            _ => Failure::Outside(format!("standard output: {error}")),
        })
}
