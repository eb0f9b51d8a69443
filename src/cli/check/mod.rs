//! `vrcs check`: each entry point in a process of its own, so that a shader that hangs or kills the driver ends only that.

pub(super) mod child;
mod parent;
mod sidecar;

use std::{path::PathBuf, time::Duration};

use serde::{Deserialize, Serialize};
use vrcs_passes::{
    Options, Source, emit,
    input::{self, Language},
};

use super::{
    Failure,
    inputs::{In, Work},
    parse_size, rewrite, talk,
};
use sidecar::Sidecar;

use crate::check::{
    Failure as Difference, Report, Route, Verdict,
    gpu::{Gpu, GpuError},
    inputs::Settings,
};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Values and files can also stand in `SHADER.toml` beside SHADER.wgsl.

Examples:
  vrcs check light.wgsl
  vrcs check light.wgsl --size 320x200 --cases 200 --mode list
  vrcs check blur.wgsl --set radius=4 --input source=photo.png --seed 7
  vrcs check shaders --json > reports.json"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    shader: In,
    /// The entry point; without, every one that stores per pixel.
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// The size of the picture. [default: 61x47]
    ///
    /// Odd by default, so that partial tiles and quads occur.
    #[arg(long, value_parser = parse_size, value_name = "WxH")]
    size: Option<[u32; 2]>,
    /// How many shading-rate images to try. [default: 64]
    #[arg(long, value_name = "N")]
    cases: Option<u32>,
    /// Where all chance comes from. [default: from the clock, and printed]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// A value for a variable, a member or an override.
    ///
    /// For example `width=64` or `frame.size=64,48`.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// A picture or a file of bytes for a texture or buffer.
    #[arg(long, value_name = "NAME=FILE")]
    input: Vec<String>,
    /// How the rewritten shader is handed to the driver.
    #[arg(long, value_enum, default_value_t = RouteName::Text, hide_short_help = true)]
    route: RouteName,
    /// Seconds that a case may take.
    #[arg(long, default_value_t = 60, value_name = "SECONDS")]
    time_limit: u64,
    /// Where the picture of a failure goes.
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
    /// Print the reports as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    how: rewrite::How,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum RouteName {
    /// As the WGSL that `rewrite` writes.
    Text,
    /// As naga's module, as the runtime does.
    Module,
}

/// A check, as it is handed to the process that makes it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Order {
    name: String,
    text: String,
    entry: String,
    size: [u32; 2],
    cases: u32,
    seed: u64,
    adapter: Option<String>,
    options: Options,
    settings: Settings,
    route: Route,
    /// Where the picture of a failure goes.
    picture: PathBuf,
}

/// What the process that makes a check says, a line each.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Word {
    /// A case is done.
    Case(u32),
    /// The check is done.
    Report(Box<Report>),
    /// The check could not start: exit status and message.
    Failed(u8, String),
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut order = order(arguments)?;
    let source = Source::new(order.name.clone(), order.text.clone());
    let entries = entries(arguments, &source, &order.options)?;
    // without a driver there is nothing to start
    drop(Gpu::open(order.adapter.as_deref())?);
    let limit = Duration::from_secs(arguments.time_limit);
    let mut reports = Vec::new();
    for entry in entries {
        order.entry.clone_from(&entry);
        order.picture = arguments.out.join(format!("{entry}.failure.png"));
        let report = parent::check(&order, limit)?;
        if !arguments.json {
            print(&report, &order)?;
        }
        reports.push(report);
    }
    if arguments.json {
        match serde_json::to_string_pretty(&reports) {
            Ok(json) => talk::data(&json)?,
            Err(error) => unreachable!("reports are plain data: {error}"),
        }
    }
    let passed = |report: &Report| matches!(report.verdict, Verdict::Passed | Verdict::NotRunnable);
    match reports.iter().all(passed) && reports.iter().any(|r| r.verdict == Verdict::Passed) {
        true => Ok(()),
        false => Err(Failure::Refused(String::new())),
    }
}

fn order(arguments: &Arguments) -> Result<Order, Failure> {
    let (work, text) = read(&arguments.shader)?;
    let sidecar = match work.paths.last() {
        Some(path) => sidecar::read(path)?,
        None => Sidecar::default(),
    };
    let mut settings = sidecar.settings;
    for set in &arguments.set {
        let (name, values) = sidecar::parse_set(set).map_err(Failure::Misused)?;
        settings.set.insert(name, values);
    }
    for input in &arguments.input {
        let Some((name, file)) = input.split_once('=') else {
            return Err(Failure::Misused(format!("`{input}` is not NAME=FILE")));
        };
        settings.files.insert(name.to_owned(), PathBuf::from(file));
    }
    Ok(Order {
        name: work.name,
        text,
        entry: String::new(),
        size: arguments.size.or(sidecar.size).unwrap_or([61, 47]),
        cases: arguments.cases.or(sidecar.cases).unwrap_or(64),
        seed: arguments.seed.unwrap_or_else(seed_from_clock),
        adapter: arguments.adapter.clone(),
        options: arguments.how.options()?,
        settings,
        route: match arguments.route {
            RouteName::Text => Route::Text,
            RouteName::Module => Route::Module,
        },
        picture: PathBuf::new(),
    })
}

/// The shader, and its text with all that it is made of. Other languages become WGSL.
fn read(input: &In) -> Result<(Work, String), Failure> {
    if input.has_folder() {
        return Err(Failure::Misused(
            "one shader is checked at a time: name its files".to_owned(),
        ));
    }
    let inputs = input.gather(false, None)?;
    let Some(work) = inputs.works.first().cloned() else {
        return Err(Failure::Misused("no shader is named".to_owned()));
    };
    let shader = inputs
        .read(&work)?
        .shader(work.language)
        .map_err(|invalid| {
            talk::say(invalid.render(talk::color()));
            Failure::Refused(String::new())
        })?;
    // where modules are imported, what nobody uses is left out of the module, not of the text
    let is_plain = shader.source.files().count() == work.paths.len();
    let text = match shader.source.text() {
        text if work.language == Language::Wgsl && is_plain => text.to_owned(),
        _ => emit::wgsl_with(&shader.module, &shader.info, &shader.directives)
            .map_err(|error| Failure::Refused(format!("{}: {error}", work.name)))?,
    };
    Ok((work, text))
}

fn seed_from_clock() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    now.map_or(1, |now| now.as_nanos() as u64 % 1_000_000)
}

/// The entry points to check. Refusals are told here, once, before any process is started.
fn entries(
    arguments: &Arguments,
    source: &Source,
    options: &Options,
) -> Result<Vec<String>, Failure> {
    let rewritten = rewrite::rewrite(source, arguments.entry.as_deref(), options)?;
    for (entry, finding) in &rewritten.left_alone {
        talk::say(&format!(
            "note: `{entry}` is left as it is: {}",
            finding.message
        ));
    }
    Ok(rewritten
        .manifest
        .entries
        .into_iter()
        .map(|entry| entry.name)
        .collect())
}

fn print(report: &Report, order: &Order) -> Result<(), Failure> {
    let verdict = match report.verdict {
        Verdict::Passed => "passed",
        Verdict::Failed => "FAILED",
        Verdict::Inconclusive => "inconclusive",
        Verdict::NotRunnable => "not runnable",
    };
    talk::data(&format!(
        "{}: {verdict}{}",
        report.entry,
        report
            .why
            .as_ref()
            .map_or(String::new(), |why| format!(": {why}"))
    ))?;
    let held: Vec<String> = report
        .held
        .iter()
        .map(|(law, times)| format!("{law} {times}"))
        .collect();
    if !held.is_empty() {
        talk::data(&format!("  held: {}", held.join(", ")))?;
    }
    talk::data(&format!(
        "  on {}, {}x{}, {} cases, seed {}",
        report.adapter, order.size[0], order.size[1], order.cases, order.seed
    ))?;
    for note in &report.notes {
        talk::data(&format!("  note: {note}"))?;
    }
    match &report.failure {
        Some(failure) => print_failure(failure, order),
        None => Ok(()),
    }
}

fn print_failure(failure: &Difference, order: &Order) -> Result<(), Failure> {
    let pixel = |p: [u32; 3]| match p[2] {
        0 => format!("({}, {})", p[0], p[1]),
        z => format!("({}, {}, {z})", p[0], p[1]),
    };
    talk::data(&format!(
        "  {} does not hold in case {}: {}, extent {}x{}",
        failure.law, failure.case, failure.pattern, failure.extent[0], failure.extent[1]
    ))?;
    let whose = match (failure.pixel, failure.tile, failure.primary) {
        (Some(p), Some(tile), Some(primary)) => format!(
            "pixel {} of tile ({}, {}), shaded by {}",
            pixel(p),
            tile[0],
            tile[1],
            pixel(primary)
        ),
        _ => "nothing was to be written there".to_owned(),
    };
    talk::data(&format!(
        "  first difference: `{}`, {}: {whose}",
        failure.target, failure.place
    ))?;
    talk::data(&format!("    expected {}", failure.expected))?;
    talk::data(&format!("    got      {}", failure.got))?;
    if order.picture.exists() {
        talk::data(&format!("  picture: {}", order.picture.display()))?;
    }
    Ok(())
}

fn status_of(error: &GpuError) -> u8 {
    match error {
        GpuError::NoSuchAdapter { .. } => 2,
        _ => 3,
    }
}

/// Parses the order's shader.
fn parse(source: &Source) -> Result<(naga::Module, naga::valid::ModuleInfo), (u8, String)> {
    input::wgsl(source).map_err(|invalid| (1, invalid.rendered))
}
