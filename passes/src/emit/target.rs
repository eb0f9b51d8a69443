//! What a module can be written as: the language, its version, and what has to be decided for it.

use std::{collections::BTreeMap, fmt, str::FromStr};

#[cfg(any(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl"))]
use naga::back::PipelineConstants;
#[cfg(any(feature = "spirv", feature = "msl", feature = "glsl"))]
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};

use crate::{manifest::Output, near};

/// A language that modules are written in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Language {
    /// WGSL text.
    #[default]
    Wgsl,
    /// SPIR-V, binary.
    SpirV,
    /// HLSL text, for DXC.
    Hlsl,
    /// Metal Shading Language text.
    Msl,
    /// GLSL text: one entry point.
    Glsl,
}

impl Language {
    /// Every language with its name and the extension of its files.
    pub const ALL: &'static [(Language, &'static str, &'static str)] = &[
        (Language::Wgsl, "wgsl", "wgsl"),
        (Language::SpirV, "spirv", "spv"),
        (Language::Hlsl, "hlsl", "hlsl"),
        (Language::Msl, "msl", "metal"),
        (Language::Glsl, "glsl", "comp"),
    ];

    /// Its name: `wgsl`, `spirv`, `hlsl`, `msl`, `glsl`.
    pub fn name(self) -> &'static str {
        self.entry().1
    }

    /// The extension of its files: `wgsl`, `spv`, `hlsl`, `metal`, `comp`.
    pub fn extension(self) -> &'static str {
        self.entry().2
    }

    fn entry(self) -> (Language, &'static str, &'static str) {
        let found = Language::ALL
            .iter()
            .find(|(language, ..)| *language == self);
        found.copied().unwrap_or(Language::ALL[0])
    }

    /// The language of a file with this extension.
    pub fn from_extension(extension: &str) -> Option<Language> {
        let extension = extension.to_ascii_lowercase();
        match extension.as_str() {
            "msl" => Some(Language::Msl),
            "glsl" => Some(Language::Glsl),
            other => Language::ALL
                .iter()
                .find(|(_, _, known)| *known == other)
                .map(|&(language, ..)| language),
        }
    }

    /// The version that is written if none is asked for, and the versions that can be.
    fn versions(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Language::Wgsl => ("", &[]),
            Language::SpirV => ("1.3", &["1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6"]),
            Language::Hlsl => (
                "6.0",
                &[
                    "5.1", "6.0", "6.1", "6.2", "6.3", "6.4", "6.5", "6.6", "6.7",
                ],
            ),
            Language::Msl => (
                "2.4",
                &["1.2", "2.0", "2.1", "2.2", "2.3", "2.4", "3.0", "3.1"],
            ),
            Language::Glsl => ("450", &["430", "440", "450", "460", "310es", "320es"]),
        }
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A language and its version: on the command line `wgsl`, `spirv-1.3`, `hlsl-6.0`, `msl-2.4`, `glsl-450`, `glsl-310es`; the version
/// may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Target {
    language: Language,
    version: &'static str,
}

impl Default for Target {
    fn default() -> Target {
        Target::from(Language::Wgsl)
    }
}

impl From<Language> for Target {
    fn from(language: Language) -> Target {
        Target {
            language,
            version: language.versions().0,
        }
    }
}

impl Target {
    /// The language.
    pub fn language(self) -> Language {
        self.language
    }

    /// The version as it is written: `1.3`, `450`, `310es`; empty for WGSL.
    pub fn version(self) -> &'static str {
        self.version
    }

    /// The version as two numbers; `450` is 450 and 0.
    #[cfg(any(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl"))]
    pub(super) fn numbers(self) -> (u16, u8) {
        let (major, minor) = self.version.split_once('.').unwrap_or((self.version, "0"));
        let major = major.trim_end_matches("es");
        (major.parse().unwrap_or(0), minor.parse().unwrap_or(0))
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.version {
            "" => self.language.fmt(f),
            version => write!(f, "{}-{version}", self.language),
        }
    }
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Target, String> {
        let (name, version) = match text.split_once('-') {
            Some((name, version)) => (name, Some(version)),
            None => (text, None),
        };
        let names = || Language::ALL.iter().map(|&(_, name, _)| name);
        let language = Language::ALL
            .iter()
            .find(|(_, known, extension)| name == *known || name == *extension)
            .map(|&(language, ..)| language)
            .ok_or_else(|| {
                let near = near::nearest(name, names());
                let near = near.map(|near| format!("; did you mean `{near}`?"));
                format!(
                    "`{name}` is none of {}{}",
                    names().collect::<Vec<_>>().join(", "),
                    near.unwrap_or_default()
                )
            })?;
        let Some(version) = version else {
            return Ok(Target::from(language));
        };
        let known = language.versions().1;
        match known.iter().find(|known| **known == version) {
            Some(version) => Ok(Target { language, version }),
            None if known.is_empty() => Err(format!("{language} has no versions")),
            None => Err(format!(
                "{language} {version} is none of {}",
                known.join(", ")
            )),
        }
    }
}

/// A module, written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The text or, for SPIR-V, the words in little-endian order.
    pub bytes: Vec<u8>,
    /// Which binding became what.
    pub output: Output,
}

impl Written {
    pub(super) fn text(text: String, output: Output) -> Written {
        Written {
            bytes: text.into_bytes(),
            output,
        }
    }
}

/// What has to be decided when a module is written in another language than WGSL.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    /// The one entry point to write; every one if `None`. GLSL texts have only one.
    pub entry: Option<String>,
    /// Values of `override` constants, by name or by number: other languages than WGSL have none. What has neither a value
    /// here nor one of its own is an error.
    pub constants: BTreeMap<String, f64>,
    /// Whether indices are kept inside their arrays, buffers and textures, as WGSL promises it. Turn it off only if the API
    /// that runs the shader sees to it.
    pub checks_bounds: bool,
}

impl Default for Form {
    fn default() -> Form {
        Form {
            entry: None,
            constants: BTreeMap::new(),
            checks_bounds: true,
        }
    }
}

impl Form {
    #[cfg(any(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl"))]
    pub(super) fn constants(&self) -> PipelineConstants {
        self.constants
            .iter()
            .map(|(name, &value)| (name.clone(), value))
            .collect()
    }

    /// As wgpu has them for drivers without robust access.
    #[cfg(any(feature = "spirv", feature = "msl", feature = "glsl"))]
    pub(super) fn policies(&self) -> BoundsCheckPolicies {
        if !self.checks_bounds {
            return BoundsCheckPolicies {
                index: BoundsCheckPolicy::Unchecked,
                buffer: BoundsCheckPolicy::Unchecked,
                image_load: BoundsCheckPolicy::Unchecked,
                binding_array: BoundsCheckPolicy::Unchecked,
            };
        }
        BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            image_load: BoundsCheckPolicy::ReadZeroSkipWrite,
            binding_array: BoundsCheckPolicy::Unchecked,
        }
    }
}
