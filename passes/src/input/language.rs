//! The languages that shaders come in, and the ones but WGSL.

use std::{fmt, str::FromStr};

use super::{Defines, Invalid, Shader, invalid::Report};
use crate::source::Source;

/// A language that shaders come in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Language {
    /// WGSL.
    Wgsl,
    /// SPIR-V, binary.
    SpirV,
    /// GLSL 4.40 to 4.60 for Vulkan: one compute shader.
    Glsl,
}

impl Language {
    /// Every extension that is known, with its language.
    pub const EXTENSIONS: &'static [(&'static str, Language)] = &[
        ("wgsl", Language::Wgsl),
        ("spv", Language::SpirV),
        ("comp", Language::Glsl),
        ("glsl", Language::Glsl),
    ];

    /// The language of a file with this extension.
    pub fn from_extension(extension: &str) -> Option<Language> {
        Language::EXTENSIONS
            .iter()
            .find(|(known, _)| extension.eq_ignore_ascii_case(known))
            .map(|&(_, language)| language)
    }

    /// Its name: `wgsl`, `spirv`, `glsl`.
    pub fn name(self) -> &'static str {
        match self {
            Language::Wgsl => "wgsl",
            Language::SpirV => "spirv",
            Language::Glsl => "glsl",
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Language {
    type Err = String;

    fn from_str(text: &str) -> Result<Language, String> {
        match text {
            "wgsl" => Ok(Language::Wgsl),
            "spirv" | "spv" => Ok(Language::SpirV),
            "glsl" => Ok(Language::Glsl),
            other => Err(format!("`{other}` is none of wgsl, spirv, glsl")),
        }
    }
}

/// Reads a SPIR-V module. What it says has no text to point into.
#[cfg(feature = "spirv")]
pub(super) fn spirv(files: &[(String, Vec<u8>)]) -> Result<Shader, Invalid> {
    let [(name, bytes)] = files else {
        let name = files.first().map(|(name, _)| name.as_str());
        let source = Source::new(name.unwrap_or("spirv"), "");
        return Err(Report::new("SPIR-V modules cannot be joined").render(&source));
    };
    let prepared = super::spirv::prepare(name, bytes);
    if !prepared.combined.is_empty() {
        let names: Vec<_> = prepared.combined.iter().map(|n| format!("`{n}`")).collect();
        let is = if names.len() == 1 {
            "is a combined image sampler"
        } else {
            "are combined image samplers"
        };
        let mut report = Report::new(format!("{} {is}, and naga has none", names.join(", ")));
        report.help = Some(APART.to_owned());
        return Err(report.render(&Source::new(name.clone(), "")));
    }
    let options = naga::front::spv::Options {
        // compute shaders have no position that would have to be turned over
        adjust_coordinate_space: false,
        strict_capabilities: true,
        block_ctx_dump_prefix: None,
    };
    let parsed = crate::deep::run(|| {
        naga::front::spv::parse_u8_slice(&prepared.bytes, &options)
            .map_err(|error| error.to_string())
    });
    let mut module = match parsed {
        Ok(Ok(module)) => module,
        Ok(Err(why)) => {
            let source = Source::new(name.clone(), "");
            return Err(
                Report::new(format!("it is no SPIR-V that naga understands: {why}"))
                    .render(&source),
            );
        }
        Err(panic) => {
            return Err(
                Report::new(format!("naga's SPIR-V front end gave up: {panic}"))
                    .render(&Source::new(name.clone(), "")),
            );
        }
    };
    prepared.size_groups(&mut module);
    finish(module, prepared.source)
}

/// Reads a GLSL compute shader of one file or several, in order.
#[cfg(feature = "glsl")]
pub(super) fn glsl(files: Vec<(String, String)>, defines: &Defines) -> Result<Shader, Invalid> {
    let mut source = Source::default();
    for (name, text) in files {
        source.push(name, text);
    }
    super::check_depth(crate::deep::of_text(source.text()), &source)?;
    let options = naga::front::glsl::Options {
        stage: naga::ShaderStage::Compute,
        defines: defines
            .iter()
            .map(|(name, value)| {
                let value = if value == "true" { "1" } else { value };
                (name.clone(), value.to_owned())
            })
            .collect(),
    };
    let parsed =
        crate::deep::run(|| naga::front::glsl::Frontend::default().parse(&options, source.text()));
    let module = match parsed {
        Ok(Ok(module)) => module,
        Ok(Err(errors)) => {
            let Some(first) = errors.errors.first() else {
                return Err(Report::new("it is no GLSL").render(&source));
            };
            let mut report = Report::new(first.kind.to_string());
            report.labels.push((first.meta, "here".to_owned()));
            report.help = Some(match is_combined(&report, &source) {
                true => APART.to_owned(),
                false => "naga's GLSL front end knows less than glslang: `glslangValidator -V -g` makes SPIR-V of it, which comes in too".to_owned(),
            });
            return Err(report.render(&source));
        }
        Err(panic) => {
            return Err(
                Report::new(format!("naga's GLSL front end gave up: {panic}")).render(&source),
            );
        }
    };
    finish(module, source)
}

/// Whether a message of naga's is about a combined image sampler.
#[cfg(feature = "glsl")]
fn is_combined(report: &Report, source: &Source) -> bool {
    let words = report
        .labels
        .first()
        .and_then(|(at, _)| source.snippet(*at));
    let words = words.unwrap_or_default();
    let kind = words.trim_start_matches(['i', 'u']);
    kind.starts_with("sampler") && kind != "sampler" && !words.contains('(')
}

/// What to do about a combined image sampler.
#[cfg(any(feature = "spirv", feature = "glsl"))]
const APART: &str = "declare the texture and its sampler apart, `uniform texture2D t; uniform sampler s;`, and read by `texture(sampler2D(t, s), at)`";

#[cfg(any(feature = "spirv", feature = "glsl"))]
fn finish(mut module: naga::Module, source: Source) -> Result<Shader, Invalid> {
    // `buffer Sums { .. };` has a name for its block alone, and `--target Sums=leader` has to mean something
    for (_, global) in module.global_variables.iter_mut() {
        if let Some(place) = global.binding
            && global.name.as_deref().is_none_or(str::is_empty)
        {
            let block = module.types[global.ty].name.clone();
            global.name = block
                .filter(|name| !name.is_empty())
                // a module whose names were taken out
                .or_else(|| Some(format!("binding_{}_{}", place.group, place.binding)));
        }
        // `writeonly buffer`: naga has no such buffers, and one that may be read as well holds the same
        if let naga::AddressSpace::Storage { access } = &mut global.space
            && access.contains(naga::StorageAccess::STORE)
        {
            *access |= naga::StorageAccess::LOAD;
        }
    }
    for (_, function) in module.functions.iter_mut() {
        // glslang has the types of the parameters in a function's name: `hit(vf3;f1;`
        if let Some(name) = &mut function.name
            && let Some(end) = name.find('(')
        {
            name.truncate(end);
        }
    }
    let depth = crate::deep::of_module(&module);
    super::check_depth(depth, &source)?;
    let info = crate::deep::run_if_deep(depth, || super::validate(&module, &source))?;
    Ok(Shader {
        module,
        info,
        source,
        directives: super::Directives::default(),
    })
}

#[cfg(not(feature = "spirv"))]
pub(super) fn spirv(files: &[(String, Vec<u8>)]) -> Result<Shader, Invalid> {
    let name = files.first().map_or("spirv", |(name, _)| name);
    Err(
        Report::new("vrcs-passes was built without its feature `spirv`")
            .render(&Source::new(name, "")),
    )
}

#[cfg(not(feature = "glsl"))]
pub(super) fn glsl(files: Vec<(String, String)>, _: &Defines) -> Result<Shader, Invalid> {
    let name = files.first().map_or("glsl", |(name, _)| name);
    Err(
        Report::new("vrcs-passes was built without its feature `glsl`")
            .render(&Source::new(name, "")),
    )
}
