//! Between which numbers an index lies.
//!
//! *Does*: reads bounds off how a value comes about (`min`, `clamp`, `&`, `%`, what a counter starts from) and off the conditions that
//! hold where it is used. *Guarantees*: the value lies inside, if sums and products of indices do not wrap around: an index that
//! does is beyond the end of what it indexes.

use naga::{BinaryOperator, MathFunction, ScalarKind, TypeInner};

use super::{
    guard::Formula,
    polynomial::is_integer,
    term::{Term, TermId, Terms, integer},
};

/// Both ends belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// The least value.
    pub least: i64,
    /// The greatest value.
    pub most: i64,
}

/// Anything that 32 bits hold, signed or not.
const ANY: Interval = Interval {
    least: i32::MIN as i64,
    most: u32::MAX as i64,
};

/// How many steps are followed.
const DEPTH: u32 = 24;

impl Interval {
    /// A single number.
    pub fn number(number: i64) -> Interval {
        Interval {
            least: number,
            most: number,
        }
    }

    /// Where an integer term lies, under conditions that hold.
    pub fn of(terms: &Terms, facts: &[Formula], id: TermId) -> Interval {
        find(terms, facts, id, DEPTH)
    }

    /// Whether it has a least and a greatest value that something said.
    pub fn is_bounded(self) -> bool {
        self.least > ANY.least && self.most < ANY.most
    }

    /// Whether no number lies in both.
    pub fn is_apart(self, other: Interval) -> bool {
        self.most < other.least || other.most < self.least
    }

    /// Where sums lie.
    pub fn plus(self, other: Interval) -> Interval {
        Interval {
            least: self.least.saturating_add(other.least),
            most: self.most.saturating_add(other.most),
        }
    }

    /// Where products lie.
    pub fn times(self, other: Interval) -> Interval {
        let corners =
            [self.least, self.most].map(|a| [other.least, other.most].map(|b| a.saturating_mul(b)));
        let corners = corners.as_flattened().iter().copied();
        Interval {
            least: corners.clone().min().unwrap_or(i64::MIN),
            most: corners.max().unwrap_or(i64::MAX),
        }
    }

    /// Where the negatives lie.
    pub fn negative(self) -> Interval {
        Interval {
            least: self.most.saturating_neg(),
            most: self.least.saturating_neg(),
        }
    }

    fn join(self, other: Interval) -> Interval {
        Interval {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
        }
    }

    fn meet(self, other: Interval) -> Interval {
        Interval {
            least: self.least.max(other.least),
            most: self.most.min(other.most),
        }
    }
}

fn find(terms: &Terms, facts: &[Formula], id: TermId, depth: u32) -> Interval {
    if depth == 0 {
        return ANY;
    }
    let of = |id| find(terms, facts, id, depth - 1);
    let built = match *terms.get(id) {
        Term::Literal(_) => integer(terms.as_literal(id)).map_or(ANY, Interval::number),
        Term::Id(_) | Term::ImageQuery(..) | Term::ArrayLength(..) => AT_LEAST_ZERO,
        Term::Extract(base, _) => match terms.get(base) {
            Term::ImageQuery(..) => AT_LEAST_ZERO,
            Term::Load(global, path) => loaded(terms.loaded(*global, path)),
            _ => ANY,
        },
        Term::Load(global, ref path) => loaded(terms.loaded(global, path)),
        Term::Binary(op, left, right) if is_integer(terms, id) => {
            let number = |id| integer(terms.as_literal(id));
            // what commutes may have its number on either side
            let number = match op {
                BinaryOperator::And => number(right).or(number(left)),
                _ => number(right),
            };
            operation(op, (of(left), of(right)), number)
        }
        Term::Math(fun, ref arguments) if is_integer(terms, id) => {
            match (fun, arguments.as_ref()) {
                (MathFunction::Min, &[a, b]) => least(of(a), of(b)),
                (MathFunction::Max, &[a, b]) => greatest(of(a), of(b)),
                // naga's own reading of `clamp`, which is what every back end writes
                (MathFunction::Clamp, &[value, low, high]) => {
                    least(greatest(of(value), of(low)), of(high))
                }
                _ => ANY,
            }
        }
        // a float becomes the nearest number that the type holds
        Term::As(ScalarKind::Uint, Some(4), value) if !is_integer(terms, value) => AT_LEAST_ZERO,
        Term::As(ScalarKind::Sint | ScalarKind::Uint, Some(4) | None, value)
            if is_integer(terms, value) =>
        {
            let inner = of(value);
            // both types hold what lies between
            if inner.least >= 0 && inner.most <= i64::from(i32::MAX) {
                inner
            } else {
                ANY
            }
        }
        Term::Select(_, accept, reject) => of(accept).join(of(reject)),
        Term::Merge { ref values, .. } => values
            .iter()
            .map(|&value| of(value))
            .reduce(Interval::join)
            .unwrap_or(ANY),
        Term::LoopVar { of, var, ref part } if part.is_empty() => {
            let variable = &terms.loops[of.index()].variables[var as usize];
            match variable.next.map(|next| step(terms, next, id)) {
                // it only grows
                Some(Some(1..)) => Interval {
                    least: find(terms, &[], variable.before, depth - 1).least,
                    most: ANY.most,
                },
                // or shrinks
                Some(Some(..=-1)) => Interval {
                    least: ANY.least,
                    most: find(terms, &[], variable.before, depth - 1).most,
                },
                _ => ANY,
            }
        }
        _ => ANY,
    };
    facts
        .iter()
        .filter_map(|fact| bound(terms, fact, id))
        .fold(built, Interval::meet)
}

const AT_LEAST_ZERO: Interval = Interval {
    least: 0,
    most: ANY.most,
};

fn loaded(inner: Option<&TypeInner>) -> Interval {
    match inner {
        Some(
            TypeInner::Scalar(scalar)
            | TypeInner::Atomic(scalar)
            | TypeInner::Vector { scalar, .. },
        ) if scalar.kind == ScalarKind::Uint => AT_LEAST_ZERO,
        _ => ANY,
    }
}

fn least(a: Interval, b: Interval) -> Interval {
    Interval {
        least: a.least.min(b.least),
        most: a.most.min(b.most),
    }
}

fn greatest(a: Interval, b: Interval) -> Interval {
    Interval {
        least: a.least.max(b.least),
        most: a.most.max(b.most),
    }
}

fn operation(
    op: BinaryOperator,
    (left, right): (Interval, Interval),
    number: Option<i64>,
) -> Interval {
    use BinaryOperator as B;
    match (op, number) {
        (B::Add, _) => left.plus(right),
        (B::Subtract, _) => left.plus(right.negative()),
        (B::Multiply, _) => left.times(right),
        (B::And, Some(mask @ 0..)) => Interval {
            least: 0,
            most: mask,
        },
        (B::Modulo, Some(by @ 1..)) => Interval {
            least: if left.least >= 0 { 0 } else { 1 - by },
            most: by - 1,
        },
        (B::Divide, Some(by @ 1..)) if left.least >= 0 => Interval {
            least: left.least / by,
            most: left.most / by,
        },
        (B::ShiftRight, Some(by @ 0..=31)) if left.least >= 0 => Interval {
            least: left.least >> by,
            most: left.most >> by,
        },
        (B::ShiftLeft, Some(by @ 0..=31)) => left.times(Interval::number(1 << by)),
        _ => ANY,
    }
}

/// By how much an iteration moves a variable on, if that is a number.
fn step(terms: &Terms, next: TermId, variable: TermId) -> Option<i64> {
    let Term::Binary(op, left, right) = *terms.get(next) else {
        return None;
    };
    match (op, left == variable, right == variable) {
        (BinaryOperator::Add, true, false) => integer(terms.as_literal(right)),
        (BinaryOperator::Add, false, true) => integer(terms.as_literal(left)),
        (BinaryOperator::Subtract, true, false) => integer(terms.as_literal(right))?.checked_neg(),
        _ => None,
    }
}

/// What a condition that holds says of a term.
fn bound(terms: &Terms, fact: &Formula, id: TermId) -> Option<Interval> {
    let (lesser, greater, strictly) = less(terms, fact)?;
    let strictly = i64::from(strictly);
    let end = |other| find(terms, &[], other, DEPTH / 2);
    if lesser == id {
        return Some(Interval {
            least: i64::MIN,
            most: end(greater).most - strictly,
        });
    }
    (greater == id).then(|| Interval {
        least: end(lesser).least + strictly,
        most: i64::MAX,
    })
}

/// A condition as `a < b` (strictly) or `a <= b`.
pub fn less(terms: &Terms, fact: &Formula) -> Option<(TermId, TermId, bool)> {
    use BinaryOperator as B;
    let Formula::Is(condition, holds) = *fact else {
        return None;
    };
    let Term::Binary(op, left, right) = *terms.get(condition) else {
        return None;
    };
    match (op, holds) {
        (B::Less, true) => Some((left, right, true)),
        (B::LessEqual, true) => Some((left, right, false)),
        (B::Greater, true) => Some((right, left, true)),
        (B::GreaterEqual, true) => Some((right, left, false)),
        (B::Less, false) => Some((right, left, false)),
        (B::LessEqual, false) => Some((right, left, true)),
        (B::Greater, false) => Some((left, right, false)),
        (B::GreaterEqual, false) => Some((left, right, true)),
        _ => None,
    }
}
