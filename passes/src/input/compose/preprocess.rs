//! `#ifdef` and its kin, `#define`, `#{NAME}`, `#import`: what of a file's text counts.
//!
//! The syntax is naga_oil's: `#ifdef`, `#ifndef`, `#if NAME == VALUE` (also `!=`, `<`, `<=`, `>`, `>=`), `#else`, `#else ifdef`,
//! `#else ifndef`, `#else if`, `#endif`, `#define NAME VALUE`, `#{NAME}` and `#NAME` for a value, `#define_import_path`,
//! `#import`.

use std::{collections::BTreeMap, ops::Range};

use super::{
    Problem,
    imports::{self, Import},
    tokens,
};

/// What is defined, and as what; `true` where nothing is said.
pub type Defines = BTreeMap<String, String>;

/// A part of a file that counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Text of the file.
    Text(Range<usize>),
    /// A value in the place of `#{NAME}`.
    Value(Range<usize>, String),
}

/// What of a file counts.
#[derive(Clone, Debug, Default)]
pub(super) struct Preprocessed {
    /// The file's name as a module.
    pub(super) path: Option<String>,
    /// What it imports.
    pub(super) imports: Vec<Import>,
    /// The text that remains.
    pub(super) parts: Vec<Part>,
}

/// A condition that is open: whether its branch counts, and whether a branch before it did.
struct Branch {
    counts: bool,
    taken: bool,
    at: usize,
}

/// Whether a text has lines for a preprocessor.
pub(super) fn has_commands(text: &str) -> bool {
    text.contains('#') && {
        let bare = tokens::without_comments(text);
        bare.lines()
            .any(|line| command(line).is_some() || line.contains("#{"))
    }
}

/// The command and its arguments, if a line is one.
fn command(line: &str) -> Option<(&str, &str)> {
    let rest = line.trim_start().strip_prefix('#')?.trim_start();
    let end = rest
        .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        .unwrap_or(rest.len());
    let (name, arguments) = (&rest[..end], rest[end..].trim());
    matches!(
        name,
        "ifdef" | "ifndef" | "if" | "else" | "endif" | "define" | "define_import_path" | "import"
    )
    .then_some((name, arguments))
}

/// Reads a file. `#define`s are added to `defines` if the file is no module.
pub(super) fn preprocess(
    text: &str,
    file: usize,
    defines: &mut Defines,
) -> Result<Preprocessed, Problem> {
    let bare = tokens::without_comments(text);
    let problem = |range: Range<usize>, message: String| Problem::at(file, range, message);
    let mut out = Preprocessed::default();
    let mut open: Vec<Branch> = Vec::new();
    let mut at = 0;
    while at < bare.len() {
        let end = bare[at..].find('\n').map_or(bare.len(), |len| at + len + 1);
        let line = at..end;
        let words = &bare[line.clone()];
        let counts = open.last().is_none_or(|branch| branch.counts);
        let Some((name, arguments)) = command(words) else {
            if counts {
                keep(text, &bare, line, defines, &mut out.parts);
            }
            at = end;
            continue;
        };
        let here = at + (words.len() - words.trim_start().len())..at + words.trim_end().len();
        at = end;
        match name {
            "if" | "ifdef" | "ifndef" => {
                let holds = counts
                    && condition(name, arguments, defines)
                        .map_err(|message| problem(here.clone(), message))?;
                open.push(Branch {
                    counts: holds,
                    taken: holds || !counts,
                    at: here.start,
                });
            }
            "else" => {
                let Some(branch) = open.last_mut() else {
                    return Err(problem(here, "`#else` without `#if`".to_owned()));
                };
                let holds = !branch.taken
                    && match arguments.split_once(char::is_whitespace) {
                        None => true,
                        Some((name, arguments)) => condition(name, arguments.trim(), defines)
                            .map_err(|message| problem(here, message))?,
                    };
                branch.counts = holds;
                branch.taken |= holds;
            }
            "endif" => {
                if open.pop().is_none() {
                    return Err(problem(here, "`#endif` without `#if`".to_owned()));
                }
            }
            _ if !counts => {}
            "define_import_path" => out.path = Some(arguments.trim_end_matches(';').to_owned()),
            "define" => define(arguments, defines).map_err(|message| problem(here, message))?,
            _ => {
                let (imported, next) = imports::parse(&bare, here.start, file)?;
                out.imports.extend(imported);
                at = at.max(next);
            }
        }
        // the lines stay where they are
        out.parts.push(Part::Value(at..at, "\n".to_owned()));
    }
    match open.pop() {
        Some(branch) => Err(problem(
            branch.at..branch.at,
            "this condition has no `#endif`".to_owned(),
        )),
        None => Ok(out),
    }
}

fn define(arguments: &str, defines: &mut Defines) -> Result<(), String> {
    let mut words = arguments.split_whitespace();
    let name = words.next().ok_or("`#define` needs a name")?;
    let value = words.collect::<Vec<_>>().join(" ");
    // what the caller defines goes before what the file does
    defines
        .entry(name.to_owned())
        .or_insert(match value.is_empty() {
            true => "true".to_owned(),
            false => value,
        });
    Ok(())
}

fn condition(name: &str, arguments: &str, defines: &Defines) -> Result<bool, String> {
    match name {
        "ifdef" => Ok(defines.contains_key(arguments)),
        "ifndef" => Ok(!defines.contains_key(arguments)),
        "if" => compare(arguments, defines),
        other => Err(format!("`#else {other}` is not understood")),
    }
}

fn compare(arguments: &str, defines: &Defines) -> Result<bool, String> {
    let is_operator = |c: char| "=!<>".contains(c);
    let start = arguments.find(is_operator);
    let (name, rest) = arguments.split_at(start.unwrap_or(arguments.len()));
    let name = name.trim();
    let end = rest.find(|c: char| !is_operator(c)).unwrap_or(rest.len());
    let (operator, value) = (&rest[..end], rest[end..].trim());
    if name.is_empty() || operator.is_empty() || value.is_empty() {
        return Err("a condition is `#if NAME == VALUE`".to_owned());
    }
    let known = defines
        .get(name)
        .ok_or_else(|| format!("`{name}` is not defined: give it with `--define {name}=VALUE`"))?;
    let number = |text: &str| text.trim_end_matches(['u', 'i']).parse::<i64>().ok();
    let order = match (number(known), number(value)) {
        (Some(a), Some(b)) => a.cmp(&b),
        _ => known.as_str().cmp(value),
    };
    match operator {
        "==" => Ok(order.is_eq()),
        "!=" => Ok(order.is_ne()),
        "<" => Ok(order.is_lt()),
        "<=" => Ok(order.is_le()),
        ">" => Ok(order.is_gt()),
        ">=" => Ok(order.is_ge()),
        _ => Err(format!("`{operator}` does not compare")),
    }
}

/// Keeps a line, its `#{NAME}` and `#NAME` replaced by what they are defined as.
fn keep(text: &str, bare: &str, line: Range<usize>, defines: &Defines, parts: &mut Vec<Part>) {
    let mut from = line.start;
    let mut at = line.start;
    while let Some(found) = bare[at..line.end].find('#').map(|offset| at + offset) {
        let rest = &bare[found + 1..line.end];
        let (name, len) = match rest.strip_prefix('{').and_then(|r| r.split_once('}')) {
            Some((name, _)) => (name.trim(), name.len() + 3),
            None => {
                let end = rest
                    .find(|c: char| !c.is_alphanumeric() && c != '_')
                    .unwrap_or(rest.len());
                (&rest[..end], end + 1)
            }
        };
        at = found + 1;
        if let Some(value) = defines.get(name) {
            parts.push(Part::Text(from..found));
            parts.push(Part::Value(found..found + len, value.clone()));
            at = found + len;
            from = at;
        }
    }
    debug_assert!(text.is_char_boundary(from));
    parts.push(Part::Text(from..line.end));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remains(text: &str, defines: &[(&str, &str)]) -> Result<String, String> {
        let mut defines = defines
            .iter()
            .map(|&(n, v)| (n.to_owned(), v.to_owned()))
            .collect();
        let out = preprocess(text, 0, &mut defines).map_err(|problem| problem.message)?;
        let words: String = out
            .parts
            .iter()
            .map(|part| match part {
                Part::Text(range) => &text[range.clone()],
                Part::Value(_, value) => value,
            })
            .collect();
        Ok(words.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn without_commands_nothing_changes() {
        let text = "fn f() {}\r\n// #ifdef A\n";
        assert!(!has_commands(text));
        assert_eq!(remains(text, &[]).as_deref(), Ok("fn f() {} // #ifdef A"));
    }

    #[test]
    fn conditions_choose() {
        let text = "#ifdef A\na\n#else ifdef B\nb\n#else\nc\n#endif\n#if N >= 3\nd\n#endif";
        let n = ("N", "3");
        assert_eq!(remains(text, &[n]).as_deref(), Ok("c d"));
        assert_eq!(remains(text, &[n, ("A", "true")]).as_deref(), Ok("a d"));
        assert_eq!(
            remains(text, &[("N", "2u"), ("B", "1")]).as_deref(),
            Ok("b")
        );
        assert_eq!(
            remains(text, &[]),
            Err("`N` is not defined: give it with `--define N=VALUE`".to_owned())
        );
    }

    #[test]
    fn conditions_nest() {
        let text = "#ifdef A\n#ifdef B\nab\n#else\na\n#endif\n#else\n#ifdef B\nb\n#endif\n#endif";
        assert_eq!(remains(text, &[("A", "")]).as_deref(), Ok("a"));
        assert_eq!(remains(text, &[("B", "")]).as_deref(), Ok("b"));
        assert_eq!(remains(text, &[("A", ""), ("B", "")]).as_deref(), Ok("ab"));
        assert_eq!(remains(text, &[]).as_deref(), Ok(""));
    }

    #[test]
    fn values_are_put_in() {
        let text = "#define N 4\nx = #{N} + #N + #M;";
        assert_eq!(remains(text, &[]).as_deref(), Ok("x = 4 + 4 + #M;"));
        assert_eq!(
            remains(text, &[("N", "5")]).as_deref(),
            Ok("x = 5 + 5 + #M;")
        );
    }

    #[test]
    fn what_is_not_closed_is_told() {
        for text in [
            "#ifdef A\n",
            "#endif\n",
            "#else\n",
            "#if A\n#endif",
            "#define",
        ] {
            assert!(remains(text, &[]).is_err(), "{text}");
        }
    }
}
