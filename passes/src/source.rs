//! The text that a module came from: one file or several, in order, with their names.
//!
//! naga's spans are byte offsets into one text. Where a shader is put together from several files, they are joined with
//! line breaks, and a span is led back to its file.

use std::ops::Range;

use naga::Span;

/// A piece of source text.
#[derive(Clone, Debug)]
struct File {
    name: String,
    start: usize,
    text: String,
}

/// Files, joined into the one text that a front end parses.
#[derive(Clone, Debug, Default)]
pub struct Source {
    files: Vec<File>,
    text: String,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's name.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, in bytes, from 1.
    pub column: usize,
}

impl Source {
    /// A single file.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Source {
        let mut source = Source::default();
        source.push(name, text);
        source
    }

    /// Appends a file.
    pub fn push(&mut self, name: impl Into<String>, text: impl Into<String>) {
        let text = text.into();
        if !self.text.is_empty() && !self.text.ends_with('\n') {
            self.text.push('\n');
        }
        self.files.push(File {
            name: name.into(),
            start: self.text.len(),
            text: text.clone(),
        });
        self.text.push_str(&text);
    }

    /// The joined text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names of the files, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|file| file.name.as_str())
    }

    /// The file that holds a span, and the span inside it. A span that runs over a file's end is cut there.
    pub(crate) fn locate(&self, span: Span) -> Option<(usize, Range<usize>)> {
        let range = span.to_range()?;
        let index = self
            .files
            .iter()
            .rposition(|file| file.start <= range.start)?;
        let file = &self.files[index];
        let end = file.text.len();
        let local = (range.start - file.start).min(end)..(range.end - file.start).min(end);
        // a span from another text must not cut a character in two
        (file.text.is_char_boundary(local.start) && file.text.is_char_boundary(local.end))
            .then_some((index, local))
    }

    /// Where a span starts.
    pub fn place(&self, span: Span) -> Option<Place> {
        let (index, range) = self.locate(span)?;
        let file = &self.files[index];
        let before = &file.text[..range.start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        Some(Place {
            file: file.name.clone(),
            line: before.matches('\n').count() + 1,
            column: range.start - line_start + 1,
        })
    }

    /// The text of a span, its white space made single.
    pub fn snippet(&self, span: Span) -> Option<String> {
        let (index, range) = self.locate(span)?;
        let text = &self.files[index].text[range];
        Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    pub(crate) fn codespan_files(&self) -> codespan_reporting::files::SimpleFiles<&str, &str> {
        let mut files = codespan_reporting::files::SimpleFiles::new();
        for file in &self.files {
            files.add(file.name.as_str(), file.text.as_str());
        }
        files
    }
}
