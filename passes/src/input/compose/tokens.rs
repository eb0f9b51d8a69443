//! The words of a shader's text, comments left out.

use std::ops::Range;

/// The text with every byte of its comments, line breaks apart, made a space: the same length, the same lines.
pub(super) fn without_comments(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut blank = |range: Range<usize>| {
        for byte in &mut out[range] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    };
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let len = if rest.starts_with(b"//") {
            rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())
        } else if rest.starts_with(b"/*") {
            block_comment(rest)
        } else {
            at += 1;
            continue;
        };
        blank(at..at + len);
        at += len;
    }
    // comments are blanked whole, so that no character is cut in two
    String::from_utf8(out).unwrap_or_else(|_| text.to_owned())
}

/// The length of a block comment; they nest.
fn block_comment(text: &[u8]) -> usize {
    let mut depth = 0usize;
    let mut at = 0;
    while at < text.len() {
        match &text[at..] {
            [b'/', b'*', ..] => {
                depth += 1;
                at += 2;
            }
            [b'*', b'/', ..] => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    return at;
                }
            }
            _ => at += 1,
        }
    }
    text.len()
}

/// A word: an identifier, or several joined by `::`, the first of which may be a file in quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word {
    /// Its parts.
    pub(super) parts: Vec<String>,
    /// Where it stands.
    pub(super) range: Range<usize>,
}

fn is_start(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn is_rest(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// What a text consists of, white space apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Token {
    /// A word.
    Word(Word),
    /// Another character, and where it stands. Numbers are left out.
    Mark(char, usize),
}

/// The tokens of a part of a text without comments.
pub(super) fn tokens(text: &str, part: Range<usize>) -> Vec<Token> {
    let mut found = Vec::new();
    let mut at = part.start;
    while let Some(c) = text[at..part.end].chars().next() {
        if c.is_whitespace() {
            at += c.len_utf8();
        } else if is_start(c) || is_file(&text[at..part.end]) {
            let word = word(text, at, part.end);
            at = word.range.end;
            found.push(Token::Word(word));
        } else if c.is_ascii_digit() {
            // letters behind digits belong to the number
            at += text[at..part.end]
                .find(|c: char| !is_rest(c) && c != '.')
                .unwrap_or(part.end - at);
        } else {
            found.push(Token::Mark(c, at));
            at += c.len_utf8();
        }
    }
    found
}

/// Whether a name of a file in quotes starts here.
fn is_file(text: &str) -> bool {
    text.strip_prefix('"')
        .and_then(|rest| {
            rest.find(['"', '\n'])
                .map(|end| rest[end..].starts_with('"'))
        })
        .unwrap_or(false)
}

fn word(text: &str, start: usize, end: usize) -> Word {
    let mut parts = Vec::new();
    let mut at = start;
    loop {
        let rest = &text[at..end];
        let (part, len) = match rest
            .strip_prefix('"')
            .and_then(|r| r.find('"').map(|e| &r[..e]))
        {
            Some(name) => (name, name.len() + 2),
            None => {
                let len = rest.find(|c: char| !is_rest(c)).unwrap_or(rest.len());
                (&rest[..len], len)
            }
        };
        parts.push(part.to_owned());
        at += len;
        let follows = text[at..end]
            .strip_prefix("::")
            .is_some_and(|rest| rest.starts_with(is_start));
        if !follows {
            return Word {
                parts,
                range: start..at,
            };
        }
        at += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_become_spaces() {
        let text = "a // ü\n/* b /* c */ d\n */ e /* f";
        let without = without_comments(text);
        assert_eq!(without.len(), text.len());
        assert_eq!(without.split_whitespace().collect::<String>(), "ae");
        assert_eq!(without.matches('\n').count(), 2);
    }

    #[test]
    fn words_are_found_whole() {
        let text = "a::b::c(x1.y, 0x1fu, 1e5f) \"f.wgsl\"::g";
        let words: Vec<String> = tokens(text, 0..text.len())
            .into_iter()
            .filter_map(|token| match token {
                Token::Word(word) => Some(word.parts.join("::")),
                Token::Mark(..) => None,
            })
            .collect();
        assert_eq!(words, ["a::b::c", "x1", "y", "f.wgsl::g"]);
    }
}
