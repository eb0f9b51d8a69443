//! Windows on a torus: addresses that wrap, and keep the pixels of a window apart all the same.
//!
//! A grid that scrolls keeps its cells where they are and lets the window move over them: cell `w = origin + id` stands in column
//! `w % n`, `((w % n) + n) % n` or `w & (n - 1)`. *Does*: finds such columns and rows in an address, and asks whether the window is
//! no wider than the torus, as a bound on the way to the store tells. *Guarantees*: where different pixels share a place all the same
//! (a mask whose size is no power of two, an origin at the end of all numbers), the original's pixels race for it.

use naga::BinaryOperator;

use super::{Planner, domain::Domain};
use crate::analysis::{
    depends::Depends,
    guard::{Formula, flatten},
    interval::less,
    polynomial::{Polynomial, Product, without},
    term::{Term, TermId},
};

impl Planner<'_> {
    /// Whether different pixels of a layer have different addresses, since each of two parts, or of two strides of one part,
    /// moves along one axis and wraps at the window's width or height, if at all.
    pub(super) fn wraps_tell_apart(
        &mut self,
        store: usize,
        parts: &[TermId],
        domain: &Domain,
    ) -> bool {
        let guards = self.access(store).guards.clone();
        let mut facts = Vec::new();
        flatten(&domain.shared, &mut self.found.terms, &mut facts);
        flatten(&guards, &mut self.found.terms, &mut facts);
        // the axis that a part moves along, its number, and the stride
        let mut found: Vec<(Depends, usize, Product, i64)> = Vec::new();
        for (number, &part) in parts.iter().enumerate() {
            let Some(sum) = self.polynomial(part) else {
                return false;
            };
            for (product, &factor) in &sum.factors {
                match self.moving(product, &facts) {
                    Moving::Not => {}
                    Moving::Along(axis, stride) => found.push((axis, number, stride, factor)),
                    Moving::Unknown => return false,
                }
            }
        }
        let [a, b] = found.as_slice() else {
            return false;
        };
        let is_apart = a.1 != b.1 || a.2 != b.2 || a.3.abs() != b.3.abs();
        a.0 != b.0 && is_apart
    }

    /// How a product moves with the pixel.
    fn moving(&mut self, product: &[TermId], facts: &[Formula]) -> Moving {
        let pixel = Depends::X | Depends::Y;
        let mut moving = Vec::new();
        for &symbol in product {
            let on = self.on.of(&mut self.found.terms, symbol);
            if on.intersects(pixel) {
                moving.push((symbol, on));
            }
        }
        let (symbol, on) = match moving.as_slice() {
            [] => return Moving::Not,
            [only] => *only,
            _ => return Moving::Unknown,
        };
        let is_straight = |axis| on & (pixel | Depends::DATA | Depends::STATE) == axis;
        if !is_straight(Depends::X) && !is_straight(Depends::Y) {
            return Moving::Unknown;
        }
        let axis = on & pixel;
        let keeps_apart = self.moves_on(symbol, axis)
            || self
                .wrapped(symbol)
                .is_some_and(|(inner, size)| self.is_window(inner, &size, axis, facts));
        match (keeps_apart, without(product, &[symbol])) {
            (true, Some(stride)) => Moving::Along(axis, stride),
            _ => Moving::Unknown,
        }
    }

    /// Whether a value moves along an axis with every pixel.
    fn moves_on(&mut self, value: TermId, axis: Depends) -> bool {
        let tangent = self.tangents.of(&mut self.found.terms, &mut self.on, value);
        let along = usize::from(axis == Depends::Y);
        tangent.is_some_and(|tangent| tangent.pixel[along].constant != 0)
    }

    /// What wraps, and after how much, where a value is a remainder.
    fn wrapped(&mut self, value: TermId) -> Option<(TermId, Polynomial)> {
        use BinaryOperator as B;
        match *self.found.terms.get(value) {
            Term::Binary(B::And, a, b) => [(a, b), (b, a)].into_iter().find_map(|(inner, mask)| {
                let is_same = self.on.of(&mut self.found.terms, mask).is_empty();
                let size = self.polynomial(mask)?.plus(&Polynomial::number(1), 1)?;
                is_same.then_some((inner, size))
            }),
            Term::Binary(B::Modulo, sum, size) => {
                let whole = self.polynomial(size)?;
                Some((self.made_positive(sum, &whole).unwrap_or(sum), whole))
            }
            _ => None,
        }
    }

    /// What is in `(inner % size) + size`.
    fn made_positive(&mut self, sum: TermId, size: &Polynomial) -> Option<TermId> {
        use BinaryOperator as B;
        let Term::Binary(B::Add, a, b) = *self.found.terms.get(sum) else {
            return None;
        };
        [(a, b), (b, a)]
            .into_iter()
            .find_map(|(remainder, beyond)| {
                let Term::Binary(B::Modulo, inner, by) = *self.found.terms.get(remainder) else {
                    return None;
                };
                let is_size =
                    |planner: &mut Self, term| planner.polynomial(term).as_ref() == Some(size);
                (is_size(self, beyond) && is_size(self, by)).then_some(inner)
            })
    }

    /// Whether what moves in a value moves along an axis with every pixel, and stays below a size as conditions on the way say.
    fn is_window(
        &mut self,
        value: TermId,
        size: &Polynomial,
        axis: Depends,
        facts: &[Formula],
    ) -> bool {
        let Some(value) = self.polynomial(value) else {
            return false;
        };
        facts.iter().any(|fact| {
            let Some((lesser, greater, _)) = less(&self.found.terms, fact) else {
                return false;
            };
            let (Some(bounded), Some(bound)) = (self.polynomial(lesser), self.polynomial(greater))
            else {
                return false;
            };
            let Some(rest) = value.plus(&bounded, -1) else {
                return false;
            };
            let is_same = rest.factors.keys().flatten().all(|&symbol| {
                !self
                    .on
                    .of(&mut self.found.terms, symbol)
                    .intersects(Depends::X | Depends::Y)
            });
            bound == *size && is_same && self.moves_on(lesser, axis)
        })
    }
}

/// How a product moves with the pixel.
enum Moving {
    Not,
    /// With every pixel along an axis, by a stride.
    Along(Depends, Product),
    Unknown,
}
