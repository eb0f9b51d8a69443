//! A whole study: scenes by settings, journalled, and written as page, tables and plot whenever more of it is there.
//!
//! *Does*: for each scene, in batches: looks at every setting, then times them together; then the truth; then pictures of the presets and of
//! the front. *Guarantees*: what the journal has is not measured again; files appear whole, after each batch, so that an interruption
//! leaves a report of what there was. *Refuses*: pictures that the machine cannot hold, and a sweep of which no setting suits a scene.

use std::{
    path::{Path, PathBuf},
    sync::mpsc,
};

use rayon::prelude::*;

use super::{
    Trouble,
    bench::{Bench, Uncompared},
    choice, chosen,
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
use crate::{
    Rate, atomic,
    check::gpu::Gpu,
    metrics::{self, Shown},
    scenes::SceneName,
};

/// Settings that are timed together, at most: each holds buffers of its own.
const TOGETHER: usize = 16;
/// Points of a scene that have pictures, at least if there are so many.
const PICTURED: usize = 6;
/// Bytes of pictures that wait to be compared, at most.
const MEMORY: u64 = 1 << 30;

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
    /// So many of these are compared with full rate, the last; 1 or more.
    pub compared: u32,
    /// How often each point is timed.
    pub rounds: Rounds,
    /// The settings.
    pub trials: Vec<Trial>,
    /// Whether the time that each effect adds is measured.
    pub effects: bool,
    /// Whether presets are chosen for each scene, of what was measured and what may do better.
    pub chooses: bool,
    /// The frames in which the analysis is held against the truth; 0 for none.
    pub truth: u32,
    /// Where all chance comes from.
    pub seed: u64,
    /// The command, for the report.
    pub command: String,
    /// The build of this program: points of another are not taken up again.
    pub build: String,
}

/// A setting that is neither a preset nor another's.
fn own(setting: Setting) -> Trial {
    Trial {
        preset: None,
        is_peer: false,
        setting,
    }
}

/// What a study tells while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step<'s> {
    /// A step is done.
    Done(&'s str),
    /// There are so many more than was known.
    More(usize),
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
                    trial: own(setting),
                });
            }
        }
        if self.chooses {
            named.push(Named {
                name: choice::UNTOUCHED.to_owned(),
                trial: own(Setting::untouched()),
            });
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

    /// The number of steps that are known before [`run`] tells of them.
    pub fn steps(&self) -> usize {
        let of = |&scene: &SceneName| {
            steps_of(self.trials_of(scene).len()) + usize::from(self.truth > 0) + 1
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

/// The steps of so many settings.
fn steps_of(settings: usize) -> usize {
    settings + settings.div_ceil(TOGETHER)
}

/// Runs a study, and writes it. `step` is told of each step that is done; see [`Request::steps`].
///
/// # Errors
/// If the device lacks what is needed or was lost, or a file cannot be written. What was finished is in the journal and the report.
pub fn run(gpu: &Gpu, request: &Request, step: &mut dyn FnMut(Step)) -> Result<Study, Trouble> {
    request.check()?;
    let together = request.together();
    memory::check(gpu, request.size, together)?;
    // not after minutes of work
    std::fs::create_dir_all(&request.out).map_err(|error| unwritable(&request.out, &error))?;
    let with = With {
        adapter: format!("{} {}", gpu.info.name, gpu.info.driver_info),
        build: request.build.clone(),
        size: request.size,
        frames: request.frames,
        compared: request.compared,
        rounds: request.rounds.counted,
        seed: request.seed,
    };
    let journal = Journal::open(&request.out, with)
        .map_err(|error| unwritable(&request.out.join("points.jsonl"), &error))?;
    let study = Study {
        adapter: format!("{} ({})", gpu.info.name, gpu.info.driver_info),
        size: request.size,
        frames: request.frames,
        compared: request.compared.min(request.frames),
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
        finished: 0,
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

/// Settings whose frames wait to be compared, at most: as many as processors have work with, and no more than memory holds.
fn most_under_way(size: [u32; 2]) -> usize {
    let room = MEMORY / Uncompared::bytes(size).max(1);
    rayon::current_num_threads().min(room as usize).max(2)
}

/// The points whose pictures the report has: presets, the scene's own first; then the front, as far apart as may be; then others, up to
/// [`PICTURED`].
fn pictured(scene: &SceneStudy) -> Vec<usize> {
    let mut all: Vec<usize> = scene.chosen.iter().map(|chosen| chosen.point).collect();
    all.dedup();
    let general = (0..scene.points.len()).filter(|&index| scene.points[index].preset.is_some());
    let general: Vec<usize> = general.filter(|index| !all.contains(index)).collect();
    all.extend(general);
    let front: Vec<usize> = front_of(scene)
        .into_iter()
        .filter(|index| !all.contains(index))
        .collect();
    let room = PICTURED.saturating_sub(all.len());
    let apart = front.len().div_ceil(room.max(1)).max(1);
    all.extend(front.into_iter().step_by(apart).take(room));
    let others = (0..scene.points.len()).filter(|index| !all.contains(index));
    let others: Vec<usize> = others.take(PICTURED.saturating_sub(all.len())).collect();
    all.extend(others);
    all
}

/// A study under way.
struct Work<'w> {
    gpu: &'w Gpu,
    request: &'w Request,
    journal: Journal,
    study: Study,
    /// Scenes of which all is there.
    finished: usize,
    step: &'w mut dyn FnMut(Step),
}

impl Work<'_> {
    fn done(&mut self, what: &str) {
        (self.step)(Step::Done(what));
    }

    fn note(&mut self, scene: SceneName, found: Found) -> Result<(), Trouble> {
        let noted = self.journal.note(scene.name(), found);
        noted.map_err(|error| unwritable(self.journal.path(), &error))
    }

    fn scene(&mut self, scene: SceneName) -> Result<(), Trouble> {
        let request = self.request;
        let bench =
            Bench::new(self.gpu, scene, request.size, request.seed)?.comparing(request.compared);
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
            full: pictures::whole(request.size, &full),
            close: None,
            points: Vec::new(),
            fronts: Default::default(),
            chosen: Vec::new(),
            left_out: request.left_out(scene),
            effects: Vec::new(),
            truth: None,
        });
        self.all(&bench, &request.trials_of(scene))?;
        if request.chooses {
            let better: Vec<Named> = choice::candidates(scene, self.last())
                .into_iter()
                .map(|(name, setting)| Named {
                    name,
                    trial: own(setting),
                })
                .collect();
            (self.step)(Step::More(steps_of(better.len())));
            self.all(&bench, &better)?;
            self.last().chosen = choice::choose(scene, self.last());
        }
        if request.truth > 0 {
            let found = match self.journal.truth(scene.name()) {
                Some(known) => known.clone(),
                None => {
                    let found = truth(&bench, request.truth)?;
                    self.note(scene, Found::Truth(found.clone()))?;
                    found
                }
            };
            self.last().truth = Some(found);
            self.done(&format!("{scene}: truth"));
        }
        self.pictures(&bench)?;
        self.done(&format!("{scene}: pictures"));
        self.finished += 1;
        self.write()
    }

    /// Tries settings, in batches.
    fn all(&mut self, bench: &Bench, named: &[Named]) -> Result<(), Trouble> {
        for batch in named.chunks(TOGETHER) {
            self.batch(bench, batch)?;
            self.write()?;
        }
        Ok(())
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
        self.looks(bench, batch)?;
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
        self.done(&format!("{scene}: times of {} settings", batch.len()));
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

    /// Looks at every setting of a batch: the device draws one while processors compare those before it.
    fn looks(&mut self, bench: &Bench, batch: &[Named]) -> Result<(), Trouble> {
        let (scene, frames) = (bench.scene(), self.request.frames);
        let (tell, told) = mpsc::channel();
        rayon::in_place_scope(|scope| {
            let mut under_way = 0;
            for Named { name, trial } in batch {
                if self.journal.look(scene.name(), &trial.setting).is_some() {
                    self.done(&format!("{scene}: {name}"));
                    continue;
                }
                while under_way >= most_under_way(bench.size()) {
                    under_way -= self.seen(scene, told.recv())?;
                }
                let uncompared = bench.frames(&trial.setting, frames)?;
                under_way += 1;
                let (tell, name, setting) = (tell.clone(), name.clone(), trial.setting.clone());
                scope.spawn(move |_| {
                    let seen = uncompared.compare();
                    // nobody listens after trouble
                    let _ = tell.send((name, Found::Look { setting, seen }));
                });
            }
            while under_way > 0 {
                under_way -= self.seen(scene, told.recv())?;
            }
            Ok(())
        })
    }

    /// Notes what was seen; one less is under way.
    fn seen(
        &mut self,
        scene: SceneName,
        told: Result<(String, Found), mpsc::RecvError>,
    ) -> Result<usize, Trouble> {
        let (name, found) = told.map_err(|error| Trouble::Own(error.to_string()))?;
        self.note(scene, found)?;
        self.done(&format!("{scene}: {name}"));
        Ok(1)
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

    /// Pictures of the presets, of the front and, if there is room, of others.
    fn pictures(&mut self, bench: &Bench) -> Result<(), Trouble> {
        let (size, frames) = (self.request.size, self.request.frames);
        let scene = self.last();
        let mut shown = Vec::new();
        for index in pictured(scene) {
            shown.push((index, bench.show(&scene.points[index].setting, frames)?));
        }
        let errors: Vec<Vec<f32>> = shown
            .par_iter()
            .map(|(_, last)| match last.picture == *last.full {
                true => vec![0.0; last.full.len() / 4],
                false => {
                    let [full, own] = [&last.full, &last.picture].map(|p| Shown::new(size, p));
                    metrics::flip(full, own).errors
                }
            })
            .collect();
        let window = pictures::window(size, &errors);
        let settings = shown.iter().map(|(index, _)| &scene.points[*index].setting);
        let most: Vec<Rate> = settings
            .map(|setting| match setting.quality {
                Quality::Exact => Rate::R1X1,
                Quality::Adaptive => largest(setting.largest),
            })
            .collect();
        let made: Vec<_> = shown
            .par_iter()
            .zip(errors.par_iter().zip(&most))
            .map(|((index, last), (errors, &most))| {
                let pictures = pictures::of_frame(size, last, most, errors, window);
                (*index, pictures)
            })
            .collect();
        let full = bench.full(Bench::last(frames))?;
        scene.close = pictures::close(size, &full, window);
        for (index, pictures) in made {
            scene.points[index].pictures = pictures;
        }
        Ok(())
    }

    /// Writes all files.
    fn write(&mut self) -> Result<(), Trouble> {
        let wanted = self.request.scenes.len();
        self.study.unfinished = (self.finished < wanted).then(|| {
            format!(
                "This study is not finished: {} of {wanted} scenes are. The same command goes on.",
                self.finished
            )
        });
        self.study.summary = summary::of(&self.study.scenes);
        let study = &self.study;
        for (name, text) in [
            ("report.html", report::html(study)),
            ("points.csv", report::csv(study)),
            ("passes.csv", report::passes_csv(study)),
            ("study.json", report::json(study)),
            ("plot.svg", plot::svg(study)),
            ("presets.toml", chosen::toml(study)),
        ] {
            let path = self.request.out.join(name);
            atomic::write(&path, text.as_bytes()).map_err(|error| unwritable(&path, &error))?;
        }
        Ok(())
    }
}
