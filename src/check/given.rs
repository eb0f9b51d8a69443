//! Checks shaders that ask `vrcs_copies()`, `vrcs_rate()` and `vrcs_user()`.
//!
//! The original's stubs say that nothing is shared, so what it does is no reference for a pixel that shares. *Does*: runs the
//! original with stubs that give constants, once for each answer that occurs in a case; and puts together, invocation by
//! invocation, what each does with the answer that is due to it. In the copying modes that is the smallest aligned block that holds
//! its group, confined to the extent and the domain; in graded mode also the number of the others. The user's own bits are made up
//! for each tile; a shader may leave by them.
//!
//! *Guarantees*: the answers come from the effective map of the CPU twin, never from the prelude or the buffers that it reads.
//! *Refuses* (inconclusive): a shader that stores at all or not by what it is told of its group, or where data tells which pixels
//! store.

use std::collections::BTreeMap;

use vrcs_passes::{
    graded::{self, Given},
    instrument::{self, LogSize},
    options::{Mode, Policy},
};

use super::{
    compare::{Group, Original},
    learn::Set,
    reference::{AddressBook, Log, position, units},
    run::{Outputs, Program},
    session::{Case, Session, Stop, inconclusive, shape_of, to_words, validated},
};

/// The originals with constant answers, by their answers; the same for every set.
#[derive(Default)]
pub(super) struct Asked {
    programs: BTreeMap<Given, (u32, naga::ResourceBinding, Program)>,
}

/// What the original did with a set of inputs and a constant answer.
pub(super) struct Answered {
    log: Log,
    outputs: Outputs,
}

impl Asked {
    /// What is needed for a shader that asks; `None` for one that does not.
    pub(super) fn of(session: &Session) -> Option<Asked> {
        graded::asks(session.module, session.entry).then(Asked::default)
    }
}

impl Session<'_> {
    /// For each invocation, the answer that is due to it in a case.
    fn answers(&self, original: &Original, case: &Case) -> Result<Vec<Given>, Stop> {
        let grid = original.log.grid();
        let at = |[x, y]: [u32; 2], z: u32| ((z * grid[1] + y) * grid[0] + x) as usize;
        // what lies in no group may run for itself, in its own tile
        let alone = |invocation: usize| {
            let [x, y, _] = position(invocation, grid);
            match x < case.extent[0] && y < case.extent[1] {
                true => Given::of_user(case.user_at([x, y])),
                false => Given::NOTHING,
            }
        };
        let mut answers: Vec<Given> = (0..original.log.invocations()).map(alone).collect();
        let is_graded = self.mode() == Mode::Graded;
        for z in 0..grid[2] {
            for group in &case.groups {
                let stores = |member: &[u32; 2]| original.stores_ever[at(*member, z)];
                let is_asked = is_graded || group.members.len() == 1;
                if !is_asked && original.depends_on_data && !group.members.iter().all(stores) {
                    return Err(inconclusive(
                        "data tells which pixels store, so which of them a rate is for is not known",
                    ));
                }
                let mut members = group.members.clone();
                if !is_asked {
                    members.retain(stores);
                }
                let given = Given {
                    copies: match is_graded {
                        true => members.len() as u32 - 1,
                        false => 0,
                    },
                    rate: [0, 1].map(|axis| block(members.iter().map(|member| member[axis]))),
                    user: case.user_at(group.primary),
                };
                for member in members {
                    answers[at(member, z)] = given;
                }
            }
        }
        Ok(answers)
    }

    /// Puts in the place of the original what it does with the answers of a case, and gives the plain one back. In graded mode
    /// the groups then fall apart: every pixel is shaded for itself.
    pub(super) fn answer(
        &mut self,
        asked: &mut Asked,
        set: &mut Set,
        case: &mut Case,
    ) -> Result<Original, Stop> {
        let plain = set.original.clone();
        self.heed_tiles(asked, set, case)?;
        case.answers = self.answers(&set.original, case)?;
        let mut wanted = case.answers.clone();
        wanted.sort_unstable();
        wanted.dedup();
        for given in wanted {
            if given == Given::NOTHING || set.answered.contains_key(&given) {
                continue;
            }
            self.note_answer(asked, set, given)?;
            // a tile's bits are the same for a whole group, so a shader may store or not by them
            let answered = &set.answered[&given].log;
            let alone = match given.user {
                0 => &set.original.log,
                user => &set.answered[&Given::of_user(user)].log,
            };
            let is_same = (0..answered.invocations())
                .all(|i| answered.of(i).is_empty() == alone.of(i).is_empty());
            if !is_same {
                return Err(inconclusive(
                    "whether a pixel stores depends on what it is told that it shares",
                ));
            }
        }
        let together = together(set, &case.answers);
        if together.log.race(&together.sites).is_some() {
            return Err(inconclusive(
                "where a pixel stores depends on what it is told that it shares",
            ));
        }
        self.note_seen(&together);
        if self.mode() == Mode::Graded {
            case.groups = case.groups.iter().flat_map(Group::apart).collect();
        }
        set.original = together;
        Ok(Original {
            book: set.original.book.clone(),
            ..plain
        })
    }

    /// Learns what the original does alone in tiles with the bits of a case, and which pixels store there.
    fn heed_tiles(&self, asked: &mut Asked, set: &mut Set, case: &Case) -> Result<(), Stop> {
        let [across, down, layers] = set.original.log.grid();
        for y in 0..case.extent[1].min(down) {
            for x in 0..case.extent[0].min(across) {
                let given = Given::of_user(case.user_at([x, y]));
                if given == Given::NOTHING {
                    continue;
                }
                if !set.answered.contains_key(&given) {
                    self.note_answer(asked, set, given)?;
                }
                for z in 0..layers {
                    let at = ((z * down + y) * across + x) as usize;
                    set.original.stores_ever[at] |= !set.answered[&given].log.of(at).is_empty();
                }
            }
        }
        Ok(())
    }

    /// Runs the original with a constant answer and notes what it did.
    fn note_answer(&self, asked: &mut Asked, set: &mut Set, given: Given) -> Result<(), Stop> {
        let answered = self.run_with(asked, set, given)?;
        set.logs.push(answered.log.clone());
        set.original.book = AddressBook::new(&set.logs, &set.textures);
        set.answered.insert(given, answered);
        Ok(())
    }

    /// Runs the original with a constant answer.
    fn run_with(&self, asked: &mut Asked, set: &Set, given: Given) -> Result<Answered, Stop> {
        let grid = set.original.log.grid();
        let mut slots = set.slots;
        loop {
            let size = LogSize { grid, slots };
            let is_known = asked
                .programs
                .get(&given)
                .is_some_and(|(known, ..)| *known >= slots);
            if !is_known {
                let module = graded::with_given(self.module, given);
                let info = validated(&module);
                let shape = |global| shape_of(&set.made, global);
                let logging = instrument::log_stores(&module, &info, self.entry, size, &shape);
                let info = validated(&logging.module);
                let label = format!("original, told {given:?}");
                let program = self.program(&label, &logging.module, &info, 0, &set.immediates)?;
                asked
                    .programs
                    .insert(given, (slots, logging.binding, program));
            }
            let (slots_there, binding, program) = &asked.programs[&given];
            let size = LogSize {
                slots: *slots_there,
                ..size
            };
            let words = vec![0; set.dispatched * size.words_each() as usize * 4];
            let buffer = self.gpu.buffer("log", &words, wgpu::BufferUsages::STORAGE);
            let extras = [(*binding, &buffer)];
            let (outputs, read) = self.run_build(
                program,
                &set.made,
                &extras,
                &set.immediates,
                set.groups,
                &[&buffer],
            )?;
            let words = to_words(&read[0]);
            let log = Log::new(&words[..size.words() as usize], size);
            if log.most <= *slots_there {
                return Ok(Answered { log, outputs });
            }
            slots = log.most.next_power_of_two();
        }
    }
}

/// What the original does where each invocation gets its own answer.
fn together(set: &Set, answers: &[Given]) -> Original {
    let mut together = set.original.clone();
    for (invocation, given) in answers.iter().enumerate() {
        let Some(answered) = set.answered.get(given) else {
            continue;
        };
        for stored in answered.log.of(invocation) {
            let site = &together.sites[stored.site as usize];
            let output = together.output_of_site[stored.site as usize];
            if stored.place == instrument::OUTSIDE || site.atomic.is_some() {
                continue;
            }
            // what runs for every pixel shares nothing, in whatever tile
            let answered = match (together.policies[output], given.user) {
                (Policy::Full, 0) => continue,
                (Policy::Full, user) => match set.answered.get(&Given::of_user(user)) {
                    Some(alone) => alone,
                    None => continue,
                },
                _ => answered,
            };
            let of = units(site, stored.place);
            let unit = together.unit(output);
            let bytes = of.start as usize * unit..of.end as usize * unit;
            let Some(from) = answered.outputs[output].get(bytes.clone()) else {
                continue;
            };
            together.outputs[output][bytes].copy_from_slice(from);
        }
        together
            .log
            .replace(invocation, answered.log.of(invocation).to_vec());
    }
    together
}

/// The side of the smallest aligned block that holds these, of 1, 2 or 4.
fn block(places: impl Iterator<Item = u32>) -> u32 {
    let (mut all, mut any) = (u32::MAX, 0);
    for place in places {
        all &= place;
        any |= place;
    }
    match all ^ any {
        0 | u32::MAX => 1,
        1 => 2,
        _ => 4,
    }
}
