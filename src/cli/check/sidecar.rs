//! The settings of a shader's check that lie beside it: `shade.wgsl` has `shade.toml`.
//!
//! ```toml
//! size = [64, 48]
//! cases = 200
//!
//! [set]
//! width = 64
//! "frame.sun" = [0.0, 1.0, 0.0]
//!
//! [input]
//! albedo = "albedo.png"
//! ```

use std::{collections::BTreeMap, path::Path};

use serde::Deserialize;

use super::{Failure, Settings};
use crate::cli::files;

/// What a sidecar says.
#[derive(Debug, Default)]
pub(super) struct Sidecar {
    pub(super) size: Option<[u32; 2]>,
    pub(super) cases: Option<u32>,
    pub(super) settings: Settings,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    size: Option<[u32; 2]>,
    cases: Option<u32>,
    #[serde(default)]
    set: BTreeMap<String, Values>,
    #[serde(default)]
    input: BTreeMap<String, String>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Values {
    One(f64),
    Several(Vec<f64>),
}

/// Reads the sidecar of a shader; nothing if there is none.
pub(super) fn read(shader: &Path) -> Result<Sidecar, Failure> {
    let path = shader.with_extension("toml");
    if files::is_stream(shader) || !path.exists() {
        return Ok(Sidecar::default());
    }
    let file: File = toml::from_str(&files::read_text(&path)?)
        .map_err(|error| Failure::Misused(format!("{}: {error}", path.display())))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    Ok(Sidecar {
        size: file.size,
        cases: file.cases,
        settings: Settings {
            set: file
                .set
                .into_iter()
                .map(|(name, values)| match values {
                    Values::One(value) => (name, vec![value]),
                    Values::Several(values) => (name, values),
                })
                .collect(),
            files: file
                .input
                .into_iter()
                .map(|(name, file)| (name, folder.join(file)))
                .collect(),
        },
    })
}

/// Parses `NAME=VALUE` or `NAME=VALUE,VALUE`.
pub(super) fn parse_set(text: &str) -> Result<(String, Vec<f64>), String> {
    let Some((name, values)) = text.split_once('=') else {
        return Err(format!("`{text}` is not NAME=VALUE"));
    };
    let parsed: Result<Vec<f64>, _> = values.split(',').map(|v| v.trim().parse()).collect();
    match parsed {
        Ok(values) => Ok((name.trim().to_owned(), values)),
        Err(_) => Err(format!("`{values}` in `{text}` is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::parse_set;

    #[test]
    fn values_are_numbers_with_commas_between() {
        assert_eq!(parse_set("a.b=1"), Ok(("a.b".to_owned(), vec![1.0])));
        assert_eq!(
            parse_set("v = 1, -2.5"),
            Ok(("v".to_owned(), vec![1.0, -2.5]))
        );
        assert!(parse_set("v").is_err());
        assert!(parse_set("v=x").is_err());
    }
}
