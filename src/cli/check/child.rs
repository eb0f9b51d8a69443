//! The process that makes one check: reads an order from standard input, says a line of JSON for each case.

use std::io::{Read, Write};

use super::{Failure, Order, Source, Word, parse, status_of};
use crate::check::{CheckError, Job, Report, check, gpu::Gpu};

/// What the program calls itself by.
pub(crate) const NAME: &str = "__check";

/// Makes a check.
pub(crate) fn run() -> Result<(), Failure> {
    let mut text = String::new();
    let order: Order = std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| error.to_string())
        .and_then(|_| serde_json::from_str(&text).map_err(|error| error.to_string()))
        .map_err(|error| Failure::Misused(format!("no order on standard input: {error}")))?;
    match obey(&order) {
        Ok(report) => {
            if let Some(failure) = &report.failure
                && !failure.picture.is_empty()
            {
                write_picture(&order, &failure.picture);
            }
            say(&Word::Report(Box::new(report)));
        }
        Err((status, message)) => say(&Word::Failed(status, message)),
    }
    Ok(())
}

fn obey(order: &Order) -> Result<Report, (u8, String)> {
    let source = Source::new(order.name.clone(), order.text.clone());
    let (module, info) = parse(&source)?;
    let gpu = Gpu::open(order.adapter.as_deref())
        .map_err(|error| (status_of(&error), error.to_string()))?;
    let job = Job {
        entry: order.entry.clone(),
        size: order.size,
        cases: order.cases,
        seed: order.seed,
        options: order.options.clone(),
        settings: order.settings.clone(),
        route: order.route,
    };
    check(&gpu, &source, &module, &info, &job, &mut |case| {
        say(&Word::Case(case));
    })
    .map_err(|error| match error {
        CheckError::Refused(refusal) => (1, refusal.to_string()),
        CheckError::Input(error) => (2, error.to_string()),
        error => (2, error.to_string()),
    })
}

fn say(word: &Word) {
    if let Ok(line) = serde_json::to_string(word) {
        let mut stdout = std::io::stdout().lock();
        // a parent that has gone away has no use for this process
        if writeln!(stdout, "{line}")
            .and_then(|()| stdout.flush())
            .is_err()
        {
            std::process::exit(3);
        }
    }
}

fn write_picture(order: &Order, bytes: &[u8]) {
    let written = order
        .picture
        .parent()
        .map_or(Ok(()), std::fs::create_dir_all)
        .and_then(|()| std::fs::write(&order.picture, bytes));
    if let Err(error) = written {
        super::talk::error(&format!("{}: {error}", order.picture.display()));
    }
}
