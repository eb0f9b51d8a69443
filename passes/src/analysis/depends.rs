//! What a value depends on: which axes of the invocation grid, data, state.
//!
//! Two invocations that agree in what a value depends on agree in the value. A value that depends on nothing is the
//! primary's and its duplicates' alike and is captured; one that depends on ids alone is computed anew for a
//! duplicate; one that depends on state cannot be.
//!
//! *Guarantees*: control counts. A value chosen by a condition depends on what the condition depends on; a value that
//! a loop leaves behind depends on what decided when the loop was left.

use bitflags::bitflags;
use rustc_hash::FxHashMap;

use super::{
    Facts,
    term::{Id, LoopVariable, Term, TermId, Terms},
};

bitflags! {
    /// What a value depends on.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Depends: u8 {
        /// The first axis of the invocation grid.
        const X = 1;
        /// The second axis.
        const Y = 2;
        /// The third axis.
        const Z = 4;
        /// Memory that the shader only reads, at a place that depends on the ids.
        const DATA = 8;
        /// Something that cannot be computed a second time: memory that the shader writes, the result of an atomic.
        const STATE = 16;
        /// All axes.
        const IDS = 7;
    }
}

impl Depends {
    /// Whether the value differs between invocations by their ids alone.
    pub fn on_ids_alone(self) -> bool {
        !self.is_empty() && Depends::IDS.contains(self)
    }

    fn axis(axis: u8) -> Depends {
        [Depends::X, Depends::Y, Depends::Z][axis as usize]
    }
}

/// Answers what terms depend on.
pub struct Dependence<'f> {
    facts: &'f Facts,
    known: FxHashMap<TermId, Depends>,
    /// The order in which answers were found, so that those found under an assumption can be taken back.
    found: Vec<TermId>,
}

impl<'f> Dependence<'f> {
    /// Nothing is known yet.
    pub fn new(facts: &'f Facts) -> Dependence<'f> {
        Dependence {
            facts,
            known: FxHashMap::default(),
            found: Vec::new(),
        }
    }

    /// What a term depends on.
    pub fn of(&mut self, terms: &mut Terms, id: TermId) -> Depends {
        if let Some(&known) = self.known.get(&id) {
            return known;
        }
        if let Term::LoopVar { of, var, part } = terms.get(id).clone() {
            return self.of_loop_variable(terms, id, (of.0, var), &part);
        }
        let depends = self.compute(terms, id);
        self.learn(id, depends);
        depends
    }

    fn learn(&mut self, id: TermId, depends: Depends) {
        if self.known.insert(id, depends).is_none() {
            self.found.push(id);
        }
    }

    /// The least fixed point: assume what holds before the loop, and widen until an iteration adds nothing.
    fn of_loop_variable(
        &mut self,
        terms: &mut Terms,
        id: TermId,
        (of, var): (u32, u32),
        part: &[u32],
    ) -> Depends {
        let LoopVariable { before, next, .. } =
            terms.loops[of as usize].variables[var as usize].clone();
        let before = terms.project(before, part);
        let mut assumed = self.of(terms, before);
        let Some(next) = next else {
            self.learn(id, assumed);
            return assumed;
        };
        let next = terms.project(next, part);
        loop {
            self.learn(id, assumed);
            let mark = self.found.len();
            let widened = assumed | self.of(terms, next);
            if widened == assumed {
                return assumed;
            }
            for taken_back in self.found.split_off(mark) {
                self.known.remove(&taken_back);
            }
            self.known.insert(id, widened);
            assumed = widened;
        }
    }

    fn compute(&mut self, terms: &mut Terms, id: TermId) -> Depends {
        let own = match *terms.get(id) {
            Term::Id(Id::Global(axis) | Id::Local(axis) | Id::Group(axis)) => Depends::axis(axis),
            Term::Id(Id::LocalIndex) => Depends::IDS,
            Term::Opaque { .. } => Depends::STATE,
            Term::LoopExit { of, var, ref part } => {
                let part = part.clone();
                return self.of_loop_exit(terms, (of.0, var), &part);
            }
            Term::Call(function, _) => {
                if let Some(&expansion) = terms.expansions.get(&id) {
                    return self.of(terms, expansion);
                }
                let operands = self.of_operands(terms, id);
                return if self.facts.function(function).reads_memory {
                    fetched(operands)
                } else {
                    operands
                };
            }
            Term::Load(..) | Term::Original { .. } => {
                return fetched(self.of_operands(terms, id));
            }
            _ => Depends::empty(),
        };
        own | self.of_operands(terms, id)
    }

    fn of_operands(&mut self, terms: &mut Terms, id: TermId) -> Depends {
        let mut operands = Vec::new();
        terms.operands(id, &mut |operand| operands.push(operand));
        operands.into_iter().fold(Depends::empty(), |all, operand| {
            all | self.of(terms, operand)
        })
    }

    fn of_loop_exit(&mut self, terms: &mut Terms, (of, var): (u32, u32), part: &[u32]) -> Depends {
        let of = &terms.loops[of as usize];
        let conditions = of.conditions.clone();
        let after = of.variables[var as usize].after.clone();
        let mut depends = Depends::empty();
        for condition in conditions {
            depends |= self.of(terms, condition);
        }
        for value in after {
            let value = terms.project(value, part);
            depends |= self.of(terms, value);
        }
        depends
    }
}

/// What is fetched from a place that depends on the ids is data.
fn fetched(place: Depends) -> Depends {
    if place.is_empty() {
        place
    } else {
        place | Depends::DATA
    }
}
