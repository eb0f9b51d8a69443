//! `vrcs rewrite`

use std::path::{Path, PathBuf};

use serde::Serialize;
use vrcs_passes::{
    Entries, Options, Rewritten, Source,
    emit::{Form, Language, Target},
    input,
    manifest::Manifest,
    near,
    options::{Atomics, FullTiles, Linear, MaxRate, Mode, Place, Policy, Sky},
    told::Told,
};

use super::{
    Failure, batch, files,
    inputs::{In, Inputs},
    make::{Made, Status, Wish, make},
    talk, watch,
};

#[derive(Debug, clap::Args)]
#[command(
    after_help = "Files alone are one shader, joined in order. A folder is a batch, each file a shader of its own, and so are
files where the output is a folder.

Examples:
  vrcs rewrite light.wgsl -o light.vrcs.wgsl --manifest light.json
  vrcs rewrite common.wgsl light.wgsl -D SAMPLES=4 -o light.spv
  vrcs rewrite shaders -o out/ --to hlsl"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: In,
    /// Where the rewritten shader goes.
    ///
    /// A file; a folder, for a batch (`out/`); `-` is standard output.
    #[arg(short, long, value_name = "PATH", default_value = "-")]
    output: PathBuf,
    /// The language that is written: wgsl, spirv, hlsl, msl or glsl. [default: wgsl]
    ///
    /// With a version if need be (spirv-1.3, hlsl-6.2, glsl-310es). The output's extension tells it, too.
    #[arg(long, value_name = "LANGUAGE")]
    to: Option<Target>,
    /// The entry point; without, every one that stores per pixel.
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// Where the manifest goes: what a program dispatches by, as JSON.
    ///
    /// A batch writes each beside its shader.
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// A value of an `override` constant, by name or number, for languages that have none.
    #[arg(long = "override", value_name = "NAME=VALUE", hide_short_help = true)]
    overrides: Vec<String>,
    /// Leave out the bounds checks that WGSL promises, in other languages.
    #[arg(long, hide_short_help = true)]
    no_bounds_checks: bool,
    /// Rewrite what has not changed, too.
    #[arg(long)]
    force: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
    /// Go on, and rewrite again whenever a file changes.
    #[arg(long)]
    watch: bool,
    #[command(flatten)]
    how: How,
}

/// The options of a rewrite, shared with `check`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct How {
    /// tiled, list, classified, graded or auto: how primaries find their pixels.
    #[arg(long, value_enum, default_value_t = ModeName::Tiled, hide_possible_values = true)]
    mode: ModeName,
    /// The largest shading rate that is copied: 2x2, 2x4, 4x2 or 4x4.
    #[arg(long, value_enum, default_value_t = MaxRateName::R2x2, value_name = "RATE", hide_possible_values = true)]
    max_rate: MaxRateName,
    /// What becomes of tiles that are nearly full.
    #[arg(long, value_enum, default_value_t = FullTilesName::Promote, value_name = "RULE", hide_short_help = true)]
    full_tiles: FullTilesName,
    /// What becomes of what the scene calls sky.
    #[arg(long, value_enum, default_value_t = SkyName::Skip, value_name = "RULE", hide_short_help = true)]
    sky: SkyName,
    /// Invocations that retire together.
    #[arg(long, default_value_t = 32, value_name = "N", hide_short_help = true)]
    wave: u32,
    /// Bind groups of the device.
    #[arg(long, default_value_t = 4, value_name = "N", hide_short_help = true)]
    max_bind_groups: u32,
    /// Uniform buffers that the device has for a shader.
    #[arg(long, default_value_t = 12, value_name = "N", hide_short_help = true)]
    max_uniform_buffers: u32,
    /// Storage buffers that the device has for a shader.
    #[arg(long, default_value_t = 8, value_name = "N", hide_short_help = true)]
    max_storage_buffers: u32,
    /// Where the two added bindings go: this number and the next.
    ///
    /// If not given: into the first free group, else into free numbers of the group that is used least.
    #[arg(long, value_name = "GROUP:BINDING")]
    place: Option<Place>,
    /// What becomes of a target's stores: copy, leader, full or refuse.
    ///
    /// `copy` for the duplicates, `leader` for the primary alone, `full` for every pixel what the original stores, `refuse`. Targets
    /// that are not named are copied, or `full` where copies cannot serve them (VRCS107).
    #[arg(long = "target", value_name = "NAME=POLICY", value_parser = parse_target)]
    targets: Vec<(String, Policy)>,
    /// What becomes of unread atomics: refuse or weight.
    ///
    /// Those whose result nobody uses.
    #[arg(long, value_enum, default_value_t = AtomicsName::Refuse, value_name = "RULE", hide_possible_values = true)]
    atomics: AtomicsName,
    /// The dispatch has one dimension, over a picture of this width.
    ///
    /// Pixels row by row; the width is a number, a uniform's member such as `params.width`, or an `override`.
    #[arg(long, value_name = "WIDTH")]
    linear: Option<Linear>,
    /// Scale the gradients of textureSampleGrad by the block that a primary stands for, as hardware VRS does on its own.
    #[arg(long, hide_short_help = true)]
    scale_gradients: bool,
    /// Bias the level of textureSampleLevel by log2 of the rate, for the texture of this name. Can be given again.
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    bias_level: Vec<String>,
    /// The view's entries carry the linear depth of their primaries: for a shader that shares a view with one that asks `vrcs_depth()`, which
    /// turns it on by itself.
    #[arg(long)]
    linear_depth: bool,
    /// Two writable bindings that are never the same memory, by your word. Can be given again.
    #[arg(long, value_name = "A,B", value_parser = parse_distinct, hide_short_help = true)]
    distinct: Vec<[String; 2]>,
    /// A target that is never read where another pixel stores, whatever its data, by your word. Can be given again.
    ///
    /// For several pictures in one buffer, of which one is read and another is written, where the addresses do not show it.
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    apart: Vec<String>,
}

fn parse_distinct(text: &str) -> Result<[String; 2], String> {
    match text.split_once(',') {
        Some((a, b)) if !a.is_empty() && !b.is_empty() && a != b && !b.contains(',') => {
            Ok([a.to_owned(), b.to_owned()])
        }
        _ => Err(format!("`{text}` is not A,B, the names of two bindings")),
    }
}

fn parse_target(text: &str) -> Result<(String, Policy), String> {
    let Some((name, policy)) = text.split_once('=') else {
        return Err(format!("`{text}` is not NAME=POLICY"));
    };
    let policy = match policy {
        "copy" => Policy::Copy,
        "leader" => Policy::Leader,
        "full" => Policy::Full,
        "refuse" => Policy::Refuse,
        _ => {
            return Err(format!(
                "there is no policy `{policy}`: there are copy, leader, full and refuse"
            ));
        }
    };
    Ok((name.to_owned(), policy))
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum AtomicsName {
    /// A shader that has any is refused.
    Refuse,
    /// A primary's count for all its pixels.
    Weight,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum ModeName {
    /// One workgroup for each tile of the picture.
    Tiled,
    /// One list of the picture's primaries, dispatched indirectly.
    List,
    /// A list for each class of tiles, in one indirect dispatch.
    Classified,
    /// Every pixel is shaded; the shader asks `vrcs_copies()` how many share the work.
    Graded,
    /// Tiled or list, as suits the shader; the manifest tells why.
    Auto,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum SkyName {
    /// It is not shaded.
    Skip,
    /// It is shaded.
    Shade,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum MaxRateName {
    /// Up to 2×2: copies are three conditional stores.
    #[value(name = "2x2")]
    R2x2,
    /// Up to 2 across, 4 down: copies are a loop, as with every larger rate.
    #[value(name = "2x4")]
    R2x4,
    /// Up to 4 across, 2 down.
    #[value(name = "4x2")]
    R4x2,
    /// Up to 4×4.
    #[value(name = "4x4")]
    R4x4,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum FullTilesName {
    /// All their pixels become primaries.
    Promote,
    /// Their primaries stay as they are.
    Keep,
}

impl How {
    pub(super) fn options(&self) -> Result<Options, Failure> {
        if !self.wave.is_power_of_two() || self.wave > 128 {
            return Err(Failure::Misused(format!(
                "a wave has 1, 2, 4 … 128 invocations, not {}",
                self.wave
            )));
        }
        Ok(Options {
            mode: match self.mode {
                ModeName::Tiled => Mode::Tiled,
                ModeName::List => Mode::List,
                ModeName::Classified => Mode::Classified,
                ModeName::Graded => Mode::Graded,
                ModeName::Auto => Mode::Auto,
            },
            sky: match self.sky {
                SkyName::Skip => Sky::Skip,
                SkyName::Shade => Sky::Shade,
            },
            full_tiles: match self.full_tiles {
                FullTilesName::Promote => FullTiles::Promote,
                FullTilesName::Keep => FullTiles::Keep,
            },
            max_rate: match self.max_rate {
                MaxRateName::R2x2 => MaxRate::R2x2,
                MaxRateName::R2x4 => MaxRate::R2x4,
                MaxRateName::R4x2 => MaxRate::R4x2,
                MaxRateName::R4x4 => MaxRate::R4x4,
            },
            wave: self.wave,
            max_bind_groups: self.max_bind_groups,
            max_uniform_buffers: self.max_uniform_buffers,
            max_storage_buffers: self.max_storage_buffers,
            place: self.place,
            targets: self.targets.iter().cloned().collect(),
            atomics: match self.atomics {
                AtomicsName::Refuse => Atomics::Refuse,
                AtomicsName::Weight => Atomics::Weight,
            },
            linear: self.linear.clone(),
            scale_gradients: self.scale_gradients,
            bias_level: self.bias_level.iter().cloned().collect(),
            linear_depth: self.linear_depth,
            distinct: self.distinct.clone(),
            apart: self.apart.iter().cloned().collect(),
            ..Options::default()
        })
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let job = Job::new(arguments)?;
    if !arguments.watch {
        return job.run().map(|_| ());
    }
    if arguments
        .input
        .shaders
        .iter()
        .any(|path| files::is_stream(path))
    {
        return Err(Failure::Misused(
            "standard input cannot be watched".to_owned(),
        ));
    }
    watch::run(&arguments.input, || job.run())
}

/// What is to be done, once or again and again.
struct Job<'a> {
    arguments: &'a Arguments,
    options: Options,
    target: Target,
    form: Form,
    is_batch: bool,
}

impl<'a> Job<'a> {
    fn new(arguments: &'a Arguments) -> Result<Job<'a>, Failure> {
        let output = &arguments.output;
        let is_folder = output.is_dir() || ends_with_separator(output);
        let is_batch = is_folder || arguments.input.has_folder();
        if is_batch && !is_folder {
            return Err(Failure::Misused(
                "several shaders are written into a folder: `-o DIR/`".to_owned(),
            ));
        }
        if is_batch && arguments.manifest.is_some() {
            return Err(Failure::Misused(
                "a batch writes each manifest beside its shader; leave --manifest out".to_owned(),
            ));
        }
        if arguments.json && !is_batch && files::is_stream(output) {
            return Err(Failure::Misused(
                "the report and the shader cannot both go to standard output: name a file with -o"
                    .to_owned(),
            ));
        }
        if !is_batch {
            check_paths(arguments)?;
        }
        let job = Job {
            options: arguments.how.options()?,
            target: target(arguments, is_batch)?,
            form: form(arguments)?,
            is_batch,
            arguments,
        };
        if job.target.language() == Language::Wgsl && !arguments.overrides.is_empty() {
            return Err(Failure::Misused(
                "WGSL keeps its overrides: --override is for other languages".to_owned(),
            ));
        }
        Ok(job)
    }

    /// Does it once, and tells which files it is about.
    fn run(&self) -> Result<Vec<PathBuf>, Failure> {
        let folder = self.is_batch.then_some(self.arguments.output.as_path());
        let inputs = self.arguments.input.gather(self.is_batch, folder)?;
        let wish = Wish {
            entry: self.arguments.entry.as_deref(),
            options: &self.options,
            target: self.target,
            form: &self.form,
        };
        let outcome = match folder {
            Some(folder) => self.batch(&inputs, folder, &wish),
            None => self.one(&inputs, &wish),
        };
        outcome.map(|()| inputs.files.into_iter().collect())
    }

    fn one(&self, inputs: &Inputs, wish: &Wish) -> Result<(), Failure> {
        let Some(work) = inputs.works.first() else {
            return Err(Failure::Misused("no shader is named".to_owned()));
        };
        let made = make(inputs, work, wish);
        if let Some((bytes, manifest)) = &made.written {
            self.write(bytes, manifest)?;
        }
        let report = Reported::new(&work.name, Some(&self.arguments.output), &made);
        self.tell(&[(report, &made)])
    }

    fn write(&self, bytes: &[u8], manifest: &Manifest) -> Result<(), Failure> {
        let manifest = manifest.to_json();
        let arguments = self.arguments;
        // both files are ready before either appears
        let mut pending = Vec::new();
        for (path, bytes) in [
            (Some(&arguments.output), bytes),
            (arguments.manifest.as_ref(), manifest.as_bytes()),
        ] {
            match path {
                Some(path) if !files::is_stream(path) => {
                    pending.push((path, files::prepare(path, bytes)?));
                }
                _ => {}
            }
        }
        for (path, file) in pending {
            file.appear()
                .map_err(|error| files::unwritable(path, &error))?;
        }
        if files::is_stream(&arguments.output) {
            files::to_stdout(bytes)?;
        }
        if arguments.manifest.as_deref().is_some_and(files::is_stream) {
            files::to_stdout(manifest.as_bytes())?;
        }
        Ok(())
    }

    fn batch(&self, inputs: &Inputs, folder: &Path, wish: &Wish) -> Result<(), Failure> {
        std::fs::create_dir_all(folder).map_err(|error| files::unwritable(folder, &error))?;
        let outcomes = batch::run(inputs, folder, wish, self.arguments.force)?;
        let reports: Vec<_> = outcomes
            .iter()
            .map(|outcome| {
                let mut report =
                    Reported::new(&outcome.work.name, Some(&outcome.output), &outcome.made);
                if matches!(outcome.made.status, Status::Rewritten | Status::Unchanged) {
                    report.manifest = Some(outcome.manifest.display().to_string());
                }
                (report, &outcome.made)
            })
            .collect();
        let told = self.tell(&reports);
        if !self.arguments.json {
            let count = |status| outcomes.iter().filter(|o| o.made.status == status).count();
            let failed = outcomes
                .iter()
                .filter(|o| o.made.status.is_failure())
                .count();
            talk::say(&format!(
                "{} rewritten, {} unchanged, {} passed by, {failed} failed",
                count(Status::Rewritten),
                count(Status::Unchanged),
                count(Status::NothingPerPixel),
            ));
        }
        told
    }

    /// Tells what became of each shader.
    fn tell(&self, reports: &[(Reported, &Made)]) -> Result<(), Failure> {
        if self.arguments.json {
            let reports: Vec<&Reported> = reports.iter().map(|(report, _)| report).collect();
            match serde_json::to_string_pretty(&reports) {
                Ok(json) => talk::data(&json)?,
                Err(error) => unreachable!("reports are plain data: {error}"),
            }
        } else {
            for text in reports.iter().flat_map(|(_, made)| &made.said) {
                talk::say(text);
            }
        }
        let has = |wanted: &dyn Fn(Status) -> bool| reports.iter().any(|(_, m)| wanted(m.status));
        if has(&|status| status == Status::Failed) {
            return Err(Failure::Outside(String::new()));
        }
        match has(&Status::is_failure) {
            true => Err(Failure::Refused(String::new())),
            false => Ok(()),
        }
    }
}

/// A shader in the report.
#[derive(Debug, Serialize)]
struct Reported {
    shader: String,
    status: Status,
    /// Where it was written.
    output: Option<String>,
    /// Where its manifest was written, by a batch.
    manifest: Option<String>,
    /// The rewritten entry points.
    entries: Vec<String>,
    findings: Vec<Told>,
}

impl Reported {
    fn new(shader: &str, output: Option<&Path>, made: &Made) -> Reported {
        let is_there = matches!(made.status, Status::Rewritten | Status::Unchanged);
        let manifest = made.written.as_ref().map(|(_, manifest)| manifest);
        Reported {
            shader: shader.to_owned(),
            status: made.status,
            output: output
                .filter(|_| is_there)
                .map(|path| path.display().to_string()),
            manifest: None,
            entries: manifest
                .map(|manifest| manifest.entries.iter().map(|e| e.name.clone()).collect())
                .unwrap_or_default(),
            findings: made.told.clone(),
        }
    }
}

fn ends_with_separator(path: &Path) -> bool {
    path.to_string_lossy().ends_with(std::path::is_separator)
}

/// The language that is written.
fn target(arguments: &Arguments, is_batch: bool) -> Result<Target, Failure> {
    if let Some(target) = arguments.to {
        return Ok(target);
    }
    let output = &arguments.output;
    if is_batch || files::is_stream(output) {
        return Ok(Target::default());
    }
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    let known = || Language::ALL.iter().map(|&(_, _, extension)| extension);
    Language::from_extension(&extension)
        .map(Target::from)
        .ok_or_else(|| {
            let near = near::nearest(&extension, known())
                .map(|near| format!("; did you mean `.{near}`?"))
                .unwrap_or_default();
            let known: Vec<String> = known().map(|extension| format!(".{extension}")).collect();
            Failure::Misused(format!(
                "{}: the output's name ends in {}, or --to tells its language{near}",
                output.display(),
                known.join(", ")
            ))
        })
}

fn form(arguments: &Arguments) -> Result<Form, Failure> {
    let mut form = Form {
        entry: arguments.entry.clone(),
        checks_bounds: !arguments.no_bounds_checks,
        ..Form::default()
    };
    for text in &arguments.overrides {
        let value = text
            .split_once('=')
            .and_then(|(name, value)| Some((name, value.parse().ok()?)));
        let Some((name, value)) = value else {
            return Err(Failure::Misused(format!("`{text}` is not NAME=VALUE")));
        };
        form.constants.insert(name.to_owned(), value);
    }
    Ok(form)
}

fn check_paths(arguments: &Arguments) -> Result<(), Failure> {
    let outputs: Vec<&PathBuf> = std::iter::once(&arguments.output)
        .chain(&arguments.manifest)
        .collect();
    let input = &arguments.input;
    for output in &outputs {
        let inputs = input
            .shaders
            .iter()
            .chain(&input.imports)
            .chain(&input.with);
        if inputs
            .into_iter()
            .any(|shader| files::is_same(output, shader))
        {
            return Err(Failure::Misused(format!(
                "{} is the shader itself: choose another file to write to",
                output.display()
            )));
        }
    }
    if let [shader, manifest] = outputs.as_slice()
        && (files::is_same(shader, manifest)
            || files::is_stream(shader) && files::is_stream(manifest))
    {
        return Err(Failure::Misused(
            "the shader and its manifest cannot go to the same place".to_owned(),
        ));
    }
    Ok(())
}

/// Parses and rewrites a shader.
pub(super) fn rewrite(
    source: &Source,
    entry: Option<&str>,
    options: &Options,
) -> Result<Rewritten, Failure> {
    let (module, info) = input::wgsl(source).map_err(|invalid| {
        talk::say(invalid.render(talk::color()));
        Failure::Refused(String::new())
    })?;
    let entries = entry.map_or(Entries::PerPixel, Entries::Named);
    vrcs_passes::rewrite(&module, &info, entries, options).map_err(|refusal| {
        talk::say(&refusal.render(source, talk::color()));
        Failure::Refused(String::new())
    })
}
