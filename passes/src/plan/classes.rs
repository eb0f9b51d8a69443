//! Pixels by what their position leaves when it is divided by small numbers: the colours of a checkerboard, interleaved rows.
//!
//! A relaxation that goes over the red cells and then over the black ones reads, from a red cell, black cells alone, which nobody
//! stores in that dispatch. *Does*: takes such conditions out of the domain, `(x + y) % 2 == 1` or `(x & 3) != 0`, and asks
//! whether a pixel and another beside it can both fulfil them all. *Guarantees*: what is left out is outside the domain for every
//! pixel inside.

use naga::BinaryOperator;

use crate::analysis::{
    guard::Formula,
    polynomial::Polynomial,
    term::{Id, Term, TermId, Terms, integer},
};

/// Patterns that repeat after more pixels are not followed.
const LONGEST: i64 = 16;

/// `(x * factors[0] + y * factors[1] + number) % by`, compared with a number.
struct Class {
    factors: [i64; 2],
    number: i64,
    by: i64,
    is: i64,
    equal: bool,
}

impl Class {
    fn has(&self, place: [i64; 2]) -> bool {
        let sum = self.factors[0] * place[0] + self.factors[1] * place[1] + self.number;
        (sum.rem_euclid(self.by) == self.is) == self.equal
    }

    fn of(terms: &mut Terms, group_size: [TermId; 3], fact: &Formula) -> Option<Class> {
        use BinaryOperator as B;
        let Formula::Is(condition, holds) = *fact else {
            return None;
        };
        let Term::Binary(op @ (B::Equal | B::NotEqual), left, right) = *terms.get(condition) else {
            return None;
        };
        let number = |terms: &Terms, id| integer(terms.as_literal(id));
        let (rest, is) = match (number(terms, left), number(terms, right)) {
            (None, Some(is)) => (left, is),
            (Some(is), None) => (right, is),
            _ => return None,
        };
        let (sum, by) = match *terms.get(rest) {
            Term::Binary(B::Modulo, sum, by) => (sum, number(terms, by)?),
            Term::Binary(B::And, a, b) => match (number(terms, a), number(terms, b)) {
                (None, Some(mask)) => (a, mask.checked_add(1)?),
                (Some(mask), None) => (b, mask.checked_add(1)?),
                _ => return None,
            },
            _ => return None,
        };
        let is_mask = matches!(terms.get(rest), Term::Binary(B::And, ..));
        if !(2..=LONGEST).contains(&by) || is_mask && by.count_ones() != 1 {
            return None;
        }
        let sum = Polynomial::of(terms, group_size, sum)?;
        let axes = [0, 1].map(|axis| vec![terms.intern(Term::Id(Id::Global(axis)))]);
        let mut class = Class {
            factors: [0; 2],
            number: 0,
            by,
            is,
            equal: (op == B::Equal) == holds,
        };
        for (product, &factor) in &sum.factors {
            // what is negative leaves a negative rest
            if factor < 0 && !is_mask {
                return None;
            }
            match axes.iter().position(|axis| axis == product) {
                Some(axis) => class.factors[axis] = factor,
                None if product.is_empty() => class.number = factor,
                None => return None,
            }
        }
        Some(class)
    }
}

/// Conditions that all pixels of the domain fulfil.
pub(super) struct Classes {
    all: Vec<Class>,
    /// After so many pixels along either axis they repeat.
    period: i64,
}

impl Classes {
    /// What conditions that hold say of a pixel's class.
    pub(super) fn of(terms: &mut Terms, group_size: [TermId; 3], facts: &[Formula]) -> Classes {
        let mut classes = Classes {
            all: Vec::new(),
            period: 1,
        };
        for fact in facts {
            let Some(class) = Class::of(terms, group_size, fact) else {
                continue;
            };
            let period = lcm(classes.period, class.by);
            if period <= LONGEST {
                classes.period = period;
                classes.all.push(class);
            }
        }
        classes
    }

    /// Whether, of every pixel that fulfils them, the one that lies so far beside it does not.
    pub(super) fn leave_out(&self, beside: [i64; 2]) -> bool {
        let has = |place| self.all.iter().all(|class| class.has(place));
        let residues = || 0..self.period;
        residues().all(|y| {
            residues().all(|x| {
                let other = [x + beside[0] % self.period, y + beside[1] % self.period];
                !has([x, y]) || !has(other)
            })
        })
    }
}

fn lcm(a: i64, b: i64) -> i64 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
