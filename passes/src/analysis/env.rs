//! What every variable holds at the point that the walk has reached.
//!
//! Changes are journalled, so that a branch can be walked, its changes taken off as a list, and the other branch walked
//! from the same start.

use naga::{GlobalVariable, Handle, LocalVariable};
use rustc_hash::FxHashMap;

use super::term::{TermId, Terms};

/// A variable whose value the walk follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Variable {
    /// A local variable of one call.
    Local {
        /// The call.
        frame: u32,
        /// The variable.
        local: Handle<LocalVariable>,
    },
    /// A `var<private>`.
    Private(Handle<GlobalVariable>),
}

/// Values of variables, in the order of first change.
pub type Changes = Vec<(Variable, TermId)>;

/// The state of all variables.
#[derive(Default)]
pub struct Env {
    values: FxHashMap<Variable, TermId>,
    journal: Vec<(Variable, Option<TermId>)>,
}

impl Env {
    /// The value of a variable that has been set.
    pub fn get(&self, variable: Variable) -> Option<TermId> {
        self.values.get(&variable).copied()
    }

    /// Sets a variable.
    pub fn set(&mut self, variable: Variable, value: TermId) {
        let before = self.values.insert(variable, value);
        if before != Some(value) {
            self.journal.push((variable, before));
        }
    }

    /// A point to come back to.
    pub fn mark(&self) -> usize {
        self.journal.len()
    }

    /// What has changed since a mark.
    pub fn changes_since(&self, mark: usize) -> Changes {
        let mut changes = Changes::new();
        for &(variable, _) in &self.journal[mark..] {
            if !changes.iter().any(|&(known, _)| known == variable)
                && let Some(value) = self.get(variable)
            {
                changes.push((variable, value));
            }
        }
        changes
    }

    /// Goes back to a mark; what had changed since.
    pub fn rewind(&mut self, mark: usize) -> Changes {
        let changes = self.changes_since(mark);
        for (variable, before) in self.journal.split_off(mark).into_iter().rev() {
            match before {
                Some(before) => self.values.insert(variable, before),
                None => self.values.remove(&variable),
            };
        }
        changes
    }

    /// Makes changes.
    pub fn apply(&mut self, changes: &[(Variable, TermId)]) {
        for &(variable, value) in changes {
            self.set(variable, value);
        }
    }

    /// Joins two branches: each variable that either has changed gets `select(condition, accept, reject)`.
    pub fn join(
        &mut self,
        terms: &mut Terms,
        condition: TermId,
        accept: &[(Variable, TermId)],
        reject: &[(Variable, TermId)],
    ) {
        for variable in changed([accept, reject]) {
            // what only one branch has ever set belongs to a call inside that branch, and is gone
            let both = (self.after(accept, variable), self.after(reject, variable));
            if let (Some(a), Some(b)) = both {
                let joined = terms.select(condition, a, b);
                self.set(variable, joined);
            }
        }
    }

    /// The value of a variable after changes that have not been made.
    pub fn after(&self, changes: &[(Variable, TermId)], variable: Variable) -> Option<TermId> {
        changes
            .iter()
            .find(|&&(changed, _)| changed == variable)
            .map(|&(_, value)| value)
            .or_else(|| self.get(variable))
    }
}

/// The variables in any of several lists of changes, each once.
pub fn changed<'c>(lists: impl IntoIterator<Item = &'c [(Variable, TermId)]>) -> Vec<Variable> {
    let mut variables = Vec::new();
    for &(variable, _) in lists.into_iter().flatten() {
        if !variables.contains(&variable) {
            variables.push(variable);
        }
    }
    variables
}
