//! The value graph: what every expression of a shader is, as a function of the invocation's ids.
//!
//! The [walk](super::walk) runs the shader once, symbolically, from its entry point through every call, and names each
//! value with a [`Term`]. Terms are hash-consed, so two expressions that compute the same thing from the same things
//! get the same [`TermId`]: an address that is read is an address that is stored if their terms are equal.
//!
//! Integers and booleans are kept as scalars, so that each component of a coordinate is followed on its own; vectors of
//! floats stay whole. Locals and private variables do not occur: a load yields the value stored. Where control flow
//! joins, a value is a [`Term::Select`] of its condition; around a loop, it is a [`Term::LoopVar`].
//!
//! *Guarantees*: a term without [`Term::Opaque`], [`Term::LoopVar`], [`Term::LoopExit`] and [`Term::Merge`] can be
//! computed anywhere, from the ids alone (see [`recompute`](crate::transform::recompute)).

mod constants;
mod rebuild;
mod simplify;

use std::hash::{Hash, Hasher};

use naga::{
    BinaryOperator, Bytes, Constant, Expression, Function, GlobalVariable, Handle, ImageQuery,
    Literal, MathFunction, Module, Override, RelationalFunction, Scalar, ScalarKind,
    SwizzleComponent, Type, TypeInner, UnaryOperator, VectorSize,
};
use rustc_hash::{FxHashMap, FxHashSet};

use super::FunctionRef;

/// A value of the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TermId(pub(in crate::analysis) u32);

/// An axis of the invocation grid: 0, 1 or 2.
pub type Axis = u8;

/// A literal, compared by its bits: a NaN equals itself, and 0 differs from −0.
#[derive(Clone, Copy, Debug)]
pub struct Bits(pub Literal);

impl Bits {
    fn key(self) -> (u8, u64) {
        match self.0 {
            Literal::F64(v) => (0, v.to_bits()),
            Literal::F32(v) => (1, u64::from(v.to_bits())),
            Literal::F16(v) => (2, u64::from(v.to_bits())),
            Literal::U16(v) => (3, u64::from(v)),
            Literal::I16(v) => (4, v as u64),
            Literal::U32(v) => (5, u64::from(v)),
            Literal::I32(v) => (6, v as u64),
            Literal::U64(v) => (7, v),
            Literal::I64(v) => (8, v as u64),
            Literal::Bool(v) => (9, u64::from(v)),
            Literal::AbstractInt(v) => (10, v as u64),
            Literal::AbstractFloat(v) => (11, v.to_bits()),
        }
    }
}

impl PartialEq for Bits {
    fn eq(&self, other: &Bits) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Bits {}

impl Hash for Bits {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

/// One of the ids that a compute invocation can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Id {
    /// `global_invocation_id`
    Global(Axis),
    /// `local_invocation_id`
    Local(Axis),
    /// `local_invocation_index`
    LocalIndex,
    /// `workgroup_id`
    Group(Axis),
    /// `num_workgroups`
    GroupCount(Axis),
}

/// A step from a variable into a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// A struct member, or an element at a constant place.
    Index(u32),
    /// An element at a computed place.
    Dynamic(TermId),
}

/// Why a value cannot be computed a second time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Opacity {
    /// It was loaded from memory that the shader writes.
    Written(Handle<GlobalVariable>),
    /// An atomic gave it.
    Atomic,
    /// It was loaded from `var<workgroup>` memory.
    WorkGroup,
    /// A subgroup or quad operation gave it.
    Subgroup,
    /// A ray query gave it.
    RayQuery,
    /// A function with effects of its own gave it.
    Effect,
    /// An index lies beyond the end of what it indexes.
    Beyond,
    /// A form that the analysis does not follow.
    Unfollowed,
}

/// How a value comes about.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Term {
    /// A literal.
    Literal(Bits),
    /// A module constant that is not a number.
    Constant(Handle<Constant>),
    /// A pipeline-overridable constant.
    Override(Handle<Override>),
    /// The zero value of a type.
    Zero(Handle<Type>),
    /// An id of the invocation.
    Id(Id),
    /// A vector, matrix, array or struct of its parts.
    Compose {
        /// The type; `None` for a vector that the analysis itself put together.
        ty: Composite,
        /// The parts, in order.
        parts: Box<[TermId]>,
    },
    /// One part of a value.
    Extract(TermId, u32),
    /// One element of a value, at a computed place.
    Index(TermId, TermId),
    /// A value with one part replaced.
    Insert(TermId, u32, TermId),
    /// A value with one element replaced, at a computed place.
    Update(TermId, TermId, TermId),
    /// A vector of equal components.
    Splat(VectorSize, TermId),
    /// A shuffle of a float vector.
    Swizzle(VectorSize, TermId, [u8; 4]),
    /// A unary operation.
    Unary(UnaryOperator, TermId),
    /// A binary operation.
    Binary(BinaryOperator, TermId, TermId),
    /// `select(reject, accept, condition)`, in the order condition, accept, reject.
    Select(TermId, TermId, TermId),
    /// `all`, `any`.
    Relational(RelationalFunction, TermId),
    /// A built-in function.
    Math(MathFunction, Box<[TermId]>),
    /// A conversion, or a bit cast where the width is `None`.
    As(ScalarKind, Option<Bytes>, TermId),
    /// A value loaded from memory that the shader does not write.
    Load(Handle<GlobalVariable>, Box<[Step]>),
    /// `arrayLength`
    ArrayLength(Handle<GlobalVariable>, Box<[Step]>),
    /// A texture or sampler itself.
    Resource(Handle<GlobalVariable>, Box<[Step]>),
    /// A size or count of a texture.
    ImageQuery(Query, TermId, Option<TermId>),
    /// A texture fetch or another pure expression, kept as its original with other operands.
    Original {
        /// The function that holds the original.
        function: FunctionRef,
        /// The original.
        expression: Handle<Expression>,
        /// The operands, in the order of [`visit::operands`](crate::ir::visit::operands).
        operands: Box<[TermId]>,
    },
    /// The result of a function that has no effects and reads nothing but its arguments and read-only memory.
    Call(Handle<Function>, Box<[TermId]>),
    /// The value of a variable on entering an iteration of a loop.
    LoopVar {
        /// The loop.
        of: LoopId,
        /// The variable, numbered within the loop.
        var: u32,
        /// The part of the variable.
        part: Box<[u32]>,
    },
    /// The value of a variable after a loop.
    LoopExit {
        /// The loop.
        of: LoopId,
        /// The variable, numbered within the loop.
        var: u32,
        /// The part of the variable.
        part: Box<[u32]>,
    },
    /// One of several values; which one depends on the conditions.
    Merge {
        /// What sets it apart from another merge of the same values.
        id: u32,
        /// The values.
        values: Box<[TermId]>,
        /// Everything that has a say in the choice.
        conditions: Box<[TermId]>,
    },
    /// A value that cannot be computed a second time.
    Opaque {
        /// What sets it apart from every other.
        id: u32,
        /// Why.
        why: Opacity,
        /// What it depends on besides.
        operands: Box<[TermId]>,
    },
}

/// The type of a [`Term::Compose`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Composite {
    /// A type of the module.
    Type(Handle<Type>),
    /// A vector that the module may not name.
    Vector(VectorSize, Scalar),
}

/// What is asked of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Query {
    /// `textureDimensions`
    Size,
    /// `textureNumLevels`
    Levels,
    /// `textureNumLayers`
    Layers,
    /// `textureNumSamples`
    Samples,
}

impl From<&ImageQuery> for Query {
    fn from(query: &ImageQuery) -> Query {
        match query {
            ImageQuery::Size { .. } => Query::Size,
            ImageQuery::NumLevels => Query::Levels,
            ImageQuery::NumLayers => Query::Layers,
            ImageQuery::NumSamples => Query::Samples,
        }
    }
}

/// What a binary operation works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operands {
    /// Integer scalars, which commute freely.
    Integers,
    /// Anything else: a matrix product does not commute, and float sums keep the author's order.
    Other,
}

/// A loop, once for each path of calls that leads to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LoopId(pub(in crate::analysis) u32);

impl LoopId {
    /// Its place among [`Terms::loops`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What is known of a variable that a loop changes.
#[derive(Clone, Debug)]
pub struct LoopVariable {
    /// Its value before the loop.
    pub before: TermId,
    /// Its value at the end of an iteration that is followed by another.
    pub next: Option<TermId>,
    /// Its values where the loop is left.
    pub after: Vec<TermId>,
}

/// A loop's variables and conditions.
#[derive(Clone, Debug, Default)]
pub struct Loop {
    /// The variables that it changes.
    pub variables: Vec<LoopVariable>,
    /// Everything that has a say in when the loop is left.
    pub conditions: Vec<TermId>,
}

/// The graph.
pub struct Terms<'a> {
    module: &'a Module,
    terms: Vec<Term>,
    index: FxHashMap<Term, TermId>,
    /// The loops met so far.
    pub loops: Vec<Loop>,
    /// The width of the picture, where the dispatch numbers its pixels row by row.
    pub width: Option<TermId>,
    /// The sides of the workgroup, where they are numbers.
    pub sides: Option<[u32; 3]>,
    /// What a call comes to, where its body was followed.
    pub expansions: FxHashMap<TermId, TermId>,
    fresh: u32,
}

impl<'a> Terms<'a> {
    /// An empty graph over a module.
    pub fn new(module: &'a Module) -> Terms<'a> {
        Terms {
            module,
            terms: Vec::new(),
            index: FxHashMap::default(),
            loops: Vec::new(),
            width: None,
            sides: None,
            expansions: FxHashMap::default(),
            fresh: 0,
        }
    }

    /// The module whose values these are.
    pub fn module(&self) -> &'a Module {
        self.module
    }

    /// All values, in the order in which they were met.
    pub fn all(&self) -> impl Iterator<Item = &Term> {
        self.terms.iter()
    }

    /// How a value comes about.
    pub fn get(&self, id: TermId) -> &Term {
        &self.terms[id.0 as usize]
    }

    /// Adds a term as it stands, or finds it.
    pub fn intern(&mut self, term: Term) -> TermId {
        if let Some(&id) = self.index.get(&term) {
            return id;
        }
        let id = TermId(self.terms.len() as u32);
        self.terms.push(term.clone());
        self.index.insert(term, id);
        id
    }

    /// A number that no other merge or opaque value has.
    pub fn fresh(&mut self) -> u32 {
        self.fresh += 1;
        self.fresh
    }

    /// A literal.
    pub fn literal(&mut self, literal: Literal) -> TermId {
        self.intern(Term::Literal(Bits(literal)))
    }

    /// A `bool` literal.
    pub fn bool(&mut self, value: bool) -> TermId {
        self.literal(Literal::Bool(value))
    }

    /// A value that cannot be computed a second time.
    pub fn opaque(&mut self, why: Opacity, operands: Vec<TermId>) -> TermId {
        let id = self.fresh();
        self.intern(Term::Opaque {
            id,
            why,
            operands: operands.into(),
        })
    }

    /// The literal that a term is, if it is one.
    pub fn as_literal(&self, id: TermId) -> Option<Literal> {
        match self.get(id) {
            Term::Literal(bits) => Some(bits.0),
            _ => None,
        }
    }

    /// A composite of parts; the parts themselves where the whole was only taken apart.
    pub fn compose(&mut self, ty: Composite, parts: Vec<TermId>) -> TermId {
        self.intern(Term::Compose {
            ty,
            parts: parts.into(),
        })
    }

    /// An integer or boolean vector of components.
    pub fn vector(&mut self, scalar: Scalar, parts: Vec<TermId>) -> TermId {
        match crate::ir::build::vector_size(parts.len()) {
            None => parts[0],
            Some(size) => self.compose(Composite::Vector(size, scalar), parts),
        }
    }

    /// A composite whose parts may themselves be vectors, as naga writes `vec3(v.xy, z)`; each part comes with its number of
    /// components.
    pub fn compose_flat(&mut self, ty: Handle<Type>, parts: Vec<(TermId, u32)>) -> TermId {
        let whole = |parts: Vec<(TermId, u32)>| parts.into_iter().map(|(part, _)| part).collect();
        let TypeInner::Vector { size, scalar } = self.module.types[ty].inner else {
            return self.compose(Composite::Type(ty), whole(parts));
        };
        if parts.len() == size as usize || !followed(scalar) {
            return self.compose(Composite::Type(ty), whole(parts));
        }
        let mut flat = Vec::with_capacity(size as usize);
        for (part, width) in parts {
            match width {
                1 => flat.push(part),
                _ => flat.extend((0..width).map(|i| self.extract(part, i))),
            }
        }
        if flat.len() == size as usize {
            self.compose(Composite::Type(ty), flat)
        } else {
            self.opaque(Opacity::Unfollowed, flat)
        }
    }

    /// Whether each part of a composite is one component of it: naga composes a vector of shorter vectors, too.
    fn is_flat(&self, ty: Composite, parts: usize) -> bool {
        match ty {
            Composite::Type(ty) => match self.module.types[ty].inner {
                TypeInner::Vector { size, .. } => parts == size as usize,
                _ => true,
            },
            Composite::Vector(..) => true,
        }
    }

    /// The number of components of a term that is known to be a vector.
    pub fn width(&self, id: TermId) -> Option<u32> {
        match self.get(id) {
            Term::Compose {
                ty: Composite::Vector(size, _),
                ..
            }
            | Term::Splat(size, _)
            | Term::Swizzle(size, ..) => Some(*size as u32),
            Term::Compose {
                ty: Composite::Type(ty),
                ..
            }
            | Term::Zero(ty) => match self.module.types[*ty].inner {
                TypeInner::Vector { size, .. } => Some(size as u32),
                _ => None,
            },
            Term::Load(global, path) => match self.loaded(*global, path) {
                Some(TypeInner::Vector { size, .. }) => Some(*size as u32),
                _ => None,
            },
            Term::Constant(handle) => {
                match self.module.types[self.module.constants[*handle].ty].inner {
                    TypeInner::Vector { size, .. } => Some(size as u32),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// The type of what a load yields.
    pub fn loaded(&self, global: Handle<GlobalVariable>, path: &[Step]) -> Option<&'a TypeInner> {
        let mut inner = &self.module.types[self.module.global_variables[global].ty].inner;
        for step in path {
            let ty = match (inner, step) {
                (TypeInner::Struct { members, .. }, Step::Index(index)) => {
                    members.get(*index as usize)?.ty
                }
                (TypeInner::Array { base, .. } | TypeInner::BindingArray { base, .. }, _) => *base,
                _ => return None,
            };
            inner = &self.module.types[ty].inner;
        }
        Some(inner)
    }

    fn loads_aggregate(&self, global: Handle<GlobalVariable>, path: &[Step]) -> bool {
        matches!(
            self.loaded(global, path),
            Some(TypeInner::Struct { .. } | TypeInner::Array { .. })
        )
    }

    /// Whether any of some terms, or of all that they are made of, is such a one.
    pub fn is_any_below(&self, from: &[TermId], is: impl Fn(&Term) -> bool) -> bool {
        let mut open = from.to_vec();
        let mut seen = FxHashSet::default();
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            if is(self.get(id)) {
                return true;
            }
            self.operands(id, &mut |operand| open.push(operand));
        }
        false
    }

    /// Calls `visit` on every term that a term is made of, the values around its loop included.
    pub fn operands(&self, id: TermId, visit: &mut dyn FnMut(TermId)) {
        let steps = |path: &[Step], visit: &mut dyn FnMut(TermId)| {
            for step in path {
                if let Step::Dynamic(index) = *step {
                    visit(index);
                }
            }
        };
        match self.get(id) {
            Term::Literal(_)
            | Term::Constant(_)
            | Term::Override(_)
            | Term::Zero(_)
            | Term::Id(_)
            | Term::LoopVar { .. }
            | Term::LoopExit { .. } => {}
            Term::Compose { parts, .. } => parts.iter().for_each(|&part| visit(part)),
            Term::Extract(base, _)
            | Term::Splat(_, base)
            | Term::Swizzle(_, base, _)
            | Term::Unary(_, base)
            | Term::Relational(_, base)
            | Term::As(_, _, base) => visit(*base),
            Term::Index(a, b) | Term::Binary(_, a, b) | Term::Insert(a, _, b) => {
                visit(*a);
                visit(*b);
            }
            Term::Update(a, b, c) | Term::Select(a, b, c) => {
                visit(*a);
                visit(*b);
                visit(*c);
            }
            Term::Math(_, arguments) => arguments.iter().for_each(|&argument| visit(argument)),
            Term::Load(_, path) | Term::ArrayLength(_, path) | Term::Resource(_, path) => {
                steps(path, visit);
            }
            Term::ImageQuery(_, image, level) => {
                visit(*image);
                level.iter().for_each(|&level| visit(level));
            }
            Term::Original { operands, .. } | Term::Opaque { operands, .. } => {
                operands.iter().for_each(|&operand| visit(operand));
            }
            Term::Call(_, arguments) => arguments.iter().for_each(|&argument| visit(argument)),
            Term::Merge {
                values, conditions, ..
            } => {
                values.iter().for_each(|&value| visit(value));
                conditions.iter().for_each(|&condition| visit(condition));
            }
        }
    }

    /// The part `part` of a value.
    pub fn project(&mut self, mut value: TermId, part: &[u32]) -> TermId {
        for &index in part {
            value = self.extract(value, index);
        }
        value
    }
}

/// Whether values of this scalar type are followed component by component.
pub fn followed(scalar: Scalar) -> bool {
    matches!(
        scalar.kind,
        ScalarKind::Sint | ScalarKind::Uint | ScalarKind::Bool
    )
}

/// The integer that a literal is.
pub fn integer(literal: Option<Literal>) -> Option<i64> {
    match literal? {
        Literal::U16(v) => Some(i64::from(v)),
        Literal::I16(v) => Some(i64::from(v)),
        Literal::U32(v) => Some(i64::from(v)),
        Literal::I32(v) => Some(i64::from(v)),
        Literal::I64(v) | Literal::AbstractInt(v) => Some(v),
        Literal::U64(v) => i64::try_from(v).ok(),
        Literal::F64(_)
        | Literal::F32(_)
        | Literal::F16(_)
        | Literal::Bool(_)
        | Literal::AbstractFloat(_) => None,
    }
}

/// The component of a swizzle as an index.
pub fn component(component: SwizzleComponent) -> u8 {
    component.index() as u8
}

fn longer(part: &[u32], index: u32) -> Box<[u32]> {
    part.iter().copied().chain([index]).collect()
}
