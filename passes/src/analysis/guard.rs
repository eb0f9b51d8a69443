//! The conditions under which a statement runs.

use naga::{BinaryOperator, UnaryOperator};

use super::term::{Term, TermId, Terms};

/// A condition on the way to a statement, in negation normal form: only single conditions are negated, so that one
/// that is not understood can be taken to hold and the whole only becomes weaker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Formula {
    /// The term is true (or false).
    Is(TermId, bool),
    /// All of these.
    All(Vec<Formula>),
    /// At least one of these.
    Any(Vec<Formula>),
}

impl Formula {
    /// Calls `visit` on every condition in the formula.
    pub fn conditions(&self, visit: &mut dyn FnMut(TermId)) {
        match self {
            Formula::Is(condition, _) => visit(*condition),
            Formula::All(parts) | Formula::Any(parts) => {
                parts.iter().for_each(|part| part.conditions(visit));
            }
        }
    }

    /// The formula as a term.
    pub fn term(&self, terms: &mut Terms) -> TermId {
        match self {
            Formula::Is(condition, true) => *condition,
            Formula::Is(condition, false) => terms.not(*condition),
            Formula::All(parts) => all(parts, terms),
            Formula::Any(parts) => {
                let mut any = terms.bool(false);
                for part in parts {
                    let part = part.term(terms);
                    any = terms.or(any, part);
                }
                any
            }
        }
    }

    /// The formula with every condition for which `keep` is false taken to hold; `None` if it then always holds.
    pub fn relaxed(&self, keep: &mut dyn FnMut(TermId) -> bool) -> Option<Formula> {
        match self {
            Formula::Is(condition, _) => keep(*condition).then(|| self.clone()),
            Formula::All(parts) => {
                let parts: Vec<_> = parts.iter().filter_map(|part| part.relaxed(keep)).collect();
                (!parts.is_empty()).then_some(Formula::All(parts))
            }
            Formula::Any(parts) => {
                let parts: Option<Vec<_>> = parts.iter().map(|part| part.relaxed(keep)).collect();
                parts.map(Formula::Any)
            }
        }
    }
}

/// The conjunction of formulas, as a term.
pub fn all(formulas: &[Formula], terms: &mut Terms) -> TermId {
    let mut all = terms.bool(true);
    for formula in formulas {
        let formula = formula.term(terms);
        all = terms.and(all, formula);
    }
    all
}

/// Splits conjunctions, so that what several statements have in common can be found part by part.
pub fn flatten(formulas: &[Formula], terms: &mut Terms, into: &mut Vec<Formula>) {
    for formula in formulas {
        match formula {
            Formula::All(parts) => flatten(parts, terms, into),
            Formula::Is(condition, holds) => flatten_condition(*condition, *holds, terms, into),
            Formula::Any(_) => push_once(formula.clone(), into),
        }
    }
}

/// `a && b` holds: both do. `a || b` does not: neither does.
fn flatten_condition(condition: TermId, holds: bool, terms: &mut Terms, into: &mut Vec<Formula>) {
    match *terms.get(condition) {
        Term::Binary(BinaryOperator::LogicalAnd, a, b) if holds => {
            flatten_condition(a, holds, terms, into);
            flatten_condition(b, holds, terms, into);
        }
        Term::Binary(BinaryOperator::LogicalOr, a, b) if !holds => {
            flatten_condition(a, holds, terms, into);
            flatten_condition(b, holds, terms, into);
        }
        Term::Unary(UnaryOperator::LogicalNot, inner) => {
            flatten_condition(inner, !holds, terms, into);
        }
        _ => push_once(Formula::Is(condition, holds), into),
    }
}

fn push_once(formula: Formula, into: &mut Vec<Formula>) {
    if !into.contains(&formula) {
        into.push(formula);
    }
}
