//! `vrcs plan`: what the analysis of a scene would compile, bind and dispatch.
//!
//! Does: prints the passes, kernels, bindings and buffers that follow from what a scene has.
//! Needs: one of the six scenes, or a TOML file that says what a renderer has. No GPU.
//! Guarantees: what is printed is what [`Analysis`](crate::analyse::Analysis) makes of the same plan.
//! Refuses: a file that is no declaration, with its line; effects that need what is not there.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::json;

use super::{Failure, files, parse_size, talk};
use crate::{
    analyse::{
        own::{IdRates, OwnRates},
        params,
        settings::*,
    },
    plan::{Binding, ColourForm, Plan, Scene},
    scenes::{Declared, SceneName},
    sri::SriLayout,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "SCENE.toml, every line of which may be left out:
  colour = \"codes\"      # or linear, sqrt-luma
  motion = true         # motion vectors; and of the same kind:
  # depth, cameras, after-transparents, previous-rates, materials, noise, ids, flags, blur, attachment, reasons, sqrt-luma

Examples:
  vrcs plan interior
  vrcs plan scene.toml --size 3840x2160 --json")]
pub(super) struct Arguments {
    /// interior, foliage, landscape, text, ramps or disocclusion; or a TOML file that says what the renderer has.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The size of the picture, for the sizes of the buffers.
    #[arg(long, value_parser = parse_size, default_value = "1920x1080", value_name = "WxH")]
    size: [u32; 2],
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
    reasons: bool,
    sqrt_luma: bool,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Form {
    #[default]
    Codes,
    Linear,
    SqrtLuma,
}

/// What a scene of ours has for its analysis: the rates of the frame before are always had.
pub(crate) fn scene_of(declared: &Declared) -> Scene {
    Scene {
        motion: declared.motion_vectors || declared.camera_motion,
        depth: declared.depth && (declared.motion_vectors || declared.camera_motion),
        previous_rates: true,
        materials: declared.materials,
        noise: declared.grain,
        flags: declared.sky,
        ..Scene::default()
    }
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

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (name, scene) = read(&arguments.scene)?;
    let settings = settings_of(&scene);
    let plan = Plan::new(&scene, &settings)
        .map_err(|error| Failure::Refused(format!("{name}: {error}")))?;
    let buffers = buffers(&plan, arguments.size);
    if arguments.json {
        let mut object = plan.to_json();
        object["scene"] = json!(name);
        object["buffers"] = buffers
            .iter()
            .map(|(name, bytes)| json!({ "name": name, "bytes": bytes }))
            .collect();
        return talk::data(&object.to_string());
    }
    let [width, height] = arguments.size;
    talk::data(&format!("{name} at {width}x{height}"))?;
    talk::data(plan.to_string().trim_end())?;
    for (name, bytes) in buffers {
        talk::data(&format!("  buffer {name}: {bytes} bytes"))?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<(String, Scene), Failure> {
    if let Some(Ok(name)) = path.to_str().map(str::parse::<SceneName>) {
        return Ok((name.to_string(), scene_of(&name.declared())));
    }
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
        reasons: declared.reasons,
        sqrt_luma: declared.sqrt_luma,
    };
    Ok((name, scene))
}

/// The buffers of a plan and their bytes at a size; with smoothing, raw rates are the analysis's own.
fn buffers(plan: &Plan, size: [u32; 2]) -> Vec<(String, u64)> {
    let rates = SriLayout::new(size[0], size[1]).bytes();
    let luma = u64::from(params::luma_pitch(size[0])) * u64::from(size[1]);
    let mut all = Vec::new();
    for &binding in &plan.bindings {
        let bytes = match binding {
            Binding::Params => size_of::<params::Params>() as u64,
            // a matrix, a row, five numbers and room
            Binding::Optics => 112,
            Binding::Tables => (params::TABLE_FALLOFF + params::FALLOFF) as u64 * 4,
            Binding::SqrtLuma => luma,
            Binding::Colour | Binding::After if plan.scene.colour == ColourForm::SqrtLuma => luma,
            _ if binding.is_storage_buffer(plan.scene.colour) => rates,
            _ => continue,
        };
        all.push((binding.name().to_owned(), bytes));
        let is_smoothed = plan.settings.smoothing != Smoothing::None
            && matches!(binding, Binding::Rates | Binding::Attachment);
        if is_smoothed {
            all.push((format!("{} before smoothing", binding.name()), bytes));
        }
    }
    all
}
