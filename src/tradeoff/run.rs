//! A whole study: scenes by settings, journalled, then written as page, tables and plot.
//!
//! *Guarantees*: a point that the journal has is not measured again; files appear whole. *Refuses*: pictures that the device
//! cannot hold.

use std::path::{Path, PathBuf};

use super::{
    Trouble,
    bench::Bench,
    journal::{Journal, With},
    pictures, plot,
    realise::{largest, missing, realise},
    report,
    setting::{DeblockName, HysteresisName, Quality, Setting, SharingName, presets},
    study::{Effect, Point, SceneStudy, Study},
    sweep::Trial,
    truth::truth,
};
use crate::{Rate, atomic, check::gpu::Gpu, scenes::SceneName};

/// The preset that effects are measured on.
const BASE: &str = "Balanced";

/// What is to be studied.
#[derive(Clone, Debug)]
pub struct Request {
    /// The scenes.
    pub scenes: Vec<SceneName>,
    /// Where everything goes.
    pub out: PathBuf,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Frames of each point, 1 or more.
    pub frames: u32,
    /// Timed frames of each point.
    pub rounds: u32,
    /// Untimed frames before them.
    pub warm: u32,
    /// The settings.
    pub trials: Vec<Trial>,
    /// Whether the time that each effect adds is measured.
    pub effects: bool,
    /// Whether the analysis is held against the truth.
    pub truth: bool,
    /// Where all chance comes from.
    pub seed: u64,
    /// The command, for the report.
    pub command: String,
    /// The build of this program: points of another are not taken up again.
    pub build: String,
}

/// An effect that a scene declares, and Balanced without it.
fn effects(scene: SceneName) -> Vec<(&'static str, Setting)> {
    let Some(base) = presets().into_iter().find(|preset| preset.name == BASE) else {
        unreachable!("there is such a preset");
    };
    let base = base.setting;
    let declared = scene.declared();
    let tells_surfaces = declared.surface_ids || declared.triangle_ids || declared.depth;
    let all = [
        (
            "motion",
            declared.motion_vectors || declared.camera_motion,
            Setting {
                motion: false,
                ..base.clone()
            },
        ),
        (
            "materials",
            declared.materials,
            Setting {
                materials: false,
                ..base.clone()
            },
        ),
        (
            "ids and depth",
            tells_surfaces,
            Setting {
                sharing: SharingName::Rate,
                ..base.clone()
            },
        ),
        (
            "grain",
            declared.grain,
            Setting {
                grain: false,
                ..base.clone()
            },
        ),
        (
            "sky",
            declared.sky,
            Setting {
                sky: false,
                ..base.clone()
            },
        ),
        (
            "hysteresis",
            true,
            Setting {
                hysteresis: HysteresisName::Off,
                ..base.clone()
            },
        ),
        (
            "deblocking",
            true,
            Setting {
                deblock: DeblockName::Off,
                ..base.clone()
            },
        ),
    ];
    all.into_iter()
        .filter(|&(_, is_there, _)| is_there)
        .map(|(name, _, setting)| (name, setting))
        .collect()
}

impl Request {
    /// What is tried for a scene: the sweep, then what effects need.
    fn trials_of(&self, scene: SceneName) -> Vec<(String, Trial)> {
        let named = |trial: &Trial| match trial.preset {
            Some(name) => name.to_owned(),
            None => trial.setting.summary(),
        };
        let mut trials: Vec<(String, Trial)> = self
            .trials
            .iter()
            .filter(|trial| missing(scene, &trial.setting).is_none())
            .map(|trial| (named(trial), trial.clone()))
            .collect();
        if self.effects {
            for (name, setting) in effects(scene) {
                if !trials.iter().any(|(_, known)| known.setting == setting) {
                    let trial = Trial {
                        preset: None,
                        is_peer: false,
                        setting,
                    };
                    trials.push((format!("{BASE} without {name}"), trial));
                }
            }
        }
        trials
    }

    /// The number of steps of which [`run`] tells.
    pub fn steps(&self) -> usize {
        let points: usize = self
            .scenes
            .iter()
            .map(|&scene| self.trials_of(scene).len())
            .sum();
        points + usize::from(self.truth) * self.scenes.len()
    }
}

/// Runs a study, and writes it. `step` is told of each step that is done; see [`Request::steps`].
///
/// # Errors
/// If the device lacks what is needed or was lost, or a file cannot be written. What was finished is in the journal.
pub fn run(gpu: &Gpu, request: &Request, step: &mut dyn FnMut(&str)) -> Result<Study, Trouble> {
    let unwritable = |path: &Path, error: std::io::Error| Trouble::Write {
        path: path.display().to_string(),
        why: error.to_string(),
    };
    std::fs::create_dir_all(&request.out).map_err(|error| unwritable(&request.out, error))?;
    let with = With {
        adapter: format!("{} {}", gpu.info.name, gpu.info.driver_info),
        build: request.build.clone(),
        size: request.size,
        frames: request.frames,
        rounds: request.rounds,
        seed: request.seed,
    };
    let mut journal =
        Journal::open(&request.out, with).map_err(|error| unwritable(&request.out, error))?;
    let mut study = Study {
        adapter: format!("{} ({})", gpu.info.name, gpu.info.driver_info),
        size: request.size,
        frames: request.frames,
        rounds: request.rounds,
        seed: request.seed,
        command: request.command.clone(),
        note: note(gpu),
        legends: pictures::legends(),
        scenes: Vec::new(),
    };
    for &scene in &request.scenes {
        study
            .scenes
            .push(one_scene(gpu, request, scene, &mut journal, step)?);
        write(request, &study)?;
    }
    Ok(study)
}

/// What the reader should know of the times.
fn note(gpu: &Gpu) -> String {
    match gpu.is_software() {
        true => "Times are those of a software driver, on which memory, caches and waves are not what they are on a GPU: read the \
                 shares of primaries and of retired waves, and measure on your own GPU."
            .to_owned(),
        false => "Times are medians of GPU timestamps. Each timed frame runs the scene at full and at variable rate, in alternating \
                  order; the control is the G-buffer, which never changes."
            .to_owned(),
    }
}

fn one_scene(
    gpu: &Gpu,
    request: &Request,
    scene: SceneName,
    journal: &mut Journal,
    step: &mut dyn FnMut(&str),
) -> Result<SceneStudy, Trouble> {
    let bench = Bench::new(gpu, scene, request.size, request.seed)?;
    let mut points = Vec::new();
    for (name, trial) in request.trials_of(scene) {
        let known = journal.find(scene.name(), &trial.setting).cloned();
        let point = match known {
            Some(known) => Point { name, ..known },
            None => {
                let point = measure(&bench, request, name, &trial)?;
                journal
                    .note(scene.name(), &point)
                    .map_err(|error| Trouble::Write {
                        path: journal.path().display().to_string(),
                        why: error.to_string(),
                    })?;
                point
            }
        };
        step(&format!("{scene}: {}", point.name));
        points.push(point);
    }
    let truth = match request.truth {
        true => {
            let found = truth(&bench)?;
            step(&format!("{scene}: truth"));
            Some(found)
        }
        false => None,
    };
    let plan = presets()
        .into_iter()
        .find(|preset| preset.name == BASE)
        .map(|preset| realise(scene, &preset.setting, false).map_err(Trouble::Setting))
        .transpose()?;
    let full = bench.full(Bench::last(request.frames))?;
    Ok(SceneStudy {
        name: scene.name().to_owned(),
        about: scene.about().to_owned(),
        plan: plan.map_or_else(Vec::new, |plan| plan.lines(scene)),
        full: pictures::picture(request.size, &full),
        effects: match request.effects {
            true => effects(scene)
                .into_iter()
                .filter_map(|(name, without)| effect(name, &without, &points))
                .collect(),
            false => Vec::new(),
        },
        points,
        truth,
    })
}

/// Measures a point.
fn measure(
    bench: &Bench,
    request: &Request,
    name: String,
    trial: &Trial,
) -> Result<Point, Trouble> {
    let setting = &trial.setting;
    let look = bench.look(setting, request.frames)?;
    let time = bench.time(setting, request.warm, request.rounds)?;
    let most = match setting.quality {
        Quality::Exact => Rate::R1X1,
        Quality::Adaptive => largest(setting.largest),
    };
    let preset = presets()
        .into_iter()
        .find(|preset| Some(preset.name) == trial.preset);
    Ok(Point {
        name,
        preset: trial.preset.map(str::to_owned),
        peer: trial.is_peer,
        settings: setting.to_sweep(),
        setting: setting.clone(),
        pictures: match preset.is_some() || request.trials.len() == 1 {
            true => pictures::of_look(request.size, &look, most),
            false => Default::default(),
        },
        gives_up: preset.map(|preset| preset.gives_up.to_owned()),
        primary_share: look.primary_share,
        retired_share: look.retired_share,
        average_rate: look.average_rate,
        error: look.error,
        time,
        identical: look.identical,
    })
}

/// What an effect adds, from the points with and without it. The two were measured at different times: each is taken relative
/// to the full-rate passes that ran beside it.
fn effect(name: &str, without: &Setting, points: &[Point]) -> Option<Effect> {
    let with = points
        .iter()
        .find(|point| point.preset.as_deref() == Some(BASE))?;
    let without = points.iter().find(|point| point.setting == *without)?;
    let machinery = |point: &Point| point.time.machinery_ms() / point.time.full_ms;
    Some(Effect {
        name: name.to_owned(),
        machinery_ms: (machinery(with) - machinery(without)) * with.time.full_ms,
        frame_ms: (with.time.share() - without.time.share()) * with.time.full_ms,
        primaries: with.primary_share - without.primary_share,
        flip: with.error.flip_mean - without.error.flip_mean,
    })
}

/// Writes all files of a study.
fn write(request: &Request, study: &Study) -> Result<(), Trouble> {
    for (name, text) in [
        ("report.html", report::html(study)),
        ("points.csv", report::csv(study)),
        ("study.json", report::json(study)),
        ("plot.svg", plot::svg(study)),
    ] {
        let path = request.out.join(name);
        atomic::write(&path, text.as_bytes()).map_err(|error| Trouble::Write {
            path: path.display().to_string(),
            why: error.to_string(),
        })?;
    }
    Ok(())
}
