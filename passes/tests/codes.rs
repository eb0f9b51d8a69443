//! The table of codes: each that can be given has an example, which yields it and nothing else, at the line that it is about, and
//! says what to do.

use std::collections::BTreeSet;

use vrcs_passes::{Code, Severity, examples};

/// Codes without an example: what nobody knows how to make, and what is not given any more.
const WITHOUT: [Code; 2] = [Code::Defect, Code::UnsupportedStore];

#[test]
fn numbers_are_told_apart_and_say_how_grave_a_code_is() {
    let numbers: BTreeSet<u16> = Code::ALL.iter().map(|code| code.number()).collect();
    assert_eq!(numbers.len(), Code::ALL.len());
    for &code in Code::ALL {
        assert_eq!(
            code.number() < 100,
            code.severity() == Severity::Refusal,
            "{code}"
        );
        assert_eq!(code.to_string().parse(), Ok(code));
        assert!(
            code.explanation().ends_with('.'),
            "{code}: {}",
            code.explanation()
        );
    }
}

/// What is wrong with the example of a code.
fn wrong(code: Code) -> Option<String> {
    let Some(example) = examples::of(code) else {
        return (!WITHOUT.contains(&code)).then(|| format!("{code} has no example"));
    };
    let source = example.source(code);
    let findings = example.findings(&source);
    let codes: BTreeSet<Code> = findings.iter().map(|finding| finding.code).collect();
    if codes != BTreeSet::from([code]) {
        return Some(format!("{code}: {findings:#?}"));
    }
    let label = findings[0].labels.first();
    let line = label.map(|label| {
        source
            .place(label.span)
            .expect("a place in the source")
            .line
    });
    if line != example.marked() {
        return Some(format!(
            "{code} is about line {line:?}, and the mark says {:?}",
            example.marked()
        ));
    }
    let silent = findings.iter().find(|finding| finding.help.is_none());
    silent.map(|finding| format!("{code} does not say what to do: {}", finding.message))
}

#[test]
fn every_code_has_an_example_that_yields_it_alone_at_its_line() {
    let wrong: Vec<String> = Code::ALL.iter().filter_map(|&code| wrong(code)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
