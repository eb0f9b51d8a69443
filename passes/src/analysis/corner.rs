//! Whether what holds for one corner of a block of pixels holds for all of the block.
//!
//! `id.x < size.x` holds for a whole block if it holds for the pixel that is farthest from the origin, `id.x >= 2` if for the nearest one.
//! So a rewritten shader asks such a domain once for a group, and not for each of its members.
//!
//! *Does*: follows conditions down to comparisons of something that only grows with the ids, or only shrinks, with something that the ids
//! have no part in. *Guarantees*: where the [asked](Asked) holds, the formula holds for every pixel of the block; where it does not, that says
//! nothing. *Refuses*: what may wrap around between two pixels of a block, as `id.x - 1u` does, and floats but for an id that is
//! converted; the domain is asked for each member there.

use naga::{BinaryOperator, ScalarKind, UnaryOperator};

use super::{
    guard::Formula,
    term::{Id, Term, TermId, Terms, integer},
};

/// The corner of a block that decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// The least ids.
    Near,
    /// The greatest ids.
    Far,
}

/// What has to hold, and at which corner, for a formula to hold throughout a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asked {
    /// The term is true (or false) for the ids of the corner.
    At(Corner, TermId, bool),
    /// All of these.
    All(Vec<Asked>),
    /// At least one of these.
    Any(Vec<Asked>),
}

/// How a value moves while ids grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trend {
    Fixed,
    Up,
    Down,
}

impl Trend {
    fn opposite(self) -> Trend {
        match self {
            Trend::Fixed => Trend::Fixed,
            Trend::Up => Trend::Down,
            Trend::Down => Trend::Up,
        }
    }
}

/// Added to an id, more than this may wrap around: ids end below 65,535 groups of 1,024.
const MOST_ADDED: i64 = 1 << 30;

/// What to ask so that all the formulas hold throughout a block; `None` if no corner tells.
pub fn of_all(formulas: &[Formula], terms: &Terms) -> Option<Asked> {
    let parts: Option<Vec<_>> = formulas.iter().map(|part| of(part, terms)).collect();
    parts.map(Asked::All)
}

fn of(formula: &Formula, terms: &Terms) -> Option<Asked> {
    match formula {
        Formula::Is(condition, holds) => of_condition(*condition, *holds, terms),
        Formula::All(parts) => of_all(parts, terms),
        Formula::Any(parts) => {
            let parts: Option<Vec<_>> = parts.iter().map(|part| of(part, terms)).collect();
            parts.map(Asked::Any)
        }
    }
}

fn of_condition(condition: TermId, holds: bool, terms: &Terms) -> Option<Asked> {
    let both = |a, b| {
        Some(vec![
            of_condition(a, holds, terms)?,
            of_condition(b, holds, terms)?,
        ])
    };
    match *terms.get(condition) {
        Term::Unary(UnaryOperator::LogicalNot, inner) => of_condition(inner, !holds, terms),
        Term::Binary(BinaryOperator::LogicalAnd, a, b) if holds => both(a, b).map(Asked::All),
        Term::Binary(BinaryOperator::LogicalAnd, a, b) => both(a, b).map(Asked::Any),
        Term::Binary(BinaryOperator::LogicalOr, a, b) if holds => both(a, b).map(Asked::Any),
        Term::Binary(BinaryOperator::LogicalOr, a, b) => both(a, b).map(Asked::All),
        Term::Binary(op, a, b) => {
            // what `a - b` does decides: `a < b` is lost while it grows
            let lost_by = match op {
                BinaryOperator::Less | BinaryOperator::LessEqual => Trend::Up,
                BinaryOperator::Greater | BinaryOperator::GreaterEqual => Trend::Down,
                _ => return fixed(condition, holds, terms),
            };
            let lost_by = if holds { lost_by } else { lost_by.opposite() };
            let difference = match (trend(a, terms)?, trend(b, terms)?.opposite()) {
                (Trend::Fixed, one) | (one, Trend::Fixed) => one,
                (one, other) if one == other => one,
                _ => return None,
            };
            let corner = if difference == lost_by {
                Corner::Far
            } else {
                Corner::Near
            };
            Some(Asked::At(corner, condition, holds))
        }
        _ => fixed(condition, holds, terms),
    }
}

fn fixed(condition: TermId, holds: bool, terms: &Terms) -> Option<Asked> {
    let is_fixed = trend(condition, terms) == Some(Trend::Fixed);
    is_fixed.then_some(Asked::At(Corner::Near, condition, holds))
}

/// How a number moves; `None` if it may do either, or wrap around.
fn trend(value: TermId, terms: &Terms) -> Option<Trend> {
    match *terms.get(value) {
        // a conversion rounds, and keeps the order
        Term::As(ScalarKind::Float, Some(_), inner) if grows(inner, terms) => Some(Trend::Up),
        _ if grows(value, terms) => Some(Trend::Up),
        _ => does_not_move(value, terms).then_some(Trend::Fixed),
    }
}

/// Whether an integer grows along the block.
fn grows(value: TermId, terms: &Terms) -> bool {
    match *terms.get(value) {
        // an offset below zero stays one, where there is a sign
        Term::Binary(BinaryOperator::Subtract, a, b) => {
            is_signed_id(a, terms) && is_added(b, terms)
        }
        _ => is_small(value, terms),
    }
}

/// Whether a value is an id that grows along the block, or such a one and a number, far from where integers wrap around.
fn is_small(value: TermId, terms: &Terms) -> bool {
    match *terms.get(value) {
        Term::As(ScalarKind::Sint | ScalarKind::Uint, Some(4..), inner) => is_small(inner, terms),
        Term::Binary(BinaryOperator::Add, a, b) => {
            (is_id(a, terms) && is_added(b, terms)) || (is_id(b, terms) && is_added(a, terms))
        }
        _ => is_id(value, terms),
    }
}

fn is_id(value: TermId, terms: &Terms) -> bool {
    match *terms.get(value) {
        Term::Id(Id::Global(_) | Id::Group(_)) => true,
        Term::As(ScalarKind::Sint | ScalarKind::Uint, Some(4..), inner) => is_id(inner, terms),
        _ => false,
    }
}

fn is_signed_id(value: TermId, terms: &Terms) -> bool {
    matches!(*terms.get(value), Term::As(ScalarKind::Sint, Some(4..), inner) if is_id(inner, terms))
}

fn is_added(value: TermId, terms: &Terms) -> bool {
    integer(terms.as_literal(value)).is_some_and(|number| (0..=MOST_ADDED).contains(&number))
}

/// Whether no id has a part in a value.
fn does_not_move(value: TermId, terms: &Terms) -> bool {
    !terms.is_any_below(&[value], |term| match term {
        Term::Id(id) => !matches!(id, Id::GroupCount(_)),
        Term::Opaque { .. } | Term::LoopVar { .. } | Term::LoopExit { .. } | Term::Merge { .. } => {
            true
        }
        _ => false,
    })
}
