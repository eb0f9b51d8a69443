//! An index as a polynomial: a sum of products of what it is made of, with whole factors.
//!
//! Two ways to write an index (`y * w + x + k * (w * h)`, `(k * h + y) * w + x`) come out as one. *Does*: multiplies sums,
//! products and shifts by a number out, looks through conversions between `u32` and `i32`, and tells local ids by global ids and the
//! workgroup's place, so that `group * size + local` is the global id. *Guarantees*: the polynomial is the index in the
//! wrapping arithmetic of WGSL; what is not multiplied out is one of its symbols. There is none where it would grow too long.

use std::collections::BTreeMap;

use naga::{BinaryOperator, MathFunction, ScalarKind, TypeInner, UnaryOperator};

use super::term::{Axis, Id, Term, TermId, Terms, integer};

/// More monomials than that are no index that somebody wrote.
const MOST: usize = 32;

/// A product of symbols, in order; empty for a number.
pub type Product = Vec<TermId>;

/// A sum of products with factors, none of which is zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polynomial {
    /// The factor of each product.
    pub factors: BTreeMap<Product, i64>,
}

impl Polynomial {
    /// A number.
    pub fn number(number: i64) -> Polynomial {
        Polynomial::monomial(Vec::new(), number)
    }

    /// A product with a factor.
    pub fn monomial(product: Product, factor: i64) -> Polynomial {
        let mut polynomial = Polynomial::default();
        if factor != 0 {
            polynomial.factors.insert(product, factor);
        }
        polynomial
    }

    /// The polynomial of an integer term. `group_size` is the original workgroup's, as terms.
    pub fn of(terms: &mut Terms, group_size: [TermId; 3], id: TermId) -> Option<Polynomial> {
        let of = |terms: &mut Terms, id| Polynomial::of(terms, group_size, id);
        match *terms.get(id) {
            Term::Literal(_) => Some(match integer(terms.as_literal(id)) {
                Some(number) => Polynomial::number(number),
                None => Polynomial::monomial(vec![id], 1),
            }),
            Term::Id(Id::Local(axis)) => local(terms, group_size, axis),
            Term::Id(Id::LocalIndex) => {
                let [x, y, z] = [0, 1, 2].map(|axis| local(terms, group_size, axis));
                let [width, height, _] = group_size.map(|size| of(terms, size));
                let (width, height) = (width?, height?);
                let rows = y?.plus(&z?.times(&height)?, 1)?;
                x?.plus(&rows.times(&width)?, 1)
            }
            Term::Binary(op, left, right) if is_integer(terms, id) => match op {
                BinaryOperator::Add => of(terms, left)?.plus(&of(terms, right)?, 1),
                BinaryOperator::Subtract => of(terms, left)?.plus(&of(terms, right)?, -1),
                BinaryOperator::Multiply => of(terms, left)?.times(&of(terms, right)?),
                BinaryOperator::ShiftLeft => match integer(terms.as_literal(right)) {
                    Some(by @ 0..=31) => of(terms, left)?.times(&Polynomial::number(1 << by)),
                    _ => Some(Polynomial::monomial(vec![id], 1)),
                },
                _ => Some(Polynomial::monomial(vec![id], 1)),
            },
            Term::Unary(UnaryOperator::Negate, value) if is_integer(terms, value) => {
                of(terms, value)?.times(&Polynomial::number(-1))
            }
            // 32-bit conversions between the signs keep all bits
            Term::As(ScalarKind::Sint | ScalarKind::Uint, None | Some(4), value)
                if is_integer(terms, value) =>
            {
                of(terms, value)
            }
            Term::Call(..) => match terms.expansions.get(&id) {
                Some(&expansion) => of(terms, expansion),
                None => Some(Polynomial::monomial(vec![id], 1)),
            },
            Term::Extract(base, index) => match terms.expansions.get(&base) {
                Some(&expansion) => {
                    let part = terms.extract(expansion, index);
                    of(terms, part)
                }
                None => Some(Polynomial::monomial(vec![id], 1)),
            },
            _ => Some(Polynomial::monomial(vec![id], 1)),
        }
    }

    /// The sum with a multiple of another.
    pub fn plus(&self, other: &Polynomial, times: i64) -> Option<Polynomial> {
        let mut sum = self.clone();
        for (product, factor) in &other.factors {
            let entry = sum.factors.entry(product.clone()).or_insert(0);
            *entry = entry.checked_add(factor.checked_mul(times)?)?;
        }
        sum.factors.retain(|_, factor| *factor != 0);
        (sum.factors.len() <= MOST).then_some(sum)
    }

    /// The product with another.
    pub fn times(&self, other: &Polynomial) -> Option<Polynomial> {
        let mut all = Polynomial::default();
        for (a, m) in &self.factors {
            for (b, n) in &other.factors {
                let mut product: Product = a.iter().chain(b).copied().collect();
                product.sort_unstable();
                let monomial = Polynomial::monomial(product, m.checked_mul(*n)?);
                all = all.plus(&monomial, 1)?;
            }
        }
        Some(all)
    }

    /// Splits it into the products that satisfy a condition, and the others.
    pub fn split(&self, mut is_first: impl FnMut(&[TermId]) -> bool) -> (Polynomial, Polynomial) {
        let (mut first, mut second) = (Polynomial::default(), Polynomial::default());
        for (product, &factor) in &self.factors {
            let into = if is_first(product) {
                &mut first
            } else {
                &mut second
            };
            into.factors.insert(product.clone(), factor);
        }
        (first, second)
    }

    /// Whether each of its products is a multiple of a product with a factor, whatever the symbols stand for.
    pub fn is_multiple_of(&self, (product, factor): (&[TermId], i64)) -> bool {
        self.factors
            .iter()
            .all(|(all, by)| factor != 0 && by % factor == 0 && without(all, product).is_some())
    }

    /// The greatest number that divides all factors; 0 if there are none.
    pub fn divisor(&self) -> i64 {
        self.factors.values().fold(0, |all, &by| gcd(all, by))
    }

    /// The number that it is, if it is one.
    pub fn as_number(&self) -> Option<i64> {
        match self.factors.len() {
            0 => Some(0),
            1 => self.factors.get(&Vec::new()).copied(),
            _ => None,
        }
    }
}

/// A product without another's symbols; `None` if it does not have them all.
pub fn without(product: &[TermId], symbols: &[TermId]) -> Option<Product> {
    let mut left = product.to_vec();
    for symbol in symbols {
        let place = left.iter().position(|other| other == symbol)?;
        left.remove(place);
    }
    Some(left)
}

fn gcd(a: i64, b: i64) -> i64 {
    match b {
        0 => a.abs(),
        _ => gcd(b, a % b),
    }
}

/// A local id: the global id less the workgroup's place.
fn local(terms: &mut Terms, group_size: [TermId; 3], axis: Axis) -> Option<Polynomial> {
    let group = terms.intern(Term::Id(Id::Group(axis)));
    let global = terms.intern(Term::Id(Id::Global(axis)));
    let size = Polynomial::of(terms, group_size, group_size[axis as usize])?;
    let place = Polynomial::monomial(vec![group], 1).times(&size)?;
    Polynomial::monomial(vec![global], 1).plus(&place, -1)
}

/// Whether a term is surely an integer of 32 bits.
pub fn is_integer(terms: &Terms, id: TermId) -> bool {
    let is_scalar = |inner: Option<&TypeInner>| {
        matches!(inner, Some(TypeInner::Scalar(s) | TypeInner::Vector { scalar: s, .. } | TypeInner::Atomic(s))
            if matches!(s.kind, ScalarKind::Sint | ScalarKind::Uint) && s.width == 4)
    };
    match *terms.get(id) {
        Term::Literal(bits) => {
            matches!(bits.0, naga::Literal::U32(_) | naga::Literal::I32(_))
        }
        Term::Id(_) | Term::ArrayLength(..) | Term::ImageQuery(..) => true,
        Term::As(ScalarKind::Sint | ScalarKind::Uint, Some(4), _) => true,
        Term::As(ScalarKind::Sint | ScalarKind::Uint, None, value) => is_integer(terms, value),
        Term::Override(handle) => {
            let ty = terms.module().overrides[handle].ty;
            is_scalar(Some(&terms.module().types[ty].inner))
        }
        Term::Load(global, ref path) => is_scalar(terms.loaded(global, path)),
        Term::Extract(base, _) => match *terms.get(base) {
            Term::Load(global, ref path) => is_scalar(terms.loaded(global, path)),
            Term::ImageQuery(..) => true,
            Term::Math(_, ref arguments) => is_integer(terms, arguments[0]),
            _ => false,
        },
        Term::Unary(UnaryOperator::Negate | UnaryOperator::BitwiseNot, value) => {
            is_integer(terms, value)
        }
        Term::Binary(op, left, right) => {
            use BinaryOperator as B;
            let is_arithmetic = matches!(
                op,
                B::Add
                    | B::Subtract
                    | B::Multiply
                    | B::Divide
                    | B::Modulo
                    | B::And
                    | B::InclusiveOr
                    | B::ExclusiveOr
                    | B::ShiftLeft
                    | B::ShiftRight
            );
            // the two are of one type, and either may tell it; the right of a shift is of another
            is_arithmetic
                && (is_integer(terms, left)
                    || !matches!(op, B::ShiftLeft | B::ShiftRight) && is_integer(terms, right))
        }
        Term::Select(_, accept, reject) => is_integer(terms, accept) || is_integer(terms, reject),
        Term::Math(
            MathFunction::Min | MathFunction::Max | MathFunction::Clamp | MathFunction::Abs,
            ref arguments,
        ) => arguments
            .iter()
            .any(|&argument| is_integer(terms, argument)),
        Term::LoopVar { of, var, ref part } if part.is_empty() => {
            let before = terms.loops[of.index()].variables[var as usize].before;
            is_integer(terms, before)
        }
        _ => false,
    }
}
