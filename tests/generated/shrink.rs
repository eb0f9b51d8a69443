//! Makes a failing shader small.
//!
//! *Does*: deletes lines and blocks, takes blocks apart, and replaces bracketed expressions by their parts, as long as the
//! shader still fails in the same way. *Needs*: a test for that; a text that is no shader any more simply does not fail.
//! *Guarantees*: the result fails. It is small, not smallest.

/// Shrinks `text` while `fails` says so; `tries` bounds how often it is asked.
pub fn shrink(text: &str, tries: u32, fails: &mut dyn FnMut(&str) -> bool) -> String {
    let mut shrinker = Shrinker {
        lines: text.lines().map(str::to_owned).collect(),
        tries,
        fails,
    };
    loop {
        let before = shrinker.lines.clone();
        shrinker.delete_blocks();
        shrinker.delete_lines();
        shrinker.take_apart();
        shrinker.simplify();
        if shrinker.lines == before || shrinker.tries == 0 {
            return shrinker.lines.join("\n") + "\n";
        }
    }
}

struct Shrinker<'f> {
    lines: Vec<String>,
    tries: u32,
    fails: &'f mut dyn FnMut(&str) -> bool,
}

impl Shrinker<'_> {
    /// Takes over `lines` if they still fail.
    fn attempt(&mut self, lines: Vec<String>) -> bool {
        if self.tries == 0 {
            return false;
        }
        self.tries -= 1;
        let fails = (self.fails)(&(lines.join("\n") + "\n"));
        if fails {
            self.lines = lines;
        }
        fails
    }

    /// The line that closes the block which line `first` opens, if it opens one.
    fn end_of(&self, first: usize) -> Option<usize> {
        let mut depth = 0i32;
        for (index, line) in self.lines.iter().enumerate().skip(first) {
            depth += line.matches('{').count() as i32 - line.matches('}').count() as i32;
            if depth <= 0 {
                return (index > first).then_some(index);
            }
        }
        None
    }

    fn without(&self, ranges: &[std::ops::RangeInclusive<usize>]) -> Vec<String> {
        let kept = |index: &usize| !ranges.iter().any(|range| range.contains(index));
        (0..self.lines.len())
            .filter(kept)
            .map(|index| self.lines[index].clone())
            .collect()
    }

    /// Deletes whole blocks, the last first: what is declared first is used later.
    fn delete_blocks(&mut self) {
        let mut first = self.lines.len();
        while first > 0 {
            first = (first - 1).min(self.lines.len().saturating_sub(1));
            if let Some(last) = self.end_of(first) {
                self.attempt(self.without(&[first..=last]));
            }
        }
    }

    /// Deletes runs of lines, long ones first.
    fn delete_lines(&mut self) {
        let mut run = 8;
        while run > 0 {
            let mut end = self.lines.len();
            while end > 0 {
                let first = end.saturating_sub(run);
                self.attempt(self.without(&[first..=end - 1]));
                end = first.min(self.lines.len());
            }
            run /= 2;
        }
    }

    /// Deletes a block's brackets and keeps what is inside.
    fn take_apart(&mut self) {
        let mut first = self.lines.len();
        while first > 0 {
            first -= 1;
            if let Some(last) = self.end_of(first) {
                self.attempt(self.without(&[first..=first, last..=last]));
            }
        }
    }

    /// Replaces bracketed expressions by their parts.
    fn simplify(&mut self) {
        for index in (0..self.lines.len()).rev() {
            let mut at = 0;
            while let Some((candidates, next)) = replacements(&self.lines[index], at) {
                let replaced = candidates.into_iter().any(|line| {
                    let mut lines = self.lines.clone();
                    lines[index] = line;
                    self.attempt(lines)
                });
                if !replaced {
                    at = next;
                }
                if self.tries == 0 {
                    return;
                }
            }
        }
    }
}

/// The ways to replace the first bracketed expression from `from` on by one of its parts, and where to look next.
fn replacements(line: &str, from: usize) -> Option<(Vec<String>, usize)> {
    let open = from + line.get(from..)?.find('(')?;
    let mut depth = 0;
    let mut parts = Vec::new();
    let mut part = open + 1;
    let mut close = None;
    for (at, character) in line.char_indices().skip_while(|&(at, _)| at < open) {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            parts.push(part..at);
            close = Some(at);
            break;
        }
        if depth == 1 && at > open {
            let rest = &line[at..];
            let operator = [
                ", ", " + ", " - ", " * ", " / ", " && ", " || ", " ^ ", " & ",
            ]
            .iter()
            .find(|operator| rest.starts_with(**operator));
            if let Some(operator) = operator {
                parts.push(part..at);
                part = at + operator.len();
            }
        }
    }
    let close = close?;
    let name = line[..open]
        .rfind(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '<' | '>')))
        .map_or(0, |at| at + 1);
    let candidates = parts
        .into_iter()
        .filter(|part| !part.is_empty())
        .map(|part| format!("{}{}{}", &line[..name], &line[part], &line[close + 1..]))
        .collect();
    Some((candidates, open + 1))
}

#[test]
fn what_does_not_matter_is_gone() {
    let text = "
struct Unused {
    a: u32,
}

fn helper(a: f32) -> f32 {
    return a * 2.0;
}

fn main() {
    let a = 1.0;
    if a > 0.5 {
        let b = helper(a);
        store(max((culprit + 1.0), helper(2.0)));
    } else {
        let c = 3.0;
    }
}
";
    let balanced = |text: &str| text.matches('{').count() == text.matches('}').count();
    let small = shrink(text, 10_000, &mut |text| {
        balanced(text)
            && text.contains("fn main")
            && text.contains("store(")
            && text.contains("culprit")
    });
    assert_eq!(small.trim(), "fn main() {\n        store(culprit);\n}");
}
