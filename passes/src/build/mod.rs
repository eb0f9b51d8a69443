//! For build scripts: shaders rewritten while a crate is built, and typed constants for what they bind.
//!
//! ```no_run
//! // build.rs
//! vrcs_passes::build::Rewriter::new()
//!     .folder("shaders")
//!     .write_to_out_dir();
//! ```
//! ```ignore
//! // main.rs
//! mod shaders {
//!     include!(concat!(env!("OUT_DIR"), "/vrcs.rs"));
//! }
//! let groups = shaders::lighting::shade::ENTRY.groups([1920, 1080, 1]);
//! ```
//!
//! *Does*: rewrites each shader and writes it, its manifest, and one Rust module for all of them; tells Cargo which files
//! they are made from.
//! *Guarantees*: the same files for the same input; nothing is written unless every shader could be rewritten; files whose
//! content stays the same keep their time of change, so that nothing is compiled in vain.
//! *Refuses*: what the rewriter refuses, with the rendered message; then the build fails.

mod rust;

use std::{
    collections::BTreeMap,
    fmt, io,
    path::{Path, PathBuf},
};

use naga::{Module, proc::Layouter, valid::ModuleInfo};

use crate::{
    Code, Color, Entries, Options,
    emit::{self, Form, Target},
    input::{self, Language, Reader, Shader, compose},
    manifest::{Manifest, Warning},
};

/// What is rewritten, and how.
#[derive(Clone, Debug, Default)]
pub struct Rewriter {
    sources: Vec<Source>,
    imports: Vec<PathBuf>,
    reader: Reader,
    entry: Option<String>,
    options: Options,
    target: Target,
    form: Form,
}

/// Where shaders lie.
#[derive(Clone, Debug)]
enum Source {
    /// Each file is a shader.
    Folder(PathBuf),
    /// All files together are one.
    Files(Vec<PathBuf>),
}

/// What was written.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The rewritten shaders, by their names.
    pub shaders: Vec<PathBuf>,
    /// The Rust module.
    pub module: PathBuf,
    /// The files and folders that it was all made from.
    pub inputs: Vec<PathBuf>,
    /// What the authors should know, a line each.
    pub warnings: Vec<String>,
}

/// Why a build failed: every shader that is at fault, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed {
    /// The rendered messages.
    pub messages: Vec<String>,
    /// The files and folders that were looked at.
    pub inputs: Vec<PathBuf>,
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.messages.join("\n"))
    }
}

impl std::error::Error for Failed {}

/// A shader that has been rewritten.
struct Done {
    /// Its name in the Rust module.
    name: String,
    /// What it was made from, for documentation.
    from: String,
    /// Where it goes, below the output folder.
    below: PathBuf,
    bytes: Vec<u8>,
    manifest: Manifest,
    /// Its own bindings: name, group, number, and the size in bytes where it is fixed.
    bindings: Vec<(String, u32, u32, Option<u32>)>,
}

impl Rewriter {
    /// Nothing to rewrite yet, and the default [`Options`].
    pub fn new() -> Rewriter {
        Rewriter::default()
    }

    /// Every shader of a folder and the folders in it. Files with a `#define_import_path` can be imported by the others; shaders
    /// that store nothing per pixel are passed by.
    pub fn folder(mut self, path: impl Into<PathBuf>) -> Rewriter {
        self.sources.push(Source::Folder(path.into()));
        self
    }

    /// A shader of one file.
    pub fn file(self, path: impl Into<PathBuf>) -> Rewriter {
        self.files([path.into()])
    }

    /// A shader of several files, joined in order. It gets the last file's name.
    pub fn files<P: Into<PathBuf>>(mut self, paths: impl IntoIterator<Item = P>) -> Rewriter {
        let paths = paths.into_iter().map(Into::into).collect();
        self.sources.push(Source::Files(paths));
        self
    }

    /// A file, or a folder of files, that shaders may `#import`.
    pub fn import(mut self, path: impl Into<PathBuf>) -> Rewriter {
        self.imports.push(path.into());
        self
    }

    /// Defines a name for `#ifdef`, `#if` and `#{NAME}`.
    pub fn define(mut self, name: impl Into<String>, value: impl Into<String>) -> Rewriter {
        self.reader = self.reader.define(name, value);
        self
    }

    /// The entry point; every one that stores per pixel if not given.
    pub fn entry(mut self, name: impl Into<String>) -> Rewriter {
        self.entry = Some(name.into());
        self
    }

    /// How shaders are rewritten.
    pub fn options(mut self, options: Options) -> Rewriter {
        self.options = options;
        self
    }

    /// The language that is written; WGSL if not given.
    pub fn target(mut self, target: impl Into<Target>) -> Rewriter {
        self.target = target.into();
        self
    }

    /// Values of overrides and bounds checks, for other languages than WGSL.
    pub fn form(mut self, form: Form) -> Rewriter {
        self.form = form;
        self
    }

    /// Writes everything into Cargo's `OUT_DIR`, and the Rust module as `vrcs.rs`.
    ///
    /// Tells Cargo on standard output which files to look at, and warnings. If a shader cannot be rewritten, it tells why on standard
    /// error and **ends the process** with status 1, which fails the build; outside of a build script use
    /// [`write_to`](Rewriter::write_to).
    pub fn write_to_out_dir(&self) {
        let Some(out) = std::env::var_os("OUT_DIR") else {
            eprintln!("vrcs_passes::build: OUT_DIR is not set: this is for build scripts");
            std::process::exit(1);
        };
        let outcome = self.write_to(Path::new(&out));
        let inputs = match &outcome {
            Ok(built) => &built.inputs,
            Err(failed) => &failed.inputs,
        };
        for input in inputs {
            println!("cargo::rerun-if-changed={}", input.display());
        }
        match outcome {
            Ok(built) => {
                for warning in built.warnings {
                    println!("cargo::warning={warning}");
                }
            }
            Err(failed) => {
                eprintln!("{failed}");
                std::process::exit(1);
            }
        }
    }

    /// Writes everything into a folder, and the Rust module as `vrcs.rs`.
    ///
    /// # Errors
    /// Every shader that cannot be rewritten, and every file that cannot be read or written. Then nothing is written.
    pub fn write_to(&self, folder: &Path) -> Result<Built, Failed> {
        let mut job = Job {
            rewriter: self,
            reader: self.reader.clone(),
            works: Vec::new(),
            inputs: Vec::new(),
            messages: Vec::new(),
            warnings: Vec::new(),
        };
        job.gather();
        let done = job.rewrite();
        if job.messages.is_empty() {
            match job.write(folder, &done) {
                Ok((shaders, module)) => {
                    return Ok(Built {
                        shaders,
                        module,
                        inputs: job.inputs,
                        warnings: job.warnings,
                    });
                }
                Err((path, error)) => job.messages.push(format!("{}: {error}", path.display())),
            }
        }
        Err(Failed {
            messages: job.messages,
            inputs: job.inputs,
        })
    }
}

/// A shader on its way.
struct Work {
    paths: Vec<PathBuf>,
    below: PathBuf,
    language: Language,
    is_named: bool,
}

struct Job<'r> {
    rewriter: &'r Rewriter,
    reader: Reader,
    works: Vec<Work>,
    inputs: Vec<PathBuf>,
    messages: Vec<String>,
    warnings: Vec<String>,
}

impl Job<'_> {
    fn outside(&mut self, path: &Path, error: &io::Error) {
        self.messages.push(format!("{}: {error}", path.display()));
    }

    fn gather(&mut self) {
        for path in &self.rewriter.imports {
            self.inputs.push(path.clone());
            for file in self.listed(path) {
                self.module(&file);
            }
        }
        for source in &self.rewriter.sources {
            match source {
                Source::Folder(folder) => self.gather_folder(folder),
                Source::Files(files) => self.gather_files(files),
            }
        }
        self.inputs.sort();
        self.inputs.dedup();
    }

    fn listed(&mut self, path: &Path) -> Vec<PathBuf> {
        if path.is_file() {
            return vec![path.to_owned()];
        }
        match input::folder::files(path, &|_| false) {
            Ok(files) => files,
            Err(error) => {
                self.outside(path, &error);
                Vec::new()
            }
        }
    }

    fn module(&mut self, path: &Path) {
        self.inputs.push(path.to_owned());
        match std::fs::read_to_string(path) {
            Ok(text) => {
                let reader = std::mem::take(&mut self.reader);
                self.reader = reader.module(path.display().to_string(), text);
            }
            Err(error) => self.outside(path, &error),
        }
    }

    fn gather_folder(&mut self, folder: &Path) {
        // a new file has to be seen
        self.inputs.push(folder.to_owned());
        for file in self.listed(folder) {
            let Some(language) = language(&file) else {
                continue;
            };
            self.inputs.push(file.clone());
            let is_module = language == Language::Wgsl
                && std::fs::read_to_string(&file)
                    .is_ok_and(|text| compose::import_path(&text).is_some());
            if is_module {
                self.module(&file);
                continue;
            }
            self.works.push(Work {
                below: file.strip_prefix(folder).unwrap_or(&file).to_owned(),
                paths: vec![file],
                language,
                is_named: false,
            });
        }
    }

    fn gather_files(&mut self, files: &[PathBuf]) {
        let Some(last) = files.last() else {
            return;
        };
        self.inputs.extend(files.iter().cloned());
        let Some(language) = language(last) else {
            let known = Language::EXTENSIONS.iter();
            let known: Vec<String> = known.map(|(known, _)| format!(".{known}")).collect();
            self.messages.push(format!(
                "{}: the name of a shader ends in {}",
                last.display(),
                known.join(", ")
            ));
            return;
        };
        self.works.push(Work {
            paths: files.to_vec(),
            below: PathBuf::from(last.file_name().unwrap_or(last.as_os_str())),
            language,
            is_named: true,
        });
    }

    fn rewrite(&mut self) -> Vec<Done> {
        let mut done = Vec::new();
        let mut names: BTreeMap<String, String> = BTreeMap::new();
        for work in std::mem::take(&mut self.works) {
            let Some(shader) = self.read(&work) else {
                continue;
            };
            let Some(one) = self.rewrite_one(&work, &shader) else {
                continue;
            };
            if let Some(other) = names.insert(one.name.clone(), one.from.clone()) {
                self.messages.push(format!(
                    "{other} and {} would both be called `{}`: rename one",
                    one.from, one.name
                ));
            }
            done.push(one);
        }
        done
    }

    fn read(&mut self, work: &Work) -> Option<Shader> {
        let mut files = Vec::new();
        let mut by_name = Vec::new();
        for path in &work.paths {
            match std::fs::read(path) {
                Ok(bytes) => {
                    let text = String::from_utf8_lossy(&bytes);
                    by_name.extend(input::folder::imported_by_name(path, &text));
                    files.push((path.display().to_string(), bytes));
                }
                Err(error) => {
                    self.outside(path, &error);
                    return None;
                }
            }
        }
        for path in by_name {
            if path.is_file() && !self.inputs.contains(&path) {
                self.module(&path);
            }
        }
        match self.reader.read(work.language, files) {
            Ok(shader) => Some(shader),
            Err(invalid) => {
                self.messages.push(invalid.rendered);
                None
            }
        }
    }

    fn rewrite_one(&mut self, work: &Work, shader: &Shader) -> Option<Done> {
        let rewriter = self.rewriter;
        let name = work.paths.last().map(|path| path.display().to_string());
        let from = name.unwrap_or_default();
        let entry = rewriter.entry.as_deref();
        let entries = entry.map_or(Entries::PerPixel, Entries::Named);
        let rewritten = crate::rewrite(&shader.module, &shader.info, entries, &rewriter.options);
        let mut rewritten = match rewritten {
            Ok(rewritten) => rewritten,
            Err(refusal) => {
                let has_nothing = refusal
                    .findings
                    .iter()
                    .all(|f| matches!(f.code, Code::NothingPerPixel | Code::NoComputeEntry));
                if !has_nothing || work.is_named {
                    self.messages
                        .push(refusal.render(&shader.source, Color::Never));
                }
                return None;
            }
        };
        for (entry, finding) in &rewritten.warnings {
            let warning = Warning::new(finding, Some(&shader.source));
            let place = warning.place.clone().unwrap_or_else(|| from.clone());
            self.warnings
                .push(format!("{place}: {} [{}]", warning.message, warning.code));
            let entries = &mut rewritten.manifest.entries;
            if let Some(of) = entries.iter_mut().find(|e| e.name == *entry) {
                of.warnings.push(warning);
            }
        }
        let written = emit::write(
            &rewritten.module,
            &rewritten.info,
            rewriter.target,
            &rewriter.form,
            &shader.directives,
        );
        let written = match written {
            Ok(written) => written,
            Err(error) => {
                self.messages.push(format!("{from}: {error}"));
                return None;
            }
        };
        rewritten.manifest.output = Some(written.output);
        Some(Done {
            name: rust::module_name(&work.below),
            from,
            below: work
                .below
                .with_extension(rewriter.target.language().extension()),
            bytes: written.bytes,
            bindings: bindings(&shader.module, &shader.info),
            manifest: rewritten.manifest,
        })
    }

    fn write(
        &self,
        folder: &Path,
        done: &[Done],
    ) -> Result<(Vec<PathBuf>, PathBuf), (PathBuf, io::Error)> {
        let mut shaders = Vec::new();
        let inner = folder.join("vrcs");
        for one in done {
            let path = inner.join(&one.below);
            write_if_changed(&path, &one.bytes)?;
            write_if_changed(
                &path.with_extension("json"),
                one.manifest.to_json().as_bytes(),
            )?;
            shaders.push(path);
        }
        let module = folder.join("vrcs.rs");
        let text = rust::module(done, self.rewriter.target);
        write_if_changed(&module, text.as_bytes())?;
        Ok((shaders, module))
    }
}

fn language(path: &Path) -> Option<Language> {
    Language::from_extension(&path.extension()?.to_string_lossy())
}

fn write_if_changed(path: &Path, bytes: &[u8]) -> Result<(), (PathBuf, io::Error)> {
    if std::fs::read(path).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    let parent = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent)
        .and_then(|()| std::fs::write(path, bytes))
        .map_err(|error| (path.to_owned(), error))
}

/// The author's own bindings.
fn bindings(module: &Module, _: &ModuleInfo) -> Vec<(String, u32, u32, Option<u32>)> {
    let mut layouter = Layouter::default();
    let has_layouts = layouter.update(module.to_ctx()).is_ok();
    let globals = module.global_variables.iter();
    globals
        .filter_map(|(_, global)| {
            let at = global.binding?;
            let is_buffer = matches!(
                global.space,
                naga::AddressSpace::Uniform | naga::AddressSpace::Storage { .. }
            );
            // the size of what ends in an array of any length is that with one element
            let size = (is_buffer && has_layouts).then(|| layouter[global.ty].size);
            Some((global.name.clone()?, at.group, at.binding, size))
        })
        .collect()
}
