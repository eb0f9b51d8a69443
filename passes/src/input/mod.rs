//! Reads shaders: files to a validated module, or one clear message that points into the right file.
//!
//! *Does*: WGSL, several files at once and naga_oil's `#import` and `#ifdef` included ([`compose`]); SPIR-V and GLSL compute
//! shaders, where the crate's features allow.
//! *Guarantees*: spans that lead back to the files; [directives] that naga rejects are no error, and are not
//! forgotten. No input makes it panic or overflow the stack.
//! *Refuses*: what is not valid, and what nests [too deep](crate::deep::MOST).

pub mod compose;
pub mod directives;
pub mod folder;
mod hints;
mod invalid;
mod language;
#[cfg(feature = "spirv")]
mod spirv;

use naga::{
    Module,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::{deep, source::Source};
pub use compose::Defines;
pub use directives::Directives;
pub use invalid::Invalid;
use invalid::Report;
pub use language::Language;

/// A shader that has been read.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The module, valid.
    pub module: Module,
    /// What naga knows of it.
    pub info: ModuleInfo,
    /// The text that its spans point into; without text for SPIR-V.
    pub source: Source,
    /// The directives of its text.
    pub directives: Directives,
}

/// Reads shaders of several files, with what is defined and what can be imported.
///
/// ```
/// let shader = vrcs_passes::input::Reader::new()
///     .define("SAMPLES", "4")
///     .module("noise.wgsl", "
///         #define_import_path lib::noise
///         fn white(seed: u32) -> f32 { return f32(seed * 747796405u) / 4294967296.0; }
///     ")
///     .wgsl([(
///         "main.wgsl",
///         "
///         #import lib::noise
///         @group(0) @binding(0) var picture: texture_storage_2d<rgba8unorm, write>;
///         @compute @workgroup_size(8, 8)
///         fn main(@builtin(global_invocation_id) id: vec3<u32>) {
///             textureStore(picture, id.xy, vec4(noise::white(id.x) * #{SAMPLES}.0));
///         }
///         ",
///     )])?;
/// assert_eq!(shader.module.entry_points.len(), 1);
/// # Ok::<(), vrcs_passes::input::Invalid>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Reader {
    defines: Defines,
    modules: Vec<(String, String)>,
}

impl Reader {
    /// A reader for which nothing is defined.
    pub fn new() -> Reader {
        Reader::default()
    }

    /// Defines a name for `#ifdef`, `#if` and `#{NAME}`. It goes before a `#define` of a file.
    pub fn define(mut self, name: impl Into<String>, value: impl Into<String>) -> Reader {
        self.defines.insert(name.into(), value.into());
        self
    }

    /// Makes a file known that can be imported: by its `#define_import_path`, or by its name in quotes.
    pub fn module(mut self, name: impl Into<String>, text: impl Into<String>) -> Reader {
        self.modules.push((name.into(), text.into()));
        self
    }

    /// Joins files, in order, to the one text that is parsed. Files without a line for a preprocessor stay as they are.
    ///
    /// # Errors
    /// If a condition or an import is not understood, or there is no such module.
    pub fn compose<N, T>(&self, files: impl IntoIterator<Item = (N, T)>) -> Result<Source, Invalid>
    where
        N: Into<String>,
        T: Into<String>,
    {
        Ok(self.join(files)?.0)
    }

    /// The joined text, and whether a module was needed.
    fn join<N, T>(&self, files: impl IntoIterator<Item = (N, T)>) -> Result<(Source, bool), Invalid>
    where
        N: Into<String>,
        T: Into<String>,
    {
        let files: Vec<(String, String)> = files
            .into_iter()
            .map(|(name, text)| (name.into(), text.into()))
            .collect();
        if let [(name, text)] = files.as_slice()
            && !compose::has_commands(text)
        {
            return Ok((Source::new(name.clone(), text.clone()), false));
        }
        compose::compose(&files, &self.modules, &self.defines).map_err(|failed| {
            let (mut source, problem) = *failed;
            // only the files themselves are there: the place is told by a text of its own
            let mut report = Report::new(problem.message);
            let start = source.text().len() as u32;
            source.keep(problem.file, problem.range.clone());
            let end = source.text().len() as u32;
            report.labels.push((
                naga::Span::new(start, end.max(start + 1)),
                "here".to_owned(),
            ));
            report.help = problem.help;
            report.render(&source)
        })
    }

    /// Reads a WGSL shader of one file or several, in order.
    ///
    /// # Errors
    /// If it is not valid.
    pub fn wgsl<N, T>(&self, files: impl IntoIterator<Item = (N, T)>) -> Result<Shader, Invalid>
    where
        N: Into<String>,
        T: Into<String>,
    {
        let (source, has_modules) = self.join(files)?;
        let (mut module, mut info) = wgsl(&source)?;
        if has_modules {
            // what a module has and nobody uses may share bindings with what is used
            naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
            let depth = deep::of_module(&module);
            info = deep::run_if_deep(depth, || validate(&module, &source))?;
        }
        Ok(Shader {
            module,
            info,
            directives: Directives::of(source.text()),
            source,
        })
    }

    /// Reads a shader of any language from the bytes of its files.
    ///
    /// # Errors
    /// If it is not valid, or if the crate was built without the language.
    pub fn read<N: Into<String>>(
        &self,
        language: Language,
        files: impl IntoIterator<Item = (N, Vec<u8>)>,
    ) -> Result<Shader, Invalid> {
        let files: Vec<(String, Vec<u8>)> = files
            .into_iter()
            .map(|(name, bytes)| (name.into(), bytes))
            .collect();
        if language == Language::SpirV {
            return language::spirv(&files);
        }
        let mut texts = Vec::new();
        for (name, bytes) in files {
            let Ok(text) = String::from_utf8(bytes) else {
                let report = Report::new("it is not text");
                return Err(report.render(&Source::new(name, "")));
            };
            texts.push((name, text));
        }
        match language {
            Language::Glsl => language::glsl(texts, &self.defines),
            _ => self.wgsl(texts),
        }
    }
}

/// Parses and validates WGSL.
///
/// All of naga's capabilities are allowed: what a device lacks is the device's to say. Lines for a preprocessor are not
/// understood: a [`Reader`] does that.
///
/// # Errors
/// If it is not valid WGSL.
pub fn wgsl(source: &Source) -> Result<(Module, ModuleInfo), Invalid> {
    let text = directives::blank(source.text());
    let depth = deep::of_text(&text);
    check_depth(depth, source)?;
    deep::run_if_deep(depth, || {
        let module = naga::front::wgsl::parse_str(&text)
            .map_err(|error| Report::parse(&error).render(source))?;
        check_depth(deep::of_module(&module), source)?;
        let info = validate(&module, source)?;
        Ok((module, info))
    })
}

fn check_depth(depth: usize, source: &Source) -> Result<(), Invalid> {
    if depth <= deep::MOST {
        return Ok(());
    }
    let mut report = Report::new(format!(
        "the shader nests about {depth} deep, and {} is the most",
        deep::MOST
    ));
    report.help = Some("split long expressions and chains of `else if`".to_owned());
    Err(report.render(source))
}

fn validate(module: &Module, source: &Source) -> Result<ModuleInfo, Invalid> {
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(module)
        .map_err(|error| Report::validation(&error).render(source))
}
