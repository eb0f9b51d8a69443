//! Which shaders a command is about: files joined in order to one shader, or a batch of many.
//!
//! - Files alone are **one shader**, joined in order: `common.wgsl main.wgsl`. A file with a `#define_import_path` is no part of it but
//!   can be imported, unless there is nothing else.
//! - A folder is a **batch**: every shader in it, folders inside included, is one of its own. Files with a `#define_import_path`
//!   can be imported by the others.
//! - Where the output is a folder, files are a batch, too.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use vrcs_passes::{
    input::{Invalid, Language, Reader, Shader, compose, folder},
    near,
};

use super::{Failure, files};

/// What shaders are read from.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct In {
    /// The shader: a file, or several that are joined in order.
    ///
    /// Or folders, each file of which is a shader. `-` reads standard input.
    #[arg(required = true, value_name = "SHADER")]
    pub(super) shaders: Vec<PathBuf>,
    /// Define a name for `#ifdef`, `#if` and `#{NAME}`.
    ///
    /// It is `true` if no value is given.
    #[arg(short = 'D', long = "define", value_name = "NAME[=VALUE]")]
    pub(super) defines: Vec<String>,
    /// A file, or a folder of files, that shaders may `#import`.
    #[arg(short = 'I', long = "import", value_name = "PATH")]
    pub(super) imports: Vec<PathBuf>,
    /// A file that is put in front of every shader.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(super) with: Vec<PathBuf>,
    /// The language, where the extension does not tell it: wgsl, spirv or glsl.
    #[arg(long, value_name = "LANGUAGE", hide_short_help = true)]
    pub(super) from: Option<Language>,
}

/// One shader: its files, in order.
#[derive(Debug, Clone)]
pub(super) struct Work {
    /// What it is called in messages.
    pub(super) name: String,
    /// Where it lies below the folder that was named; the file's name if it was named itself.
    pub(super) below: PathBuf,
    /// Its files.
    pub(super) paths: Vec<PathBuf>,
    /// Its language.
    pub(super) language: Language,
    /// Whether it was named itself, rather than found in a folder.
    pub(super) is_named: bool,
}

/// The shaders of a command and what they are read with.
#[derive(Debug)]
pub(super) struct Inputs {
    /// The shaders, in the order of the command line; those of a folder by name.
    pub(super) works: Vec<Work>,
    /// What is defined, and the modules.
    pub(super) reader: Reader,
    /// The names of the modules.
    modules: BTreeSet<String>,
    /// Every file that was read or will be.
    pub(super) files: BTreeSet<PathBuf>,
}

/// A shader's files, read.
#[derive(Debug)]
pub(super) struct Read {
    pub(super) files: Vec<(String, Vec<u8>)>,
    reader: Reader,
}

impl Read {
    /// Parses and validates it.
    pub(super) fn shader(&self, language: Language) -> Result<Shader, Invalid> {
        self.reader.read(language, self.files.clone())
    }
}

impl In {
    /// Whether a folder is among what was named.
    pub(super) fn has_folder(&self) -> bool {
        self.shaders.iter().any(|path| path.is_dir())
    }

    /// Finds the shaders. `leave_out` is a folder whose files are not looked at: where the output goes.
    pub(super) fn gather(
        &self,
        is_batch: bool,
        leave_out: Option<&Path>,
    ) -> Result<Inputs, Failure> {
        let mut reader = Reader::new();
        for define in &self.defines {
            let (name, value) = define.split_once('=').unwrap_or((define, "true"));
            if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
                return Err(Failure::Misused(format!("`{define}` is not NAME=VALUE")));
            }
            reader = reader.define(name, value);
        }
        let mut inputs = Inputs {
            works: Vec::new(),
            reader,
            modules: BTreeSet::new(),
            files: BTreeSet::new(),
        };
        for path in &self.imports {
            for file in files_of(path, None)? {
                // a folder of shaders may hold pictures, too
                if path.is_dir() && file.extension().is_none_or(|e| e != "wgsl") {
                    continue;
                }
                inputs.module(&file)?;
            }
        }
        match is_batch {
            true => self.batch(&mut inputs, leave_out)?,
            false => self.join(&mut inputs)?,
        }
        inputs.files.extend(self.with.iter().cloned());
        Ok(inputs)
    }

    fn batch(&self, inputs: &mut Inputs, leave_out: Option<&Path>) -> Result<(), Failure> {
        for path in &self.shaders {
            let is_folder = path.is_dir();
            let found = match is_folder {
                true => files_of(path, leave_out)?,
                false => vec![path.clone()],
            };
            for file in found {
                let language = match (self.language(&file), is_folder) {
                    (Ok(language), _) => language,
                    (Err(_), true) => continue,
                    (Err(failure), false) => return Err(failure),
                };
                let is_module = language == Language::Wgsl
                    && is_folder
                    && compose::import_path(&files::read_text(&file)?).is_some();
                if is_module {
                    inputs.module(&file)?;
                    continue;
                }
                inputs.files.insert(file.clone());
                let below = match is_folder {
                    true => file.strip_prefix(path).unwrap_or(&file).to_owned(),
                    false => PathBuf::from(file.file_name().unwrap_or(file.as_os_str())),
                };
                inputs.works.push(Work {
                    name: files::display_name(&file),
                    below,
                    paths: self.with.iter().cloned().chain([file]).collect(),
                    language,
                    is_named: !is_folder,
                });
            }
        }
        if inputs.works.is_empty() {
            return Err(Failure::Misused(format!(
                "there is no shader in {}: their names end in {}",
                self.shaders
                    .iter()
                    .map(|path| path.display().to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
                extensions()
            )));
        }
        Ok(())
    }

    fn join(&self, inputs: &mut Inputs) -> Result<(), Failure> {
        let mut own: Vec<PathBuf> = self.with.clone();
        let mut languages = BTreeSet::new();
        for (index, path) in self.shaders.iter().enumerate() {
            let language = self.language(path)?;
            languages.insert(language.name());
            let is_last = index + 1 == self.shaders.len();
            let is_module = language == Language::Wgsl
                && !files::is_stream(path)
                && !(is_last && own.len() == self.with.len())
                && compose::import_path(&files::read_text(path)?).is_some();
            match is_module {
                true => inputs.module(path)?,
                false => own.push(path.clone()),
            }
        }
        if languages.len() > 1 {
            return Err(Failure::Misused(format!(
                "files of {} cannot be one shader: name a folder to write to, `-o DIR/`, and each is one of its own",
                languages.into_iter().collect::<Vec<_>>().join(" and ")
            )));
        }
        let Some(last) = self.shaders.last() else {
            return Err(Failure::Misused("no shader is named".to_owned()));
        };
        inputs.files.extend(own.iter().cloned());
        inputs.works.push(Work {
            name: files::display_name(last),
            below: PathBuf::from(last.file_name().unwrap_or(last.as_os_str())),
            language: self.language(last)?,
            paths: own,
            is_named: true,
        });
        Ok(())
    }

    fn language(&self, path: &Path) -> Result<Language, Failure> {
        if let Some(language) = self.from {
            return Ok(language);
        }
        if files::is_stream(path) {
            return Ok(Language::Wgsl);
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Language::from_extension(&extension).ok_or_else(|| {
            let known = Language::EXTENSIONS.iter().map(|(known, _)| *known);
            let near = near::nearest(&extension, known)
                .map(|near| format!("; did you mean `.{near}`?"))
                .unwrap_or_default();
            Failure::Misused(format!(
                "{}: the name of a shader ends in {}, or --from tells its language{near}",
                path.display(),
                extensions()
            ))
        })
    }
}

fn extensions() -> String {
    let known = Language::EXTENSIONS.iter();
    let known: Vec<String> = known.map(|(known, _)| format!(".{known}")).collect();
    known.join(", ")
}

impl Inputs {
    fn module(&mut self, path: &Path) -> Result<(), Failure> {
        let text = files::read_text(path)?;
        let name = files::display_name(path);
        self.files.insert(path.to_owned());
        if self.modules.insert(name.clone()) {
            self.reader = std::mem::take(&mut self.reader).module(name, text);
        }
        Ok(())
    }

    /// Reads a shader's files, and the files that it imports by name.
    pub(super) fn read(&self, work: &Work) -> Result<Read, Failure> {
        let mut read = Read {
            files: Vec::new(),
            reader: self.reader.clone(),
        };
        let mut by_name: Vec<PathBuf> = Vec::new();
        for path in &work.paths {
            let bytes = match work.language {
                Language::SpirV => files::read_bytes(path)?,
                _ => files::read_text(path)?.into_bytes(),
            };
            if work.language == Language::Wgsl {
                by_name.extend(folder::imported_by_name(
                    path,
                    &String::from_utf8_lossy(&bytes),
                ));
            }
            read.files.push((files::display_name(path), bytes));
        }
        let mut seen = BTreeSet::new();
        while let Some(path) = by_name.pop() {
            if seen.insert(path.clone()) && path.is_file() {
                let text = files::read_text(&path)?;
                by_name.extend(folder::imported_by_name(&path, &text));
                read.reader = read.reader.module(files::display_name(&path), text);
            }
        }
        Ok(read)
    }
}

/// A file, or all files of a folder and the folders in it, by name. Hidden ones and `leave_out` are left out.
fn files_of(path: &Path, leave_out: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let is_left_out = |inner: &Path| leave_out.is_some_and(|out| files::is_same(out, inner));
    folder::files(path, &is_left_out)
        .map_err(|error| Failure::Outside(format!("{}: {error}", path.display())))
}
