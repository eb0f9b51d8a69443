//! Many shaders at once: in parallel, each on its own, the unchanged skipped, the order and the text always the same.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{
    Failure, files,
    inputs::{Inputs, Work},
    make::{Made, Status, Wish, make},
    talk,
};

/// Where a batch keeps what it has done, in the folder that it writes to.
const RECORD: &str = ".vrcs.json";

/// What has been done.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Record {
    version: u32,
    /// By the shader's place below the folder.
    shaders: BTreeMap<String, Done>,
}

/// A shader that has been rewritten.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Done {
    /// The hash of all that it was made from.
    from: String,
    /// The hash of the shader and the manifest that were written.
    to: String,
}

/// A shader of a batch, done.
pub(super) struct Outcome<'i> {
    pub(super) work: &'i Work,
    pub(super) output: PathBuf,
    pub(super) manifest: PathBuf,
    pub(super) made: Made,
}

/// Rewrites all shaders into a folder.
pub(super) fn run<'i>(
    inputs: &'i Inputs,
    folder: &Path,
    wish: &Wish,
    is_forced: bool,
) -> Result<Vec<Outcome<'i>>, Failure> {
    let places = places(inputs, folder, wish)?;
    let record = match is_forced {
        true => Record::default(),
        false => read_record(folder),
    };
    let progress = talk::Progress::new(inputs.works.len());
    let outcomes: Vec<(Outcome, Option<Done>)> = inputs
        .works
        .par_iter()
        .zip(places)
        .map(|(work, (output, manifest))| {
            let done = record.shaders.get(&key(work));
            let (made, done) = one(inputs, work, wish, done, &output, &manifest);
            progress.step(&work.name);
            let outcome = Outcome {
                work,
                output,
                manifest,
                made,
            };
            (outcome, done)
        })
        .collect();
    progress.done();
    write_record(folder, &outcomes)?;
    Ok(outcomes.into_iter().map(|(outcome, _)| outcome).collect())
}

fn key(work: &Work) -> String {
    work.below.to_string_lossy().replace('\\', "/")
}

/// Where each shader and its manifest go. No two go to one place.
fn places(inputs: &Inputs, folder: &Path, wish: &Wish) -> Result<Vec<(PathBuf, PathBuf)>, Failure> {
    let mut taken: BTreeMap<PathBuf, &Work> = BTreeMap::new();
    let mut places = Vec::new();
    for work in &inputs.works {
        let output = folder
            .join(&work.below)
            .with_extension(wish.target.language().extension());
        if work.paths.iter().any(|path| files::is_same(path, &output)) {
            return Err(Failure::Misused(format!(
                "{} is the shader itself: choose another folder to write to",
                output.display()
            )));
        }
        if let Some(other) = taken.insert(output.clone(), work) {
            return Err(Failure::Misused(format!(
                "{} and {} would both be written to {}",
                other.name,
                work.name,
                output.display()
            )));
        }
        let manifest = output.with_extension("json");
        places.push((output, manifest));
    }
    Ok(places)
}

fn one(
    inputs: &Inputs,
    work: &Work,
    wish: &Wish,
    done: Option<&Done>,
    output: &Path,
    manifest: &Path,
) -> (Made, Option<Done>) {
    let from = hash_of_inputs(inputs, work, wish);
    if let Some(done) = done
        && from.as_deref() == Some(done.from.as_str())
        && hash_of_files(output, manifest).as_deref() == Some(done.to.as_str())
    {
        return (Made::new(Status::Unchanged), Some(done.clone()));
    }
    let made = make(inputs, work, wish);
    let Some((bytes, data)) = &made.written else {
        return (made, None);
    };
    match write(output, bytes, manifest, &data.to_json()) {
        Ok(()) => {
            let done = from.zip(hash_of_files(output, manifest));
            let done = done.map(|(from, to)| Done { from, to });
            (made, done)
        }
        Err(failure) => {
            let made = Made::new(Status::Failed);
            (made.say(talk::labelled_error(failure.message())), None)
        }
    }
}

fn write(output: &Path, bytes: &[u8], manifest: &Path, json: &str) -> Result<(), Failure> {
    if let Some(parent) = output.parent() {
        std::fs::create_dir_all(parent).map_err(|error| files::unwritable(parent, &error))?;
    }
    let shader = files::prepare(output, bytes)?;
    let data = files::prepare(manifest, json.as_bytes())?;
    shader
        .appear()
        .map_err(|error| files::unwritable(output, &error))?;
    data.appear()
        .map_err(|error| files::unwritable(manifest, &error))
}

/// The hash of all that a shader is made from; `None` if a file cannot be read.
fn hash_of_inputs(inputs: &Inputs, work: &Work, wish: &Wish) -> Option<String> {
    let read = inputs.read(work).ok()?;
    let mut hash = Sha256::new();
    let mut add = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    add(env!("CARGO_PKG_VERSION").as_bytes());
    // a build of the same version may have another rewriter
    add(build_of_the_program().as_bytes());
    add(format!(
        "{:?} {:?} {} {:?} {}",
        wish.entry, wish.options, wish.target, wish.form, work.language
    )
    .as_bytes());
    add(format!("{read:?}").as_bytes());
    Some(hex(&hash.finalize()))
}

/// The program's size and time of change.
pub(super) fn build_of_the_program() -> String {
    let program = std::env::current_exe().and_then(std::fs::metadata);
    program.map_or(String::new(), |data| {
        format!("{} {:?}", data.len(), data.modified().ok())
    })
}

fn hash_of_files(output: &Path, manifest: &Path) -> Option<String> {
    let mut hash = Sha256::new();
    for path in [output, manifest] {
        let bytes = std::fs::read(path).ok()?;
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(&bytes);
    }
    Some(hex(&hash.finalize()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A record that is not there or not understood is an empty one.
fn read_record(folder: &Path) -> Record {
    let text = std::fs::read_to_string(folder.join(RECORD)).unwrap_or_default();
    let record: Record = serde_json::from_str(&text).unwrap_or_default();
    match record.version {
        1 => record,
        _ => Record::default(),
    }
}

fn write_record(folder: &Path, outcomes: &[(Outcome, Option<Done>)]) -> Result<(), Failure> {
    let shaders: BTreeMap<String, Done> = outcomes
        .iter()
        .filter_map(|(outcome, done)| Some((key(outcome.work), done.clone()?)))
        .collect();
    if shaders.is_empty() {
        return Ok(());
    }
    let record = Record {
        version: 1,
        shaders,
    };
    let path = folder.join(RECORD);
    let json = match serde_json::to_string_pretty(&record) {
        Ok(json) => json + "\n",
        Err(error) => unreachable!("a record is plain data: {error}"),
    };
    files::prepare(&path, json.as_bytes())?
        .appear()
        .map_err(|error| files::unwritable(&path, &error))
}
