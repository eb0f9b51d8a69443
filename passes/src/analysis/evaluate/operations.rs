//! Operations on values: integers and booleans component by component, floats whole.

use naga::{
    BinaryOperator, Expression, Handle, Literal, MathFunction, RelationalFunction, TypeInner,
};

use crate::analysis::{
    term::{Operands, Term, TermId, Terms, followed},
    walk::{Frame, Walk},
};

impl<'a> Walk<'a> {
    /// Applies an operation to each component where the result is a vector of integers or booleans, else to the whole.
    pub(super) fn componentwise(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        operands: &[Handle<Expression>],
        apply: impl Fn(&mut Self, &[TermId]) -> TermId,
    ) -> TermId {
        let values: Vec<_> = operands.iter().map(|&o| self.term(frame, o)).collect();
        let Some((size, scalar)) = self.followed_vector(frame, handle) else {
            return apply(self, &values);
        };
        let is_vector: Vec<_> = operands
            .iter()
            .map(|&o| matches!(self.inner(frame, o), TypeInner::Vector { .. }))
            .collect();
        let mut parts = Vec::with_capacity(size as usize);
        for index in 0..size as u32 {
            let components: Vec<_> = values
                .iter()
                .zip(&is_vector)
                .map(|(&value, &vector)| match vector {
                    true => self.terms.extract(value, index),
                    false => value,
                })
                .collect();
            parts.push(apply(self, &components));
        }
        self.terms.vector(scalar, parts)
    }

    pub(super) fn binary(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> TermId {
        let integers = |inner: &TypeInner| match *inner {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => followed(scalar),
            _ => false,
        };
        let operands = if integers(self.inner(frame, left)) && integers(self.inner(frame, right)) {
            Operands::Integers
        } else {
            Operands::Other
        };
        let bits = match *self.inner(frame, left) {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => {
                8 * u32::from(scalar.width)
            }
            _ => 32,
        };
        self.componentwise(frame, handle, &[left, right], |walk, parts| {
            let right = walk.shift_amount(op, parts[1], bits);
            walk.terms.binary(op, operands, parts[0], right)
        })
    }

    /// The right side of an operation; the amount of a shift modulo the number of bits, as WGSL takes it at run time. naga does
    /// not accept a larger one as a literal.
    fn shift_amount(&mut self, op: BinaryOperator, right: TermId, bits: u32) -> TermId {
        let is_shift = matches!(op, BinaryOperator::ShiftLeft | BinaryOperator::ShiftRight);
        match self.terms.as_literal(right) {
            Some(Literal::U32(by)) if is_shift && by >= bits => {
                self.terms.literal(Literal::U32(by % bits))
            }
            _ => right,
        }
    }

    pub(super) fn relational(
        &mut self,
        frame: &mut Frame<'a>,
        fun: RelationalFunction,
        argument: Handle<Expression>,
    ) -> TermId {
        let value = self.term(frame, argument);
        let join = match fun {
            RelationalFunction::All => Terms::and,
            RelationalFunction::Any => Terms::or,
            _ => return self.terms.intern(Term::Relational(fun, value)),
        };
        let Some((size, _)) = self.followed_vector(frame, argument) else {
            return value;
        };
        let parts: Vec<_> = (0..size as u32)
            .map(|i| self.terms.extract(value, i))
            .collect();
        parts
            .into_iter()
            .reduce(|joined, part| join(&mut self.terms, joined, part))
            .unwrap_or(value)
    }

    pub(super) fn math(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        fun: MathFunction,
        arguments: &[Handle<Expression>],
    ) -> TermId {
        use MathFunction as M;
        match fun {
            M::Abs
            | M::Min
            | M::Max
            | M::Clamp
            | M::Sign
            | M::CountTrailingZeros
            | M::CountLeadingZeros
            | M::CountOneBits
            | M::ReverseBits
            | M::ExtractBits
            | M::InsertBits
            | M::FirstTrailingBit
            | M::FirstLeadingBit => self.componentwise(frame, handle, arguments, |walk, parts| {
                walk.terms.intern(Term::Math(fun, parts.into()))
            }),
            // an address may be `dot(gid.xy, vec2(1, width))`
            M::Dot if self.followed_vector(frame, arguments[0]).is_some() => {
                let (left, right) = (
                    self.term(frame, arguments[0]),
                    self.term(frame, arguments[1]),
                );
                let size = self
                    .followed_vector(frame, arguments[0])
                    .map_or(0, |(size, _)| size as u32);
                let products: Vec<_> = (0..size)
                    .map(|i| {
                        let (a, b) = (self.terms.extract(left, i), self.terms.extract(right, i));
                        self.terms
                            .binary(BinaryOperator::Multiply, Operands::Integers, a, b)
                    })
                    .collect();
                products
                    .into_iter()
                    .reduce(|sum, product| {
                        self.terms
                            .binary(BinaryOperator::Add, Operands::Integers, sum, product)
                    })
                    .unwrap_or(left)
            }
            _ => {
                let values = arguments.iter().map(|&a| self.term(frame, a)).collect();
                self.terms.intern(Term::Math(fun, values))
            }
        }
    }
}
