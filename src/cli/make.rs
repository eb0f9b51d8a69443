//! One shader, rewritten: from its files to the bytes that are written, and all that is to be told of it.

use serde::Serialize;
use vrcs_passes::{
    Code, Entries, Options, Refusal,
    emit::{self, Form, Target},
    manifest,
    told::Told,
};

use super::{
    inputs::{Inputs, Work},
    talk,
};

/// What is asked for.
pub(super) struct Wish<'w> {
    pub(super) entry: Option<&'w str>,
    pub(super) options: &'w Options,
    pub(super) target: Target,
    pub(super) form: &'w Form,
}

/// What became of a shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Status {
    /// It was rewritten.
    Rewritten,
    /// It has not changed since it was rewritten.
    Unchanged,
    /// It has no compute entry point that stores per pixel, and nobody asked for it by name.
    NothingPerPixel,
    /// It cannot be rewritten.
    Refused,
    /// It is not valid.
    Invalid,
    /// A file could not be read or written.
    Failed,
}

impl Status {
    /// Whether what was asked for was not done.
    pub(super) fn is_failure(self) -> bool {
        matches!(self, Status::Refused | Status::Invalid | Status::Failed)
    }
}

/// A shader that was worked on.
pub(super) struct Made {
    pub(super) status: Status,
    /// The rewritten shader, and its manifest.
    pub(super) written: Option<(Vec<u8>, manifest::Manifest)>,
    /// What to say about it, for people.
    pub(super) said: Vec<String>,
    /// The same as data.
    pub(super) told: Vec<Told>,
}

impl Made {
    pub(super) fn new(status: Status) -> Made {
        Made {
            status,
            written: None,
            said: Vec::new(),
            told: Vec::new(),
        }
    }

    pub(super) fn say(mut self, text: impl Into<String>) -> Made {
        self.said.push(text.into());
        self
    }

    fn refuse(mut self, message: String) -> Made {
        self.told.push(Told {
            code: "output".to_owned(),
            severity: "refusal".to_owned(),
            message: message.clone(),
            places: Vec::new(),
            help: None,
        });
        self.say(talk::labelled_error(&message))
    }
}

/// Reads, rewrites and writes, in memory.
pub(super) fn make(inputs: &Inputs, work: &Work, wish: &Wish) -> Made {
    let read = match inputs.read(work) {
        Ok(read) => read,
        Err(failure) => {
            return Made::new(Status::Failed).refuse(failure.message().to_owned());
        }
    };
    let shader = match read.shader(work.language) {
        Ok(shader) => shader,
        Err(invalid) => {
            let mut made = Made::new(Status::Invalid);
            made.told.push(Told::from(&invalid));
            return made.say(invalid.render(talk::color()));
        }
    };
    let entries = wish.entry.map_or(Entries::PerPixel, Entries::Named);
    let rewritten = vrcs_passes::rewrite(&shader.module, &shader.info, entries, wish.options);
    let mut rewritten = match rewritten {
        Ok(rewritten) => rewritten,
        Err(refusal) => return refused(work, wish, &refusal, &shader.source),
    };
    let mut made = Made::new(Status::Rewritten);
    for (entry, warning) in &rewritten.warnings {
        made.said
            .push(warning.render(&shader.source, talk::color()));
        made.told.push(Told::new(warning, &shader.source));
        let entries = &mut rewritten.manifest.entries;
        if let Some(of) = entries.iter_mut().find(|e| e.name == *entry) {
            of.warnings
                .push(manifest::Warning::new(warning, Some(&shader.source)));
        }
    }
    for (entry, finding) in &rewritten.left_alone {
        made.told.push(Told::new(finding, &shader.source));
        made.said.push(format!(
            "note: `{entry}` is left as it is: {}",
            finding.message
        ));
    }
    // an entry point that was asked for is the one to write, where a language holds only one
    let form = Form {
        entry: wish
            .form
            .entry
            .clone()
            .or_else(|| match rewritten.manifest.entries.as_slice() {
                [only] if wish.target.language() == emit::Language::Glsl => Some(only.name.clone()),
                _ => None,
            }),
        ..wish.form.clone()
    };
    let written = emit::write(
        &rewritten.module,
        &rewritten.info,
        wish.target,
        &form,
        &shader.directives,
    );
    match written {
        Ok(written) => {
            rewritten.manifest.output = Some(written.output);
            for entry in &rewritten.manifest.entries {
                made.said.push(summary(entry));
            }
            made.written = Some((written.bytes, rewritten.manifest));
            made
        }
        Err(error) => {
            made.status = Status::Refused;
            made.refuse(format!("{}: {error}", work.name))
        }
    }
}

fn refused(work: &Work, wish: &Wish, refusal: &Refusal, source: &vrcs_passes::Source) -> Made {
    // a shader of a folder that stores nothing per pixel is none of our business
    let has_nothing = refusal
        .findings
        .iter()
        .all(|f| matches!(f.code, Code::NothingPerPixel | Code::NoComputeEntry));
    let passes_by = has_nothing && !work.is_named && wish.entry.is_none();
    let mut made = Made::new(match passes_by {
        true => Status::NothingPerPixel,
        false => Status::Refused,
    });
    let told = refusal.findings.iter().map(|f| Told::new(f, source));
    made.told.extend(told);
    match passes_by {
        true => {
            let why = refusal.findings.first().map_or("", |f| f.message.as_str());
            made.say(format!("note: {} is passed by: {why}", work.name))
        }
        false => made.say(refusal.render(source, talk::color())),
    }
}

/// What was done to an entry point, in a line.
fn summary(entry: &manifest::Entry) -> String {
    let targets: Vec<_> = entry
        .targets
        .iter()
        .map(|t| format!("`{}`", t.name))
        .collect();
    let numbers: Vec<String> = (entry.bindings.iter())
        .map(|added| format!("{}:{}", added.group, added.binding))
        .collect();
    let shared = match entry.shares_group {
        true => ", in a group of the shader's",
        false => "",
    };
    format!(
        "note: `{}` is variable-rate: {}; bindings {}{shared}",
        entry.name,
        targets.join(", "),
        numbers.join(" and "),
    )
}
