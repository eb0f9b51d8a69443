//! Findings as data: for reports in JSON, editors and build scripts.

use serde::{Deserialize, Serialize};

use crate::{
    finding::{Finding, Severity},
    input::Invalid,
    source::Source,
};

/// A finding, its places led back to files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Told {
    /// The stable code, such as `VRCS013`; `invalid` where the shader is not valid.
    pub code: String,
    /// `refusal` or `warning`; `invalid` where the shader is not valid.
    pub severity: String,
    /// One sentence.
    pub message: String,
    /// Where it is, the main place first.
    pub places: Vec<ToldPlace>,
    /// What the author can do.
    pub help: Option<String>,
}

/// A place that a finding is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToldPlace {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in bytes, from 1.
    pub column: usize,
    /// The author's own words there.
    pub snippet: String,
    /// What is said of it.
    pub text: String,
}

impl Told {
    /// A finding about a source.
    pub fn new(finding: &Finding, source: &Source) -> Told {
        let places = finding.labels.iter().filter_map(|label| {
            let place = source.place(label.span)?;
            Some(ToldPlace {
                file: place.file,
                line: place.line,
                column: place.column,
                snippet: source.snippet(label.span).unwrap_or_default(),
                text: label.text.clone(),
            })
        });
        Told {
            code: finding.code.to_string(),
            severity: match finding.code.severity() {
                Severity::Refusal => "refusal",
                Severity::Warning => "warning",
            }
            .to_owned(),
            message: finding.message.clone(),
            places: places.collect(),
            help: finding.help.clone(),
        }
    }
}

impl From<&Invalid> for Told {
    fn from(invalid: &Invalid) -> Told {
        let place = invalid.place.as_ref().map(|place| ToldPlace {
            file: place.file.clone(),
            line: place.line,
            column: place.column,
            snippet: String::new(),
            text: String::new(),
        });
        Told {
            code: "invalid".to_owned(),
            severity: "invalid".to_owned(),
            message: invalid.message.clone(),
            places: place.into_iter().collect(),
            help: invalid.help.as_deref().map(str::to_owned),
        }
    }
}
