//! The expressions of the symbolic walk: one naga expression in, one [term](super::term) or place out.

mod operations;
mod places;

use std::rc::Rc;

use naga::{Expression, GlobalVariable, Handle, Scalar, TypeInner, VectorSize};

use super::{
    AccessKind,
    env::Variable,
    term::{self, Opacity, Step, Term, TermId, followed},
    walk::{Frame, Walk},
};
use crate::ir::visit;
use places::pointer;

/// What an expression is.
#[derive(Clone, Debug)]
pub enum Value {
    /// A value.
    Term(TermId),
    /// A pointer.
    Place(Rc<Place>),
}

/// What a pointer points to.
#[derive(Clone, Debug)]
pub struct Place {
    /// The variable.
    pub root: Root,
    /// The part of it.
    pub steps: Vec<Step>,
}

/// The variable behind a pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Root {
    /// A variable whose value is followed.
    Variable(Variable),
    /// A buffer.
    Memory(Handle<GlobalVariable>),
    /// A `var<workgroup>`.
    WorkGroup(Handle<GlobalVariable>),
    /// Something that the analysis does not follow.
    Unfollowed,
}

impl<'a> Walk<'a> {
    /// The term of an expression; a pointer has none.
    pub(super) fn term(&mut self, frame: &mut Frame<'a>, handle: Handle<Expression>) -> TermId {
        match self.value(frame, handle) {
            Value::Term(term) => term,
            Value::Place(_) => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    /// The place that a pointer expression points to.
    pub(super) fn place(&mut self, frame: &mut Frame<'a>, handle: Handle<Expression>) -> Rc<Place> {
        match self.value(frame, handle) {
            Value::Place(place) => place,
            Value::Term(_) => Rc::new(Place {
                root: Root::Unfollowed,
                steps: Vec::new(),
            }),
        }
    }

    /// What an expression is; found when it is emitted, or at the first use of what needs no emission.
    pub(super) fn value(&mut self, frame: &mut Frame<'a>, handle: Handle<Expression>) -> Value {
        if let Some(known) = &frame.values[handle.index()] {
            return known.clone();
        }
        let value = self.evaluate(frame, handle);
        frame.values[handle.index()] = Some(value.clone());
        value
    }

    fn evaluate(&mut self, frame: &mut Frame<'a>, handle: Handle<Expression>) -> Value {
        let function = frame.function;
        let term = match function.expressions[handle] {
            Expression::FunctionArgument(index) => return frame.arguments[index as usize].clone(),
            Expression::GlobalVariable(global) => return self.global(global),
            Expression::LocalVariable(local) => {
                return pointer(Root::Variable(Variable::Local {
                    frame: frame.id,
                    local,
                }));
            }
            Expression::Access { base, index } => {
                let index = self.term(frame, index);
                return self.step(frame, base, Step::Dynamic(index));
            }
            Expression::AccessIndex { base, index } => {
                return self.step(frame, base, Step::Index(index));
            }
            Expression::Load { pointer } => {
                let place = self.place(frame, pointer);
                self.load(frame, handle, &place)
            }
            Expression::Literal(literal) => self.terms.literal(literal),
            Expression::Constant(constant) => self.terms.constant(constant),
            Expression::Override(handle) => self.terms.intern(Term::Override(handle)),
            Expression::ZeroValue(ty) => self.terms.zero(ty),
            Expression::Compose { ty, ref components } => {
                let parts = components
                    .iter()
                    .map(|&component| {
                        let width = match *self.inner(frame, component) {
                            TypeInner::Vector { size, .. } => size as u32,
                            _ => 1,
                        };
                        (self.term(frame, component), width)
                    })
                    .collect();
                self.terms.compose_flat(ty, parts)
            }
            Expression::Splat { size, value } => {
                let value = self.term(frame, value);
                match self.followed_vector(frame, handle) {
                    Some((_, scalar)) => self.terms.vector(scalar, vec![value; size as usize]),
                    None => self.terms.intern(Term::Splat(size, value)),
                }
            }
            Expression::Swizzle {
                size,
                vector,
                pattern,
            } => {
                let vector = self.term(frame, vector);
                match self.followed_vector(frame, handle) {
                    Some((_, scalar)) => {
                        let parts = pattern[..size as usize]
                            .iter()
                            .map(|component| self.terms.extract(vector, component.index()))
                            .collect();
                        self.terms.vector(scalar, parts)
                    }
                    None => {
                        let pattern = pattern.map(term::component);
                        self.terms.intern(Term::Swizzle(size, vector, pattern))
                    }
                }
            }
            Expression::Unary { op, expr } => {
                self.componentwise(frame, handle, &[expr], |walk, parts| {
                    walk.terms.intern(Term::Unary(op, parts[0]))
                })
            }
            Expression::Binary { op, left, right } => self.binary(frame, handle, op, left, right),
            Expression::Select {
                condition,
                accept,
                reject,
            } => self.componentwise(
                frame,
                handle,
                &[condition, accept, reject],
                |walk, parts| walk.terms.select(parts[0], parts[1], parts[2]),
            ),
            Expression::Relational { fun, argument } => self.relational(frame, fun, argument),
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3,
            } => {
                let arguments: Vec<_> = [Some(arg), arg1, arg2, arg3]
                    .into_iter()
                    .flatten()
                    .collect();
                self.math(frame, handle, fun, &arguments)
            }
            Expression::As {
                expr,
                kind,
                convert,
            } => self.componentwise(frame, handle, &[expr], |walk, parts| {
                walk.terms.cast(kind, convert, parts[0])
            }),
            Expression::ArrayLength(pointer) => {
                let place = self.place(frame, pointer);
                match place.root {
                    Root::Memory(global) => {
                        let steps = place.steps.clone().into();
                        self.terms.intern(Term::ArrayLength(global, steps))
                    }
                    _ => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
                }
            }
            Expression::ImageQuery { image, ref query } => {
                let level = match *query {
                    naga::ImageQuery::Size { level } => level.map(|l| self.term(frame, l)),
                    _ => None,
                };
                let image = self.term(frame, image);
                self.terms
                    .intern(Term::ImageQuery(query.into(), image, level))
            }
            Expression::ImageLoad {
                image,
                coordinate,
                array_index,
                ..
            } => match self.written_texture(frame, image) {
                Some(target) => {
                    let address = self.texel(frame, coordinate, array_index);
                    let operands = address.terms();
                    let global = target.global;
                    // naga's GLSL front end gives `imageLoad` no place
                    let span = [handle, coordinate, image]
                        .map(|of| function.expressions.get_span(of))
                        .into_iter()
                        .find(|span| span.is_defined())
                        .unwrap_or_default();
                    self.note_access(
                        frame,
                        AccessKind::Load { value: handle },
                        target,
                        address,
                        span,
                    );
                    self.terms.opaque(Opacity::Written(global), operands)
                }
                None => self.original(frame, handle),
            },
            Expression::ImageSample { .. } | Expression::Derivative { .. } => {
                self.original(frame, handle)
            }
            Expression::RayQueryGetIntersection { .. }
            | Expression::RayQueryVertexPositions { .. } => {
                self.terms.opaque(Opacity::RayQuery, Vec::new())
            }
            Expression::CooperativeLoad { .. } | Expression::CooperativeMultiplyAdd { .. } => {
                self.terms.opaque(Opacity::Subgroup, Vec::new())
            }
            // results are set by the statements that give them
            Expression::CallResult(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. }
            | Expression::RayQueryProceedResult
            | Expression::SubgroupBallotResult
            | Expression::SubgroupOperationResult { .. } => {
                self.terms.opaque(Opacity::Unfollowed, Vec::new())
            }
        };
        Value::Term(term)
    }

    fn original(&mut self, frame: &mut Frame<'a>, expression: Handle<Expression>) -> TermId {
        let mut operands = Vec::new();
        visit::operands(&frame.function.expressions[expression], &mut |&operand| {
            operands.push(operand);
        });
        let operands = operands.into_iter().map(|o| self.term(frame, o)).collect();
        self.terms.intern(Term::Original {
            function: frame.of,
            expression,
            operands,
        })
    }

    fn inner(&self, frame: &Frame<'a>, handle: Handle<Expression>) -> &'a TypeInner {
        frame.info[handle].ty.inner_with(&self.module.types)
    }

    /// The size and scalar of an expression that is a vector of integers or booleans.
    fn followed_vector(
        &self,
        frame: &Frame<'a>,
        handle: Handle<Expression>,
    ) -> Option<(VectorSize, Scalar)> {
        match *self.inner(frame, handle) {
            TypeInner::Vector { size, scalar } if followed(scalar) => Some((size, scalar)),
            _ => None,
        }
    }
}
