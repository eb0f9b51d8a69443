//! A whole study: scenes by settings, journalled, and written as page, tables and plot whenever more of it is there.
//!
//! *Does*: for each scene, in batches: looks at every setting, then times them together; then the truth; then pictures of the presets and of
//! the front. *Guarantees*: what the journal has is not measured again; files appear whole, after each batch, so that an interruption
//! leaves a report of what there was. *Refuses*: pictures that the machine cannot hold, and a sweep of which no setting suits a scene.

use std::path::{Path, PathBuf};

use super::{
    Trouble,
    bench::Bench,
    effects::{BASE, base, effects},
    journal::{Found, Journal, With},
    memory, pictures, plot,
    realise::{largest, missing, realise},
    report::{self, front_of},
    setting::{Quality, Setting, presets},
    study::{Effect, Point, SceneStudy, Study, Times},
    summary,
    sweep::Trial,
    truth::truth,
    turns::Rounds,
};
use crate::{Rate, atomic, check::gpu::Gpu, scenes::SceneName};

/// Settings that are timed together, at most: each holds buffers of its own.
const TOGETHER: usize = 16;

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
    /// How often each point is timed.
    pub rounds: Rounds,
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

/// A trial, and what it is called.
#[derive(Clone, Debug)]
struct Named {
    name: String,
    trial: Trial,
}

impl Request {
    /// What is tried for a scene: the presets, what effects need, the sweep.
    fn trials_of(&self, scene: SceneName) -> Vec<Named> {
        let suits = |trial: &&Trial| missing(scene, &trial.setting).is_none();
        let (mut named, rest): (Vec<Named>, Vec<Named>) = self
            .trials
            .iter()
            .filter(suits)
            .map(|trial| Named {
                name: trial.name(),
                trial: trial.clone(),
            })
            .partition(|named| named.trial.preset.is_some());
        let without = match self.effects {
            true => effects(scene),
            false => Vec::new(),
        };
        for (name, setting) in without {
            if !named.iter().any(|known| known.trial.setting == setting) {
                named.push(Named {
                    name: format!("{BASE} without {name}"),
                    trial: Trial {
                        preset: None,
                        is_peer: false,
                        setting,
                    },
                });
            }
        }
        for one in rest {
            match named
                .iter_mut()
                .find(|known| known.trial.setting == one.trial.setting)
            {
                Some(known) => known.trial.is_peer |= one.trial.is_peer,
                None => named.push(one),
            }
        }
        named
    }

    /// What a scene cannot be tried with, and why, for the reader.
    pub fn left_out(&self, scene: SceneName) -> Vec<String> {
        let why = |trial: &Trial| {
            let what = missing(scene, &trial.setting)?;
            Some(format!(
                "{} is left out: {scene} declares no {what}",
                trial.name()
            ))
        };
        self.trials.iter().filter_map(why).collect()
    }

    /// The number of steps of which [`run`] tells.
    pub fn steps(&self) -> usize {
        let of = |&scene: &SceneName| {
            let points = self.trials_of(scene).len();
            points + points.div_ceil(TOGETHER) + usize::from(self.truth) + 1
        };
        self.scenes.iter().map(of).sum()
    }

    /// Settings that are at work at once, at most.
    fn together(&self) -> usize {
        let of = |&scene: &SceneName| self.trials_of(scene).len().min(TOGETHER);
        self.scenes.iter().map(of).max().unwrap_or_default()
    }

    /// Refuses a sweep of which a scene cannot be tried with anything.
    fn check(&self) -> Result<(), Trouble> {
        let is_own = |trial: &&Trial| trial.preset.is_none();
        for &scene in &self.scenes {
            let mut own = self.trials.iter().filter(is_own).peekable();
            if own.peek().is_some() && own.all(|trial| missing(scene, &trial.setting).is_some()) {
                return Err(Trouble::Setting(format!(
                    "nothing of the sweep can be tried: {}",
                    self.left_out(scene).join("; ")
                )));
            }
        }
        Ok(())
    }
}

/// Runs a study, and writes it. `step` is told of each step that is done; see [`Request::steps`].
///
/// # Errors
/// If the device lacks what is needed or was lost, or a file cannot be written. What was finished is in the journal and the report.
pub fn run(gpu: &Gpu, request: &Request, step: &mut dyn FnMut(&str)) -> Result<Study, Trouble> {
    request.check()?;
    let together = request.together();
    memory::check(gpu, request.size, together)?;
    let with = With {
        adapter: format!("{} {}", gpu.info.name, gpu.info.driver_info),
        build: request.build.clone(),
        size: request.size,
        frames: request.frames,
        rounds: request.rounds.counted,
        seed: request.seed,
    };
    let journal = Journal::open(&request.out, with)
        .map_err(|error| unwritable(&request.out.join("points.jsonl"), &error))?;
    let study = Study {
        adapter: format!("{} ({})", gpu.info.name, gpu.info.driver_info),
        size: request.size,
        frames: request.frames,
        rounds: request.rounds.counted,
        seed: request.seed,
        command: request.command.clone(),
        note: note(gpu),
        legends: pictures::legends(),
        summary: None,
        unfinished: None,
        scenes: Vec::new(),
    };
    let mut work = Work {
        gpu,
        request,
        journal,
        study,
        step,
    };
    for &scene in &request.scenes {
        work.scene(scene)
            .map_err(|trouble| memory::explained(trouble, gpu, request.size, together))?;
    }
    Ok(work.study)
}

fn unwritable(path: &Path, error: &std::io::Error) -> Trouble {
    Trouble::Write {
        path: path.display().to_string(),
        why: error.to_string(),
    }
}

/// What the reader should know of the times.
fn note(gpu: &Gpu) -> String {
    let how = "Settings of a scene are timed in turns: each round draws one frame at full rate and at every setting, in a shuffled \
               order, and a setting is compared with the full rate of its own round; in brackets, the interval that holds the median \
               in 95 of 100 cases. The control is the G-buffer, which never changes: rounds in which it was more than 5 % off do \
               not count.";
    match gpu.is_software() {
        true => format!(
            "{how} These are the times of a software driver, on which memory, caches and waves are not what they are on a GPU: read \
             the shares of primaries and of waves, and measure on your own GPU."
        ),
        false => how.to_owned(),
    }
}

/// A study under way.
struct Work<'w> {
    gpu: &'w Gpu,
    request: &'w Request,
    journal: Journal,
    study: Study,
    step: &'w mut dyn FnMut(&str),
}

impl Work<'_> {
    fn note(&mut self, scene: SceneName, found: Found) -> Result<(), Trouble> {
        let noted = self.journal.note(scene.name(), found);
        noted.map_err(|error| unwritable(self.journal.path(), &error))
    }

    fn scene(&mut self, scene: SceneName) -> Result<(), Trouble> {
        let request = self.request;
        let bench = Bench::new(self.gpu, scene, request.size, request.seed)?;
        let plan = presets()
            .into_iter()
            .find(|preset| preset.name == BASE)
            .map(|preset| realise(scene, &preset.setting, false).map_err(Trouble::Setting))
            .transpose()?;
        let full = bench.full(Bench::last(request.frames))?;
        self.study.scenes.push(SceneStudy {
            name: scene.name().to_owned(),
            about: scene.about().to_owned(),
            plan: plan.map_or_else(Vec::new, |plan| plan.lines(scene)),
            full: pictures::picture(request.size, &full),
            points: Vec::new(),
            fronts: Default::default(),
            left_out: request.left_out(scene),
            effects: Vec::new(),
            truth: None,
        });
        let trials = request.trials_of(scene);
        for batch in trials.chunks(TOGETHER) {
            self.batch(&bench, batch)?;
            self.write(trials.len())?;
        }
        if request.truth {
            let found = match self.journal.truth(scene.name()) {
                Some(known) => known.clone(),
                None => {
                    let found = truth(&bench)?;
                    self.note(scene, Found::Truth(found.clone()))?;
                    found
                }
            };
            self.last().truth = Some(found);
            (self.step)(&format!("{scene}: truth"));
        }
        self.pictures(&bench)?;
        (self.step)(&format!("{scene}: pictures"));
        self.write(trials.len())
    }

    /// The scene under way.
    fn last(&mut self) -> &mut SceneStudy {
        match self.study.scenes.last_mut() {
            Some(scene) => scene,
            None => unreachable!("a scene is under way"),
        }
    }

    /// Looks at a batch, then times it.
    fn batch(&mut self, bench: &Bench, batch: &[Named]) -> Result<(), Trouble> {
        let scene = bench.scene();
        for Named { name, trial } in batch {
            if self.journal.look(scene.name(), &trial.setting).is_none() {
                let seen = bench.look(&trial.setting, self.request.frames)?;
                let setting = trial.setting.clone();
                self.note(scene, Found::Look { setting, seen })?;
            }
            (self.step)(&format!("{scene}: {name}"));
        }
        let is_timed = |named: &Named| {
            let known = self.journal.times(scene.name(), &named.trial.setting);
            known.is_some()
        };
        let left: Vec<&Setting> = batch
            .iter()
            .filter(|named| !is_timed(named))
            .map(|named| &named.trial.setting)
            .collect();
        if !left.is_empty() {
            // effects are told from the same rounds, so that presets and effects are timed anew together
            let has_base = |settings: &[&Setting]| settings.iter().any(|&s| *s == base());
            let all: Vec<&Setting> = batch.iter().map(|named| &named.trial.setting).collect();
            let settings = if has_base(&all) { all } else { left };
            let found = self.times(bench, &settings)?;
            self.note(scene, found)?;
        }
        (self.step)(&format!("{scene}: times of {} settings", batch.len()));
        let points: Vec<Point> = batch
            .iter()
            .filter_map(|named| self.point(scene, named))
            .collect();
        let effects = self.journal.effects(scene.name());
        let known = self.last();
        known.points.extend(points);
        known.effects = effects;
        known.fronts = report::fronts(&known.points);
        Ok(())
    }

    fn times(&self, bench: &Bench, settings: &[&Setting]) -> Result<Found, Trouble> {
        let scene = bench.scene();
        let taken = bench.time(settings, self.request.rounds)?;
        let place = |wanted: &Setting| settings.iter().position(|&known| known == wanted);
        let times = settings
            .iter()
            .enumerate()
            .map(|(index, setting)| {
                let times = taken.times(scene, index, setting.every);
                ((*setting).clone(), times)
            })
            .collect();
        let found = |(name, without): (&str, Setting)| {
            let (with, without_at) = (place(&base())?, place(&without)?);
            let seen = |setting: &Setting| self.journal.look(scene.name(), setting);
            let (a, b) = (seen(&base())?, seen(&without)?);
            let rest = Effect {
                name: name.to_owned(),
                primaries: a.primary_share - b.primary_share,
                flip: a.error.flip_mean - b.error.flip_mean,
                ..Effect::default()
            };
            Some(taken.effect(scene, with, without_at, rest))
        };
        let effects = match self.request.effects {
            true => effects(scene).into_iter().filter_map(found).collect(),
            false => Vec::new(),
        };
        Ok(Found::Times { times, effects })
    }

    /// A point of what the journal has.
    fn point(&self, scene: SceneName, named: &Named) -> Option<Point> {
        let Named { name, trial } = named;
        let setting = &trial.setting;
        let seen = self.journal.look(scene.name(), setting)?.clone();
        let time: Times = self.journal.times(scene.name(), setting)?.clone();
        let preset = presets()
            .into_iter()
            .find(|preset| Some(preset.name) == trial.preset);
        Some(Point {
            name: name.clone(),
            preset: trial.preset.map(str::to_owned),
            peer: trial.is_peer,
            settings: setting.to_sweep(),
            setting: setting.clone(),
            gives_up: preset.map(|preset| preset.gives_up.to_owned()),
            seen,
            time,
            pictures: Default::default(),
        })
    }

    /// Pictures of the presets and of the front.
    fn pictures(&mut self, bench: &Bench) -> Result<(), Trouble> {
        let (size, frames) = (self.request.size, self.request.frames);
        let scene = self.last();
        let front = front_of(scene);
        for (index, point) in scene.points.iter_mut().enumerate() {
            if point.preset.is_none() && !front.contains(&index) {
                continue;
            }
            let most = match point.setting.quality {
                Quality::Exact => Rate::R1X1,
                Quality::Adaptive => largest(point.setting.largest),
            };
            let shown = bench.show(&point.setting, frames)?;
            point.pictures = pictures::of_frame(size, &shown, most);
        }
        Ok(())
    }

    /// Writes all files; `wanted` points of the scene under way will be there at last.
    fn write(&mut self, wanted: usize) -> Result<(), Trouble> {
        let scenes = &self.study.scenes;
        let there = scenes.last().map_or(0, |scene| scene.points.len());
        let is_whole = scenes.len() == self.request.scenes.len()
            && there == wanted
            && scenes
                .iter()
                .all(|s| s.points.iter().any(|p| !p.pictures.is_empty()));
        self.study.unfinished = (!is_whole).then(|| {
            format!(
                "This study is not finished: {} of {} scenes, of the last {there} of {wanted} points. The same command goes on.",
                scenes.len(),
                self.request.scenes.len()
            )
        });
        self.study.summary = summary::of(&self.study.scenes);
        let study = &self.study;
        for (name, text) in [
            ("report.html", report::html(study)),
            ("points.csv", report::csv(study)),
            ("study.json", report::json(study)),
            ("plot.svg", plot::svg(study)),
        ] {
            let path = self.request.out.join(name);
            atomic::write(&path, text.as_bytes()).map_err(|error| unwritable(&path, &error))?;
        }
        Ok(())
    }
}
