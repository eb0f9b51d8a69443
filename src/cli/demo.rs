//! `vrcs demo`

use std::path::{Path, PathBuf};

use vrcs_passes::Source;

use super::{Failure, batch::build_of_the_program, files, parse_size, talk, tradeoff};
use crate::{
    analyse::content::Sensitivity,
    check::{Verdict, gpu::Gpu},
    demo::{Demo, DemoError, Shown},
    scenes::{SceneName, UnknownScene},
    tradeoff::{
        chosen,
        run::Request,
        setting::{Preset, Setting, presets},
        sweep::Trial,
    },
    web,
};

/// The size of the small scene's picture.
const SIZE: [u32; 2] = [1280, 720];

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  vrcs demo
  vrcs demo --size 640x360 --threshold 0.1 --out pictures
  vrcs demo interior --preset Fast --out interior
  vrcs demo --web page && xdg-open page/index.html")]
pub(super) struct Arguments {
    /// A scene of `vrcs tradeoff`; without, a small scene as pictures.
    ///
    /// interior, foliage, landscape, text, ramps or disocclusion: its report with one point, in the folder of --out.
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// The preset to show: Exact, Balanced or Fast.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "Balanced",
        requires = "scene"
    )]
    preset: String,
    /// A presets.toml of `vrcs tradeoff`, in place of the general presets.
    ///
    /// It has what was chosen for each scene, of what was measured.
    #[arg(long, value_name = "FILE.toml", requires = "scene")]
    presets: Option<PathBuf>,
    /// Where the pictures go.
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
    /// The size of the picture. [default: 1280x720]
    ///
    /// For a SCENE it is what `vrcs tradeoff` uses, if not given.
    #[arg(long, value_parser = parse_size, value_name = "WxH")]
    size: Option<[u32; 2]>,
    /// How large a difference may be, as a share of the luma around it. [default: 0.06]
    ///
    /// The paper's t, which is 0.15 for a 4K display at arm's length, and less for larger pixels. For a SCENE it is the preset's, if
    /// not given.
    #[arg(long, value_name = "T")]
    threshold: Option<f64>,
    /// The adapter: a part of its name. See `vrcs adapters`.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Write a page instead that runs it in a browser, `index.html` in this folder.
    ///
    /// It runs the original and the rewritten shader in the browser's own WebGPU, and holds the laws there. Needs no GPU here.
    #[arg(long, value_name = "FOLDER", conflicts_with = "scene")]
    web: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.threshold.is_some_and(|t| t.is_nan() || t < 0.0) {
        return Err(Failure::Misused(
            "the threshold has to be 0 or more".to_owned(),
        ));
    }
    if let Some(folder) = &arguments.web {
        return write_page(folder, arguments.size.unwrap_or(SIZE));
    }
    if let Some(name) = &arguments.scene {
        return scene(arguments, name);
    }
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    let size = arguments.size.unwrap_or(SIZE);
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if size.iter().any(|&side| side > limit) {
        return Err(Failure::Misused(format!(
            "the picture can be at most {limit} pixels wide and high on {}",
            gpu.info.name
        )));
    }
    let demo = Demo {
        size,
        out: arguments.out.clone(),
        sensitivity: Sensitivity {
            threshold: arguments.threshold.unwrap_or(0.06),
            ..Sensitivity::default()
        },
    };
    let shown = demo.run(&gpu, &mut talk::status);
    talk::status_done();
    let shown = shown.map_err(|error| match error {
        DemoError::Gpu(error) => error.into(),
        error => Failure::Outside(error.to_string()),
    })?;
    print(&shown)?;
    match shown.laws.verdict {
        Verdict::Passed => Ok(()),
        _ => Err(Failure::Refused("the laws do not hold".to_owned())),
    }
}

fn write_page(folder: &Path, size: [u32; 2]) -> Result<(), Failure> {
    let source = Source::new("plaza.wgsl", crate::demo::SCENE);
    let page =
        web::page(&source, "plaza", size).map_err(|error| Failure::Outside(error.to_string()))?;
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Outside(format!("{}: {error}", folder.display())))?;
    let path = folder.join("index.html");
    crate::atomic::write(&path, page.as_bytes())
        .map_err(|error| files::unwritable(&path, &error))?;
    talk::data(&path.display().to_string())
}

/// The preset of this name, in any case.
pub(super) fn preset(name: &str) -> Result<Preset, Failure> {
    presets()
        .into_iter()
        .find(|preset| preset.name.eq_ignore_ascii_case(name))
        .ok_or_else(|| {
            Failure::Misused(format!(
                "no preset is called `{name}`; there are Exact, Balanced and Fast"
            ))
        })
}

/// A preset for a scene: the general one, or that of a file of `vrcs tradeoff`.
pub(super) fn preset_for(
    scene: SceneName,
    general: Preset,
    file: Option<&Path>,
) -> Result<Preset, Failure> {
    let Some(path) = file else {
        return Ok(general);
    };
    let text = files::read_text(path)?;
    let setting = chosen::read(&text, scene, general.name)
        .map_err(|error| Failure::Misused(format!("{}: {error}", files::display_name(path))))?;
    Ok(Preset { setting, ..general })
}

/// Shows one point of a scene of `vrcs tradeoff`, in the same page.
fn scene(arguments: &Arguments, name: &str) -> Result<(), Failure> {
    let scene: SceneName = name
        .parse()
        .map_err(|error: UnknownScene| Failure::Misused(error.to_string()))?;
    let general = preset(&arguments.preset)?;
    let preset = preset_for(scene, general.clone(), arguments.presets.as_deref())?;
    let gpu = Gpu::open(arguments.adapter.as_deref())?;
    let trial = Trial {
        preset: (arguments.threshold.is_none() && preset == general).then_some(preset.name),
        is_peer: false,
        setting: Setting {
            threshold: arguments.threshold.unwrap_or(preset.setting.threshold),
            ..preset.setting
        },
    };
    let request = Request {
        scenes: vec![scene],
        out: arguments.out.clone(),
        size: tradeoff::size(&gpu, arguments.size)?,
        frames: 4,
        compared: 4,
        rounds: tradeoff::rounds(&gpu, true),
        trials: vec![trial],
        effects: false,
        chooses: false,
        truth: 0,
        seed: 1,
        command: tradeoff::command(),
        build: build_of_the_program(),
    };
    let found = tradeoff::study_with_bar(&gpu, &request)?;
    tradeoff::print(&found, &request.out)
}

fn print(shown: &Shown) -> Result<(), Failure> {
    let times = &shown.times;
    let share = |part: f64| format!("{part:8.2} ms  {:5.1} %", 100.0 * part / times.original);
    let rates: Vec<String> = shown
        .rates
        .iter()
        .map(|(rate, share)| format!("{rate} {:.1} %", 100.0 * share))
        .collect();
    let held: u32 = shown.laws.held.values().sum();
    let laws = match shown.laws.verdict {
        Verdict::Passed => format!(
            "{} of {}, in {held} trials",
            shown.laws.held.len(),
            shown.laws.held.len()
        ),
        _ => format!(
            "NO: {}",
            shown
                .laws
                .why
                .clone()
                .unwrap_or_else(|| format!("{:?}", shown.laws.failure))
        ),
    };
    let psnr = |psnr: f64| match psnr.is_infinite() {
        true => "equal".to_owned(),
        false => format!("{psnr:.1} dB"),
    };
    let clock = match times.by_gpu {
        true => "GPU timestamps",
        false => "the host's clock",
    };
    let statistics = &shown.statistics;
    let rows = [
        ("adapter", shown.adapter.clone()),
        ("picture", format!("{}x{}", shown.size[0], shown.size[1])),
        ("rates", rates.join(", ")),
        (
            "primaries",
            format!("{:.1} % of pixels", 100.0 * statistics.primary_share()),
        ),
        (
            "waves retired",
            format!("{:.1} %", 100.0 * statistics.retired_share()),
        ),
        ("original shader", share(times.original)),
        ("rewritten, all 1x1", share(times.identity)),
        ("rewritten", share(times.variable)),
        ("coordinate build", share(times.build)),
        ("deblocker", share(times.deblock)),
        ("times from", clock.to_owned()),
        ("PSNR", psnr(shown.psnr)),
        ("PSNR, deblocked", psnr(shown.psnr_deblocked)),
        ("laws held", laws),
    ];
    for (name, value) in rows {
        talk::data(&format!("{name:<20} {value}"))?;
    }
    for picture in &shown.pictures {
        talk::data(&format!("{:<20} {}", "picture written", picture.display()))?;
    }
    Ok(())
}
