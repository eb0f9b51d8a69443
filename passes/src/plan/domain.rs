//! The shader's domain: the pixels for which it stores anything at all, as far as ids and uniforms tell.
//!
//! A guard such as `if any(gid.xy >= size) { return; }` keeps invocations from storing. A duplicate outside the domain
//! must get no copy, and a primary outside it would leave its whole group without one, so the domain is asked for
//! every member of a group, and a group whose primary lies outside is re-homed to its first member inside.
//!
//! *Does*: takes the conditions on the way to each store, forgets those that are not made of ids and uniforms alone (they
//! are taken to hold; those that loop counters have a part in [come to](super::iterations) at least one iteration in which they
//! hold), and joins the stores: what all have in common, and at least one of what is left of each.
//! *Guarantees*: the domain holds every pixel that stores.

use super::Planner;
use crate::analysis::{
    depends::Depends,
    guard::{Formula, flatten},
    term::TermId,
};

/// The domain.
pub(super) struct Domain {
    /// What every pixel of it fulfils.
    pub(super) shared: Vec<Formula>,
    /// What all stores have in common.
    pub(super) common: Vec<Formula>,
}

impl Planner<'_> {
    /// The domain of the entry point.
    pub(super) fn domain(&mut self) -> Domain {
        let mut of_stores = Vec::new();
        for index in self.stores() {
            let guards = self.access(index).guards.clone();
            // uniform conditions count: where one keeps a store from running, the pixels that only it has are outside
            let mut known = self.relaxed(&guards, |planner, condition| {
                planner.is_known(condition) && planner.is_computable_up_front(condition)
            });
            known.extend(self.over_iterations(&guards));
            of_stores.push(known);
        }
        let Some((first, rest)) = of_stores.split_first() else {
            return Domain {
                shared: Vec::new(),
                common: Vec::new(),
            };
        };
        let common: Vec<Formula> = first
            .iter()
            .filter(|formula| rest.iter().all(|other| other.contains(formula)))
            .cloned()
            .collect();
        let left: Vec<Formula> = of_stores
            .iter()
            .map(|formulas| {
                let left = formulas.iter().filter(|f| !common.contains(f)).cloned();
                Formula::All(left.collect())
            })
            .collect();
        let mut shared = common.clone();
        let open = left.iter().any(|left| *left == Formula::All(Vec::new()));
        if !open && !exhausts(&left) {
            shared.push(Formula::Any(left));
        }
        // what is uniform is the same for all members of a group, and the shader's own guard asks for it
        shared.retain(|formula| self.is_any_positional(formula));
        Domain { shared, common }
    }

    /// The conditions that satisfy `keep`, split into conjuncts; the others are taken to hold.
    pub(super) fn relaxed(
        &mut self,
        guards: &[Formula],
        keep: impl Fn(&mut Self, TermId) -> bool,
    ) -> Vec<Formula> {
        let mut conjuncts = Vec::new();
        flatten(guards, &mut self.found.terms, &mut conjuncts);
        conjuncts
            .iter()
            .filter_map(|formula| formula.relaxed(&mut |condition| keep(self, condition)))
            .collect()
    }

    /// Whether a condition depends on nothing but ids and uniforms.
    pub(super) fn is_known(&mut self, condition: TermId) -> bool {
        Depends::IDS.contains(self.on.of(&mut self.found.terms, condition))
    }

    /// Whether any condition of a formula depends on the ids.
    fn is_any_positional(&mut self, formula: &Formula) -> bool {
        let mut conditions = Vec::new();
        formula.conditions(&mut |condition| conditions.push(condition));
        conditions
            .into_iter()
            .any(|condition| self.is_positional(condition))
    }

    /// Whether a condition depends on the ids, and on nothing else but uniforms.
    pub(super) fn is_positional(&mut self, condition: TermId) -> bool {
        let depends: Depends = self.on.of(&mut self.found.terms, condition);
        depends.on_ids_alone()
    }
}

/// Whether one of several conditions always holds, because two of them are a condition and its opposite.
fn exhausts(ways: &[Formula]) -> bool {
    let single = |formula: &Formula| match formula {
        Formula::All(parts) => match parts.as_slice() {
            [Formula::Is(condition, holds)] => Some((*condition, *holds)),
            _ => None,
        },
        _ => None,
    };
    ways.iter().filter_map(single).any(|(condition, holds)| {
        ways.iter()
            .filter_map(single)
            .any(|other| other == (condition, !holds))
    })
}
