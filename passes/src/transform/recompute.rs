//! Writes the code that computes a [term](crate::analysis::term) for some invocation's ids.
//!
//! *Needs*: that the [plan](crate::plan) found the term computable, with the captures that it listed.
//! *Guarantees*: the same operations as the original's, on the same operands: for the same ids the same bits.

use naga::{BinaryOperator, BuiltIn, Expression, GlobalVariable, Handle, Scalar, SwizzleComponent};
use rustc_hash::FxHashMap;

use crate::{
    analysis::term::{Axis, Composite, Id, Query, Step, Term, TermId, Terms},
    ir::{build::Code, visit},
};

/// The member of the parameters that holds the original number of workgroups.
const PARAMS_GROUPS: u32 = 2;

/// Where an invocation's ids come from.
#[derive(Clone, Copy, Debug)]
pub struct Ids {
    /// The invocation's place in the grid, a `vec3<u32>`.
    pub pixel: Handle<Expression>,
    /// The original workgroup size.
    pub group_size: [TermId; 3],
    /// The parameters.
    pub params: Handle<GlobalVariable>,
    /// The width of the picture, where the dispatch numbers its pixels row by row.
    pub width: Option<TermId>,
}

/// Computes terms at one place.
pub struct Recompute<'t, 'm> {
    terms: &'t Terms<'m>,
    entry: usize,
    ids: Ids,
    known: FxHashMap<TermId, Handle<Expression>>,
}

impl<'t, 'm> Recompute<'t, 'm> {
    /// Starts from ids and from values that are at hand.
    pub fn new(
        terms: &'t Terms<'m>,
        entry: usize,
        ids: Ids,
        captured: impl IntoIterator<Item = (TermId, Handle<Expression>)>,
    ) -> Recompute<'t, 'm> {
        Recompute {
            terms,
            entry,
            ids,
            known: captured.into_iter().collect(),
        }
    }

    /// Computes a term.
    pub fn emit(&mut self, code: &mut Code, term: TermId) -> Handle<Expression> {
        if let Some(&known) = self.known.get(&term) {
            return known;
        }
        let handle = self.write(code, term);
        self.known.insert(term, handle);
        handle
    }

    fn write(&mut self, code: &mut Code, term: TermId) -> Handle<Expression> {
        let expression = match self.terms.get(term).clone() {
            Term::Literal(bits) => Expression::Literal(bits.0),
            Term::Constant(constant) => Expression::Constant(constant),
            Term::Override(handle) => Expression::Override(handle),
            Term::Zero(ty) => Expression::ZeroValue(ty),
            Term::Id(id) => return self.id(code, id),
            Term::Compose { ty, parts } => {
                let components = parts.iter().map(|&part| self.emit(code, part)).collect();
                let ty = match ty {
                    Composite::Type(ty) => ty,
                    Composite::Vector(size, scalar) => {
                        crate::ir::build::numeric(code.types, Some(size), scalar)
                    }
                };
                Expression::Compose { ty, components }
            }
            Term::Extract(base, index) => Expression::AccessIndex {
                base: self.emit(code, base),
                index,
            },
            Term::Index(base, index) => Expression::Access {
                base: self.emit(code, base),
                index: self.emit(code, index),
            },
            Term::Splat(size, value) => Expression::Splat {
                size,
                value: self.emit(code, value),
            },
            Term::Swizzle(size, vector, pattern) => Expression::Swizzle {
                size,
                vector: self.emit(code, vector),
                pattern: pattern.map(|i| SwizzleComponent::XYZW[i as usize]),
            },
            Term::Unary(op, value) => Expression::Unary {
                op,
                expr: self.emit(code, value),
            },
            Term::Binary(op, left, right) => Expression::Binary {
                op,
                left: self.emit(code, left),
                right: self.emit(code, right),
            },
            Term::Select(condition, accept, reject) => Expression::Select {
                condition: self.emit(code, condition),
                accept: self.emit(code, accept),
                reject: self.emit(code, reject),
            },
            Term::Relational(fun, argument) => Expression::Relational {
                fun,
                argument: self.emit(code, argument),
            },
            Term::Math(fun, arguments) => {
                let mut arguments = arguments.iter().map(|&argument| self.emit(code, argument));
                let (arg, arg1, arg2, arg3) = (
                    arguments.next(),
                    arguments.next(),
                    arguments.next(),
                    arguments.next(),
                );
                let Some(arg) = arg else {
                    unreachable!("a built-in function without arguments");
                };
                Expression::Math {
                    fun,
                    arg,
                    arg1,
                    arg2,
                    arg3,
                }
            }
            Term::As(kind, convert, value) => Expression::As {
                expr: self.emit(code, value),
                kind,
                convert,
            },
            Term::Load(global, path) => Expression::Load {
                pointer: self.part(code, global, &path),
            },
            Term::ArrayLength(global, path) => {
                Expression::ArrayLength(self.part(code, global, &path))
            }
            Term::Resource(global, path) => return self.part(code, global, &path),
            Term::ImageQuery(query, image, level) => Expression::ImageQuery {
                image: self.emit(code, image),
                query: match query {
                    Query::Size => naga::ImageQuery::Size {
                        level: level.map(|level| self.emit(code, level)),
                    },
                    Query::Levels => naga::ImageQuery::NumLevels,
                    Query::Layers => naga::ImageQuery::NumLayers,
                    Query::Samples => naga::ImageQuery::NumSamples,
                },
            },
            Term::Original {
                function,
                expression,
                operands,
            } => {
                let original = function.get(self.terms.module(), self.entry);
                let mut copy = original.expressions[expression].clone();
                let mut operands = operands.iter().map(|&operand| self.emit(code, operand));
                visit::operands_mut(&mut copy, &mut |slot| {
                    if let Some(operand) = operands.next() {
                        *slot = operand;
                    }
                });
                copy
            }
            Term::Call(function, arguments) => {
                let arguments = arguments.iter().map(|&a| self.emit(code, a)).collect();
                return code.value_of(function, arguments);
            }
            Term::Insert(..)
            | Term::Update(..)
            | Term::LoopVar { .. }
            | Term::LoopExit { .. }
            | Term::Merge { .. }
            | Term::Opaque { .. } => unreachable!("the plan found this term computable"),
        };
        code.add(expression)
    }

    /// One of the ids.
    fn id(&mut self, code: &mut Code, id: Id) -> Handle<Expression> {
        use BinaryOperator as B;
        match id {
            Id::Global(axis) => code.at(self.ids.pixel, u32::from(axis)),
            Id::Local(axis) => self.divided(code, B::Modulo, axis),
            Id::Group(axis) => self.divided(code, B::Divide, axis),
            Id::LocalIndex => {
                let [x, y, z] = [0, 1, 2].map(|axis| self.divided(code, B::Modulo, axis));
                let [width, height, _] = self.ids.group_size;
                let (width, height) = (self.emit(code, width), self.emit(code, height));
                let row = code.binary(B::Multiply, z, height);
                let row = code.binary(B::Add, row, y);
                let row = code.binary(B::Multiply, row, width);
                code.binary(B::Add, row, x)
            }
            Id::GroupCount(axis) => {
                let groups = code.global_member(self.ids.params, PARAMS_GROUPS);
                code.at(groups, u32::from(axis))
            }
        }
    }

    fn divided(&mut self, code: &mut Code, op: BinaryOperator, axis: Axis) -> Handle<Expression> {
        let place = code.at(self.ids.pixel, u32::from(axis));
        let size = self.emit(code, self.ids.group_size[axis as usize]);
        code.binary(op, place, size)
    }

    /// The value of an id builtin, whole.
    pub fn builtin(&mut self, code: &mut Code, builtin: BuiltIn) -> Option<Handle<Expression>> {
        use BinaryOperator as B;
        if let Some(width) = self.ids.width
            && let Some(value) = self.linear_builtin(code, builtin, width)
        {
            return Some(value);
        }
        Some(match builtin {
            BuiltIn::GlobalInvocationId => self.ids.pixel,
            BuiltIn::LocalInvocationId => {
                let size = self.group_size(code);
                code.binary(B::Modulo, self.ids.pixel, size)
            }
            BuiltIn::WorkGroupId => {
                let size = self.group_size(code);
                code.binary(B::Divide, self.ids.pixel, size)
            }
            BuiltIn::LocalInvocationIndex => self.id(code, Id::LocalIndex),
            BuiltIn::NumWorkGroups => code.global_member(self.ids.params, PARAMS_GROUPS),
            BuiltIn::WorkGroupSize => self.group_size(code),
            _ => return None,
        })
    }

    /// An id of invocation `y * width + x` of a one-dimensional dispatch.
    fn linear_builtin(
        &mut self,
        code: &mut Code,
        builtin: BuiltIn,
        width: TermId,
    ) -> Option<Handle<Expression>> {
        use BinaryOperator as B;
        let op = match builtin {
            BuiltIn::GlobalInvocationId => None,
            BuiltIn::LocalInvocationId | BuiltIn::LocalInvocationIndex => Some(B::Modulo),
            BuiltIn::WorkGroupId => Some(B::Divide),
            _ => return None,
        };
        let width = self.emit(code, width);
        let [x, y] = [0, 1].map(|axis| code.at(self.ids.pixel, axis));
        let row = code.binary(B::Multiply, y, width);
        let mut value = code.binary(B::Add, row, x);
        if let Some(op) = op {
            let size = self.emit(code, self.ids.group_size[0]);
            value = code.binary(op, value, size);
        }
        if builtin == BuiltIn::LocalInvocationIndex {
            return Some(value);
        }
        let zero = code.u32(0);
        Some(code.vector(Scalar::U32, vec![value, zero, zero]))
    }

    fn group_size(&mut self, code: &mut Code) -> Handle<Expression> {
        let sizes = self.ids.group_size.map(|size| self.emit(code, size));
        code.vector(Scalar::U32, sizes.to_vec())
    }

    /// A pointer to a part of a variable, or an element of a binding array.
    fn part(
        &mut self,
        code: &mut Code,
        global: Handle<GlobalVariable>,
        path: &[Step],
    ) -> Handle<Expression> {
        let mut pointer = code.add(Expression::GlobalVariable(global));
        for step in path {
            pointer = match *step {
                Step::Index(index) => code.at(pointer, index),
                Step::Dynamic(index) => {
                    let index = self.emit(code, index);
                    code.add(Expression::Access {
                        base: pointer,
                        index,
                    })
                }
            };
        }
        pointer
    }
}
