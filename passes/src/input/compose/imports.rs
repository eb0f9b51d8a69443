//! `#import`: what a file calls the things of other modules.
//!
//! `#import a::b`, `#import a::b as c`, `#import a::{b, c::{d, e as f}}`, `#import a::b d, e` (the old form) and the same
//! with a file in quotes in the place of the first name.

use std::ops::Range;

use super::{
    Problem,
    tokens::{Token, tokens},
};

/// How deep braces may nest.
const MOST: usize = 32;

/// A name and what it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Import {
    /// The name in the file.
    pub(super) name: String,
    /// A module, or a thing of a module.
    pub(super) path: Vec<String>,
}

/// Parses the import that starts at `start`, and tells where the next line begins.
pub(super) fn parse(
    bare: &str,
    start: usize,
    file: usize,
) -> Result<(Vec<Import>, usize), Problem> {
    let end = end(bare, start);
    let keyword = bare[start..end]
        .find("import")
        .map_or(start, |at| start + at + 6);
    let tokens = tokens(bare, keyword..end);
    let mut reader = Reader {
        tokens: &tokens,
        at: 0,
        found: Vec::new(),
    };
    let deepest = tokens
        .iter()
        .filter(|token| matches!(token, Token::Mark('{', _)))
        .count();
    // the old form nests by words alone
    let understood = deepest <= MOST && reader.list(&[]) && reader.rest_is_empty();
    match understood && !reader.found.is_empty() {
        true => Ok((reader.found, end)),
        false => Err(Problem::at(
            file,
            start..start + bare[start..end].trim_end().len(),
            "this import is not understood".to_owned(),
        )
        .help("an import is `#import a::b`, `#import a::b as c` or `#import a::{b, c}`")),
    }
}

/// Where the import's last line ends: braces may run over several.
fn end(bare: &str, start: usize) -> usize {
    let mut depth = 0usize;
    for (at, c) in bare[start..].char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            '\n' if depth == 0 => return start + at + 1,
            _ => {}
        }
    }
    bare.len()
}

struct Reader<'t> {
    tokens: &'t [Token],
    at: usize,
    found: Vec<Import>,
}

impl Reader<'_> {
    fn mark(&mut self, wanted: char) -> bool {
        let is_there = matches!(self.tokens.get(self.at), Some(&Token::Mark(c, _)) if c == wanted);
        self.at += usize::from(is_there);
        is_there
    }

    fn word(&mut self) -> Option<(Vec<String>, Range<usize>)> {
        let Some(Token::Word(word)) = self.tokens.get(self.at) else {
            return None;
        };
        self.at += 1;
        Some((word.parts.clone(), word.range.clone()))
    }

    fn rest_is_empty(&mut self) -> bool {
        while self.mark(';') {}
        self.at == self.tokens.len()
    }

    /// Trees, separated by commas; the last comma may be too many.
    fn list(&mut self, prefix: &[String]) -> bool {
        loop {
            if !self.tree(prefix) {
                return false;
            }
            if !self.mark(',') {
                return true;
            }
            let is_over = matches!(self.tokens.get(self.at), None | Some(Token::Mark('}', _)));
            if is_over {
                return true;
            }
        }
    }

    fn tree(&mut self, prefix: &[String]) -> bool {
        let Some((parts, _)) = self.word() else {
            return false;
        };
        let path = [prefix, &parts].concat();
        if self.mark(':') {
            return self.mark(':') && self.mark('{') && self.list(&path) && self.mark('}');
        }
        let Some(Token::Word(next)) = self.tokens.get(self.at) else {
            self.add(None, path);
            return true;
        };
        if next.parts == ["as"] {
            self.at += 1;
            let Some((name, _)) = self.word() else {
                return false;
            };
            self.add(Some(name.concat()), path);
            return true;
        }
        // the old form: things of the module, separated by commas; they are words alone
        match path.len() <= MOST {
            true => self.list(&path),
            false => false,
        }
    }

    fn add(&mut self, name: Option<String>, path: Vec<String>) {
        let name = name.or_else(|| path.last().cloned()).unwrap_or_default();
        self.found.push(Import { name, path });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn imports(text: &str) -> Option<String> {
        let (found, _) = parse(text, 0, 0).ok()?;
        let list: Vec<String> = found
            .iter()
            .map(|import| format!("{}={}", import.name, import.path.join("::")))
            .collect();
        Some(list.join(" "))
    }

    #[test]
    fn every_form_is_understood() {
        for (text, expected) in [
            ("#import a::b", "b=a::b"),
            ("#import a::b as c;", "c=a::b"),
            (
                "#import a::{b, c::{d, e as f},}",
                "b=a::b d=a::c::d f=a::c::e",
            ),
            ("#import a::b c, d", "c=a::b::c d=a::b::d"),
            ("#import a", "a=a"),
            ("#import \"x.wgsl\"::{b}", "b=x.wgsl::b"),
            ("# import a::{\n  b,\n  c\n}\nfn", "b=a::b c=a::c"),
        ] {
            assert_eq!(imports(text).as_deref(), Some(expected), "{text}");
        }
        for text in [
            "#import",
            "#import a::{b",
            "#import a as",
            "#import 3",
            "#import a::{}",
        ] {
            assert_eq!(imports(text), None, "{text}");
        }
    }
}
