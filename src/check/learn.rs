//! Learns what the original does with a set of inputs: what it writes, which invocation stores where, which pixels belong
//! to its domain.
//!
//! *Refuses* (inconclusive): an original that differs from itself, that behaves differently while it is watched, or whose
//! invocations store to one place.

use naga::{Handle, valid::GlobalUse};
use vrcs_passes::instrument::{self, Instrumented, LogSize, Shape};

use super::{
    compare::Original,
    inputs::{Made, Maker, Seeds},
    reference::{AddressBook, Log, position},
    run::Outputs,
    session::{
        Session, Stop, inconclusive, initial_bytes, shape_of, texel_bytes, to_words, validated,
    },
};
use crate::dispatch::reflect;

/// Runs with other data, from which the shader's addresses and its domain are learnt.
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
    /// Outputs under each uniform rate, by the map that it gives, for the law of locality.
    pub(super) uniform: Vec<(Vec<u32>, [u32; 2], Outputs)>,
}

impl Session<'_> {
    /// Makes up a set of inputs and learns what the original does with it.
    pub(super) fn learn(&mut self, number: u32, group_size: [u32; 3]) -> Result<Set, Stop> {
        let layers = self.layers();
        let maker = Maker::new(
            self.gpu,
            self.module,
            &self.job.settings,
            self.job.size,
            layers,
        );
        maker.check_names().map_err(Stop::Input)?;
        let resources = reflect::resources(self.module, self.info, self.entry)?;
        let uses = self.info.get_entry_point(self.entry);
        let written = |global: Handle<naga::GlobalVariable>| {
            uses[global].intersects(GlobalUse::WRITE | GlobalUse::ATOMIC)
        };
        let uniforms = self.job.seed.wrapping_add(u64::from(number) * 7919);
        let immediates = maker.immediates(uniforms);
        let [width, height] = self.job.size;
        let groups = [
            width.div_ceil(group_size[0]),
            height.div_ceil(group_size[1]),
            layers.div_ceil(group_size[2]),
        ];
        let grid = std::array::from_fn(|axis| groups[axis] * group_size[axis]);

        let plain = self.program("original", self.module, self.info, self.entry, &immediates)?;
        let mut logs = Vec::new();
        let mut first: Option<(Vec<Made>, Outputs)> = None;
        let mut slots = FIRST_SLOTS;
        let mut data = 0;
        let mut sites = Vec::new();
        while data < DATA_SETS {
            let seeds = Seeds {
                uniforms,
                data: uniforms.wrapping_mul(31).wrapping_add(data),
            };
            let made = maker
                .make(&resources, &written, seeds)
                .map_err(Stop::Input)?;
            let (outputs, _) = self.run_build(&plain, &made, &[], &immediates, groups, &[])?;
            if data == 0 && first.is_none() {
                let (again, _) = self.run_build(&plain, &made, &[], &immediates, groups, &[])?;
                if again != outputs {
                    return Err(inconclusive(
                        "the original differs from itself, run after run",
                    ));
                }
            }
            let size = LogSize { grid, slots };
            let shape = |global| shape_of(&made, global);
            let logging = instrument::log_stores(self.module, self.info, self.entry, size, &shape);
            let (log, logged) = self.run_logging(&logging, &made, &immediates, groups, size)?;
            if logged != outputs {
                return Err(inconclusive(
                    "the original behaves differently while it is watched",
                ));
            }
            if log.most > slots {
                if log.most > MOST_SLOTS {
                    return Err(inconclusive(format!(
                        "an invocation makes {} stores; at most {MOST_SLOTS} are followed",
                        log.most
                    )));
                }
                slots = log.most.next_power_of_two();
                (logs, first, data) = (Vec::new(), None, 0);
                continue;
            }
            if let Some(race) = log.race(&logging.sites) {
                let [a, b] = race.invocations.map(|i| position(i, grid));
                let site = &logging.sites[race.site as usize];
                return Err(inconclusive(format!(
                    "the original's invocations {a:?} and {b:?} store to one place{}, so what it holds is chance",
                    self.at(site.span)
                )));
            }
            sites = logging.sites;
            if first.is_none() {
                first = Some((made, outputs));
            }
            logs.push(log);
            data += 1;
        }
        let Some((made, outputs)) = first else {
            unreachable!("at least one set of data was tried");
        };
        let original = self.original(&made, logs, sites, outputs);
        self.note_seen(&original);
        Ok(Set {
            made,
            immediates,
            groups,
            original,
            uniform: Vec::new(),
        })
    }

    fn original(
        &self,
        made: &[Made],
        logs: Vec<Log>,
        sites: Vec<instrument::Site>,
        outputs: Outputs,
    ) -> Original {
        let written: Vec<&Made> = made.iter().filter(|made| made.written).collect();
        let output_of_site = sites
            .iter()
            .map(|site| {
                let found = written
                    .iter()
                    .position(|m| m.resource.global == site.global);
                found.unwrap_or_default()
            })
            .collect();
        let textures: Vec<Option<[u32; 3]>> = sites
            .iter()
            .map(|site| match shape_of(made, site.global) {
                Some(Shape::Texture(size)) => Some(size),
                _ => None,
            })
            .collect();
        let stores = |log: &Log| -> Vec<bool> {
            (0..log.invocations())
                .map(|i| !log.of(i).is_empty())
                .collect()
        };
        let each: Vec<Vec<bool>> = logs.iter().map(stores).collect();
        let stores_ever = (0..each[0].len())
            .map(|i| each.iter().any(|run| run[i]))
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
            book: AddressBook::new(&logs, &textures),
            stores_ever,
            depends_on_data: each.iter().any(|run| *run != each[0]),
            log: logs
                .into_iter()
                .next()
                .unwrap_or_else(|| unreachable!("at least one run")),
            sites,
            output_of_site,
            outputs,
            initial,
            texel_bytes: written.iter().map(|made| texel_bytes(made)).collect(),
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

    fn run_logging(
        &self,
        logging: &Instrumented,
        made: &[Made],
        immediates: &[u8],
        groups: [u32; 3],
        size: LogSize,
    ) -> Result<(Log, Outputs), Stop> {
        let info = validated(&logging.module);
        let program = self.program("original, logged", &logging.module, &info, 0, immediates)?;
        let words = vec![0u8; size.words() as usize * 4];
        let buffer = self.gpu.buffer("log", &words, wgpu::BufferUsages::STORAGE);
        let extras = [(logging.binding, &buffer)];
        let (outputs, read) =
            self.run_build(&program, made, &extras, immediates, groups, &[&buffer])?;
        let words = to_words(&read[0]);
        Ok((Log::new(&words[..size.words() as usize], size), outputs))
    }
}
