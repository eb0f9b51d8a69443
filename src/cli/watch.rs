//! `--watch`: does it again whenever a file changes.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::mpsc::channel,
    time::Duration,
};

use notify::{RecursiveMode, Watcher};

use super::{Failure, inputs::In, talk};

/// How long files have to be quiet before the work begins: editors write a file in several steps.
const QUIET: Duration = Duration::from_millis(80);

/// Runs `work` now and whenever a file changes, until the program is ended. What is refused is told and tried again.
pub(super) fn run(
    input: &In,
    work: impl Fn() -> Result<Vec<PathBuf>, Failure>,
) -> Result<(), Failure> {
    let outside =
        |error: notify::Error| Failure::Outside(format!("files cannot be watched: {error}"));
    let (sender, events) = channel();
    let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
        let is_change = event.is_ok_and(|event| !event.kind.is_access());
        // after the end there is nobody to tell
        let _ = is_change.then(|| sender.send(()));
    })
    .map_err(outside)?;
    let mut watched: BTreeSet<PathBuf> = BTreeSet::new();
    let mut watch = |path: &Path, mode| match watched.insert(path.to_owned()) {
        true => watcher.watch(path, mode).map_err(outside),
        false => Ok(()),
    };
    for path in input
        .shaders
        .iter()
        .chain(&input.imports)
        .chain(&input.with)
    {
        match path.is_dir() {
            true => watch(path, RecursiveMode::Recursive)?,
            // an editor puts a new file in the place of the old one: its folder is watched
            false => watch(folder(path), RecursiveMode::NonRecursive)?,
        }
    }
    loop {
        match work() {
            Ok(files) => {
                for file in files {
                    watch(folder(&file), RecursiveMode::NonRecursive)?;
                }
            }
            Err(Failure::Misused(message)) => return Err(Failure::Misused(message)),
            Err(failure) if failure.message().is_empty() => {}
            Err(failure) => talk::error(failure.message()),
        }
        talk::say("watching for changes");
        // what was written by the work itself changes nothing that is read
        while events.recv_timeout(QUIET).is_ok() {}
        if events.recv().is_err() {
            return Ok(());
        }
        while events.recv_timeout(QUIET).is_ok() {}
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}
