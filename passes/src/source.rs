//! The text that a module came from: one file or several, with their names.
//!
//! naga's spans are byte offsets into one text. Where a shader is put together from several files, that text is made of
//! pieces: some stand in a file word for word, some stand for other words (an imported name, a defined value). A span
//! is led back through its pieces to the file and the place that the author knows.

use std::ops::Range;

use naga::Span;

/// A file as its author has it.
#[derive(Clone, Debug)]
struct File {
    name: String,
    text: String,
}

/// A part of the joined text.
#[derive(Clone, Debug)]
struct Piece {
    /// Where it starts in the joined text.
    start: usize,
    /// The file that it comes from.
    file: usize,
    /// What it comes from, in the file.
    of: Range<usize>,
    /// Whether it is that text word for word, rather than something in its place.
    is_verbatim: bool,
}

/// Files, joined into the one text that a front end parses.
#[derive(Clone, Debug, Default)]
pub struct Source {
    files: Vec<File>,
    pieces: Vec<Piece>,
    text: String,
    /// Whether what is parsed is not text at all, and spans lead to the lines that it was compiled from.
    is_compiled: bool,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Place {
    /// The file's name.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, in bytes, from 1.
    pub column: usize,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
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
        if !self.text.is_empty() && !self.text.ends_with('\n') {
            self.text.push('\n');
        }
        let text = text.into();
        let all = 0..text.len();
        let file = self.add_file(name, text);
        self.keep(file, all);
    }

    /// Makes a file known, without any of its text.
    pub(crate) fn add_file(&mut self, name: impl Into<String>, text: impl Into<String>) -> usize {
        self.files.push(File {
            name: name.into(),
            text: text.into(),
        });
        self.files.len() - 1
    }

    /// Appends a part of a file, word for word.
    pub(crate) fn keep(&mut self, file: usize, part: Range<usize>) {
        let start = self.text.len();
        self.text.push_str(&self.files[file].text[part.clone()]);
        match self.pieces.last_mut() {
            Some(last) if last.is_verbatim && last.file == file && last.of.end == part.start => {
                last.of.end = part.end;
            }
            _ => self.pieces.push(Piece {
                start,
                file,
                of: part,
                is_verbatim: true,
            }),
        }
    }

    /// Appends other words in the place of a part of a file.
    pub(crate) fn replace(&mut self, file: usize, part: Range<usize>, words: &str) {
        self.pieces.push(Piece {
            start: self.text.len(),
            file,
            of: part,
            is_verbatim: false,
        });
        self.text.push_str(words);
    }

    /// Says that what is parsed comes, from its byte `start` on, from a part of a file. Bytes in order.
    #[cfg(feature = "spirv")]
    pub(crate) fn stand_for(&mut self, start: usize, file: usize, of: Range<usize>) {
        self.is_compiled = true;
        self.pieces.push(Piece {
            start,
            file,
            of,
            is_verbatim: false,
        });
    }

    /// The joined text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names of the files, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|file| file.name.as_str())
    }

    /// The files themselves: names and texts, in order.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files
            .iter()
            .map(|file| (file.name.as_str(), file.text.as_str()))
    }

    /// The file and what a byte of the joined text comes from.
    fn origin(&self, at: usize) -> Option<(usize, Range<usize>)> {
        let piece = self.pieces.iter().rfind(|piece| piece.start <= at)?;
        let of = match piece.is_verbatim {
            // what lies behind a piece's end (a line break between files) belongs to its end
            true => {
                let start = (piece.of.start + (at - piece.start)).min(piece.of.end);
                start..(start + 1).min(piece.of.end)
            }
            false => piece.of.clone(),
        };
        Some((piece.file, of))
    }

    /// The file that holds a span, and the span inside it. A span that runs over a file's end is cut there.
    pub(crate) fn locate(&self, span: Span) -> Option<(usize, Range<usize>)> {
        let range = span.to_range()?;
        let (file, first) = self.origin(range.start)?;
        let text = &self.files[file].text;
        let end = match range.is_empty() {
            _ if self.is_compiled => first.end,
            true => first.start,
            false => match self.origin(range.end - 1)? {
                (last_file, last) if last_file == file => last.end.max(first.start),
                _ => text.len(),
            },
        };
        // a span from another text must not cut a character in two
        (text.is_char_boundary(first.start) && text.is_char_boundary(end))
            .then_some((file, first.start..end))
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
        let (index, mut range) = self.locate(span)?;
        let text = &self.files[index].text;
        // naga ends the span of a call that is a statement before its last parenthesis
        let open = text[range.clone()].matches('(').count();
        if open == text[range.clone()].matches(')').count() + 1
            && text[range.end..].starts_with(')')
        {
            range.end += 1;
        }
        let text = &text[range];
        Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    /// The text of an expression, where the source has expressions and not only lines.
    pub(crate) fn expression(&self, span: Span) -> Option<String> {
        let words = self.snippet(span).filter(|_| !self.is_compiled)?;
        // naga's GLSL front end gives a member or an element the place of what is behind the `.` or `[` alone
        (!words.is_empty() && !words.starts_with(['.', '['])).then_some(words)
    }

    pub(crate) fn codespan_files(&self) -> codespan_reporting::files::SimpleFiles<&str, &str> {
        let mut files = codespan_reporting::files::SimpleFiles::new();
        for file in &self.files {
            files.add(file.name.as_str(), file.text.as_str());
        }
        files
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(source: &Source, word: &str) -> String {
        let at = source.text().find(word).expect("the word") as u32;
        let span = Span::new(at, at + word.len() as u32);
        source.place(span).expect("a place").to_string()
    }

    #[test]
    fn spans_lead_back_through_joined_files() {
        let mut source = Source::new("a", "one\ntwo");
        source.push("b", "three\n  four");
        assert_eq!(source.text(), "one\ntwo\nthree\n  four");
        assert_eq!(place(&source, "two"), "a:2:1");
        assert_eq!(place(&source, "four"), "b:2:3");
        let across = Span::new(4, 12);
        assert_eq!(source.snippet(across).as_deref(), Some("two"));
    }

    #[test]
    fn spans_lead_back_through_replaced_words() {
        let mut source = Source::default();
        let file = source.add_file("a", "let x = lib::value + 1;");
        source.keep(file, 0..8);
        source.replace(file, 8..18, "value_of_the_library");
        source.keep(file, 18..23);
        assert_eq!(source.text(), "let x = value_of_the_library + 1;");
        assert_eq!(place(&source, "of_the"), "a:1:9");
        assert_eq!(place(&source, "+ 1"), "a:1:20");
        let span = Span::new(8, 32);
        assert_eq!(source.snippet(span).as_deref(), Some("lib::value + 1"));
    }
}
