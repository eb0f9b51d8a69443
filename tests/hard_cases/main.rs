//! Hard cases stay numerically stable: one place where that is proved, for every stage.
//!
//! Each family is a module. The table in `README.md` is made from what is measured here.

#[path = "../common/mod.rs"]
mod common;

mod algebra;
mod case;
mod closed_loop;
mod compiled;
mod differences;
mod driver;
mod elsewhere;
mod groups;
mod pair;
mod property;
mod shaders;
mod sizes;
mod stage;
mod table;
mod time;
mod values;

use std::process::ExitCode;

use case::Family;
use libtest_mimic::{Arguments, Trial};

const FAMILIES: &[Family] = &[
    values::FAMILY,
    differences::FAMILY,
    closed_loop::FAMILY,
    time::FAMILY,
    algebra::FAMILY,
    groups::FAMILY,
    shaders::FAMILY,
    sizes::FAMILY,
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = FAMILIES.iter().flat_map(|family| {
        family.cases.iter().map(move |case| {
            let name = format!("{}::{}", family.name, case.id.to_lowercase());
            Trial::test(name, move || case::hold(family, case).map_err(Into::into))
        })
    });
    let is_whole = arguments.filter.is_none() && arguments.skip.is_empty() && !arguments.list;
    let conclusion = libtest_mimic::run(&arguments, trials.collect());
    if conclusion.has_failed() {
        return ExitCode::from(101);
    }
    if is_whole && let Err(why) = table::check(FAMILIES) {
        eprintln!("{why}");
        return ExitCode::from(101);
    }
    ExitCode::SUCCESS
}
