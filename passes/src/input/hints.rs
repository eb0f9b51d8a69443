//! What an author can do about messages of naga's that do not say it.

use super::{compose, invalid::Report};
use crate::source::Source;

/// The words that a label is about.
fn snippet(report: &Report, source: &Source) -> String {
    report
        .labels
        .first()
        .and_then(|(span, _)| source.snippet(*span))
        .unwrap_or_default()
}

/// A hint, if there is one.
pub(super) fn hint(report: &Report, source: &Source) -> Option<String> {
    let message = report.message.as_str();
    let words = snippet(report, source);
    if words.contains("push_constant") {
        return Some(
            "naga 30 calls this address space `immediate`: write `var<immediate>`".to_owned(),
        );
    }
    if let Some(name) = between(message, "the `", "` enable extension is not enabled") {
        return Some(format!("write `enable {name};` at the head of the file"));
    }
    if let Some(name) = undefined(report, source) {
        return Some(format!(
            "`{name}` is not defined: `--define {name}=VALUE` does so"
        ));
    }
    if words.starts_with('#') || words.starts_with("import") || compose::has_commands(source.text())
    {
        return Some(
            "this looks like a line for naga_oil's preprocessor: `vrcs rewrite` and `input::Reader` understand those"
                .to_owned(),
        );
    }
    if words.starts_with('[') && source.text().contains("[[") {
        return Some(
            "attributes in double brackets are WGSL of before 2022: write `@group(0)`, `@compute` and so on"
                .to_owned(),
        );
    }
    if source.text().contains("{{") || words.starts_with('$') {
        return Some("this is a template: fill it in before it is rewritten".to_owned());
    }
    if let Some(name) = between(message, "no definition in scope for identifier: `", "`") {
        return Some(format!(
            "if another file declares `{name}`, give that file first: `vrcs rewrite common.wgsl main.wgsl`"
        ));
    }
    None
}

/// The name in a `#{NAME}` that nothing was put in the place of.
fn undefined<'t>(report: &Report, source: &'t Source) -> Option<&'t str> {
    let (span, _) = report.labels.first()?;
    let rest = source.text().get(span.to_range()?.start..)?;
    Some(rest.strip_prefix("#{")?.split_once('}')?.0)
}

fn between<'t>(text: &'t str, before: &str, after: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(before)?;
    Some(rest.split_once(after)?.0)
}
