//! Terms of what the module fixes: constants, overrides, zero values.

use naga::{Constant, Expression, Handle, Literal, ScalarKind, Type, TypeInner};

use super::{Composite, Opacity, Operands, Term, TermId, Terms, followed};

impl Terms<'_> {
    /// The value of a global expression: a constant's or override's initialiser, or a workgroup size.
    pub fn global_expression(&mut self, handle: Handle<Expression>) -> TermId {
        match self.module.global_expressions[handle] {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(constant),
            Expression::Override(handle) => self.intern(Term::Override(handle)),
            Expression::ZeroValue(ty) => self.zero(ty),
            Expression::Compose { ty, ref components } => {
                let parts = components
                    .iter()
                    .map(|&part| {
                        let part = self.global_expression(part);
                        (part, self.width(part).unwrap_or(1))
                    })
                    .collect();
                self.compose_flat(ty, parts)
            }
            Expression::Splat { size, value } => {
                let value = self.global_expression(value);
                self.intern(Term::Splat(size, value))
            }
            Expression::Unary { op, expr } => {
                let value = self.global_expression(expr);
                self.intern(Term::Unary(op, value))
            }
            Expression::Binary { op, left, right } => {
                let left = self.global_expression(left);
                let right = self.global_expression(right);
                self.binary(op, Operands::Other, left, right)
            }
            Expression::As {
                expr,
                kind,
                convert,
            } => {
                let value = self.global_expression(expr);
                self.intern(Term::As(kind, convert, value))
            }
            _ => self.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    /// A constant integer as a `u32`: a workgroup size may be an `i32`, too.
    pub fn unsigned(&mut self, value: TermId) -> TermId {
        match self.as_literal(value) {
            Some(Literal::I32(n)) => return self.literal(Literal::U32(n as u32)),
            Some(_) => return value,
            None => {}
        }
        match self.is_signed(value) {
            true => self.intern(Term::As(ScalarKind::Uint, Some(4), value)),
            false => value,
        }
    }

    fn is_signed(&self, value: TermId) -> bool {
        match *self.get(value) {
            Term::Override(handle) => {
                let ty = self.module.overrides[handle].ty;
                self.module.types[ty].inner.scalar_kind() == Some(ScalarKind::Sint)
            }
            Term::Literal(bits) => matches!(bits.0, Literal::I32(_)),
            Term::As(kind, ..) => kind == ScalarKind::Sint,
            Term::Unary(_, inner) => self.is_signed(inner),
            Term::Binary(_, left, _) => self.is_signed(left),
            _ => false,
        }
    }

    /// The value of a module constant.
    pub fn constant(&mut self, handle: Handle<Constant>) -> TermId {
        match self.module.types[self.module.constants[handle].ty].inner {
            TypeInner::Scalar(_) | TypeInner::Vector { .. } => {
                self.global_expression(self.module.constants[handle].init)
            }
            _ => self.intern(Term::Constant(handle)),
        }
    }

    /// The zero value of a type.
    pub fn zero(&mut self, ty: Handle<Type>) -> TermId {
        match self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => match Literal::zero(scalar) {
                Some(literal) => self.literal(literal),
                None => self.intern(Term::Zero(ty)),
            },
            TypeInner::Vector { size, scalar } if followed(scalar) => match Literal::zero(scalar) {
                Some(literal) => {
                    let zero = self.literal(literal);
                    self.compose(Composite::Type(ty), vec![zero; size as usize])
                }
                None => self.intern(Term::Zero(ty)),
            },
            _ => self.intern(Term::Zero(ty)),
        }
    }

    pub(super) fn zero_part(&mut self, ty: Handle<Type>, index: u32) -> Option<TermId> {
        match self.module.types[ty].inner {
            TypeInner::Vector { scalar, .. } => {
                Literal::zero(scalar).map(|literal| self.literal(literal))
            }
            TypeInner::Array { base, .. } => Some(self.zero(base)),
            TypeInner::Struct { ref members, .. } => {
                let ty = members.get(index as usize)?.ty;
                Some(self.zero(ty))
            }
            _ => None,
        }
    }
}
