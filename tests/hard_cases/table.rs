//! The table in `README.md`: made by the tests themselves, and compared with what is there.

use std::{fmt::Write, path::PathBuf, sync::PoisonError};

use crate::case::{Family, MEASURED};

const HEAD: &str = "# Hard cases

Made by `cargo test --test hard_cases`, which fails if this page is not what it measures; `VRCS_BLESS=1` writes it anew. The numbers
E1 to E43 are those of the list of hazards that this project keeps, and each has a row, which is checked; a case without a number came up
on the way. The rule
for all of them: **any doubt means full rate**, never a coarse tile, never NaN.

How each test was shown to be able to fail stands beside it in the source: the guard that holds the bound, and what happens when
that line is taken out.
";

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/hard_cases/README.md")
}

/// The page.
fn page(families: &[Family]) -> Result<String, String> {
    let measured = MEASURED.lock().unwrap_or_else(PoisonError::into_inner);
    let mut page = HEAD.to_owned();
    for family in families {
        let _ = write!(
            page,
            "\n## {}\n\n{}\n\n| case | what could go wrong | bound | measured | verdict |\n|---|---|---|---|---|\n",
            family.name.replace('_', " "),
            family.about
        );
        for case in family.cases {
            let found = measured
                .iter()
                .find(|(of, id, _)| (*of, *id) == (family.name, case.id));
            let (measured, verdict) = match found {
                Some((_, _, measured)) => (measured.as_str(), "holds"),
                None => ("", "**does not hold**"),
            };
            let _ = writeln!(
                page,
                "| {}: {} | {} | {} | {measured} | {verdict} |",
                case.id, case.name, case.hazard, case.bound
            );
        }
    }
    page += &crate::elsewhere::page()?;
    for number in 1..=43 {
        let id = format!("E{number}");
        let is_there = page
            .match_indices(&format!("| {id}"))
            .any(|(at, found)| !page[at + found.len()..].starts_with(|c: char| c.is_ascii_digit()));
        if !is_there {
            return Err(format!("{id} has no test, here or elsewhere"));
        }
    }
    Ok(page)
}

/// Compares the page with what is there, or writes it.
pub fn check(families: &[Family]) -> Result<(), String> {
    let page = page(families)?;
    if std::env::var_os("VRCS_BLESS").is_some() {
        return std::fs::write(path(), page).map_err(|error| error.to_string());
    }
    let known = std::fs::read_to_string(path()).unwrap_or_default();
    let differs = known
        .lines()
        .zip(page.lines())
        .find(|(known, new)| known != new);
    match (known == page, differs) {
        (true, _) => Ok(()),
        (false, Some((known, new))) => Err(format!(
            "tests/hard_cases/README.md is not current (VRCS_BLESS=1 writes it):\n  there: {known}\n  now:   {new}"
        )),
        (false, None) => {
            Err("tests/hard_cases/README.md is not current (VRCS_BLESS=1 writes it)".to_owned())
        }
    }
}
