//! Imports functions from one module into another.
//!
//! The prelude is WGSL, parsed into a module of its own; what a rewritten shader needs of it comes over function by
//! function. Appending the prelude to the user's text instead would move no spans either, but it is not hygienic: a
//! user's own `fn firstTrailingBit` then shadows the built-in function inside the prelude, silently.
//!
//! *Does*: copies a function and all that it reaches, callees before callers, each thing once; types are merged with
//! equal ones; bindings are replaced by the caller's. A function named in `hooks` is not copied: calls to it go to the
//! given function instead, and functions that reach a hook are copied anew for each set of hooks. That is how the
//! prelude calls code that is made for one entry point.
//! *Needs*: a valid source module.
//! *Guarantees*: copied code has no spans, so that it never points into the user's text.

use naga::{
    Arena, Block, Constant, Expression, Function, GlobalVariable, Handle, Module, ResourceBinding,
    Span, Statement, StructMember, Type, TypeInner,
};
use rustc_hash::FxHashMap;

use super::visit;

/// What has been imported so far, and how the rest is to be placed.
#[derive(Default)]
pub struct Imports {
    types: FxHashMap<Handle<Type>, Handle<Type>>,
    constants: FxHashMap<Handle<Constant>, Handle<Constant>>,
    globals: FxHashMap<Handle<GlobalVariable>, Handle<GlobalVariable>>,
    functions: FxHashMap<Handle<Function>, Handle<Function>>,
    /// Functions that lead to a hook, for the hooks that are set now.
    hooked: FxHashMap<Handle<Function>, Handle<Function>>,
    hooks: FxHashMap<&'static str, Handle<Function>>,
    /// Where the source's resources go, by name.
    pub placements: FxHashMap<&'static str, ResourceBinding>,
}

impl Imports {
    /// Lets `function` stand in for the source's function of that name, from now on.
    pub fn hook(&mut self, name: &'static str, function: Handle<Function>) {
        self.hooks.insert(name, function);
    }

    /// Takes all hooks off.
    pub fn unhook(&mut self) {
        self.hooks.clear();
        self.hooked.clear();
    }

    /// Imports the function called `name`.
    ///
    /// # Panics
    /// If the source has no such function: the prelude is ours.
    pub fn function(&mut self, from: &Module, into: &mut Module, name: &str) -> Handle<Function> {
        let found = from
            .functions
            .iter()
            .find(|(_, f)| f.name.as_deref() == Some(name));
        let Some((handle, _)) = found else {
            unreachable!("the prelude has no function {name}");
        };
        self.import_function(from, into, handle)
    }

    /// Imports the global variable called `name`.
    ///
    /// # Panics
    /// If the source has no such variable: the prelude is ours.
    pub fn global(
        &mut self,
        from: &Module,
        into: &mut Module,
        name: &str,
    ) -> Handle<GlobalVariable> {
        let found = from
            .global_variables
            .iter()
            .find(|(_, g)| g.name.as_deref() == Some(name));
        let Some((handle, _)) = found else {
            unreachable!("the prelude has no variable {name}");
        };
        self.import_global(from, into, handle)
    }

    fn import_function(
        &mut self,
        from: &Module,
        into: &mut Module,
        handle: Handle<Function>,
    ) -> Handle<Function> {
        if let Some(&done) = self.hooked.get(&handle) {
            return done;
        }
        let leads_to_hook = self.leads_to_hook(from, handle);
        if let Some(&done) = self.functions.get(&handle)
            && !leads_to_hook
        {
            return done;
        }
        let source = &from.functions[handle];
        if let Some(&hook) = source.name.as_deref().and_then(|name| self.hooks.get(name)) {
            self.hooked.insert(handle, hook);
            return hook;
        }
        let mut function = source.clone();
        let mut callees = FxHashMap::default();
        visit::statements(&source.body, &mut |statement| {
            if let Statement::Call { function, .. } = *statement {
                callees.insert(function, self.import_function(from, into, function));
            }
        });
        function.diagnostic_filter_leaf = None;
        for argument in &mut function.arguments {
            argument.ty = self.import_type(from, into, argument.ty);
        }
        if let Some(result) = &mut function.result {
            result.ty = self.import_type(from, into, result.ty);
        }
        for (_, local) in function.local_variables.iter_mut() {
            local.ty = self.import_type(from, into, local.ty);
        }
        for (_, expression) in function.expressions.iter_mut() {
            match expression {
                Expression::CallResult(callee) => *callee = callees[&*callee],
                other => self.import_references(from, into, other),
            }
        }
        forget_spans(&mut function.expressions);
        forget_spans(&mut function.local_variables);
        redirect_calls(&mut function.body, &callees);
        let imported = into.functions.append(function, Span::UNDEFINED);
        match leads_to_hook {
            true => self.hooked.insert(handle, imported),
            false => self.functions.insert(handle, imported),
        };
        imported
    }

    fn leads_to_hook(&self, from: &Module, handle: Handle<Function>) -> bool {
        let function = &from.functions[handle];
        let is_hook = |name: &str| self.hooks.contains_key(name);
        let mut leads = function.name.as_deref().is_some_and(is_hook);
        visit::statements(&function.body, &mut |statement| {
            if let Statement::Call { function, .. } = *statement {
                leads |= self.leads_to_hook(from, function);
            }
        });
        leads
    }

    /// Maps what an expression refers to outside its own arena.
    fn import_references(&mut self, from: &Module, into: &mut Module, expression: &mut Expression) {
        match expression {
            Expression::Constant(constant) => {
                *constant = self.import_constant(from, into, *constant);
            }
            Expression::ZeroValue(ty)
            | Expression::Compose { ty, .. }
            | Expression::AtomicResult { ty, .. }
            | Expression::WorkGroupUniformLoadResult { ty }
            | Expression::SubgroupOperationResult { ty } => {
                *ty = self.import_type(from, into, *ty);
            }
            Expression::GlobalVariable(global) => {
                *global = self.import_global(from, into, *global);
            }
            Expression::Override(_) => unreachable!("the prelude declares no overrides"),
            _ => {}
        }
    }

    fn import_global(
        &mut self,
        from: &Module,
        into: &mut Module,
        handle: Handle<GlobalVariable>,
    ) -> Handle<GlobalVariable> {
        if let Some(&done) = self.globals.get(&handle) {
            return done;
        }
        let mut global = from.global_variables[handle].clone();
        global.ty = self.import_type(from, into, global.ty);
        global.init = global
            .init
            .map(|init| self.import_global_expression(from, into, init));
        if global.binding.is_some() {
            let name = global.name.as_deref().unwrap_or_default();
            let Some(&placement) = self.placements.get(name) else {
                unreachable!("the prelude's {name} was given no place");
            };
            global.binding = Some(placement);
        }
        let imported = into.global_variables.append(global, Span::UNDEFINED);
        self.globals.insert(handle, imported);
        imported
    }

    fn import_constant(
        &mut self,
        from: &Module,
        into: &mut Module,
        handle: Handle<Constant>,
    ) -> Handle<Constant> {
        if let Some(&done) = self.constants.get(&handle) {
            return done;
        }
        let mut constant = from.constants[handle].clone();
        constant.ty = self.import_type(from, into, constant.ty);
        constant.init = self.import_global_expression(from, into, constant.init);
        let imported = into.constants.append(constant, Span::UNDEFINED);
        self.constants.insert(handle, imported);
        imported
    }

    fn import_global_expression(
        &mut self,
        from: &Module,
        into: &mut Module,
        handle: Handle<Expression>,
    ) -> Handle<Expression> {
        let mut expression = from.global_expressions[handle].clone();
        visit::operands_mut(&mut expression, &mut |operand| {
            *operand = self.import_global_expression(from, into, *operand);
        });
        self.import_references(from, into, &mut expression);
        into.global_expressions.append(expression, Span::UNDEFINED)
    }

    fn import_type(
        &mut self,
        from: &Module,
        into: &mut Module,
        handle: Handle<Type>,
    ) -> Handle<Type> {
        if let Some(&done) = self.types.get(&handle) {
            return done;
        }
        let mut ty = from.types[handle].clone();
        match &mut ty.inner {
            TypeInner::Pointer { base, space: _ }
            | TypeInner::Array { base, .. }
            | TypeInner::BindingArray { base, .. } => *base = self.import_type(from, into, *base),
            TypeInner::Struct { members, span: _ } => {
                for StructMember { ty, .. } in members {
                    *ty = self.import_type(from, into, *ty);
                }
            }
            TypeInner::Scalar(_)
            | TypeInner::Vector { .. }
            | TypeInner::Matrix { .. }
            | TypeInner::CooperativeMatrix { .. }
            | TypeInner::Atomic(_)
            | TypeInner::ValuePointer { .. }
            | TypeInner::Image { .. }
            | TypeInner::Sampler { .. }
            | TypeInner::AccelerationStructure { .. }
            | TypeInner::RayQuery { .. } => {}
        }
        let imported = into.types.insert(ty, Span::UNDEFINED);
        self.types.insert(handle, imported);
        imported
    }
}

/// Appends everything anew: an arena's spans cannot be changed in place, and `clear` would keep them.
fn forget_spans<T>(arena: &mut Arena<T>) {
    let mut fresh = Arena::new();
    for (_, value, _) in arena.drain() {
        fresh.append(value, Span::UNDEFINED);
    }
    *arena = fresh;
}

fn redirect_calls(block: &mut Block, callees: &FxHashMap<Handle<Function>, Handle<Function>>) {
    for (statement, span) in block.span_iter_mut() {
        if let Some(span) = span {
            *span = Span::UNDEFINED;
        }
        match statement {
            Statement::Call { function, .. } => *function = callees[&*function],
            Statement::Block(inner) => redirect_calls(inner, callees),
            Statement::If { accept, reject, .. } => {
                redirect_calls(accept, callees);
                redirect_calls(reject, callees);
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    redirect_calls(&mut case.body, callees);
                }
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                redirect_calls(body, callees);
                redirect_calls(continuing, callees);
            }
            _ => {}
        }
    }
}
