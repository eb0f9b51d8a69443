//! VRCSPostFix: makes the function that repeats a store for a primary's duplicates.
//!
//! ```wgsl
//! // before                              // after
//! textureStore(dst, at, value);          vrcs_copy_dst(at, value);
//!                                        textureStore(dst, at, value);
//!
//!                                        fn vrcs_copy_dst(at: vec2<i32>, value: vec4<f32>) {
//!                                            if (vrcs_copies & 2u) != 0u {
//!                                                textureStore(dst, at + vrcs_delta(1u), value);
//!                                            }
//!                                            // 16u: below, 32u: diagonal
//!                                        }
//! ```
//!
//! Where the largest rate is more than 2×2, a loop over the set bits takes the place of the three conditions.
//!
//! *Does*: one function for each way to find an address; stores that agree share it.
//! *Needs*: a [`CopyPlan`], and the operands of the store with their types.
//! *Guarantees*: the value is the primary's own; only the address is another.

use naga::{
    AtomicFunction, BinaryOperator, Expression, Function, Handle, MathFunction, Module, Scalar,
    Span, Statement, Type, TypeInner,
};

use super::{
    prologue::Prologue,
    recompute::{Ids, Recompute},
};
use crate::{
    analysis::{
        Access, Target,
        guard::{self, Formula},
        tangent::{Slope, Tangent},
        term::{TermId, Terms},
    },
    ir::build::{self, Code},
    options::MaxRate,
    plan::{CopyPlan, How},
};

/// The relative numbers of the duplicates in a quad: right, below, diagonal.
const QUAD: [u32; 3] = [1, 4, 5];

/// An expression and its type.
#[derive(Clone, Copy, Debug)]
pub struct Operand {
    /// The expression.
    pub handle: Handle<Expression>,
    /// Its type.
    pub ty: Handle<Type>,
}

/// A step of a pointer, or of a binding array, as the function that holds the store has it.
#[derive(Clone, Copy, Debug)]
pub enum ChainStep {
    /// At a constant place.
    Index(u32),
    /// At a computed place.
    Computed(Operand),
}

/// A store's operands, as the function that holds it has them.
#[derive(Clone, Debug)]
pub struct StoreOperands {
    /// From the variable to what is stored to.
    pub steps: Vec<ChainStep>,
    /// The coordinate of a texel, and its layer.
    pub texel: Option<(Operand, Option<Operand>)>,
    /// The value.
    pub value: Operand,
    /// What an atomic does with it.
    pub atomic: Option<AtomicFunction>,
}

impl StoreOperands {
    fn computed_steps(&self) -> impl Iterator<Item = Operand> {
        self.steps.iter().filter_map(|step| match step {
            ChainStep::Computed(operand) => Some(*operand),
            ChainStep::Index(_) => None,
        })
    }

    /// The parts of the address that may differ for a duplicate, in the order of
    /// [`Address::terms`](crate::analysis::Address::terms).
    fn parts(&self) -> Vec<Operand> {
        match self.texel {
            Some((coordinate, layer)) => std::iter::once(coordinate).chain(layer).collect(),
            None => self.computed_steps().collect(),
        }
    }

    /// The element of a binding array of textures, which is the same for a duplicate.
    fn fixed(&self) -> Vec<Operand> {
        match self.texel {
            Some(_) => self.computed_steps().collect(),
            None => Vec::new(),
        }
    }
}

/// How a copy function is called.
#[derive(Clone, Debug, PartialEq)]
pub struct CopyCall {
    /// The function.
    pub function: Handle<Function>,
    /// The operands of the store that it takes, behind the captures.
    pub operands: Vec<Handle<Expression>>,
}

/// Makes copy functions, and remembers those that can be shared.
pub struct Copies<'t, 'm> {
    terms: &'t mut Terms<'m>,
    group_size: [TermId; 3],
    entry: usize,
    prologue: &'t Prologue,
    max_rate: MaxRate,
    shared: Vec<(Key, Handle<Function>)>,
}

/// What two stores must agree in to share a copy function.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    target: Target,
    steps: Vec<Option<u32>>,
    types: Vec<Handle<Type>>,
    tangents: Vec<Tangent>,
    atomic: Option<AtomicFunction>,
}

/// A copy function while it is written.
struct Draft<'d> {
    access: &'d Access,
    plan: &'d CopyPlan,
    store: &'d StoreOperands,
    /// The types of the captures.
    captured: &'d [Handle<Type>],
    name: String,
}

impl<'t, 'm> Copies<'t, 'm> {
    /// No copy functions yet.
    pub fn new(
        terms: &'t mut Terms<'m>,
        group_size: [TermId; 3],
        entry: usize,
        prologue: &'t Prologue,
        max_rate: MaxRate,
    ) -> Copies<'t, 'm> {
        Copies {
            terms,
            group_size,
            entry,
            prologue,
            max_rate,
            shared: Vec::new(),
        }
    }

    /// The function that repeats a store, and the operands that it takes. `captured` are the types of the plan's
    /// captures.
    pub fn function(
        &mut self,
        module: &mut Module,
        access: &Access,
        plan: &CopyPlan,
        store: &StoreOperands,
        captured: &[Handle<Type>],
    ) -> CopyCall {
        let taken = taken(plan, store);
        let operands = taken.iter().map(|operand| operand.handle).collect();
        let key = key(access, plan, store, &taken);
        if let Some(key) = &key
            && let Some((_, function)) = self.shared.iter().find(|(known, _)| known == key)
        {
            return CopyCall {
                function: *function,
                operands,
            };
        }
        let target = module.global_variables[access.target.global]
            .name
            .as_deref();
        let draft = Draft {
            access,
            plan,
            store,
            captured,
            name: format!("vrcs_copy_{}", target.unwrap_or("target")),
        };
        let function = self.write(module, &draft, &taken);
        if let Some(key) = key {
            self.shared.push((key, function));
        }
        CopyCall { function, operands }
    }

    fn write(&mut self, module: &mut Module, draft: &Draft, taken: &[Operand]) -> Handle<Function> {
        let guard = (!draft.plan.guards.is_empty())
            .then(|| self.guard_function(module, draft, &draft.plan.guards));
        let addresses = match &draft.plan.how {
            How::Offset(_) | How::Weigh => Vec::new(),
            How::Recompute(terms) => self.address_functions(module, draft, terms),
        };

        let names = argument_names(draft, taken.len());
        let types = draft
            .captured
            .iter()
            .copied()
            .chain(taken.iter().map(|t| t.ty));
        let arguments: Vec<_> = names.iter().map(String::as_str).zip(types).collect();
        let (mut function, arguments) = build::function(&draft.name, &arguments, None);
        let (captures, operands) = arguments.split_at(draft.captured.len());
        let mut code = Code::new(&mut module.types, &mut function, Span::UNDEFINED);

        let strides = match &draft.plan.how {
            How::Offset(tangents) => self.strides(&mut code, draft, tangents, captures),
            How::Recompute(_) | How::Weigh => Vec::new(),
        };
        let one = One {
            prologue: self.prologue,
            draft,
            captures,
            operands,
            strides: &strides,
            addresses: &addresses,
            guard,
        };
        match self.max_rate {
            _ if draft.plan.how == How::Weigh => self.for_all(&mut code, &one),
            MaxRate::R2x2 => self.for_quad(&mut code, &one),
            MaxRate::R2x4 | MaxRate::R4x2 | MaxRate::R4x4 => self.for_block(&mut code, &one),
        }
        let body = code.finish();
        build::set_body(&mut function, body);
        module.functions.append(function, Span::UNDEFINED)
    }

    /// The copies within a quad: three conditions. Whether there is any duplicate is asked first only where a copy takes more than a
    /// place to be added to: stores under one condition each are predicated, not branched around.
    fn for_quad(&self, code: &mut Code, one: &One) {
        let zero = code.u32(0);
        let copies = code.global(self.prologue.copies);
        let each = |code: &mut Code| {
            for number in QUAD {
                let bit = code.u32(1 << number);
                let set = code.binary(BinaryOperator::And, copies, bit);
                let set = code.binary(BinaryOperator::NotEqual, set, zero);
                code.when(set, |code| {
                    let number = code.u32(number);
                    one.write(code, number);
                });
            }
        };
        match one.guard.is_none() && one.addresses.is_empty() {
            true => each(code),
            false => {
                let any = code.binary(BinaryOperator::NotEqual, copies, zero);
                code.when(any, each);
            }
        }
    }

    /// An atomic sum, for all duplicates at once.
    fn for_all(&self, code: &mut Code, one: &One) {
        let zero = code.u32(0);
        let copies = code.global(self.prologue.copies);
        let any = code.binary(BinaryOperator::NotEqual, copies, zero);
        code.when(any, |code| {
            let count = code.math1(MathFunction::CountOneBits, copies);
            one.weigh(code, count);
        });
    }

    /// The copies within a block of 4×4: a loop over the set bits.
    fn for_block(&self, code: &mut Code, one: &One) {
        let ty = build::numeric(code.types, None, Scalar::U32);
        let copies = code.global(self.prologue.copies);
        let left = code.local("left", ty, Some(copies));
        code.repeat(|code| {
            let bits = code.load(left);
            let zero = code.u32(0);
            let done = code.binary(BinaryOperator::Equal, bits, zero);
            code.when(done, |code| code.push(Statement::Break));
            let first = code.u32(1);
            let below = code.binary(BinaryOperator::Subtract, bits, first);
            let rest = code.binary(BinaryOperator::And, bits, below);
            code.push(Statement::Store {
                pointer: left,
                value: rest,
            });
            let number = code.math1(MathFunction::FirstTrailingBit, bits);
            one.write(code, number);
        });
    }

    /// The strides of an offset that are not numbers, each computed once.
    fn strides(
        &mut self,
        code: &mut Code,
        draft: &Draft,
        tangents: &[Tangent],
        captures: &[Handle<Expression>],
    ) -> Vec<(TermId, Handle<Expression>)> {
        let mut symbols: Vec<TermId> = Vec::new();
        for slope in tangents.iter().flat_map(|tangent| tangent.pixel) {
            if let Some((symbol, _)) = slope.symbol
                && !symbols.contains(&symbol)
            {
                symbols.push(symbol);
            }
        }
        if symbols.is_empty() {
            return Vec::new();
        }
        let pixel = code.global(self.prologue.pixel);
        let captured = draft.plan.captures.iter().map(|c| c.term);
        let mut recompute = Recompute::new(
            self.terms,
            self.entry,
            self.ids(pixel),
            captured.zip(captures.iter().copied()),
        );
        symbols
            .into_iter()
            .map(|symbol| {
                let value = recompute.emit(code, symbol);
                (symbol, code.convert(value, Scalar::I32))
            })
            .collect()
    }

    fn guard_function(
        &mut self,
        module: &mut Module,
        draft: &Draft,
        guards: &[Formula],
    ) -> Handle<Function> {
        let holds = guard::all(guards, self.terms);
        let boolean = build::numeric(&mut module.types, None, Scalar::BOOL);
        let name = draft.name.replacen("copy", "guard", 1);
        self.outline(module, draft, &name, &[holds], boolean)
    }

    /// One function for each part of the address.
    fn address_functions(
        &mut self,
        module: &mut Module,
        draft: &Draft,
        terms: &[TermId],
    ) -> Vec<Handle<Function>> {
        let name = draft.name.replacen("copy", "address", 1);
        let mut terms = terms;
        let mut functions = Vec::new();
        for part in draft.store.parts() {
            let (of_part, rest) = terms.split_at(components(&module.types, part.ty));
            functions.push(self.outline(module, draft, &name, of_part, part.ty));
            terms = rest;
        }
        functions
    }

    /// A function of a pixel and the captures that gives the value of terms, as a scalar or a vector.
    fn outline(
        &mut self,
        module: &mut Module,
        draft: &Draft,
        name: &str,
        terms: &[TermId],
        result: Handle<Type>,
    ) -> Handle<Function> {
        let names: Vec<_> = (0..draft.captured.len()).map(captured_name).collect();
        let pixel_type = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
        let arguments: Vec<_> = std::iter::once(("pixel", pixel_type))
            .chain(
                names
                    .iter()
                    .map(String::as_str)
                    .zip(draft.captured.iter().copied()),
            )
            .collect();
        let (mut function, arguments) = build::function(name, &arguments, Some(result));
        let mut code = Code::new(&mut module.types, &mut function, Span::UNDEFINED);
        let captured = draft.plan.captures.iter().map(|c| c.term);
        let mut recompute = Recompute::new(
            self.terms,
            self.entry,
            self.ids(arguments[0]),
            captured.zip(arguments[1..].iter().copied()),
        );
        let parts: Vec<_> = terms
            .iter()
            .map(|&term| recompute.emit(&mut code, term))
            .collect();
        let value = match parts.as_slice() {
            [only] => *only,
            _ => code.add(Expression::Compose {
                ty: result,
                components: parts,
            }),
        };
        code.push(Statement::Return { value: Some(value) });
        function.body = code.finish();
        module.functions.append(function, Span::UNDEFINED)
    }

    fn ids(&self, pixel: Handle<Expression>) -> Ids {
        Ids {
            pixel,
            group_size: self.group_size,
            params: self.prologue.params,
            width: self.terms.width,
        }
    }
}

/// The copy for one duplicate, while it is written.
struct One<'d> {
    prologue: &'d Prologue,
    draft: &'d Draft<'d>,
    captures: &'d [Handle<Expression>],
    /// What the copy function was given besides: fixed parts, address parts, value.
    operands: &'d [Handle<Expression>],
    /// Uniform strides.
    strides: &'d [(TermId, Handle<Expression>)],
    /// Functions that compute the parts of the address.
    addresses: &'d [Handle<Function>],
    guard: Option<Handle<Function>>,
}

impl One<'_> {
    /// `number` is the duplicate's relative number.
    fn write(&self, code: &mut Code, number: Handle<Expression>) {
        let mut at_duplicate = Vec::new();
        if self.guard.is_some() || !self.addresses.is_empty() {
            at_duplicate.push(code.value_of(self.prologue.duplicate, vec![number]));
            at_duplicate.extend(self.captures);
        }
        match self.guard {
            None => self.store(code, number, &at_duplicate),
            Some(guard) => {
                let inside = code.value_of(guard, at_duplicate.clone());
                code.when(inside, |code| self.store(code, number, &at_duplicate));
            }
        }
    }

    /// The value, the operands that are the same for a duplicate, and the parts of the address.
    fn split_operands(
        &self,
    ) -> (
        Handle<Expression>,
        &[Handle<Expression>],
        &[Handle<Expression>],
    ) {
        let Some((&value, operands)) = self.operands.split_last() else {
            unreachable!("a store has a value");
        };
        let (fixed, bases) = operands.split_at(self.draft.store.fixed().len());
        (value, fixed, bases)
    }

    /// Adds the value `count` times more at the primary's own place.
    fn weigh(&self, code: &mut Code, count: Handle<Expression>) {
        let (value, fixed, bases) = self.split_operands();
        let ty = self.draft.store.value.ty;
        let TypeInner::Scalar(scalar) = code.types[ty].inner else {
            unreachable!("atomics are scalars");
        };
        let count = match scalar {
            Scalar::U32 => count,
            _ => code.convert(count, scalar),
        };
        let value = code.binary(BinaryOperator::Multiply, value, count);
        self.write_at(code, value, fixed, bases);
    }

    fn store(
        &self,
        code: &mut Code,
        number: Handle<Expression>,
        at_duplicate: &[Handle<Expression>],
    ) {
        let (value, fixed, bases) = self.split_operands();
        let parts = match &self.draft.plan.how {
            How::Offset(tangents) => self.offsets(code, number, bases, tangents),
            How::Recompute(_) => self
                .addresses
                .iter()
                .map(|&address| code.value_of(address, at_duplicate.to_vec()))
                .collect(),
            How::Weigh => unreachable!("sums are weighed at once"),
        };
        self.write_at(code, value, fixed, &parts);
    }

    /// Writes the store, or the atomic, at a place.
    fn write_at(
        &self,
        code: &mut Code,
        value: Handle<Expression>,
        fixed: &[Handle<Expression>],
        parts: &[Handle<Expression>],
    ) {
        let mut computed = match self.draft.store.texel {
            Some(_) => fixed.iter(),
            None => parts.iter(),
        };
        let mut pointer = code.add(Expression::GlobalVariable(self.draft.access.target.global));
        for step in &self.draft.store.steps {
            pointer = match *step {
                ChainStep::Index(index) => code.at(pointer, index),
                ChainStep::Computed(_) => {
                    let Some(&index) = computed.next() else {
                        unreachable!("a part for each computed step");
                    };
                    code.add(Expression::Access {
                        base: pointer,
                        index,
                    })
                }
            };
        }
        let texel = self.draft.store.texel.is_some();
        let statement = match (self.draft.store.atomic, texel) {
            (None, false) => Statement::Store { pointer, value },
            (None, true) => Statement::ImageStore {
                image: pointer,
                coordinate: parts[0],
                array_index: parts.get(1).copied(),
                value,
            },
            (Some(fun), false) => {
                let ty = self.draft.store.value.ty;
                let comparison = false;
                let result = code.add(Expression::AtomicResult { ty, comparison });
                Statement::Atomic {
                    pointer,
                    fun,
                    value,
                    result: Some(result),
                }
            }
            (Some(fun), true) => Statement::ImageAtomic {
                image: pointer,
                coordinate: parts[0],
                array_index: parts.get(1).copied(),
                fun,
                value,
            },
        };
        code.push(statement);
    }

    /// The parts of the address, moved from the primary's.
    fn offsets(
        &self,
        code: &mut Code,
        number: Handle<Expression>,
        bases: &[Handle<Expression>],
        mut tangents: &[Tangent],
    ) -> Vec<Handle<Expression>> {
        let delta = code.value_of(self.prologue.delta, vec![number]);
        let mut moved = Vec::with_capacity(bases.len());
        for (&base, part) in bases.iter().zip(self.draft.store.parts()) {
            let (of_part, rest) = tangents.split_at(components(code.types, part.ty));
            moved.push(offset(code, base, part.ty, of_part, delta, self.strides));
            tangents = rest;
        }
        moved
    }
}

/// `base + tangent · delta`, in the wrapping arithmetic of its own type.
fn offset(
    code: &mut Code,
    base: Handle<Expression>,
    ty: Handle<Type>,
    tangents: &[Tangent],
    delta: Handle<Expression>,
    strides: &[(TermId, Handle<Expression>)],
) -> Handle<Expression> {
    let (scalar, is_vector) = match code.types[ty].inner {
        TypeInner::Vector { scalar, .. } => (scalar, true),
        TypeInner::Scalar(scalar) => (scalar, false),
        _ => unreachable!("an address is made of integers"),
    };
    if tangents.iter().all(|t| *t == Tangent::default()) {
        return base;
    }
    // a coordinate that moves as the pixel does
    if let [x, y] = tangents
        && (*x, *y) == (Tangent::along(0), Tangent::along(1))
    {
        let delta = match scalar {
            Scalar::I32 => delta,
            _ => code.convert(delta, scalar),
        };
        return code.binary(BinaryOperator::Add, base, delta);
    }
    let components: Vec<_> = tangents
        .iter()
        .enumerate()
        .map(|(index, tangent)| {
            let component = match is_vector {
                true => code.at(base, index as u32),
                false => base,
            };
            let mut sum = None;
            for axis in 0..2 {
                let slope = tangent.pixel[axis];
                if slope.is_zero() {
                    continue;
                }
                let along = code.at(delta, axis as u32);
                let term = sloped(code, along, slope, strides);
                sum = Some(match sum {
                    None => term,
                    Some(sum) => code.binary(BinaryOperator::Add, sum, term),
                });
            }
            match sum {
                None => component,
                Some(sum) => {
                    let sum = match scalar {
                        Scalar::I32 => sum,
                        _ => code.convert(sum, scalar),
                    };
                    code.binary(BinaryOperator::Add, component, sum)
                }
            }
        })
        .collect();
    match is_vector {
        true => code.add(Expression::Compose { ty, components }),
        false => components[0],
    }
}

/// `delta * slope`, an `i32`.
fn sloped(
    code: &mut Code,
    delta: Handle<Expression>,
    slope: Slope,
    strides: &[(TermId, Handle<Expression>)],
) -> Handle<Expression> {
    let times = |code: &mut Code, value, factor: i64| match factor {
        1 => value,
        _ => {
            // wraps as the address itself does
            let factor = code.add(Expression::Literal(naga::Literal::I32(factor as i32)));
            code.binary(BinaryOperator::Multiply, value, factor)
        }
    };
    let constant = (slope.constant != 0).then(|| times(code, delta, slope.constant));
    let Some((symbol, factor)) = slope.symbol else {
        return constant.unwrap_or(delta);
    };
    let Some(&(_, stride)) = strides.iter().find(|(known, _)| *known == symbol) else {
        unreachable!("every stride has been computed");
    };
    let product = code.binary(BinaryOperator::Multiply, delta, stride);
    let product = times(code, product, factor);
    match constant {
        None => product,
        Some(constant) => code.binary(BinaryOperator::Add, constant, product),
    }
}

/// The operands of a store that its copy function takes.
fn taken(plan: &CopyPlan, store: &StoreOperands) -> Vec<Operand> {
    let mut taken = store.fixed();
    if let How::Offset(_) | How::Weigh = plan.how {
        taken.extend(store.parts());
    }
    taken.push(store.value);
    taken
}

/// What the copy function of a store can be shared by; nothing if it needs captures or guards of its own.
fn key(access: &Access, plan: &CopyPlan, store: &StoreOperands, taken: &[Operand]) -> Option<Key> {
    let tangents = match &plan.how {
        How::Offset(tangents) => tangents.as_slice(),
        How::Weigh => &[],
        How::Recompute(_) => return None,
    };
    (plan.captures.is_empty() && plan.guards.is_empty()).then(|| Key {
        target: access.target.clone(),
        steps: store
            .steps
            .iter()
            .map(|step| match *step {
                ChainStep::Index(index) => Some(index),
                ChainStep::Computed(_) => None,
            })
            .collect(),
        types: taken.iter().map(|operand| operand.ty).collect(),
        tangents: tangents.to_vec(),
        atomic: store.atomic,
    })
}

/// The number of components of an integer type.
fn components(types: &naga::UniqueArena<Type>, ty: Handle<Type>) -> usize {
    match types[ty].inner {
        TypeInner::Vector { size, .. } => size as usize,
        _ => 1,
    }
}

fn captured_name(index: usize) -> String {
    format!("captured_{}", letter(index))
}

/// A name without digits at its end, which naga's writer would change.
fn letter(index: usize) -> String {
    let letter = char::from(b'a' + (index % 26) as u8);
    match index / 26 {
        0 => letter.to_string(),
        more => format!("{}{letter}", self::letter(more - 1)),
    }
}

fn argument_names(draft: &Draft, taken: usize) -> Vec<String> {
    let mut names: Vec<String> = (0..draft.captured.len()).map(captured_name).collect();
    let fixed = draft.store.fixed().len();
    for index in 0..taken {
        names.push(if index + 1 == taken {
            "value".to_owned()
        } else if index < fixed {
            format!("element_{}", letter(index))
        } else {
            match (draft.store.texel, index - fixed) {
                (Some(_), 0) => "at".to_owned(),
                (Some(_), _) => "layer".to_owned(),
                (None, part) => format!("index_{}", letter(part)),
            }
        });
    }
    names
}
