//! The expressions of the symbolic walk: one naga expression in, one [term](super::term) or place out.

use std::rc::Rc;

use naga::{
    AddressSpace, BinaryOperator, Expression, GlobalVariable, Handle, ImageClass, Literal,
    MathFunction, RelationalFunction, Scalar, TypeInner, VectorSize,
};

use super::{
    AccessKind, Address, Target, Tie,
    env::Variable,
    term::{self, Opacity, Operands, Step, Term, TermId, followed},
    walk::{Frame, Walk},
};
use crate::ir::visit;

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
                    let span = function.expressions.get_span(handle);
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

    fn global(&mut self, global: Handle<GlobalVariable>) -> Value {
        match self.module.global_variables[global].space {
            AddressSpace::Private => pointer(Root::Variable(Variable::Private(global))),
            AddressSpace::WorkGroup => pointer(Root::WorkGroup(global)),
            AddressSpace::Uniform | AddressSpace::Storage { .. } | AddressSpace::Immediate => {
                // a binding array of buffers is a handle until it is indexed; both are places here
                pointer(Root::Memory(global))
            }
            AddressSpace::Handle => {
                Value::Term(self.terms.intern(Term::Resource(global, Box::new([]))))
            }
            _ => pointer(Root::Unfollowed),
        }
    }

    /// A part of a value, or a pointer to a part.
    fn step(&mut self, frame: &mut Frame<'a>, base: Handle<Expression>, step: Step) -> Value {
        match self.value(frame, base) {
            Value::Place(place) => {
                let mut place = (*place).clone();
                place.steps.push(self.constant_step(step));
                Value::Place(Rc::new(place))
            }
            Value::Term(base) => {
                if let Term::Resource(global, steps) = self.terms.get(base) {
                    let (global, mut steps) = (*global, steps.to_vec());
                    steps.push(self.constant_step(step));
                    return Value::Term(self.terms.intern(Term::Resource(global, steps.into())));
                }
                Value::Term(match step {
                    Step::Index(index) => self.terms.extract(base, index),
                    Step::Dynamic(index) => self.terms.index(base, index),
                })
            }
        }
    }

    fn constant_step(&self, step: Step) -> Step {
        match step {
            Step::Dynamic(index) => match self.terms.as_literal(index) {
                Some(Literal::U32(index)) => Step::Index(index),
                Some(Literal::I32(index)) if index >= 0 => Step::Index(index as u32),
                _ => step,
            },
            Step::Index(_) => step,
        }
    }

    fn load(&mut self, frame: &mut Frame<'a>, handle: Handle<Expression>, place: &Place) -> TermId {
        match place.root {
            Root::Variable(variable) => {
                let whole = self.variable(frame, variable);
                self.part(whole, &place.steps)
            }
            Root::Memory(global) => self.load_memory(frame, handle, global, place),
            Root::WorkGroup(global) => {
                let span = frame.function.expressions.get_span(handle);
                self.note_tie(frame, Tie::WorkGroup(global), span);
                let operands = dynamic(&place.steps);
                self.terms.opaque(Opacity::WorkGroup, operands)
            }
            Root::Unfollowed => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    fn load_memory(
        &mut self,
        frame: &mut Frame<'a>,
        handle: Handle<Expression>,
        global: Handle<GlobalVariable>,
        place: &Place,
    ) -> TermId {
        if self
            .facts
            .is_written(global, &leading_constants(&place.steps))
        {
            let span = frame.function.expressions.get_span(handle);
            let target = Target {
                global,
                element: Vec::new(),
            };
            let address = Address::Part(place.steps.clone());
            self.note_access(
                frame,
                AccessKind::Load { value: handle },
                target,
                address,
                span,
            );
            return self
                .terms
                .opaque(Opacity::Written(global), dynamic(&place.steps));
        }
        // vectors and matrices are loaded whole, so that all ways to a component give one term
        let mut whole = 0;
        while whole < place.steps.len()
            && matches!(
                self.terms.loaded(global, &place.steps[..whole]),
                Some(
                    TypeInner::Struct { .. }
                        | TypeInner::Array { .. }
                        | TypeInner::BindingArray { .. }
                )
            )
        {
            whole += 1;
        }
        let (path, rest) = place.steps.split_at(whole);
        let loaded = self.terms.intern(Term::Load(global, path.into()));
        self.part(loaded, rest)
    }

    fn part(&mut self, mut value: TermId, steps: &[Step]) -> TermId {
        for step in steps {
            value = match *step {
                Step::Index(index) => self.terms.extract(value, index),
                Step::Dynamic(index) => self.terms.index(value, index),
            };
        }
        value
    }

    /// What a variable holds; what it starts with, if nothing was stored yet.
    pub(super) fn variable(&mut self, frame: &mut Frame<'a>, variable: Variable) -> TermId {
        if let Some(value) = self.env.get(variable) {
            return value;
        }
        let value = match variable {
            Variable::Local { frame: of, local } if of == frame.id => {
                let local = &frame.function.local_variables[local];
                match local.init {
                    Some(init) => self.term(frame, init),
                    None => self.terms.zero(local.ty),
                }
            }
            // a caller's variable: its own frame has set it before it could hand out a pointer, or never will
            Variable::Local { .. } => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
            Variable::Private(global) => {
                let global = &self.module.global_variables[global];
                match global.init {
                    Some(init) => self.terms.global_expression(init),
                    None => self.terms.zero(global.ty),
                }
            }
        };
        self.env.set(variable, value);
        value
    }

    /// Replaces a part of a value.
    pub(super) fn with_part(&mut self, whole: TermId, steps: &[Step], value: TermId) -> TermId {
        let Some((step, rest)) = steps.split_first() else {
            return value;
        };
        match *step {
            Step::Index(index) => {
                let part = self.terms.extract(whole, index);
                let part = self.with_part(part, rest, value);
                self.terms.insert(whole, index, part)
            }
            Step::Dynamic(index) => {
                let part = self.terms.index(whole, index);
                let part = self.with_part(part, rest, value);
                self.terms.intern(Term::Update(whole, index, part))
            }
        }
    }

    /// The texture behind an expression, if the shader writes it.
    pub(super) fn written_texture(
        &mut self,
        frame: &mut Frame<'a>,
        image: Handle<Expression>,
    ) -> Option<Target> {
        let image = self.term(frame, image);
        let Term::Resource(global, element) = self.terms.get(image) else {
            return None;
        };
        let is_storage = matches!(
            self.terms.loaded(*global, element),
            Some(TypeInner::Image {
                class: ImageClass::Storage { .. },
                ..
            })
        );
        (is_storage && self.facts.is_written_anywhere(*global)).then(|| Target {
            global: *global,
            element: element.to_vec(),
        })
    }

    /// The place of a texel.
    pub(super) fn texel(
        &mut self,
        frame: &mut Frame<'a>,
        coordinate: Handle<Expression>,
        layer: Option<Handle<Expression>>,
    ) -> Address {
        let at = self.term(frame, coordinate);
        let coordinate = match self.inner(frame, coordinate) {
            &TypeInner::Vector { size, .. } => (0..size as u32)
                .map(|i| self.terms.extract(at, i))
                .collect(),
            _ => vec![at],
        };
        Address::Texel {
            coordinate,
            layer: layer.map(|layer| self.term(frame, layer)),
        }
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

    /// Applies an operation to each component where the result is a vector of integers or booleans, else to the whole.
    fn componentwise(
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

    fn binary(
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
        self.componentwise(frame, handle, &[left, right], |walk, parts| {
            walk.terms.binary(op, operands, parts[0], parts[1])
        })
    }

    fn relational(
        &mut self,
        frame: &mut Frame<'a>,
        fun: RelationalFunction,
        argument: Handle<Expression>,
    ) -> TermId {
        let value = self.term(frame, argument);
        let vector = self.followed_vector(frame, argument);
        match (fun, vector) {
            (RelationalFunction::All, Some((size, _))) => {
                let parts: Vec<_> = (0..size as u32)
                    .map(|i| self.terms.extract(value, i))
                    .collect();
                parts
                    .into_iter()
                    .reduce(|all, part| self.terms.and(all, part))
                    .unwrap_or(value)
            }
            (RelationalFunction::Any, Some((size, _))) => {
                let parts: Vec<_> = (0..size as u32)
                    .map(|i| self.terms.extract(value, i))
                    .collect();
                parts
                    .into_iter()
                    .reduce(|any, part| self.terms.or(any, part))
                    .unwrap_or(value)
            }
            (RelationalFunction::All | RelationalFunction::Any, None) => value,
            _ => self.terms.intern(Term::Relational(fun, value)),
        }
    }

    fn math(
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

fn pointer(root: Root) -> Value {
    Value::Place(Rc::new(Place {
        root,
        steps: Vec::new(),
    }))
}

/// The computed indices among steps.
pub(super) fn dynamic(steps: &[Step]) -> Vec<TermId> {
    steps
        .iter()
        .filter_map(|step| match *step {
            Step::Dynamic(index) => Some(index),
            Step::Index(_) => None,
        })
        .collect()
}

/// The steps before the first computed index.
pub(super) fn leading_constants(steps: &[Step]) -> Vec<u32> {
    steps
        .iter()
        .map_while(|step| match *step {
            Step::Index(index) => Some(index),
            Step::Dynamic(_) => None,
        })
        .collect()
}
