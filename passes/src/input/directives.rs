//! `enable`, `requires` and `diagnostic`: lines at the head of a WGSL text.
//!
//! naga 30 rejects `enable subgroups;`, which browsers demand, and language features that it does not know, and its writer
//! writes none of the three but the extensions of its own. What it rejects is made spaces, so that no span moves; all of
//! it is remembered, and [put back](crate::emit::wgsl_with) where text is written.

use std::{collections::BTreeSet, ops::Range};

/// The directives of a text, in order, each once.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Directives {
    /// The names after `enable`.
    pub enables: Vec<String>,
    /// The names after `requires`.
    pub requires: Vec<String>,
    /// What stands between the parentheses of `diagnostic(…)`.
    pub diagnostics: Vec<String>,
}

/// A directive in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Directive {
    /// From its first letter to its semicolon.
    pub(super) range: Range<usize>,
    /// Its text, white space made single.
    pub(super) text: String,
    keyword: &'static str,
    /// Its names, and where they stand.
    names: Vec<(Range<usize>, String)>,
}

/// Extensions that browsers know and naga 30 does not accept, though it needs nothing to understand what they allow.
const ENABLES: [&str; 4] = [
    "subgroups",
    "subgroups_f16",
    "chromium_experimental_subgroups",
    "chromium_internal_graphite",
];

/// Language features that naga 30 accepts.
const ACCEPTED: [&str; 3] = [
    "readonly_and_readwrite_storage_textures",
    "packed_4x8_integer_dot_product",
    "pointer_composite_access",
];

impl Directives {
    /// The directives at the head of a text.
    pub fn of(text: &str) -> Directives {
        let mut found = Directives::default();
        for directive in find(text) {
            let list = match directive.keyword {
                "enable" => &mut found.enables,
                "requires" => &mut found.requires,
                _ => &mut found.diagnostics,
            };
            for (_, name) in directive.names {
                if !list.contains(&name) {
                    list.push(name);
                }
            }
        }
        found
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.enables.is_empty() && self.requires.is_empty() && self.diagnostics.is_empty()
    }
}

/// Finds the directives at the head of a text.
pub(super) fn find(text: &str) -> Vec<Directive> {
    let mut found = Vec::new();
    let mut at = 0;
    loop {
        at = skip_blank(text, at);
        let rest = &text[at..];
        let Some(keyword) = ["enable", "requires", "diagnostic"].into_iter().find(|k| {
            rest.strip_prefix(k)
                .is_some_and(|after| after.starts_with(|c: char| c.is_whitespace() || c == '('))
        }) else {
            return found;
        };
        let Some(len) = rest.find(';') else {
            return found;
        };
        let range = at..at + len + 1;
        found.push(Directive {
            text: text[range.clone()]
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
            keyword,
            names: names(text, at + keyword.len()..at + len, keyword),
            range: range.clone(),
        });
        at = range.end;
    }
}

/// The `@diagnostic(…)` of statements, which naga does not read. They say what a compiler warns of, and nothing of what the shader does. Those
/// of functions naga reads, and heeds.
fn of_statements(text: &str) -> Vec<Range<usize>> {
    const ATTRIBUTE: &str = "@diagnostic";
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(offset) = text[at..].find(['@', '/']) {
        let start = at + offset;
        // comments are passed over
        let code = skip_blank(text, start);
        if code > start {
            at = code;
            continue;
        }
        at = start + 1;
        let Some(rest) = text[start..].strip_prefix(ATTRIBUTE) else {
            continue;
        };
        let Some(end) = rest.find(')') else {
            return found;
        };
        let end = start + ATTRIBUTE.len() + end + 1;
        at = end;
        if !is_before_function(text, end) {
            found.push(start..end);
        }
    }
    found
}

/// Whether what stands behind an attribute is a function, with more attributes in front of it or none.
fn is_before_function(text: &str, mut at: usize) -> bool {
    loop {
        at = skip_blank(text, at);
        let rest = &text[at..];
        let Some(attribute) = rest.strip_prefix('@') else {
            return rest
                .strip_prefix("fn")
                .is_some_and(|after| after.starts_with(|c: char| c.is_whitespace() || c == '/'));
        };
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        at += 1 + attribute.find(|c| !is_name(c)).unwrap_or(attribute.len());
        let open = skip_blank(text, at);
        if text[open..].starts_with('(') {
            let mut depth = 0;
            let close = text[open..].char_indices().find(|&(_, c)| {
                depth += i32::from(c == '(') - i32::from(c == ')');
                depth == 0
            });
            at = close.map_or(text.len(), |(close, _)| open + close + 1);
        }
    }
}

/// The names of a directive; a `diagnostic` has one, the whole of its parentheses.
fn names(text: &str, part: Range<usize>, keyword: &str) -> Vec<(Range<usize>, String)> {
    let words = &text[part.clone()];
    if keyword == "diagnostic" {
        let inner = words.trim().trim_start_matches('(').trim_end_matches(')');
        let tight: String = inner.split_whitespace().collect();
        return vec![(part, tight.replace(',', ", "))];
    }
    let mut at = part.start;
    words
        .split(',')
        .filter_map(|name| {
            let start = at + (name.len() - name.trim_start().len());
            at += name.len() + 1;
            let name = name.trim();
            (!name.is_empty()).then(|| (start..start + name.len(), name.to_owned()))
        })
        .collect()
}

/// The first place that is neither white space nor a comment.
fn skip_blank(text: &str, mut at: usize) -> usize {
    loop {
        let rest = &text[at..];
        let blank = rest.len() - rest.trim_start().len();
        at += blank;
        let rest = &text[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            let Some(end) = end_of_comment(rest) else {
                return at;
            };
            at += end;
        } else {
            return at;
        }
    }
}

fn end_of_comment(text: &str) -> Option<usize> {
    let mut depth = 0usize;
    let mut at = 0;
    while let Some(next) = text[at..].find(['/', '*']).map(|offset| at + offset) {
        let rest = &text[next..];
        at = next + 1;
        if rest.starts_with("/*") {
            depth += 1;
            at = next + 2;
        } else if rest.starts_with("*/") {
            depth = depth.saturating_sub(1);
            at = next + 2;
            if depth == 0 {
                return Some(at);
            }
        }
    }
    None
}

/// The text with spaces in the place of what naga rejects.
pub fn blank(text: &str) -> String {
    let mut out = text.to_owned();
    for directive in find(text) {
        let is_rejected = |name: &str| match directive.keyword {
            "enable" => ENABLES.contains(&name),
            "requires" => !ACCEPTED.contains(&name),
            _ => false,
        };
        let kept: BTreeSet<&str> = directive
            .names
            .iter()
            .map(|(_, name)| name.as_str())
            .filter(|name| !is_rejected(name))
            .collect();
        if kept.len() == directive.names.len() {
            continue;
        }
        // what is kept is written anew, in the room that there was
        let mut line = match kept.is_empty() {
            true => String::new(),
            false => format!(
                "{} {};",
                directive.keyword,
                kept.into_iter().collect::<Vec<_>>().join(",")
            ),
        };
        let room = &text[directive.range.clone()];
        let breaks = room.matches('\n').count();
        line.push_str(&" ".repeat(room.len().saturating_sub(line.len() + breaks)));
        line.push_str(&"\n".repeat(breaks));
        if line.len() == room.len() {
            out.replace_range(directive.range, &line);
        }
    }
    for range in of_statements(text) {
        let room = &text[range.clone()];
        let line: String = (room.bytes())
            .map(|byte| if byte == b'\n' { '\n' } else { ' ' })
            .collect();
        out.replace_range(range, &line);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_directives_nothing_changes() {
        let text = "// enable subgroups;\nconst enable_me = 1;";
        assert!(Directives::of(text).is_empty());
        assert_eq!(blank(text), text);
    }

    #[test]
    fn directives_are_found_behind_comments() {
        let found = Directives::of(
            "/* a /* b */ */ enable f16, subgroups;\n// c\nrequires x,\n y;\n\
             diagnostic(off,derivative_uniformity); fn f() {} enable late;",
        );
        assert_eq!(found.enables, ["f16", "subgroups"]);
        assert_eq!(found.requires, ["x", "y"]);
        assert_eq!(found.diagnostics, ["off, derivative_uniformity"]);
    }

    #[test]
    fn what_naga_rejects_becomes_spaces_and_nothing_moves() {
        let text = "enable subgroups,f16;\nrequires a,\n  b;\nenable subgroups;\nconst X = 1;";
        let blanked = blank(text);
        assert_eq!(blanked.len(), text.len());
        assert_eq!(blanked.find("const"), text.find("const"));
        assert_eq!(blanked.matches('\n').count(), text.matches('\n').count());
        assert_eq!(
            blanked.split_whitespace().collect::<Vec<_>>().join(" "),
            "enable f16; const X = 1;"
        );
    }

    #[test]
    fn diagnostics_of_statements_become_spaces_and_those_of_functions_stay() {
        let text = "// @diagnostic(off, a) {\n\
             @compute @diagnostic(off, a) /* @ */ @workgroup_size(8, max(1, 8)) fn main() {\n\
                 if x / 2 > 1 @diagnostic(off,\n chromium.b) { } else { }\n\
                 @diagnostic(warning, c) for (;;) { }\n\
             }\n@diagnostic(info, d)fn f() @diagnostic(off, e) { }";
        let blanked = blank(text);
        assert_eq!(blanked.len(), text.len());
        assert_eq!(blanked.matches('\n').count(), text.matches('\n').count());
        for (name, stays) in [
            ("(off, a) /", true),
            ("chromium", false),
            ("warning", false),
            ("info", true),
            ("e)", false),
        ] {
            assert_eq!(blanked.contains(name), stays, "{name}: {blanked}");
        }
        for cut in 0..text.len() {
            let _ = blank(&text[..cut]);
        }
    }
}
