//! The goals of speed, each with the floor that it is held against, in one run.
//!
//! *Does*: times the rewriter's output against the author's shader, and each stage of the runtime against a kernel that only moves
//! the same bytes. *Guarantees*: ratios are of one run, medians after a warm-up, inputs of more than 200 MB rotated in every row so that no
//! cache flatters, rounds in which the clock was down not counted ([`Drift`]). *Refuses*: to call what a software driver shows a goal
//! met, and to judge what hangs on a fit that failed. Outcomes on a real GPU: `shaders/bench/H100.md`.

mod barriers;
mod encodings;
mod floors;
mod heavy;
mod machinery;
mod rewriting;
mod stage;
mod timer;

use serde::Serialize;

use crate::check::gpu::{Gpu, GpuError};
use timer::{Contender, Measured, Timer};
pub use timer::{Drift, Times};

/// What to measure.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The picture's size.
    pub size: [u32; 2],
    /// Counted rounds.
    pub rounds: usize,
    /// Only rows whose name contains this.
    pub filter: Option<String>,
    /// Lights of the heavy pass.
    pub lights: u32,
    /// The bytes that inputs take at least, before they repeat.
    pub rotated: u64,
}

impl Default for Bench {
    fn default() -> Bench {
        Bench {
            size: [3840, 2160],
            rounds: 30,
            filter: None,
            lights: 256,
            rotated: 200 << 20,
        }
    }
}

/// A number that was measured beside others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// What it is.
    pub name: String,
    /// Milliseconds, the median.
    pub milliseconds: f64,
    /// Milliseconds, the 95th percentile.
    pub p95: f64,
}

/// A row of the table: one goal, and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What was measured.
    pub name: String,
    /// What was found: a ratio, or microseconds where `unit` says so.
    pub value: f64,
    /// `x` or `µs`.
    pub unit: &'static str,
    /// The most that it may be.
    pub goal: f64,
    /// Whether the goal is met; not said of a software driver, nor of a row that only informs.
    pub met: Option<bool>,
    /// What went into it.
    pub parts: Vec<Part>,
    /// How steady the clock was; none of what ran on the CPU.
    pub drift: Option<Drift>,
}

/// What was found on a device.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// The device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Whether it is a software driver, whose times say nothing of goals.
    pub is_software: bool,
    /// Whether wgpu validates the arguments of indirect dispatches in these rows, as it does by default. The program turns it off
    /// (`WGPU_VALIDATION_INDIRECT_CALL=1` turns it on), and has a row of what it costs.
    pub validates_indirect: bool,
    /// The picture's size.
    pub size: [u32; 2],
    /// The rows.
    pub rows: Vec<Row>,
}

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// There is no device, or it refused something.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The device has no clock that can be read.
    #[error("{0} has no timestamp queries: nothing can be timed on it")]
    NoClock(String),
    /// No row has such a name.
    #[error("no row contains `{0}`: leave out --filter to see them all")]
    NoRow(String),
    /// Something of this crate's own went wrong.
    #[error("{0}")]
    Own(String),
}

/// Passes what went wrong inside on.
fn own(error: impl std::fmt::Display) -> BenchError {
    BenchError::Own(error.to_string())
}

/// What is measured, on what, by which clock.
struct Lab<'l> {
    bench: &'l Bench,
    gpu: &'l Gpu,
    timer: Timer,
}

impl<'l> Lab<'l> {
    fn new(bench: &'l Bench, gpu: &'l Gpu) -> Result<Lab<'l>, BenchError> {
        let timer = Timer::new(gpu)?;
        Ok(Lab { bench, gpu, timer })
    }

    fn measure(&self, contenders: &[Contender]) -> Result<Measured, BenchError> {
        self.timer.measure(self.gpu, self.bench.rounds, contenders)
    }
}

/// A group of rows.
type Rows = fn(&Lab) -> Result<Vec<Row>, BenchError>;

/// All groups of rows and what their rows' names start with.
const GROUPS: [(&str, Rows); 12] = [
    ("identity", heavy::identity),
    ("heavy", heavy::shares),
    ("light", heavy::light_shares),
    ("classified", heavy::classified),
    ("indirect", heavy::validation),
    ("barriers", barriers::rows),
    ("build", encodings::builds),
    ("encodings", encodings::rows),
    ("stage", machinery::stages),
    ("all machinery", machinery::together),
    ("resolution", machinery::resolutions),
    ("rewrite", rewriting::rows),
];

impl Bench {
    /// Measures. `progress` is told what comes next.
    ///
    /// # Errors
    /// If there is no clock, a filter that fits no row, or a device that refuses something.
    pub fn run(&self, gpu: &Gpu, progress: &mut dyn FnMut(&str)) -> Result<Found, BenchError> {
        let has_clock = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        if !has_clock {
            return Err(BenchError::NoClock(gpu.info.name.clone()));
        }
        let wanted = |name: &str| match &self.filter {
            Some(filter) => name.contains(filter.as_str()) || filter.starts_with(name),
            None => true,
        };
        progress("the clock");
        let lab = Lab::new(self, gpu)?;
        let mut rows = Vec::new();
        for (name, measure) in GROUPS.into_iter().filter(|(name, _)| wanted(name)) {
            progress(name);
            rows.extend(measure(&lab)?);
        }
        if let Some(filter) = &self.filter {
            rows.retain(|row| row.name.contains(filter.as_str()));
            if rows.is_empty() {
                return Err(BenchError::NoRow(filter.clone()));
            }
        }
        if gpu.is_software() {
            for row in rows
                .iter_mut()
                .filter(|row| !row.name.starts_with("rewrite"))
            {
                row.met = None;
            }
        }
        Ok(Found {
            device: gpu.info.name.clone(),
            driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info),
            is_software: gpu.is_software(),
            validates_indirect: gpu.validates_indirect(),
            size: self.size,
            rows,
        })
    }
}

impl Row {
    /// A row of a ratio of times.
    fn ratio(name: impl Into<String>, value: f64, goal: f64, measured: Measured) -> Row {
        Row::new(name, value, "x", goal, measured)
    }

    /// A row of microseconds.
    fn microseconds(name: impl Into<String>, value: f64, goal: f64, measured: Measured) -> Row {
        Row::new(name, value, "µs", goal, measured)
    }

    fn new(
        name: impl Into<String>,
        value: f64,
        unit: &'static str,
        goal: f64,
        measured: Measured,
    ) -> Row {
        Row {
            name: name.into(),
            value,
            unit,
            goal,
            met: Some(value <= goal),
            parts: measured.parts,
            drift: measured.drift,
        }
    }

    /// The same row, not judged.
    fn unjudged(self) -> Row {
        Row { met: None, ..self }
    }
}

impl Part {
    fn new(name: &str, times: Times) -> Part {
        Part {
            name: name.to_owned(),
            milliseconds: times.median,
            p95: times.p95,
        }
    }
}
