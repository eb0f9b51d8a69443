//! What is wrong with a shader that is not valid, as naga tells it, led back to the author's files.

use codespan_reporting::diagnostic::{Diagnostic, Label};
use naga::{Span, WithSpan, front::wgsl::ParseError, valid::ValidationError};

use super::hints;
use crate::{
    finding::{self, Color},
    source::{Place, Source},
};

/// A shader that is not valid. The message is naga's own, with the lines that it is about.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rendered}")]
pub struct Invalid {
    /// The message, with the lines of source.
    pub rendered: String,
    /// The message alone.
    pub message: String,
    /// Where it is.
    pub place: Option<Place>,
    /// What the author can do.
    pub help: Option<Box<str>>,
    /// `rendered`, in colour.
    coloured: Box<str>,
}

impl Invalid {
    /// The message with the lines of source, in colour or not.
    pub fn render(&self, color: Color) -> &str {
        match color {
            Color::Never => &self.rendered,
            Color::Always => &self.coloured,
        }
    }
}

/// What is to be told of a text.
pub(super) struct Report {
    pub(super) message: String,
    pub(super) labels: Vec<(Span, String)>,
    pub(super) notes: Vec<String>,
    pub(super) help: Option<String>,
}

impl Report {
    pub(super) fn new(message: impl Into<String>) -> Report {
        Report {
            message: message.into(),
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
        }
    }

    pub(super) fn parse(error: &ParseError) -> Report {
        Report {
            message: error.message().to_owned(),
            labels: error
                .labels()
                .map(|(span, text)| (span, text.to_owned()))
                .collect(),
            notes: error.notes().map(str::to_owned).collect(),
            help: None,
        }
    }

    pub(super) fn validation(error: &WithSpan<ValidationError>) -> Report {
        let mut notes = Vec::new();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(inner) = cause {
            notes.push(inner.to_string());
            cause = inner.source();
        }
        Report {
            message: error.as_inner().to_string(),
            labels: error
                .spans()
                .map(|(span, text)| (*span, text.clone()))
                .collect(),
            notes,
            help: None,
        }
    }

    /// Renders it. Where there is a hint for a message, it is given.
    pub(super) fn render(mut self, source: &Source) -> Invalid {
        let help = self.help.take().or_else(|| hints::hint(&self, source));
        let labels: Vec<_> = self
            .labels
            .iter()
            .filter_map(|(span, text)| {
                let (file, range) = source.locate(*span)?;
                Some(Label::primary(file, range).with_message(text))
            })
            .collect();
        let mut message = self.message.clone();
        if labels.is_empty()
            && let Some(name) = source.names().next()
        {
            message = format!("{name}: {message}");
        }
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        let notes = notes.chain(help.iter().map(|help| format!("help: {help}")));
        let diagnostic = Diagnostic::error()
            .with_message(&message)
            .with_labels(labels)
            .with_notes(notes.collect());
        let render = |color| {
            finding::emit(&diagnostic, source, color)
                .unwrap_or_else(|| format!("error: {message}\n"))
        };
        Invalid {
            rendered: render(Color::Never),
            coloured: render(Color::Always).into_boxed_str(),
            place: self
                .labels
                .first()
                .and_then(|(span, _)| source.place(*span)),
            message: self.message,
            help: help.map(String::into_boxed_str),
        }
    }
}
