//! `vrcs plan`: what a scene's frame would compile, bind and dispatch: analysis, coordinates, the scene's own passes, deblocker.
//!
//! Does: prints the passes, kernels, bindings and buffers that follow from what a scene has.
//! Needs: one of the six scenes, or a TOML file that says what a renderer has. No GPU.
//! Guarantees: of a scene, what is printed is what `vrcs tradeoff` runs for it at the same preset; of a file, what
//! [`Analysis`](crate::analyse::Analysis), the [builder](crate::build) and the [deblocker](crate::deblock) make of the
//! declaration. Bindings are counted in the modules.
//! Refuses: a file that is no declaration or no settings, with its line; effects that need what is not there; settings for a scene of
//! ours, which runs at its preset.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::json;

use super::{Failure, demo, files, parse_size, talk};
use crate::{
    analyse::{
        half,
        own::{IdRates, OwnRates},
        params,
        settings::*,
        tiles,
    },
    build::BuildOptions,
    coverage::{Coverage, Depth, DepthKind, Sky},
    deblock,
    plan::{Binding, ColourForm, Plan, PlannedPass, Scene},
    scenes::SceneName,
    sri::SriLayout,
    tradeoff::{realise::realise, setting::Preset},
};

#[derive(Debug, clap::Args)]
#[command(after_help = "SCENE.toml, every line of which may be left out:
  colour = \"codes\"      # or linear, sqrt-luma
  motion = true         # motion vectors; and of the same kind:
  # surface-ids, triangle-ids, sky, depth, cameras, after-transparents, previous-rates, materials, noise, ids,
  # flags, blur, plain-rates, attachment, reasons, sqrt-luma, origin

Examples:
  vrcs plan interior
  vrcs plan landscape --preset Exact
  vrcs plan landscape --presets tradeoff/presets.toml
  vrcs plan scene.toml --size 3840x2160 --json
  vrcs plan scene.toml --settings mine.toml      # the file that `vrcs analyse --settings` reads")]
pub(super) struct Arguments {
    /// A scene of `vrcs tradeoff`; or a TOML file that says what a renderer has.
    ///
    /// The scenes are interior, foliage, landscape, text, ramps and disocclusion.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The size of the picture, for the sizes of the buffers.
    #[arg(long, value_parser = parse_size, default_value = "1920x1080", value_name = "WxH")]
    size: [u32; 2],
    /// Settings of the analysis for a SCENE.toml: every parameter of every effect, in the form that `vrcs analyse --settings` reads (see its
    /// help). Without it, every effect that the declaration serves is planned with its default parameters.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "preset")]
    settings: Option<PathBuf>,
    /// The preset that a scene runs at: Exact, Balanced or Fast.
    #[arg(long, value_name = "NAME", default_value = "Balanced")]
    preset: String,
    /// A presets.toml of `vrcs tradeoff`, in place of the general presets.
    ///
    /// It has what was chosen for each scene, of what was measured.
    #[arg(long, value_name = "FILE.toml")]
    presets: Option<PathBuf>,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
}

/// A scene's declaration in a file.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
struct Declaration {
    colour: Form,
    after_transparents: bool,
    motion: bool,
    depth: bool,
    cameras: bool,
    previous_rates: bool,
    materials: bool,
    noise: bool,
    ids: bool,
    flags: bool,
    blur: bool,
    attachment: bool,
    plain_rates: bool,
    reasons: bool,
    sqrt_luma: bool,
    surface_ids: bool,
    triangle_ids: bool,
    sky: bool,
    origin: bool,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Form {
    #[default]
    Codes,
    Linear,
    SqrtLuma,
}

/// Every effect that a scene's declaration serves, with its default parameters: what is not declared is not there.
pub(crate) fn settings_of(scene: &Scene) -> Settings {
    let has_motion = scene.motion || scene.cameras && scene.depth;
    Settings {
        motion: has_motion.then(Motion::default),
        later_blur: scene.blur && scene.motion,
        reprojection: has_motion.then(Reprojection::default),
        materials: scene.materials.then(Materials::default),
        stability: match scene.previous_rates {
            true => Stability::Hysteresis,
            false => Stability::None,
        },
        half_rate: scene.noise.then(HalfRate::default),
        transparents: scene.after_transparents,
        own: scene.ids.then(|| OwnRates {
            ids: Some(IdRates::default()),
            ..OwnRates::default()
        }),
        smoothing: Smoothing::Conservative,
        ..Settings::default()
    }
}

/// What a frame is made of.
struct Frame {
    name: String,
    /// What runs in a few lines, as the report of `vrcs tradeoff` has it; nothing for a file.
    lines: Vec<String>,
    analysis: Option<Plan>,
    build: Option<BuildOptions>,
    /// The scene's own passes that are rewritten, in the order in which they run; unknown for a file.
    rewritten: Vec<&'static str>,
    /// Those that run as their author wrote them.
    untouched: Vec<&'static str>,
    deblock: Option<deblock::Options>,
}

impl Frame {
    /// What `vrcs tradeoff` runs for a scene of ours at a preset.
    fn of_scene(scene: SceneName, preset: &Preset) -> Result<Frame, Failure> {
        let found = realise(scene, &preset.setting, false)
            .map_err(|why| Failure::Refused(format!("{scene}: {why}")))?;
        Ok(Frame {
            name: format!("{scene}, preset {}", preset.name),
            lines: found.lines(scene),
            rewritten: found.passes(scene, true),
            untouched: found.passes(scene, false),
            analysis: found.analysis,
            build: found.build,
            deblock: found.deblock,
        })
    }

    /// Everything that a renderer's declaration serves, or what its settings ask for.
    fn of_file(path: &Path, settings: Option<&Path>) -> Result<Frame, Failure> {
        let name = files::display_name(path);
        let (scene, coverage) = read(path)?;
        let (wanted, asking) = match settings {
            Some(file) => (
                super::analyse::options::read(file)?,
                format!("{name} with {}", files::display_name(file)),
            ),
            None => (settings_of(&scene), name),
        };
        let plan = Plan::new(&scene, &wanted)
            .map_err(|error| Failure::Refused(format!("{asking}: {error}")))?;
        let name = asking;
        Ok(Frame {
            name,
            lines: Vec::new(),
            analysis: Some(plan),
            build: Some(BuildOptions {
                coverage,
                effective: true,
                ..BuildOptions::default()
            }),
            rewritten: Vec::new(),
            untouched: Vec::new(),
            deblock: Some(deblock::Options {
                depth: coverage.depth,
                surfaces: coverage.surfaces,
                coverage: !coverage.is_empty(),
                ..deblock::Options::new(deblock::Picture::Texture(wgpu::TextureFormat::Rgba16Float))
            }),
        })
    }

    /// The passes that build coordinates, and those that deblock.
    fn planned(&self) -> [Vec<PlannedPass>; 2] {
        [
            self.build
                .as_ref()
                .map_or_else(Vec::new, crate::build::gpu::planned),
            self.deblock
                .as_ref()
                .map_or_else(Vec::new, deblock::gpu::planned),
        ]
    }

    fn json(&self, size: [u32; 2]) -> serde_json::Value {
        let mut object = self.analysis.as_ref().map_or_else(
            || json!({ "passes": [], "bindings": [], "later": [] }),
            Plan::to_json,
        );
        object["scene"] = json!(self.name);
        object["lines"] = json!(self.lines);
        let [build, deblock] = self.planned();
        object["build"] = build.iter().map(json_of).collect();
        object["rewritten"] = json!(self.rewritten);
        object["untouched"] = json!(self.untouched);
        object["deblock"] = deblock.iter().map(json_of).collect();
        object["buffers"] = self
            .buffers(size)
            .iter()
            .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }))
            .collect();
        object
    }

    fn buffers(&self, size: [u32; 2]) -> Vec<(String, u64)> {
        let analysis = self.analysis.as_ref();
        analysis.map_or_else(Vec::new, |plan| buffers(plan, size))
    }

    fn print(&self, size: [u32; 2]) -> Result<(), Failure> {
        talk::data(&format!("{} at {}x{}", self.name, size[0], size[1]))?;
        for line in &self.lines {
            talk::data(line)?;
        }
        if let Some(plan) = &self.analysis {
            talk::data("analysis")?;
            talk::data(plan.to_string().trim_end())?;
        }
        for (name, bytes) in self.buffers(size) {
            talk::data(&format!("  buffer {name}: {bytes} bytes"))?;
        }
        let [build, deblock] = self.planned();
        print("coordinates", &build)?;
        if self.rewritten.is_empty() && self.untouched.is_empty() {
            talk::data("the renderer's own passes, rewritten: each binds one group more")?;
        }
        for (passes, what) in [
            (&self.rewritten, "rewritten, each with one group more"),
            (&self.untouched, "as their author wrote them"),
        ] {
            if !passes.is_empty() {
                talk::data(&format!(
                    "the scene's own passes, {what}: {}",
                    passes.join(", ")
                ))?;
            }
        }
        print("deblocking, in place", &deblock)
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let preset = demo::preset(&arguments.preset)?;
    let frame = match arguments.scene.to_str().map(str::parse::<SceneName>) {
        Some(Ok(scene)) if arguments.settings.is_some() => {
            return Err(Failure::Misused(format!(
                "the scene {scene} runs at its preset: choose one with --preset, or say in a file what your renderer has \
                 and give that with --settings"
            )));
        }
        Some(Ok(scene)) => {
            let preset = demo::preset_for(scene, preset, arguments.presets.as_deref())?;
            Frame::of_scene(scene, &preset)?
        }
        _ if arguments.presets.is_some() => {
            return Err(Failure::Misused(
                "--presets is for the scenes of `vrcs tradeoff`: interior, foliage, landscape, text, ramps and disocclusion"
                    .to_owned(),
            ));
        }
        _ => Frame::of_file(&arguments.scene, arguments.settings.as_deref())?,
    };
    match arguments.json {
        true => talk::data(&frame.json(arguments.size).to_string()),
        false => frame.print(arguments.size),
    }
}

fn print(stage: &str, passes: &[PlannedPass]) -> Result<(), Failure> {
    if passes.is_empty() {
        return Ok(());
    }
    talk::data(stage)?;
    for pass in passes {
        let effects = pass.effects.join(", ").to_lowercase();
        talk::data(&format!(
            "pass: {}, {} bindings",
            pass.kernel, pass.bindings
        ))?;
        talk::data(&format!("  compiled in: {effects}"))?;
    }
    Ok(())
}

fn json_of(pass: &PlannedPass) -> serde_json::Value {
    json!({ "kernel": pass.kernel, "effects": pass.effects, "bindings": pass.bindings })
}

/// A renderer's declaration: what its analysis has, and what tells surfaces apart.
fn read(path: &Path) -> Result<(Scene, Coverage), Failure> {
    let name = files::display_name(path);
    if path.extension().is_none() && !files::is_stream(path) {
        return Err(Failure::Misused(format!(
            "no scene is called `{name}`; there are {}, or a file that ends in .toml",
            SceneName::ALL.map(SceneName::name).join(", ")
        )));
    }
    let text = files::read_text(path)?;
    let declared: Declaration = toml::from_str(&text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start).min(text.len());
        let line = text.get(..start).unwrap_or_default().matches('\n').count() + 1;
        let why = error.message().replace('\n', " ");
        Failure::Outside(format!("{name}:{line}: {why}"))
    })?;
    let scene = Scene {
        colour: match declared.colour {
            Form::Codes => ColourForm::Codes,
            Form::Linear => ColourForm::Linear,
            Form::SqrtLuma => ColourForm::SqrtLuma,
        },
        after_transparents: declared.after_transparents,
        origin: declared.origin,
        motion: declared.motion,
        depth: declared.depth,
        cameras: declared.cameras,
        previous_rates: declared.previous_rates,
        materials: declared.materials,
        noise: declared.noise,
        ids: declared.ids,
        flags: declared.flags,
        blur: declared.blur,
        attachment: declared.attachment,
        plain_rates: declared.plain_rates,
        reasons: declared.reasons,
        sqrt_luma: declared.sqrt_luma,
    };
    let coverage = Coverage {
        triangles: declared.triangle_ids,
        surfaces: declared.surface_ids,
        depth: declared.depth.then(|| Depth::new(DepthKind::Reversed)),
        normals: None,
        sky: (declared.sky && declared.depth).then_some(Sky::Depth),
    };
    Ok((scene, coverage))
}

/// The buffers of a plan and their bytes at a size; with smoothing, raw rates are the analysis's own.
fn buffers(plan: &Plan, size: [u32; 2]) -> Vec<(String, u64)> {
    let rates = SriLayout::new(size[0], size[1]).bytes();
    let luma = u64::from(params::luma_pitch(size[0])) * u64::from(size[1]);
    let mut all = Vec::new();
    for &binding in plan.bindings.iter().chain(&plan.later) {
        let bytes = match binding {
            Binding::Params => size_of::<params::Params>() as u64,
            // a matrix, a row, five numbers and room
            Binding::Optics => 112,
            Binding::Tables => params::TABLE_WORDS as u64 * 4,
            Binding::SqrtLuma => luma,
            Binding::TileData => tiles::data_bytes(size),
            Binding::HalfRates => {
                let [width, height] = half::size_of(size);
                SriLayout::new(width, height).bytes()
            }
            Binding::Colour | Binding::After if plan.scene.colour == ColourForm::SqrtLuma => luma,
            _ if binding.is_storage_buffer(plan.scene.colour) => rates,
            _ => continue,
        };
        all.push((binding.name().to_owned(), bytes));
        let is_smoothed = plan.settings.smoothing != Smoothing::None
            && matches!(
                binding,
                Binding::Rates | Binding::Attachment | Binding::PlainRates
            );
        if is_smoothed {
            all.push((format!("{} before smoothing", binding.name()), bytes));
        }
    }
    all
}
