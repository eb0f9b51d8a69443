//! A hard case: what could go wrong, the bound that is kept, and what was measured.

use std::sync::{Mutex, PoisonError};

/// A hard case.
pub struct Case {
    /// Its number in the list of hazards (`E1` to `E43`), or a name of its own.
    pub id: &'static str,
    /// What is done.
    pub name: &'static str,
    /// What could go wrong.
    pub hazard: &'static str,
    /// What has to hold.
    pub bound: &'static str,
    /// How the test is shown to be able to fail: the guard that holds the bound, and what happens without it.
    pub guard: &'static str,
    /// Does it; what was measured, or what went wrong. What is measured must be the same on every run.
    pub run: fn() -> Result<String, String>,
}

/// Cases that belong together.
pub struct Family {
    /// Its name: the module's.
    pub name: &'static str,
    /// What it is about.
    pub about: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}

/// What was measured, by family and case.
pub static MEASURED: Mutex<Vec<(&'static str, &'static str, String)>> = Mutex::new(Vec::new());

/// Runs a case and notes what was measured.
pub fn hold(family: &Family, case: &Case) -> Result<(), String> {
    let start = std::time::Instant::now();
    let outcome = std::panic::catch_unwind(case.run).unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
        Err(text.unwrap_or_else(|| "it panicked".to_owned()))
    });
    // tests run side by side, so that this is no more than a hint which of them is slow
    let seconds = start.elapsed().as_secs_f64();
    println!("{}::{}: {seconds:.1} s", family.name, case.id);
    let measured = outcome.map_err(|why| {
        format!(
            "{}: {}\n  bound: {}\n  found: {why}\n  kept by: {}",
            case.id, case.name, case.bound, case.guard
        )
    })?;
    MEASURED
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push((family.name, case.id, measured));
    Ok(())
}
