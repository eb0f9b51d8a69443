//! `vrcs explain`: what is made of a shader and why; or what a code means. And `vrcs codes`.

use serde::Serialize;
use vrcs_passes::{
    Code, Color, Severity, examples,
    explain::{Explained, Verdict, explain},
    near,
    plan::regions::report::Group,
    told::{Told, ToldPlace},
};

use super::{
    Failure,
    inputs::{In, Inputs, Work},
    rewrite, talk,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  vrcs explain light.wgsl
  vrcs explain shaders --json
  vrcs explain VRCS013")]
pub(super) struct Arguments {
    #[command(flatten)]
    input: In,
    /// The entry point; without, every compute entry point.
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    how: rewrite::How,
}

#[derive(Debug, clap::Args)]
pub(super) struct Codes {
    /// Print them as JSON.
    #[arg(long)]
    json: bool,
}

/// A shader, explained.
#[derive(Debug, Serialize)]
struct Report {
    shader: String,
    entries: Vec<Explained>,
    /// What is wrong with it, if it is not valid.
    findings: Vec<Told>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(code) = code(&arguments.input)? {
        return print_code(code, arguments.json);
    }
    let options = arguments.how.options()?;
    let inputs = arguments.input.gather(arguments.input.has_folder(), None)?;
    let reports: Vec<Report> = inputs
        .works
        .iter()
        .map(|work| explain_work(&inputs, work, arguments, &options))
        .collect::<Result<_, _>>()?;
    if arguments.json {
        match serde_json::to_string_pretty(&reports) {
            Ok(json) => talk::data(&json)?,
            Err(error) => unreachable!("reports are plain data: {error}"),
        }
    } else {
        for report in &reports {
            print(report)?;
        }
    }
    let is_refused = |entry: &Explained| entry.verdict == Verdict::Refused;
    let any = reports
        .iter()
        .any(|report| !report.findings.is_empty() || report.entries.iter().any(is_refused));
    match any {
        true => Err(Failure::Refused(String::new())),
        false => Ok(()),
    }
}

/// The code that is asked about, if it is one.
fn code(input: &In) -> Result<Option<Code>, Failure> {
    let [only] = input.shaders.as_slice() else {
        return Ok(None);
    };
    let text = only.to_string_lossy();
    let is_code = text
        .get(..4)
        .is_some_and(|start| start.eq_ignore_ascii_case("vrcs"))
        && text[4..].chars().all(|c| c.is_ascii_digit())
        && !only.exists();
    if !is_code {
        return Ok(None);
    }
    text.parse().map(Some).map_err(|why: String| {
        let codes: Vec<String> = Code::ALL.iter().map(Code::to_string).collect();
        let asked = text.to_uppercase();
        let near = near::nearest(&asked, codes.iter().map(String::as_str))
            .map(|near| format!("; did you mean {near}?"))
            .unwrap_or_default();
        Failure::Misused(format!("{why}{near}"))
    })
}

fn explain_work(
    inputs: &Inputs,
    work: &Work,
    arguments: &Arguments,
    options: &vrcs_passes::Options,
) -> Result<Report, Failure> {
    let mut report = Report {
        shader: work.name.clone(),
        entries: Vec::new(),
        findings: Vec::new(),
    };
    let shader = match inputs.read(work)?.shader(work.language) {
        Ok(shader) => shader,
        Err(invalid) => {
            if !arguments.json {
                talk::say(invalid.render(talk::color()));
            }
            report.findings.push(Told::from(&invalid));
            return Ok(report);
        }
    };
    let entry = arguments.entry.as_deref();
    report.entries = explain(&shader.module, &shader.info, &shader.source, entry, options);
    if let (Some(name), true) = (entry, report.entries.is_empty()) {
        let names = shader.module.entry_points.iter().map(|e| e.name.as_str());
        let near = near::nearest(name, names)
            .map(|near| format!("; did you mean `{near}`?"))
            .unwrap_or_default();
        return Err(Failure::Refused(format!(
            "{}: no compute entry point is called `{name}`{near}",
            work.name
        )));
    }
    Ok(report)
}

fn print(report: &Report) -> Result<(), Failure> {
    if report.entries.is_empty() && report.findings.is_empty() {
        talk::data(&format!("{}: no compute entry point", report.shader))?;
    }
    for entry in &report.entries {
        print_entry(&report.shader, entry)?;
    }
    Ok(())
}

/// How work that invocations do together was taken apart.
fn print_group(group: &Group) -> Result<(), Failure> {
    talk::data(&format!(
        "  regions    {} between barriers: {} with work that only primaries do, {} masked",
        group.regions, group.per_pixel, group.masked
    ))?;
    if !group.exchanged.is_empty() {
        talk::data(&format!(
            "  exchanged  {}, through workgroup memory; what else lives from region to region is computed anew for the primary",
            group.exchanged.join(", ")
        ))?;
    }
    talk::data(&format!(
        "  memory     {} bytes of the workgroup's are the author's, {} are added",
        group.author_memory, group.added_memory
    ))
}

fn print_entry(shader: &str, entry: &Explained) -> Result<(), Failure> {
    let verdict = match entry.verdict {
        Verdict::Rewritten => "rewritten",
        Verdict::NothingPerPixel => "left as it is",
        Verdict::Refused => "REFUSED",
    };
    talk::data(&format!("{shader}: {}: {verdict}", entry.name))?;
    let size: Vec<String> = entry
        .workgroup_size
        .iter()
        .map(|side| side.map_or("override".to_owned(), |side| side.to_string()))
        .collect();
    talk::data(&format!("  workgroup  {}", size.join(" x ")))?;
    if !entry.remapped.is_empty() {
        talk::data(&format!("  remapped   {}", entry.remapped.join(", ")))?;
    }
    if let Some(group) = &entry.group {
        print_group(group)?;
    }
    for condition in &entry.domain {
        talk::data(&format!("  domain     {condition}"))?;
    }
    for store in &entry.stores {
        talk::data(&format!(
            "  store      `{}` at {}",
            store.target,
            place(store.place.as_ref())
        ))?;
        talk::data(&format!("             {}: {}", store.how, store.why))?;
        if !store.captures.is_empty() {
            talk::data(&format!(
                "             from the primary: {}",
                store.captures.join(", ")
            ))?;
        }
        for guard in &store.guards {
            talk::data(&format!("             asked of each duplicate: {guard}"))?;
        }
    }
    for finding in &entry.findings {
        talk::data(&format!(
            "  {} {} at {}: {}",
            finding.code,
            finding.severity,
            place(finding.places.first()),
            finding.message
        ))?;
        for other in &finding.places {
            talk::data(&format!(
                "             {}:{}: `{}`{}",
                other.file,
                other.line,
                other.snippet,
                match other.text.is_empty() {
                    true => String::new(),
                    false => format!(": {}", other.text),
                }
            ))?;
        }
        if let Some(help) = &finding.help {
            talk::data(&format!("             help: {help}"))?;
        }
    }
    Ok(())
}

fn place(place: Option<&ToldPlace>) -> String {
    place.map_or("an unknown place".to_owned(), |place| {
        format!("{}:{}:{}", place.file, place.line, place.column)
    })
}

/// A code, explained.
#[derive(Debug, Serialize)]
struct ExplainedCode {
    code: String,
    severity: &'static str,
    explanation: String,
    /// A shader that yields it.
    #[serde(skip_serializing_if = "Option::is_none")]
    example: Option<&'static str>,
    /// What its author is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    told: Option<String>,
}

impl ExplainedCode {
    fn new(code: Code) -> ExplainedCode {
        ExplainedCode {
            code: code.to_string(),
            severity: match code.severity() {
                Severity::Refusal => "refusal",
                Severity::Warning => "warning",
            },
            explanation: code
                .explanation()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
            example: None,
            told: None,
        }
    }

    fn with_example(code: Code) -> ExplainedCode {
        let mut explained = ExplainedCode::new(code);
        if let Some(example) = examples::of(code) {
            let source = example.source(code);
            let findings = example.findings(&source);
            let told = findings.iter().map(|f| f.render(&source, Color::Never));
            explained.example = Some(example.text);
            explained.told = Some(told.collect());
        }
        explained
    }
}

fn print_code(code: Code, is_json: bool) -> Result<(), Failure> {
    let explained = ExplainedCode::with_example(code);
    if is_json {
        return match serde_json::to_string_pretty(&explained) {
            Ok(json) => talk::data(&json),
            Err(error) => unreachable!("an explanation is plain data: {error}"),
        };
    }
    talk::data(&format!("{} ({})", explained.code, explained.severity))?;
    talk::data(&explained.explanation)?;
    if let (Some(example), Some(told)) = (explained.example, explained.told) {
        talk::data("\nFor example:\n")?;
        for line in example.lines() {
            talk::data(format!("    {line}").trim_end())?;
        }
        talk::data("\nIts author is told:\n")?;
        talk::data(told.trim_end())?;
    }
    Ok(())
}

/// Lists every code.
pub(super) fn codes(arguments: &Codes) -> Result<(), Failure> {
    let all: Vec<ExplainedCode> = Code::ALL.iter().map(|&c| ExplainedCode::new(c)).collect();
    if arguments.json {
        return match serde_json::to_string_pretty(&all) {
            Ok(json) => talk::data(&json),
            Err(error) => unreachable!("explanations are plain data: {error}"),
        };
    }
    for code in all {
        talk::data(&format!(
            "{} {:<8} {}",
            code.code, code.severity, code.explanation
        ))?;
    }
    Ok(())
}
