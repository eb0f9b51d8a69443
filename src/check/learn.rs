//! Learns what the original does with a set of inputs: what it writes, which invocation stores where, which pixels belong
//! to its domain.
//!
//! *Refuses* (inconclusive): an original that differs from itself, that behaves differently while it is watched, or whose
//! invocations store to one place.

use std::collections::{BTreeMap, HashMap};

use naga::{Handle, valid::GlobalUse};
use vrcs_passes::{
    graded::Given,
    instrument::{self, Instrumented, LogSize, Shape},
    options::Policy,
};

use super::{
    compare::Original,
    given::Answered,
    inputs::{Made, Maker, Seeds},
    reference::{AddressBook, Log, position, units},
    run::{Outputs, Program},
    session::{
        Session, Stop, inconclusive, initial_bytes, shape_of, texel_bytes, to_words, validated,
    },
};
use crate::dispatch::reflect::{self, Resource};

/// Runs with other data, from which the shader's addresses and its domain are learnt. In the last one floats that are only read
/// reach over the whole picture, to either side of 0: so `if depth[i] < f32(id.y)` is not taken for a condition of row 0's own.
const DATA_SETS: u64 = 3;
/// Stores of one invocation that are logged at first; a shader that makes more gets a larger log.
const FIRST_SLOTS: u32 = 8;
/// More stores of one invocation than this are not followed.
const MOST_SLOTS: u32 = 1024;

/// A set of inputs, and everything that was learnt of the original with it.
pub(super) struct Set {
    pub(super) made: Vec<Made>,
    pub(super) immediates: Vec<u8>,
    /// Workgroups of the original dispatch.
    pub(super) groups: [u32; 3],
    pub(super) original: Original,
    /// Outputs under each uniform rate, for the law of locality.
    pub(super) uniform: Vec<Uniform>,
    /// What the original did with constant answers to what its pixel shares.
    pub(super) answered: BTreeMap<Given, Answered>,
    /// What it stored in all runs, and the sizes of the textures that its sites store to.
    pub(super) logs: Vec<Log>,
    pub(super) textures: Vec<Option<[u32; 3]>>,
    /// All invocations of the original dispatch, and how many stores of one are logged.
    pub(super) dispatched: usize,
    pub(super) slots: u32,
}

/// What the rewritten shader wrote under one rate everywhere.
pub(super) struct Uniform {
    /// The effective map, for an extent.
    pub(super) map: Vec<u32>,
    pub(super) extent: [u32; 2],
    /// What each invocation was told that it shares.
    pub(super) answers: Vec<Given>,
    pub(super) outputs: Outputs,
}

/// One run of the original.
struct Run {
    made: Vec<Made>,
    outputs: Outputs,
    log: Log,
}

/// The builds that are watched, and the dispatch that they get; the same for every set.
pub(super) struct Watch {
    resources: Vec<Resource>,
    /// Workgroups, and invocations, of the original dispatch.
    groups: [u32; 3],
    grid: [u32; 3],
    /// All invocations of it, those outside the picture included.
    dispatched: usize,
    plain: Program,
    /// The build that logs, for so many stores of an invocation.
    logging: Option<(u32, Instrumented, Program)>,
    slots: u32,
}

impl Watch {
    /// Leaves one layer of workgroups to the dispatch.
    fn flatten(&mut self, group_size: [u32; 3]) {
        self.dispatched /= self.groups[2] as usize;
        self.grid[2] /= self.groups[2];
        self.groups[2] = 1;
        debug_assert_eq!(self.grid[2], group_size[2]);
        self.logging = None;
    }
}

impl Session<'_> {
    /// Makes what the original is watched with.
    pub(super) fn watch(&mut self, group_size: [u32; 3]) -> Result<Watch, Stop> {
        let layers = self.layers();
        self.maker().check_names().map_err(Stop::Input)?;
        let [width, height] = self.job.size;
        let is_line = self.job.options.linear.is_some();
        let groups = match is_line {
            true => [(width * height).div_ceil(group_size[0]), 1, 1],
            false => [
                width.div_ceil(group_size[0]),
                height.div_ceil(group_size[1]),
                layers.div_ceil(group_size[2]),
            ],
        };
        let sides: [u32; 3] = std::array::from_fn(|axis| groups[axis] * group_size[axis]);
        let immediates = self.maker().immediates(0, 0);
        let dispatched: usize = sides.iter().map(|&n| n as usize).product();
        // of a large picture fewer, so that the log can be bound
        let room = self.gpu.device.limits().max_storage_buffer_binding_size;
        let fits = |slots: u32| {
            let words = LogSize {
                grid: [1; 3],
                slots,
            }
            .words_each();
            dispatched as u64 * u64::from(words) * 4 <= room
        };
        let slots = [FIRST_SLOTS, FIRST_SLOTS / 2, FIRST_SLOTS / 4]
            .into_iter()
            .find(|&slots| fits(slots))
            .unwrap_or(1);
        Ok(Watch {
            resources: reflect::resources(self.module, self.info, self.entry)?,
            groups,
            // what is numbered row by row is logged row by row
            grid: match is_line {
                true => [width, height, 1],
                false => sides,
            },
            dispatched,
            plain: self.program("original", self.module, self.info, self.entry, &immediates)?,
            logging: None,
            slots,
        })
    }

    /// What becomes of a target's stores: what was asked for, and what the rewriter took where nothing was said.
    fn policy(&self, name: &str) -> Policy {
        if let Some(&asked_for) = self.job.options.targets.get(name) {
            return asked_for;
        }
        let targets = &self.rewritten.manifest.entries[0].targets;
        let target = targets.iter().find(|target| target.name == name);
        target.map_or_else(|| self.job.options.policy(name), |target| target.policy)
    }

    fn maker(&self) -> Maker<'_> {
        Maker::new(
            self.gpu,
            self.module,
            &self.job.settings,
            self.job.size,
            self.layers(),
        )
    }

    /// Makes up set number `number` of inputs and learns what the original does with it. The numbers in it are the more
    /// varied the larger `breadth` is.
    pub(super) fn learn(
        &mut self,
        watch: &mut Watch,
        number: u32,
        breadth: u32,
    ) -> Result<Set, Stop> {
        let uniforms = self.job.seed.wrapping_add(u64::from(number) * 7919);
        let immediates = self.maker().immediates(uniforms, breadth);
        let runs = loop {
            let runs = self.watch_runs(watch, uniforms, breadth, &immediates)?;
            let most = runs.iter().map(|run| run.log.most).max().unwrap_or(0);
            if most <= watch.slots {
                break runs;
            }
            if most > MOST_SLOTS {
                return Err(inconclusive(format!(
                    "an invocation makes {most} stores; at most {MOST_SLOTS} are followed"
                )));
            }
            watch.slots = most.next_power_of_two();
        };
        let Some((_, logging, _)) = &watch.logging else {
            unreachable!("the runs were logged");
        };
        for run in &runs {
            if let Some(site) = run.log.exchanged_outside(&logging.sites) {
                return Err(inconclusive(format!(
                    "the original exchanges something outside its resource{}, so what it gets is chance",
                    self.at(site.span)
                )));
            }
            if let Some(race) = run.log.race(&logging.sites) {
                let [a, b] = race.invocations.map(|i| position(i, watch.grid));
                let site = &logging.sites[race.site as usize];
                // layers that one invocation goes through itself are none of the dispatch's
                if a[..2] == b[..2] && watch.groups[2] > 1 {
                    watch.flatten(self.group_size);
                    return self.learn(watch, number, breadth);
                }
                return Err(inconclusive(format!(
                    "the original's invocations {a:?} and {b:?} store to one place{}, so what it holds is chance",
                    self.at(site.span)
                )));
            }
        }
        let sites = logging.sites.clone();
        let mut runs = runs.into_iter();
        let Some(first) = runs.next() else {
            unreachable!("at least one set of data was tried");
        };
        let logs: Vec<Log> = std::iter::once(first.log)
            .chain(runs.map(|run| run.log))
            .collect();
        let textures: Vec<Option<[u32; 3]>> = sites
            .iter()
            .map(|site| match shape_of(&first.made, site.global) {
                Some(Shape::Texture(size)) => Some(size),
                _ => None,
            })
            .collect();
        let original = self.original(&first.made, &logs, &textures, sites, first.outputs);
        self.note_seen(&original);
        Ok(Set {
            made: first.made,
            immediates,
            groups: watch.groups,
            original,
            uniform: Vec::new(),
            answered: BTreeMap::new(),
            logs,
            textures,
            dispatched: watch.dispatched,
            slots: watch.slots,
        })
    }

    /// Runs the original over several sets of data, plain and logged.
    fn watch_runs(
        &self,
        watch: &mut Watch,
        uniforms: u64,
        breadth: u32,
        immediates: &[u8],
    ) -> Result<Vec<Run>, Stop> {
        let uses = self.info.get_entry_point(self.entry);
        let written = |global: Handle<naga::GlobalVariable>| {
            uses[global].intersects(GlobalUse::WRITE | GlobalUse::ATOMIC)
        };
        let maker = self.maker();
        let mut runs = Vec::new();
        for data in 0..DATA_SETS {
            let seeds = Seeds {
                uniforms,
                data: uniforms.wrapping_mul(31).wrapping_add(data),
                breadth,
                reach: match data + 1 == DATA_SETS {
                    true => self.job.size[0].max(self.job.size[1]),
                    false => 0,
                },
            };
            let made = maker
                .make(&watch.resources, &written, seeds)
                .map_err(Stop::Input)?;
            let (log, logged) = self.run_logging(watch, &made, immediates)?;
            let sites = match &watch.logging {
                Some((_, logging, _)) => &logging.sites,
                None => unreachable!("just run"),
            };
            let settled = |outputs: &Outputs| without_chance(outputs, &made, &log, sites);
            let plain = || self.run_build(&watch.plain, &made, &[], immediates, watch.groups, &[]);
            let (outputs, _) = plain()?;
            let known = settled(&outputs);
            if data == 0 && settled(&plain()?.0) != known {
                return Err(inconclusive(
                    "the original differs from itself, run after run",
                ));
            }
            if settled(&logged) != known {
                return Err(inconclusive(
                    "the original behaves differently while it is watched",
                ));
            }
            runs.push(Run { made, outputs, log });
        }
        Ok(runs)
    }

    fn run_logging(
        &self,
        watch: &mut Watch,
        made: &[Made],
        immediates: &[u8],
    ) -> Result<(Log, Outputs), Stop> {
        let size = LogSize {
            grid: watch.grid,
            slots: watch.slots,
        };
        if watch
            .logging
            .as_ref()
            .is_none_or(|(slots, ..)| *slots != watch.slots)
        {
            let shape = |global| shape_of(made, global);
            let logging = instrument::log_stores(self.module, self.info, self.entry, size, &shape);
            let info = validated(&logging.module);
            let program =
                self.program("original, logged", &logging.module, &info, 0, immediates)?;
            watch.logging = Some((watch.slots, logging, program));
        }
        let Some((_, logging, program)) = &watch.logging else {
            unreachable!("just made");
        };
        let words = vec![0u8; watch.dispatched * size.words_each() as usize * 4];
        let buffer = self.gpu.buffer("log", &words, wgpu::BufferUsages::STORAGE);
        let extras = [(logging.binding, &buffer)];
        let (outputs, read) =
            self.run_build(program, made, &extras, immediates, watch.groups, &[&buffer])?;
        let words = to_words(&read[0]);
        Ok((Log::new(&words[..size.words() as usize], size), outputs))
    }

    fn original(
        &self,
        made: &[Made],
        logs: &[Log],
        textures: &[Option<[u32; 3]>],
        sites: Vec<instrument::Site>,
        outputs: Outputs,
    ) -> Original {
        let written: Vec<&Made> = made.iter().filter(|made| made.written).collect();
        let output_of_site: Vec<usize> = sites
            .iter()
            .map(|site| {
                let found = written
                    .iter()
                    .position(|m| m.resource.global == site.global);
                found.unwrap_or_default()
            })
            .collect();
        let policies: Vec<Policy> = written
            .iter()
            .map(|made| self.policy(&made.resource.name))
            .collect();
        // what every pixel does for itself says nothing of who shades for whom
        let follows = |site: u32| policies[output_of_site[site as usize]] != Policy::Full;
        let stores = |log: &Log| -> Vec<bool> {
            (0..log.invocations())
                .map(|i| log.of(i).iter().any(|stored| follows(stored.site)))
                .collect()
        };
        let each: Vec<Vec<bool>> = logs.iter().map(stores).collect();
        let stores_ever = (0..each[0].len())
            .map(|i| each.iter().any(|run| run[i]))
            .collect();
        let mut owners = vec![HashMap::new(); written.len()];
        for log in logs {
            for invocation in 0..log.invocations() {
                for stored in log.of(invocation) {
                    let site = &sites[stored.site as usize];
                    if stored.place == instrument::OUTSIDE || site.atomic.is_some() {
                        continue;
                    }
                    let owners = &mut owners[output_of_site[stored.site as usize]];
                    owners.extend(units(site, stored.place).map(|unit| (unit, invocation)));
                }
            }
        }
        // what never ran at all may run for any pixel, for other data
        let is_reached = |site: usize| logs.iter().any(|log| log.reaches(site as u32));
        let depends_on_data =
            each.iter().any(|run| *run != each[0]) || !(0..sites.len()).all(is_reached);
        let chance = written
            .iter()
            .map(|made| {
                logs.iter()
                    .flat_map(|log| log.chance(&sites, made.resource.global))
                    .collect()
            })
            .collect();
        let initial = written
            .iter()
            .map(|made| {
                let mut bytes = initial_bytes(made);
                self.canonicalise(made, &mut bytes);
                bytes
            })
            .collect();
        Original {
            size: self.job.size,
            book: AddressBook::new(logs, textures),
            stores_ever,
            owners,
            depends_on_data,
            log: match logs.first() {
                Some(first) => first.clone(),
                None => unreachable!("at least one run"),
            },
            sites,
            output_of_site,
            outputs,
            initial,
            chance,
            texel_bytes: written.iter().map(|made| texel_bytes(made)).collect(),
            policies,
        }
    }

    /// The layers of arrayed and 3-D targets, and the depth of the dispatch.
    fn layers(&self) -> u32 {
        let uses = self.info.get_entry_point(self.entry);
        let is_layered =
            |(handle, global): (Handle<naga::GlobalVariable>, &naga::GlobalVariable)| {
                matches!(
                    self.module.types[global.ty].inner,
                    naga::TypeInner::Image {
                        dim: naga::ImageDimension::D3,
                        class: naga::ImageClass::Storage { .. },
                        ..
                    } | naga::TypeInner::Image {
                        arrayed: true,
                        class: naga::ImageClass::Storage { .. },
                        ..
                    }
                ) && uses[handle].contains(GlobalUse::WRITE)
            };
        match self.module.global_variables.iter().any(is_layered) {
            true => 3,
            false => 1,
        }
    }
}

/// Outputs with zeros where what was stored is chance.
fn without_chance(
    outputs: &Outputs,
    made: &[Made],
    log: &Log,
    sites: &[instrument::Site],
) -> Outputs {
    let mut outputs = outputs.clone();
    let written = made.iter().filter(|made| made.written);
    for (made, bytes) in written.zip(&mut outputs) {
        for unit in log.chance(sites, made.resource.global) {
            let at = unit as usize * 2;
            if let Some(bytes) = bytes.get_mut(at..at + 2) {
                bytes.fill(0);
            }
        }
    }
    outputs
}
