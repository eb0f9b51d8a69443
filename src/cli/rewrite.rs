//! `vrcs rewrite`

use std::path::PathBuf;

use vrcs_passes::{
    Entries, Options, Rewritten, Source, emit, input, manifest,
    options::{FullTiles, MaxRate, Mode},
};

use super::{Failure, files, talk};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The shader; `-` reads standard input.
    shader: PathBuf,
    /// Where the rewritten shader goes; `-` is standard output.
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// The entry point; every compute entry point that stores per pixel if not given.
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// Where the manifest goes: what a program needs to dispatch the shader, as JSON.
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    #[command(flatten)]
    how: How,
}

/// The options of a rewrite, shared with `check`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct How {
    /// How primaries find their pixels.
    #[arg(long, value_enum, default_value_t = ModeName::Tiled)]
    mode: ModeName,
    /// The largest shading rate whose copies the shader makes.
    #[arg(long, value_enum, default_value_t = MaxRateName::R2x2, value_name = "RATE")]
    max_rate: MaxRateName,
    /// What becomes of tiles that are nearly full.
    #[arg(long, value_enum, default_value_t = FullTilesName::Promote, value_name = "RULE")]
    full_tiles: FullTilesName,
    /// Invocations that retire together.
    #[arg(long, default_value_t = 32, value_name = "N")]
    wave: u32,
    /// Bind groups of the device.
    #[arg(long, default_value_t = 4, value_name = "N")]
    max_bind_groups: u32,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum ModeName {
    /// One workgroup for each tile of the picture.
    Tiled,
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
            ..Options::default()
        })
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = arguments.how.options()?;
    check_paths(arguments)?;
    let text = files::read_text(&arguments.shader)?;
    let source = Source::new(files::display_name(&arguments.shader), text);
    let mut rewritten = rewrite(&source, arguments.entry.as_deref(), &options)?;
    let text = emit::wgsl(&rewritten.module, &rewritten.info).map_err(|error| {
        Failure::Refused(format!(
            "{}: {error}",
            files::display_name(&arguments.shader)
        ))
    })?;
    warn(&source, &mut rewritten);

    let manifest = match serde_json::to_string_pretty(&rewritten.manifest) {
        Ok(json) => json + "\n",
        Err(error) => unreachable!("a manifest is plain data: {error}"),
    };
    // both files are ready before either appears
    let mut pending = Vec::new();
    for (path, bytes) in [
        (Some(&arguments.output), &text),
        (arguments.manifest.as_ref(), &manifest),
    ] {
        match path {
            Some(path) if !files::is_stream(path) => {
                pending.push((path, files::prepare(path, bytes.as_bytes())?));
            }
            _ => {}
        }
    }
    for (path, file) in pending {
        file.appear()
            .map_err(|error| files::unwritable(path, &error))?;
    }
    if files::is_stream(&arguments.output) {
        files::to_stdout(text.as_bytes())?;
    }
    if arguments.manifest.as_deref().is_some_and(files::is_stream) {
        files::to_stdout(manifest.as_bytes())?;
    }
    tell(&rewritten);
    Ok(())
}

fn check_paths(arguments: &Arguments) -> Result<(), Failure> {
    let outputs: Vec<&PathBuf> = std::iter::once(&arguments.output)
        .chain(&arguments.manifest)
        .collect();
    for output in &outputs {
        if files::is_same(output, &arguments.shader) {
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
        talk::say(&invalid.rendered);
        Failure::Refused(String::new())
    })?;
    let entries = entry.map_or(Entries::PerPixel, Entries::Named);
    vrcs_passes::rewrite(&module, &info, entries, options).map_err(|refusal| {
        talk::say(&refusal.render(source, talk::color()));
        Failure::Refused(String::new())
    })
}

/// Gives the warnings, and puts them into the manifest.
fn warn(source: &Source, rewritten: &mut Rewritten) {
    for (entry, warning) in &rewritten.warnings {
        talk::say(&warning.render(source, talk::color()));
        let entries = &mut rewritten.manifest.entries;
        if let Some(of) = entries.iter_mut().find(|e| e.name == *entry) {
            of.warnings
                .push(manifest::Warning::new(warning, Some(source)));
        }
    }
}

/// Tells what was done.
fn tell(rewritten: &Rewritten) {
    for (entry, finding) in &rewritten.left_alone {
        talk::say(&format!(
            "note: `{entry}` is left as it is: {}",
            finding.message
        ));
    }
    for entry in &rewritten.manifest.entries {
        let targets: Vec<_> = entry
            .targets
            .iter()
            .map(|t| format!("`{}`", t.name))
            .collect();
        talk::say(&format!(
            "note: `{}` is variable-rate: {}; bind group {}",
            entry.name,
            targets.join(", "),
            entry.bindings[0].group
        ));
    }
}
