//! Which axes of the invocation grid a store's address depends on: a dataflow of its own, which knows nothing of the rewriter's.
//!
//! A value depends on an axis if it is made from an id of it, or if what it is hangs on a condition that depends on it. What is loaded
//! from memory depends on none, wherever it stood: it is data, and so is what an atomic gives. That is the survey's word: its
//! values are forms of the ids, loaded data and atomics only taint them, and what lists, sorts and queues say where to store is its
//! "other storage-buffer work". An address that has a part of both axes besides such data does count.
//!
//! - `global_invocation_id` and `workgroup_id` depend on an axis by component; `local_invocation_id` does where the workgroup's side is
//!   not 1, and `local_invocation_index` and the numbers of subgroups depend on all such sides; `num_workgroups` on none.
//! - Structs and vectors are followed by component, arrays and matrices as a whole.
//! - Variables, private ones included, hold whatever is stored to them anywhere, under the conditions around the store (for a helper's own
//!   variables, those inside it) and, in a loop, those that leave it; what a helper returns hangs on the conditions around its
//!   returns. That an entry point returns early changes no value.
//! - The condition around a store to a buffer is no part of its address.
//! - Helpers are followed once for each kind of arguments; everything is repeated until nothing changes.

use std::collections::{BTreeMap, BTreeSet};

use naga::{
    AddressSpace, Binding, Block, BuiltIn, Expression as E, Function, FunctionArgument,
    GlobalVariable, Handle, LocalVariable, MathFunction as M, Module, Statement, Type, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};
use vrcs_passes::ir::visit;

/// A set of axes.
pub type Axes = u8;
pub const X: Axes = 1;
pub const Y: Axes = 2;

/// The axes that addresses in storage buffers depend on, one set for each kind of store that an entry point reaches.
pub fn of_buffer_stores(module: &Module, info: &ModuleInfo, entry: usize) -> BTreeSet<Axes> {
    let function = &module.entry_points[entry].function;
    let mut flow = Flow {
        module,
        info,
        entry,
        contexts: Vec::new(),
        known: BTreeMap::new(),
        globals: BTreeMap::new(),
        stores: BTreeSet::new(),
        has_changed: false,
        seen: BTreeSet::new(),
    };
    let arguments = function.arguments.iter().map(|a| flow.argument(a));
    let arguments: Vec<Value> = arguments.collect();
    loop {
        flow.has_changed = false;
        flow.seen.clear();
        flow.call(None, arguments.clone(), 0);
        if !flow.has_changed {
            return flow.stores;
        }
    }
}

/// What a value, or each part of it, depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Value {
    Whole(Axes),
    Parts(Vec<Value>),
    /// A place in a variable: constant steps as far as there are any, then what computed steps depend on.
    Place(Root, Vec<u32>, Axes),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Root {
    Global(Handle<GlobalVariable>),
    /// A variable of the function in a context.
    Local(usize, Handle<LocalVariable>),
}

impl Value {
    fn all(&self) -> Axes {
        match self {
            Value::Whole(axes) | Value::Place(_, _, axes) => *axes,
            Value::Parts(parts) => parts.iter().fold(0, |all, part| all | part.all()),
        }
    }

    fn part(&self, index: u32) -> Value {
        match self {
            Value::Parts(parts) => match parts.get(index as usize) {
                Some(part) => part.clone(),
                None => Value::Whole(self.all()),
            },
            Value::Whole(_) => self.clone(),
            Value::Place(root, steps, axes) => {
                let mut steps = steps.clone();
                if *axes == 0 {
                    steps.push(index);
                }
                Value::Place(*root, steps, *axes)
            }
        }
    }

    fn with(mut self, axes: Axes) -> Value {
        match &mut self {
            Value::Whole(own) | Value::Place(_, _, own) => *own |= axes,
            Value::Parts(parts) => {
                for part in parts {
                    *part = std::mem::replace(part, Value::Whole(0)).with(axes);
                }
            }
        }
        self
    }

    fn join(self, other: &Value) -> Value {
        match (self, other) {
            (Value::Parts(a), Value::Parts(b)) if a.len() == b.len() => {
                Value::Parts(a.into_iter().zip(b).map(|(a, b)| a.join(b)).collect())
            }
            (place @ Value::Place(..), other) => place.with(other.all()),
            (Value::Whole(a), Value::Place(root, steps, axes)) => {
                Value::Place(*root, steps.clone(), a | axes)
            }
            (Value::Whole(a), parts @ Value::Parts(_)) => parts.clone().with(a),
            (a, b) => a.with(b.all()),
        }
    }

    /// Joins a value into the part that constant steps lead to.
    fn join_at(&mut self, steps: &[u32], value: &Value) {
        match (&mut *self, steps) {
            (Value::Parts(parts), [step, rest @ ..]) if (*step as usize) < parts.len() => {
                parts[*step as usize].join_at(rest, value);
            }
            _ => {
                let own = std::mem::replace(self, Value::Whole(0));
                *self = match steps {
                    [] => own.join(value),
                    _ => own.with(value.all()),
                };
            }
        }
    }
}

/// A function, and what it is called with.
type Key = (Option<Handle<Function>>, Vec<Value>, Axes);

struct Context {
    key: Key,
    values: Vec<Value>,
    locals: BTreeMap<Handle<LocalVariable>, Value>,
    result: Value,
}

struct Flow<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    entry: usize,
    contexts: Vec<Context>,
    known: BTreeMap<Key, usize>,
    globals: BTreeMap<Handle<GlobalVariable>, Value>,
    /// What the addresses depend on that are stored to in buffers.
    stores: BTreeSet<Axes>,
    has_changed: bool,
    /// The contexts that this round has been in.
    seen: BTreeSet<usize>,
}

impl<'m> Flow<'m> {
    fn argument(&self, argument: &FunctionArgument) -> Value {
        let of = |binding: &Option<Binding>| match binding {
            Some(Binding::BuiltIn(builtin)) => self.builtin(*builtin),
            _ => Value::Whole(0),
        };
        match &self.module.types[argument.ty].inner {
            TypeInner::Struct { members, .. } => {
                Value::Parts(members.iter().map(|member| of(&member.binding)).collect())
            }
            _ => of(&argument.binding),
        }
    }

    fn builtin(&self, builtin: BuiltIn) -> Value {
        let entry = &self.module.entry_points[self.entry];
        let overrides = entry.workgroup_size_overrides.unwrap_or_default();
        let is_long = |axis: usize| entry.workgroup_size[axis] != 1 || overrides[axis].is_some();
        let [x, y] = [(0, X), (1, Y)].map(|(axis, bit)| if is_long(axis) { bit } else { 0 });
        let vector = |x, y| Value::Parts([x, y, 0].map(Value::Whole).to_vec());
        match builtin {
            BuiltIn::GlobalInvocationId | BuiltIn::WorkGroupId => vector(X, Y),
            BuiltIn::LocalInvocationId => vector(x, y),
            BuiltIn::NumWorkGroups | BuiltIn::NumSubgroups | BuiltIn::SubgroupSize => {
                Value::Whole(0)
            }
            _ => Value::Whole(x | y),
        }
    }

    /// A variable that nothing has been stored to, in the parts that its type has.
    fn fresh(&self, ty: Handle<Type>) -> Value {
        match &self.module.types[ty].inner {
            TypeInner::Struct { members, .. } => {
                Value::Parts(members.iter().map(|member| self.fresh(member.ty)).collect())
            }
            TypeInner::Vector { size, .. } => Value::Parts(vec![Value::Whole(0); *size as usize]),
            _ => Value::Whole(0),
        }
    }

    fn function(&self, of: Option<Handle<Function>>) -> &'m Function {
        match of {
            Some(handle) => &self.module.functions[handle],
            None => &self.module.entry_points[self.entry].function,
        }
    }

    fn call(
        &mut self,
        of: Option<Handle<Function>>,
        arguments: Vec<Value>,
        control: Axes,
    ) -> Value {
        let key = (of, arguments, control);
        let function = self.function(of);
        let context = match self.known.get(&key) {
            Some(&context) => context,
            None => {
                let locals = function.local_variables.iter();
                let locals = locals.map(|(handle, local)| (handle, self.fresh(local.ty)));
                self.contexts.push(Context {
                    locals: locals.collect(),
                    key: key.clone(),
                    values: vec![Value::Whole(0); function.expressions.len()],
                    result: Value::Whole(0),
                });
                self.has_changed = true;
                self.known.insert(key, self.contexts.len() - 1);
                self.contexts.len() - 1
            }
        };
        if self.seen.insert(context) {
            for (handle, expression) in function.expressions.iter() {
                let value = self.expression(context, handle, expression);
                self.learn(context, handle, &value);
            }
            for (handle, local) in function.local_variables.iter() {
                if let Some(init) = local.init {
                    let value = self.contexts[context].values[init.index()].clone();
                    self.store(
                        &Value::Place(Root::Local(context, handle), Vec::new(), 0),
                        &value,
                    );
                }
            }
            let left = match of {
                Some(_) => self.leaves(context, &function.body, 0, &|s| {
                    matches!(s, Statement::Return { .. })
                }),
                None => 0,
            };
            let result = self.contexts[context].result.clone().with(left);
            self.contexts[context].result = result;
            self.block(context, &function.body, left);
        }
        self.contexts[context].result.clone()
    }

    fn learn(&mut self, context: usize, handle: Handle<naga::Expression>, value: &Value) {
        let known = &mut self.contexts[context].values[handle.index()];
        // what was nothing takes the shape of what it is
        let joined = match known {
            Value::Whole(0) => value.clone(),
            _ => known.clone().join(value),
        };
        self.has_changed |= joined != *known;
        *known = joined;
    }

    fn expression(
        &self,
        context: usize,
        handle: Handle<naga::Expression>,
        expression: &naga::Expression,
    ) -> Value {
        let context_of = &self.contexts[context];
        let value = |of: Handle<naga::Expression>| context_of.values[of.index()].clone();
        let mut whole = 0;
        visit::operands(expression, &mut |&operand| whole |= value(operand).all());
        let by_part = |operands: &[Handle<naga::Expression>]| {
            let operands: Vec<Value> = operands.iter().map(|&operand| value(operand)).collect();
            let joined = operands.iter().skip(1);
            joined.fold(operands[0].clone(), |all, operand| all.join(operand))
        };
        match *expression {
            E::FunctionArgument(index) => context_of.key.1[index as usize].clone(),
            E::GlobalVariable(global) => Value::Place(Root::Global(global), Vec::new(), 0),
            E::LocalVariable(local) => Value::Place(Root::Local(context, local), Vec::new(), 0),
            E::AccessIndex { base, index } => value(base).part(index),
            E::Access { base, index } => {
                let index = value(index).all();
                match value(base) {
                    // the parts behind a computed step are one
                    Value::Place(root, mut steps, axes) => {
                        steps.push(u32::MAX);
                        Value::Place(root, steps, axes | index)
                    }
                    base => Value::Whole(base.all() | index),
                }
            }
            E::Splat { value: of, .. } => Value::Whole(value(of).all()),
            E::Swizzle {
                size,
                vector,
                pattern,
            } => {
                let vector = value(vector);
                let parts = pattern.iter().take(size as usize);
                Value::Parts(parts.map(|&of| vector.part(of as u32)).collect())
            }
            E::Compose { ty, ref components } => match self.module.types[ty].inner {
                TypeInner::Vector { .. } => {
                    let mut parts = Vec::new();
                    for &component in components {
                        let sides = match *self.ty(context, component) {
                            TypeInner::Vector { size, .. } => size as u32,
                            _ => 1,
                        };
                        let component = value(component);
                        parts.extend((0..sides).map(|side| component.part(side)));
                    }
                    Value::Parts(parts)
                }
                TypeInner::Struct { .. } => {
                    Value::Parts(components.iter().map(|&part| value(part)).collect())
                }
                _ => Value::Whole(whole),
            },
            E::Load { pointer } => match value(pointer) {
                Value::Place(Root::Global(of), ..) if !self.is_private(of) => Value::Whole(0),
                Value::Place(root, steps, axes) => self.load(root, &steps).with(axes),
                other => other,
            },
            E::Unary { expr, .. } | E::As { expr, .. } => value(expr),
            E::Binary { left, right, .. }
                if self.is_matrix(context, left) || self.is_matrix(context, right) =>
            {
                Value::Whole(whole)
            }
            E::Binary { left, right, .. } => by_part(&[left, right]),
            E::Select {
                condition,
                accept,
                reject,
            } => by_part(&[accept, reject, condition]),
            E::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3,
            } if is_by_part(fun) => {
                let rest = [arg1, arg2, arg3].into_iter().flatten();
                by_part(&[arg].into_iter().chain(rest).collect::<Vec<_>>())
            }
            // what statements give; they are learnt there
            E::CallResult(_) | E::SubgroupBallotResult | E::SubgroupOperationResult { .. } => {
                context_of.values[handle.index()].clone()
            }
            E::ImageLoad { .. }
            | E::ImageSample { .. }
            | E::ArrayLength(_)
            | E::AtomicResult { .. }
            | E::WorkGroupUniformLoadResult { .. } => Value::Whole(0),
            _ => Value::Whole(whole),
        }
    }

    fn is_private(&self, global: Handle<GlobalVariable>) -> bool {
        self.module.global_variables[global].space == AddressSpace::Private
    }

    /// The type of an expression.
    fn ty(&self, context: usize, of: Handle<naga::Expression>) -> &TypeInner {
        let info: &FunctionInfo = match self.contexts[context].key.0 {
            Some(function) => &self.info[function],
            None => self.info.get_entry_point(self.entry),
        };
        info[of].ty.inner_with(&self.module.types)
    }

    fn is_matrix(&self, context: usize, of: Handle<naga::Expression>) -> bool {
        matches!(self.ty(context, of), TypeInner::Matrix { .. })
    }

    fn load(&self, root: Root, steps: &[u32]) -> Value {
        let memory = match root {
            Root::Local(context, local) => self.contexts[context].locals.get(&local),
            Root::Global(global) => self.globals.get(&global),
        };
        let Some(memory) = memory else {
            return Value::Whole(0);
        };
        steps
            .iter()
            .fold(memory.clone(), |memory, &step| memory.part(step))
    }

    fn store(&mut self, place: &Value, value: &Value) {
        let Value::Place(root, steps, axes) = place else {
            return;
        };
        let value = value.clone().with(*axes);
        let fresh = match *root {
            Root::Global(global) => self.fresh(self.module.global_variables[global].ty),
            Root::Local(..) => Value::Whole(0),
        };
        let memory = match *root {
            Root::Local(context, local) => self.contexts[context].locals.get_mut(&local),
            Root::Global(global) => Some(self.globals.entry(global).or_insert(fresh)),
        };
        if let Some(memory) = memory {
            let before = memory.clone();
            memory.join_at(steps, &value);
            self.has_changed |= *memory != before;
        }
    }
}

impl Flow<'_> {
    fn all(&self, context: usize, of: Handle<naga::Expression>) -> Axes {
        self.contexts[context].values[of.index()].all()
    }

    /// What the conditions around statements of a block depend on that leave it.
    fn leaves(
        &self,
        context: usize,
        block: &Block,
        control: Axes,
        is: &dyn Fn(&Statement) -> bool,
    ) -> Axes {
        let mut all = 0;
        for statement in block {
            if is(statement) {
                all |= control;
            }
            let inner = control | self.condition(context, statement);
            visit::sub_blocks(statement, &mut |block| {
                all |= self.leaves(context, block, inner, is)
            });
        }
        all
    }

    /// What it depends on whether the blocks of a statement run, or run again.
    fn condition(&self, context: usize, statement: &Statement) -> Axes {
        match statement {
            Statement::If { condition, .. } => self.all(context, *condition),
            Statement::Switch { selector, .. } => self.all(context, *selector),
            // whatever leaves an inner loop is taken to leave this one, too
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let is = |s: &Statement| {
                    matches!(
                        s,
                        Statement::Break | Statement::Continue | Statement::Return { .. }
                    )
                };
                let [body, continuing] =
                    [body, continuing].map(|block| self.leaves(context, block, 0, &is));
                body | continuing | break_if.map_or(0, |condition| self.all(context, condition))
            }
            _ => 0,
        }
    }

    fn block(&mut self, context: usize, block: &Block, control: Axes) {
        for statement in block {
            self.statement(context, statement, control);
            let inner = control | self.condition(context, statement);
            visit::sub_blocks(statement, &mut |block| self.block(context, block, inner));
        }
    }

    fn statement(&mut self, context: usize, statement: &Statement, control: Axes) {
        let value = |flow: &Self, of: Handle<naga::Expression>| {
            flow.contexts[context].values[of.index()].clone()
        };
        let mut whole = 0;
        visit::statement_operands(statement, &mut |&operand| {
            whole |= self.all(context, operand)
        });
        match *statement {
            Statement::Store {
                pointer,
                value: stored,
            } => {
                let (place, stored) = (value(self, pointer), value(self, stored));
                let control = match place {
                    Value::Place(Root::Global(global), ..) if !self.is_private(global) => {
                        let space = self.module.global_variables[global].space;
                        if matches!(space, AddressSpace::Storage { .. }) {
                            self.has_changed |= self.stores.insert(place.all());
                        }
                        return;
                    }
                    // a function's own variables end with it, so that what it is called under makes them no different
                    Value::Place(Root::Local(of, _), ..) if of == context => control,
                    _ => control | self.contexts[context].key.2,
                };
                self.store(&place, &stored.with(control));
            }
            Statement::SubgroupBallot { result, .. }
            | Statement::SubgroupGather { result, .. }
            | Statement::SubgroupCollectiveOperation { result, .. } => {
                self.learn(context, result, &Value::Whole(whole));
            }
            Statement::RayQuery { query, .. } => {
                let query = value(self, query);
                self.store(&query, &Value::Whole(whole | control));
            }
            Statement::Call {
                function,
                ref arguments,
                result,
            } => {
                let arguments = arguments
                    .iter()
                    .map(|&argument| value(self, argument))
                    .collect();
                let control = control | self.contexts[context].key.2;
                let returned = self.call(Some(function), arguments, control);
                if let Some(result) = result {
                    self.learn(context, result, &returned);
                }
            }
            Statement::Return {
                value: Some(returned),
            } => {
                let returned = value(self, returned);
                let known = self.contexts[context].result.clone();
                let joined = match known {
                    Value::Whole(0) => returned,
                    _ => known.clone().join(&returned),
                };
                self.has_changed |= joined != known;
                self.contexts[context].result = joined;
            }
            _ => {}
        }
    }
}

/// Whether each component of a function's result comes of the same components of its operands.
fn is_by_part(function: M) -> bool {
    matches!(
        function,
        M::Abs
            | M::Min
            | M::Max
            | M::Clamp
            | M::Saturate
            | M::Floor
            | M::Ceil
            | M::Round
            | M::Fract
            | M::Trunc
            | M::Step
            | M::Sign
            | M::Mix
            | M::Fma
    )
}
