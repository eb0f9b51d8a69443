//! Shaders that others wrote and published: each compute entry point of some thirty crates is rewritten, or refused with a reason
//! that somebody has read and found right.
//!
//! `TABLE.md` beside this file is what came of it; `VRCS_BLESS=1` writes it anew. `DRIVERS.md` tells what a long run on drivers said. The text of the shaders is fetched, and never part of
//! this repository; where it cannot be, the tests are passed over. `VRCS_CORPUS=100` checks so many rewritten entry points on the
//! driver, picked by the seed (all of them if there are no more); a few otherwise. `VRCS_CORPUS_ONLY=sky_view` picks from those whose
//! crate, file or entry point is named so.

mod axes;
mod child;
#[path = "../common/mod.rs"]
mod common;
mod crates;
mod prepare;
mod screen;
mod spirv;
mod table;
mod verdicts;
mod wesl;

use std::path::Path;

use crates::PACKAGES;
use table::{Became, Row};
use vrcs_passes::input::Shader;

/// Everything that becomes of the corpus without a driver; `None` offline.
fn rows() -> Option<Vec<(Row, Option<Shader>)>> {
    let mut rows = Vec::new();
    // a child has one entry point to check, and needs its crate alone
    let child = std::env::var(child::NAME).ok();
    let is_wanted = |name: &str| child.as_ref().is_none_or(|child| child.starts_with(name));
    for package in PACKAGES.iter().filter(|package| is_wanted(package.name)) {
        for file in package.files()? {
            let shader = match &file.shader {
                Ok(shader) => shader.clone(),
                Err(invalid) => {
                    let became = Became::NotRead(table::first_line(&invalid.rendered));
                    let mut row = Row::new(package, &file.path, "", (became.clone(), became, None));
                    row.counts = false;
                    rows.push((row, None));
                    continue;
                }
            };
            let compute = shader.module.entry_points.iter().enumerate();
            let compute = compute.filter(|(_, entry)| {
                entry.stage == naga::ShaderStage::Compute && file.has(&entry.name)
            });
            for (index, entry) in compute {
                let became = table::rewritten(&shader, &entry.name);
                let mut row = Row::new(package, &file.path, &entry.name, became);
                row.counts = screen::counts(&shader.module, &shader.info, index);
                row.lacking = screen::lacking(&shader.module, &shader.info, index);
                rows.push((row, Some(shader.clone())));
            }
        }
    }
    Some(rows)
}

#[test]
fn the_table_is_current_and_every_refusal_has_been_read() {
    let Some(rows) = rows() else {
        println!("skipped: the corpus, for want of the crates");
        return;
    };
    let rows: Vec<Row> = rows.into_iter().map(|(row, _)| row).collect();
    let unread: Vec<String> = rows
        .iter()
        .filter(|row| row.is_refused())
        .filter(|row| verdicts::of(&row.package, &row.file, &row.entry).is_none())
        .map(|row| {
            format!(
                "{} {} {}: {:?}",
                row.package, row.file, row.entry, row.became
            )
        })
        .collect();
    assert!(unread.is_empty(), "read these: {unread:#?}");
    let defects: Vec<&Row> = rows
        .iter()
        .filter(|row| matches!(row.chosen, Became::Defect(_)))
        .collect();
    assert!(defects.is_empty(), "{defects:#?}");
    let count = |became: &Became| rows.iter().filter(|row| row.chosen == *became).count();
    assert!(rows.len() >= 60 && count(&Became::Rewritten) >= 30);

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/TABLE.md");
    let now = table::print(&rows);
    if std::env::var_os("VRCS_BLESS").is_some() {
        std::fs::write(&path, &now).expect("the table is writable");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let changed: Vec<&str> = now
        .lines()
        .filter(|line| !known.lines().any(|other| other == *line))
        .collect();
    assert!(
        known == now,
        "the table is not current (VRCS_BLESS=1 writes it anew): {changed:#?}"
    );
}

/// Everything that is rewritten is SPIR-V that the validator takes, but for what naga writes wrongly of the original, too.
#[test]
fn what_is_rewritten_is_valid_spirv() {
    if !spirv::is_there() {
        println!("skipped: spirv-val is not installed (package spirv-tools)");
        return;
    }
    let Some(rows) = rows() else {
        println!("skipped: the corpus, for want of the crates");
        return;
    };
    let mut ours = Vec::new();
    let mut tried = 0;
    for (row, shader) in rows {
        let (Became::Rewritten, Some(shader)) = (&row.chosen, shader) else {
            continue;
        };
        tried += 1;
        match spirv::refused(&row, &shader) {
            None => {}
            Some([Some(before), Some(after)]) => {
                println!("{}: as it is: {before}; rewritten: {after}", row.name());
            }
            Some([_, after]) => ours.push((row.name(), after)),
        }
    }
    assert!(tried >= 60, "only {tried} were tried");
    assert!(ours.is_empty(), "{ours:#?}");
}

#[test]
fn what_is_rewritten_keeps_the_laws() {
    let Some(rows) = rows() else {
        println!("skipped: the corpus, for want of the crates");
        return;
    };
    let count = match std::env::var("VRCS_CORPUS") {
        Ok(count) => count.parse().expect("VRCS_CORPUS is a number"),
        Err(_) => 4,
    };
    let seed = common::seed();
    let mut rewritten: Vec<(Row, Shader)> = rows
        .into_iter()
        .filter(|(row, _)| row.chosen == Became::Rewritten)
        .filter_map(|(row, shader)| Some((row, shader?)))
        .collect();
    if let Ok(child) = std::env::var(child::NAME) {
        for (row, shader) in rewritten.iter().filter(|(row, _)| row.name() == child) {
            child::check(row, shader, seed);
        }
        return;
    }
    if let Ok(only) = std::env::var("VRCS_CORPUS_ONLY") {
        rewritten.retain(|(row, _)| row.name().contains(&only));
    }
    fastrand::Rng::with_seed(seed).shuffle(&mut rewritten);
    let mut failed = Vec::new();
    for (row, _) in rewritten.iter().take(count) {
        let outcome = child::outcome(&row.name(), seed);
        println!("{}: {outcome}", row.name());
        if outcome.starts_with("FAILED") {
            failed.push(row.name());
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
