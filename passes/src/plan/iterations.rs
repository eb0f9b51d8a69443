//! Conditions that a loop's counters have a part in, as conditions on ids and uniforms: one for each iteration.
//!
//! A shader that writes a block of texels in a loop guards each of them: `if all(id.xy * 2 + vec2(x, y) < size)`. Whether an invocation
//! stores at all is then a question of all iterations together. *Does*: counts the iterations of the loops around a store, where
//! their counters are numbers, and puts each iteration's numbers into the store's conditions; the invocation stores if one of
//! them holds. *Guarantees*: every invocation that stores fulfils the result. Where a loop's end is not a number, or is too far
//! off, there is no result, and the conditions are taken to hold.

use naga::Literal;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Planner;
use crate::analysis::{
    guard::{Formula, flatten},
    term::{LoopId, Term, TermId, Terms},
};

/// Iterations that are followed, of all loops around a store together.
const MOST_ITERATIONS: usize = 64;

/// The values of loop variables in an iteration.
#[derive(Default)]
struct Values {
    of: FxHashMap<(LoopId, u32), TermId>,
    /// What has been found with them: a term may be met on many paths.
    found: FxHashMap<TermId, Option<TermId>>,
}

impl Values {
    fn copy(&self) -> Values {
        Values {
            of: self.of.clone(),
            found: FxHashMap::default(),
        }
    }
}

/// The loops around a store, and what has been found of their iterations.
struct Iterations {
    /// From the outermost to the innermost.
    loops: Vec<LoopId>,
    conjuncts: Vec<Formula>,
    /// What has to hold in each iteration that may store.
    found: Vec<Formula>,
    followed: usize,
}

impl Planner<'_> {
    /// What the conditions of a store come to over all iterations of the loops around it; `None` if that is nothing, or not known.
    pub(super) fn over_iterations(&mut self, guards: &[Formula]) -> Option<Formula> {
        let mut conjuncts = Vec::new();
        flatten(guards, &mut self.found.terms, &mut conjuncts);
        let conjuncts: Vec<Formula> = conjuncts
            .iter()
            .filter_map(|formula| formula.relaxed(&mut |condition| self.is_known(condition)))
            .collect();
        let mut loops = Vec::new();
        let mut seen = FxHashSet::default();
        for formula in &conjuncts {
            formula.conditions(&mut |condition| {
                loops_in(&self.found.terms, condition, &mut loops, &mut seen);
            });
        }
        if loops.is_empty() {
            return None;
        }
        // a loop is met after those that it lies in
        loops.sort_unstable();
        let mut iterations = Iterations {
            loops,
            conjuncts,
            found: Vec::new(),
            followed: 0,
        };
        iterations.follow(&mut self.found.terms, 0, &mut Values::default())?;
        if iterations.found.contains(&Formula::All(Vec::new())) {
            return None;
        }
        let any = Formula::Any(iterations.found);
        let mut conditions = Vec::new();
        any.conditions(&mut |condition| conditions.push(condition));
        let is_computable = conditions
            .into_iter()
            .all(|condition| self.is_computable_up_front(condition));
        is_computable.then_some(any)
    }
}

impl Iterations {
    /// Follows the iterations of the loop at a depth, those around it being in the iteration that `values` tell. `None` if they
    /// cannot be followed.
    fn follow(&mut self, terms: &mut Terms, depth: usize, values: &mut Values) -> Option<()> {
        let Some(&of) = self.loops.get(depth) else {
            let conjuncts = self.conjuncts.clone();
            if let Some(formula) = Formula::All(conjuncts).with(terms, values)? {
                let is_new = !self.found.contains(&formula);
                is_new.then(|| self.found.push(formula));
            }
            return Some(());
        };
        let mut here = values.copy();
        let variables = terms.loops[of.index()].variables.clone();
        for (var, variable) in (0..).zip(&variables) {
            // a variable that no condition needs may be of any kind
            if let Some(before) = with(terms, variable.before, values) {
                here.of.insert((of, var), before);
            }
        }
        while !self.is_over(terms, of, &mut here)? {
            self.followed += 1;
            if self.followed > MOST_ITERATIONS {
                return None;
            }
            self.follow(terms, depth + 1, &mut here)?;
            let mut following = here.copy();
            for (var, variable) in (0..).zip(&variables) {
                following.of.remove(&(of, var));
                if let Some(next) = variable.next.and_then(|next| with(terms, next, &mut here)) {
                    following.of.insert((of, var), next);
                }
            }
            here = following;
        }
        Some(())
    }

    /// Whether the loop is left before this iteration reaches the store: by a condition of its own that comes out as a number.
    /// `None` if no such condition comes out as one, so that there is no telling when it ends.
    fn is_over(&self, terms: &mut Terms, of: LoopId, values: &mut Values) -> Option<bool> {
        let conditions = terms.loops[of.index()].conditions.clone();
        let mut is_told = false;
        for formula in &self.conjuncts {
            let Formula::Is(condition, holds) = *formula else {
                continue;
            };
            if !conditions.contains(&condition) {
                continue;
            }
            let now = with(terms, condition, values);
            let now = now.and_then(|now| terms.as_literal(now));
            if let Some(Literal::Bool(now)) = now {
                if now != holds {
                    return Some(true);
                }
                is_told = true;
            }
        }
        is_told.then_some(false)
    }
}

impl Formula {
    /// The formula in an iteration; `Some(None)` if it then cannot hold, `None` if it is not known.
    fn with(&self, terms: &mut Terms, values: &mut Values) -> Option<Option<Formula>> {
        match self {
            Formula::Is(condition, holds) => {
                let condition = with(terms, *condition, values)?;
                Some(match terms.as_literal(condition) {
                    Some(Literal::Bool(value)) => {
                        (value == *holds).then(|| Formula::All(Vec::new()))
                    }
                    _ => Some(Formula::Is(condition, *holds)),
                })
            }
            Formula::All(parts) => {
                let mut all = Vec::new();
                for part in parts {
                    match part.with(terms, values)? {
                        None => return Some(None),
                        Some(Formula::All(parts)) => all.extend(parts),
                        Some(part) => all.push(part),
                    }
                }
                Some(Some(Formula::All(all)))
            }
            Formula::Any(parts) => {
                let mut any = Vec::new();
                for part in parts {
                    match part.with(terms, values)? {
                        None => {}
                        Some(Formula::All(parts)) if parts.is_empty() => {
                            return Some(Some(Formula::All(parts)));
                        }
                        Some(part) => any.push(part),
                    }
                }
                Some((!any.is_empty()).then_some(Formula::Any(any)))
            }
        }
    }
}

/// The loops whose variables a term is made of.
fn loops_in(terms: &Terms, term: TermId, into: &mut Vec<LoopId>, seen: &mut FxHashSet<TermId>) {
    let mut left = vec![term];
    while let Some(term) = left.pop() {
        if !seen.insert(term) {
            continue;
        }
        if let Term::LoopVar { of, .. } = *terms.get(term)
            && !into.contains(&of)
        {
            into.push(of);
            // what a counter starts from, or steps by, may be the counter of a loop around
            for variable in &terms.loops[of.index()].variables {
                left.push(variable.before);
                left.extend(variable.next);
            }
        }
        terms.operands(term, &mut |operand| left.push(operand));
    }
}

/// A term where loop variables have these values; `None` if it is made of something that they do not tell.
pub(super) fn at(
    terms: &mut Terms,
    id: TermId,
    variables: &[(LoopId, u32, TermId)],
) -> Option<TermId> {
    let mut values = Values::default();
    for &(of, var, value) in variables {
        values.of.insert((of, var), value);
    }
    with(terms, id, &mut values)
}

/// A term in an iteration; `None` if it is made of something that an iteration's numbers do not tell.
fn with(terms: &mut Terms, id: TermId, values: &mut Values) -> Option<TermId> {
    if let Some(&found) = values.found.get(&id) {
        return found;
    }
    let found = put(terms, id, values);
    values.found.insert(id, found);
    found
}

fn put(terms: &mut Terms, id: TermId, values: &mut Values) -> Option<TermId> {
    match terms.get(id) {
        Term::LoopVar { of, var, part } => {
            let (of, var, part) = (*of, *var, part.clone());
            let value = *values.of.get(&(of, var))?;
            Some(terms.project(value, &part))
        }
        Term::Insert(..)
        | Term::Update(..)
        | Term::Swizzle(..)
        | Term::Original { .. }
        | Term::Call(..)
        | Term::LoopExit { .. }
        | Term::Merge { .. }
        | Term::Opaque { .. } => None,
        _ => terms.rebuilt(id, &mut |terms, operand| with(terms, operand, values)),
    }
}
