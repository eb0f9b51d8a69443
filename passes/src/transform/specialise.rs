//! Inserts the copies into the functions that store: the entry point, and a clone of each helper for each path of calls.
//!
//! ```wgsl
//! // before                                   // after
//! fn put(at: vec2<i32>, v: vec4<f32>) {       fn vrcs_put(at: vec2<i32>, v: vec4<f32>) {
//!     textureStore(dst, at, v);                   textureStore(dst, at, v);
//! }                                               vrcs_copy_dst(at, v);
//!                                             }
//! ```
//!
//! *Does*: clones bottom-up, callees before callers; paths that come to the same text share a clone. What a copy needs
//! from a caller is kept in a private variable, set just before the call.
//! *Guarantees*: the author's functions stay as they are, for entry points that are left alone; in a clone the
//! author's statements keep their order and their spans.

use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Span, Statement,
    Type, valid::ModuleInfo,
};
use rustc_hash::FxHashMap;

use super::{
    copies::{ChainStep, Copies, CopyCall, Operand, StoreOperands},
    settled::{Settled, settle},
};
use crate::{
    analysis::{
        Access, Address, FunctionRef, Instance, InstanceId, facts::constant_steps, term::Step,
    },
    ir::{
        build::{self, Code},
        statements::{StatementId, rebuild},
    },
    plan::{CaptureSource, CopyPlan},
};

/// Something that is done at a statement.
#[derive(Clone, Debug, PartialEq)]
enum Edit {
    /// A copy in front of a store, or behind an atomic. The order is free, since no two of the places are the same; behind it, an H200
    /// was slower by up to a sixth where a pass does little else.
    Copy {
        call: CopyCall,
        captures: Vec<CaptureSource>,
    },
    /// A condition that is decided.
    Settle(bool),
    /// A call that goes to a clone.
    Redirect(Handle<Function>),
    /// A value kept for a copy further down, before a call.
    Keep {
        variable: Handle<GlobalVariable>,
        source: CaptureSource,
    },
}

/// What is done in one function, in the order of its statements.
type Edits = Vec<(StatementId, Edit)>;

/// Makes clones.
pub struct Specialise<'s, 'm> {
    /// The module as it was.
    pub original: &'m Module,
    /// What naga knows of it.
    pub info: &'m ModuleInfo,
    /// The entry point's number.
    pub entry: usize,
    /// The functions on paths to stores.
    pub instances: &'s [Instance],
    /// The accesses.
    pub accesses: &'s [Access],
    /// What becomes of the stores.
    pub plans: &'s [CopyPlan],
    /// The entry point's conditions that are decided.
    pub settled: &'s [Settled],
    edits: FxHashMap<InstanceId, Edits>,
    kept: Vec<(CaptureSource, Handle<GlobalVariable>)>,
    clones: Vec<(FunctionRef, Edits, Handle<Function>)>,
}

impl<'s, 'm> Specialise<'s, 'm> {
    /// Nothing is cloned yet.
    pub fn new(
        original: &'m Module,
        info: &'m ModuleInfo,
        entry: usize,
        instances: &'s [Instance],
        accesses: &'s [Access],
        plans: &'s [CopyPlan],
        settled: &'s [Settled],
    ) -> Specialise<'s, 'm> {
        Specialise {
            original,
            info,
            entry,
            instances,
            accesses,
            plans,
            settled,
            edits: FxHashMap::default(),
            kept: Vec::new(),
            clones: Vec::new(),
        }
    }

    /// Makes the copy functions and the clones. Gives the entry point as an ordinary function, and all clones with what
    /// they were made from.
    pub fn run(
        mut self,
        module: &mut Module,
        copies: &mut Copies,
    ) -> (Handle<Function>, Vec<(FunctionRef, Handle<Function>)>) {
        for plan in self.plans {
            self.plan_edits(module, copies, plan);
        }
        let Some(inner) = self.build(module, InstanceId::ENTRY) else {
            unreachable!("the entry point is always rebuilt");
        };
        let clones = self.clones.into_iter().map(|(of, _, clone)| (of, clone));
        (inner, clones.collect())
    }

    fn plan_edits(&mut self, module: &mut Module, copies: &mut Copies, plan: &CopyPlan) {
        let access = &self.accesses[plan.access];
        let store = self.operands(module, access);
        let mut types = Vec::with_capacity(plan.captures.len());
        let mut captures = Vec::with_capacity(plan.captures.len());
        for capture in &plan.captures {
            types.push(self.capture_type(module, access.instance, &capture.source));
            captures.push(capture.source.clone());
        }
        for (source, &ty) in captures.iter().zip(&types) {
            self.keep(module, source, ty);
        }
        let call = copies.function(module, access, plan, &store, &types);
        self.edits
            .entry(access.instance)
            .or_default()
            .push((access.statement, Edit::Copy { call, captures }));
    }

    /// Has a caller keep a value for a copy further down.
    fn keep(&mut self, module: &mut Module, source: &CaptureSource, ty: Handle<Type>) {
        let CaptureSource::Caller {
            instance,
            statement,
            source: at_call,
        } = source
        else {
            return;
        };
        if self.kept.iter().any(|(known, _)| known == source) {
            return;
        }
        let variable = module.global_variables.append(
            GlobalVariable {
                name: Some("vrcs_kept".to_owned()),
                space: AddressSpace::Private,
                binding: None,
                ty,
                init: None,
                memory_decorations: naga::MemoryDecorations::empty(),
            },
            Span::UNDEFINED,
        );
        self.kept.push((source.clone(), variable));
        self.edits.entry(*instance).or_default().push((
            *statement,
            Edit::Keep {
                variable,
                source: (**at_call).clone(),
            },
        ));
    }

    fn function(&self, instance: InstanceId) -> (&'m Function, FunctionRef) {
        let of = self.instances[instance.0 as usize].function;
        (of.get(self.original, self.entry), of)
    }

    fn type_of(
        &self,
        module: &mut Module,
        of: FunctionRef,
        handle: Handle<Expression>,
    ) -> Handle<Type> {
        let info = match of {
            FunctionRef::Entry => self.info.get_entry_point(self.entry),
            FunctionRef::Function(function) => &self.info[function],
        };
        match &info[handle].ty {
            naga::proc::TypeResolution::Handle(handle) => *handle,
            naga::proc::TypeResolution::Value(inner) => {
                build::intern(&mut module.types, inner.clone())
            }
        }
    }

    fn capture_type(
        &self,
        module: &mut Module,
        instance: InstanceId,
        source: &CaptureSource,
    ) -> Handle<Type> {
        let (function, of) = self.function(instance);
        match source {
            CaptureSource::Expression(handle) => self.type_of(module, of, *handle),
            CaptureSource::Local(local) => function.local_variables[*local].ty,
            CaptureSource::Caller {
                instance, source, ..
            } => self.capture_type(module, *instance, source),
        }
    }

    /// The operands of a store, with their types.
    fn operands(&self, module: &mut Module, access: &Access) -> StoreOperands {
        let (function, of) = self.function(access.instance);
        let mut operand = |handle| Operand {
            handle,
            ty: self.type_of(module, of, handle),
        };
        let known = match &access.address {
            Address::Part(steps) => steps,
            Address::Texel { .. } => &access.target.element,
        };
        match *find(function, access.statement) {
            Statement::Store { pointer, value } => {
                let steps = chain(function, pointer, known, &mut operand);
                StoreOperands {
                    steps,
                    texel: None,
                    value: operand(value),
                    atomic: None,
                }
            }
            Statement::Atomic {
                pointer,
                fun,
                value,
                ..
            } => StoreOperands {
                steps: chain(function, pointer, known, &mut operand),
                texel: None,
                value: operand(value),
                atomic: Some(fun),
            },
            Statement::ImageAtomic {
                image,
                coordinate,
                array_index,
                fun,
                value,
            } => StoreOperands {
                steps: chain(function, image, known, &mut operand),
                texel: Some((operand(coordinate), array_index.map(&mut operand))),
                value: operand(value),
                atomic: Some(fun),
            },
            Statement::ImageStore {
                image,
                coordinate,
                array_index,
                value,
            } => StoreOperands {
                steps: chain(function, image, known, &mut operand),
                texel: Some((operand(coordinate), array_index.map(&mut operand))),
                value: operand(value),
                atomic: None,
            },
            ref other => unreachable!("{other:?} does not store"),
        }
    }

    /// Builds the function of an instance, its callees first; `None` if it stays as it is.
    fn build(&mut self, module: &mut Module, instance: InstanceId) -> Option<Handle<Function>> {
        let of_instance = &self.instances[instance.0 as usize];
        let mut edits = self.edits.remove(&instance).unwrap_or_default();
        if instance == InstanceId::ENTRY {
            let settled = self.settled.iter();
            edits.extend(settled.map(|&(statement, holds)| (statement, Edit::Settle(holds))));
        }
        for call in &of_instance.calls {
            if let Some(clone) = self.build(module, call.callee) {
                edits.push((call.statement, Edit::Redirect(clone)));
            }
        }
        edits.sort_by_key(|(statement, _)| *statement);
        let of = of_instance.function;
        if edits.is_empty() && of != FunctionRef::Entry {
            return None;
        }
        let known = self.clones.iter().find(|(f, e, _)| *f == of && *e == edits);
        if let Some((_, _, clone)) = known {
            return Some(*clone);
        }
        let mut function = of.get(self.original, self.entry).clone();
        let name = match of {
            FunctionRef::Entry => format!("{}_inner", self.original.entry_points[self.entry].name),
            FunctionRef::Function(_) => {
                format!("vrcs_{}", function.name.as_deref().unwrap_or("helper"))
            }
        };
        function.name = Some(name);
        for argument in &mut function.arguments {
            argument.binding = None;
        }
        self.apply(module, &mut function, &edits);
        let clone = module.functions.append(function, Span::UNDEFINED);
        self.clones.push((of, edits, clone));
        Some(clone)
    }

    fn apply(&self, module: &mut Module, function: &mut Function, edits: &[(StatementId, Edit)]) {
        let body = std::mem::take(&mut function.body);
        function.body = rebuild(&body, &mut |id, mut statement, span, block| {
            let first = edits.partition_point(|(at, _)| *at < id);
            let here: Vec<&Edit> = edits[first..]
                .iter()
                .take_while(|(at, _)| *at == id)
                .map(|(_, edit)| edit)
                .collect();
            let is_store = matches!(
                statement,
                Statement::Store { .. } | Statement::ImageStore { .. }
            );
            let mut copies = Block::new();
            for edit in here {
                match edit {
                    Edit::Copy { call, captures } => {
                        let mut code = Code::new(&mut module.types, function, span);
                        let mut arguments: Vec<_> = captures
                            .iter()
                            .map(|source| self.value(&mut code, source))
                            .collect();
                        arguments.extend(&call.operands);
                        code.call(call.function, arguments, false);
                        copies.append(&mut code.finish());
                    }
                    Edit::Settle(holds) => settle(&mut statement, *holds, function),
                    Edit::Redirect(clone) => redirect(function, &mut statement, *clone),
                    Edit::Keep { variable, source } => {
                        let mut code = Code::new(&mut module.types, function, span);
                        let value = self.value(&mut code, source);
                        code.set_global(*variable, value);
                        block.append(&mut code.finish());
                    }
                }
            }
            match is_store {
                true => {
                    block.append(&mut copies);
                    block.push(statement, span);
                }
                false => {
                    block.push(statement, span);
                    block.append(&mut copies);
                }
            }
        });
    }

    fn value(&self, code: &mut Code, source: &CaptureSource) -> Handle<Expression> {
        match source {
            CaptureSource::Expression(handle) => *handle,
            CaptureSource::Local(local) => {
                let pointer = code.add(Expression::LocalVariable(*local));
                code.load(pointer)
            }
            CaptureSource::Caller { .. } => {
                let Some((_, variable)) = self.kept.iter().find(|(known, _)| known == source)
                else {
                    unreachable!("what a caller keeps has a variable");
                };
                code.global(*variable)
            }
        }
    }
}

/// Sends a call to another function.
fn redirect(function: &mut Function, statement: &mut Statement, to: Handle<Function>) {
    let Statement::Call {
        function: callee,
        result,
        ..
    } = statement
    else {
        unreachable!("only calls are redirected");
    };
    *callee = to;
    if let Some(result) = *result {
        function.expressions[result] = Expression::CallResult(to);
    }
}

/// The statement with a number.
fn find(function: &Function, id: StatementId) -> &Statement {
    let mut next = 0;
    let mut found = None;
    crate::ir::visit::statements(&function.body, &mut |statement| {
        if next == id.0 {
            found = Some(statement);
        }
        next += 1;
    });
    match found {
        Some(statement) => statement,
        None => unreachable!("the analysis numbered this statement"),
    }
}

/// The steps of a pointer or of a binding array, from its variable on. `known` are the same steps as the analysis has them, for which
/// an index may be a number that is none in the function's text: a helper's argument, a constant.
fn chain(
    function: &Function,
    mut pointer: Handle<Expression>,
    known: &[Step],
    operand: &mut impl FnMut(Handle<Expression>) -> Operand,
) -> Vec<ChainStep> {
    debug_assert!(matches!(
        function.expressions[constant_steps(function, pointer).0],
        Expression::GlobalVariable(_)
    ));
    let mut steps = Vec::with_capacity(known.len());
    for step in known.iter().rev() {
        let (base, computed) = match function.expressions[pointer] {
            Expression::AccessIndex { base, .. } => (base, None),
            Expression::Access { base, index } => (base, Some(index)),
            ref other => unreachable!("{other:?} is no step"),
        };
        pointer = base;
        steps.push(match (*step, computed) {
            (Step::Index(index), _) => ChainStep::Index(index),
            (Step::Dynamic(_), Some(index)) => ChainStep::Computed(operand(index)),
            (Step::Dynamic(_), None) => unreachable!("a member is at a constant place"),
        });
    }
    steps.reverse();
    steps
}
