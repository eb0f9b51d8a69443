//! Policy `full`: takes a shader apart, so that some of its targets are stored for every pixel and the rest at variable rate.
//!
//! ```wgsl
//! // before                                  // after, before anything else is rewritten
//! fn main(id) {                              fn main_full(id) {        // every pixel, with its own ids
//!     let n = decode(packed[..]);                let n = decode(packed[..]);
//!     textureStore(normals, id.xy, n);           textureStore(normals, id.xy, n);
//!     let c = light(n);                      }
//!     textureStore(color, id.xy, c);         fn main(id) {             // at variable rate
//! }                                              let n = decode(packed[..]);
//!                                                let c = light(n);
//!                                                textureStore(color, id.xy, c);
//!                                            }
//! ```
//!
//! *Does*: makes of an entry point a function that stores to the `full` targets alone, and leaves the entry point with the other
//! stores; of each, what no store needs is taken out (`prune`). Helpers that store are cloned for each half. The two halves
//! run one after the other in an invocation, the first for the invocation's own pixel, the second for the pixel that it
//! [impersonates](crate::transform::prologue).
//! *Guarantees*: the `full` half does what the original does to those targets, for every invocation; the entry point keeps its
//! name, place and arguments; nothing else of the module is changed.
//! *Refuses*: halves that would see each other: one reads what the other stores, needs the result of its atomics, or changes a
//! private variable that the other takes as it starts; barriers, workgroup memory and subgroup operations; a shader whose
//! targets are all `full`.

mod prune;
pub mod unasked;

use std::collections::{BTreeMap, BTreeSet};

use naga::{
    AddressSpace, Expression, Function, GlobalVariable, Handle, Module, Span, Statement, TypeInner,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::{
    analysis::{
        Facts,
        facts::{Effects, constant_steps},
    },
    finding::{Code, Finding, Refusal},
    ir::{statements::rebuild, visit},
    options::{Mode, Options, Policy},
};

/// A module whose entry points are taken apart.
pub struct Split {
    /// The module.
    pub module: Module,
    /// What naga knows of it.
    pub info: ModuleInfo,
    /// For each entry point that was taken apart, what runs for every pixel.
    pub full: BTreeMap<usize, Full>,
}

/// What of an entry point runs for every pixel.
pub struct Full {
    /// It has the entry point's arguments, without their bindings.
    pub function: Handle<Function>,
    /// What it stores to, in the order of declaration.
    pub targets: Vec<Handle<GlobalVariable>>,
}

/// Takes entry points apart, each by options of its own; `None` if none of their targets is `full`.
///
/// # Errors
/// If the halves cannot be separated, or the mode does not visit every pixel.
pub fn split(module: &Module, entries: &[(usize, &Options)]) -> Result<Option<Split>, Refusal> {
    // where every invocation runs, every target is full
    let asks = |options: &Options| {
        options.mode != Mode::Graded && options.targets.values().any(|&p| p == Policy::Full)
    };
    if !entries.iter().any(|(_, options)| asks(options)) {
        return Ok(None);
    }
    let mut whole = module.clone();
    let mut full = BTreeMap::new();
    for &(entry, options) in entries.iter().filter(|(_, options)| asks(options)) {
        let is_full = |global: Handle<GlobalVariable>| {
            let name = module.global_variables[global].name.as_deref();
            options.policy(name.unwrap_or_default()) == Policy::Full
        };
        let facts = Facts::new(module, entry);
        let written = facts.written();
        let targets: Vec<_> = written.iter().copied().filter(|&g| is_full(g)).collect();
        if targets.is_empty() {
            continue;
        }
        let name = &module.entry_points[entry].name;
        if !matches!(options.mode, Mode::Tiled | Mode::Auto) {
            return Err(Finding::new(
                Code::NeedsTiles,
                format!(
                    "`{name}` stores to {} for every pixel, and only mode `tiled` visits them all",
                    names(module, &targets)
                ),
            )
            .help("choose mode `tiled`")
            .into());
        }
        if targets.len() == written.len() {
            return Err(Finding::new(
                Code::UnfitOption,
                format!("every target of `{name}` is `full`, so nothing would be saved"),
            )
            .help("leave the shader as it is, or let one of the targets be copied")
            .into());
        }
        let ties = Effects::BARRIER | Effects::WORKGROUP | Effects::SUBGROUP;
        if facts.entry.effects.intersects(ties) {
            return Err(inseparable(
                module,
                &targets,
                "the invocations of a workgroup work together".to_owned(),
                stores(module, entry, &targets)
                    .first()
                    .map_or(Span::UNDEFINED, |store| store.1),
            )
            .into());
        }
        let function = halve(&mut whole, module, entry, &written, &targets)?;
        full.insert(entry, Full { function, targets });
    }
    if full.is_empty() {
        return Ok(None);
    }
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&whole)
        .map_err(|error| {
            Finding::new(
                Code::Defect,
                format!("the rewriter made a mistake: {:?}", error.into_inner()),
            )
        })?;
    Ok(Some(Split {
        module: whole,
        info,
        full,
    }))
}

/// Where an entry point and its helpers store to some resources, once each, in the order of the functions.
pub(crate) fn stores(
    module: &Module,
    entry: usize,
    targets: &[Handle<GlobalVariable>],
) -> Vec<(Handle<GlobalVariable>, Span)> {
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    let mut open = vec![&module.entry_points[entry].function];
    while let Some(function) = open.pop() {
        visit::spanned_statements(&function.body, &mut |statement, span| {
            let place = match *statement {
                Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => pointer,
                Statement::ImageStore { image, .. } | Statement::ImageAtomic { image, .. } => image,
                Statement::Call { function, .. } => {
                    if seen.insert(function) {
                        open.push(&module.functions[function]);
                    }
                    return;
                }
                _ => return,
            };
            if let Some(global) = root(function, &[], place)
                && targets.contains(&global)
            {
                found.push((
                    global,
                    crate::analysis::statement_span(function, statement, span),
                ));
            }
        });
    }
    found
}

fn names(module: &Module, globals: &[Handle<GlobalVariable>]) -> String {
    let name = |&global: &Handle<GlobalVariable>| {
        let name = module.global_variables[global].name.as_deref();
        format!("`{}`", name.unwrap_or("an unnamed resource"))
    };
    globals.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// That nothing is left to be saved.
pub(crate) fn nothing_left(module: &Module, targets: &[Handle<GlobalVariable>]) -> Finding {
    Finding::new(
        Code::UnfitOption,
        format!(
            "beside {}, which every pixel stores, nothing is stored per pixel, so nothing would be saved",
            names(module, targets)
        ),
    )
    .help("leave the shader as it is, or let the target be copied")
}

/// That the halves cannot be separated.
fn inseparable(
    module: &Module,
    targets: &[Handle<GlobalVariable>],
    why: String,
    span: Span,
) -> Finding {
    Finding::new(
        Code::NotSeparable,
        format!(
            "what is stored to {} cannot be separated from the rest: {why}",
            names(module, targets)
        ),
    )
    .at(span, "here")
    .help("let these targets be copied, or store to them in an entry point of their own, in a dispatch before or behind this one")
}

/// Leaves the entry point of `whole` with its other stores, and makes a function of those to `targets`.
fn halve(
    whole: &mut Module,
    original: &Module,
    entry: usize,
    written: &[Handle<GlobalVariable>],
    targets: &[Handle<GlobalVariable>],
) -> Result<Handle<Function>, Finding> {
    let refuse = |(why, span): (String, Span)| inseparable(original, targets, why, span);
    let others: Vec<_> = written
        .iter()
        .copied()
        .filter(|g| !targets.contains(g))
        .collect();
    let function = &original.entry_points[entry].function;

    // an invocation's private variables end with it
    let outlive = BTreeSet::new();
    let mut rest = Half::new(entry, targets);
    let rest_function = rest.of(whole, function, &[], &outlive).map_err(refuse)?;
    let rest_reads = rest.reads(whole, &rest_function).map_err(refuse)?;

    let mut own = Half::new(entry, &others);
    let mut own_function = own.of(whole, function, &[], &outlive).map_err(refuse)?;
    let own_reads = own.reads(whole, &own_function).map_err(refuse)?;
    if let Some(private) = own_reads
        .written
        .iter()
        .find(|p| rest_reads.read.contains(p))
    {
        let name = names(original, &[*private]);
        return Err(refuse((
            format!("both use the private variable {name}"),
            original.global_variables.get_span(*private),
        )));
    }
    whole.entry_points[entry].function = rest_function;
    own_function.name = Some(format!("{}_full", original.entry_points[entry].name));
    for argument in &mut own_function.arguments {
        argument.binding = None;
    }
    Ok(whole.functions.append(own_function, Span::UNDEFINED))
}

/// Why a half cannot be made, and where.
type Blocked = (String, Span);

/// The private variables of a half.
#[derive(Default)]
struct Privates {
    read: BTreeSet<Handle<GlobalVariable>>,
    written: BTreeSet<Handle<GlobalVariable>>,
}

/// A function and the resources that it is handed.
type Handed = (Handle<Function>, Vec<Option<Handle<GlobalVariable>>>);

/// A half while it is made.
struct Half<'h> {
    entry: usize,
    /// The targets whose stores are left out.
    without: &'h [Handle<GlobalVariable>],
    /// Helpers that are made already.
    known: BTreeMap<Handed, Handle<Function>>,
}

impl<'h> Half<'h> {
    fn new(entry: usize, without: &'h [Handle<GlobalVariable>]) -> Half<'h> {
        Half {
            entry,
            without,
            known: BTreeMap::new(),
        }
    }

    /// A function without the stores, and without what only they need. `handed` are the resources that its arguments stand
    /// for; `outlive` the private variables that are read when it has returned.
    fn of(
        &mut self,
        module: &mut Module,
        function: &Function,
        handed: &[Option<Handle<GlobalVariable>>],
        outlive: &BTreeSet<Handle<GlobalVariable>>,
    ) -> Result<Function, Blocked> {
        let mut half = function.clone();
        let root = |operand| root(function, handed, operand);
        let mut callees = BTreeMap::new();
        let mut blocked = None;
        let facts = Facts::new(module, self.entry);
        let stores = Effects::STORE | Effects::ATOMIC;
        let mut calls = Vec::new();
        visit::statements(&function.body, &mut |statement| {
            if let Statement::Call {
                function: callee,
                ref arguments,
                ..
            } = *statement
            {
                let roots: Vec<_> = arguments.iter().map(|&argument| root(argument)).collect();
                let takes_buffer = roots.iter().flatten().any(|&global| {
                    matches!(
                        module.global_variables[global].space,
                        AddressSpace::Storage { .. }
                    )
                });
                if takes_buffer {
                    let span = function.expressions.get_span(arguments[0]);
                    blocked = Some((
                        "a helper is handed a pointer into a buffer".to_owned(),
                        span,
                    ));
                }
                if facts.function(callee).effects.intersects(stores) {
                    calls.push((callee, roots));
                }
            }
        });
        if let Some(blocked) = blocked {
            return Err(blocked);
        }
        for (callee, roots) in calls {
            let key = (callee, roots);
            let made = match self.known.get(&key) {
                Some(&made) => made,
                None => {
                    let helper = module.functions[callee].clone();
                    let span = module.functions.get_span(callee);
                    let helper = self.of(module, &helper, &key.1, &privates(module))?;
                    let made = module.functions.append(helper, span);
                    self.known.insert(key.clone(), made);
                    made
                }
            };
            callees.insert(key, made);
        }
        let mut lost = Vec::new();
        let body = std::mem::take(&mut half.body);
        let expressions = &mut half.expressions;
        half.body = rebuild(&body, &mut |_, mut statement, span, block| {
            let target = match statement {
                Statement::Store { pointer, .. } => Some(pointer),
                Statement::ImageStore { image, .. } | Statement::ImageAtomic { image, .. } => {
                    Some(image)
                }
                Statement::Atomic { pointer, .. } => Some(pointer),
                _ => None,
            };
            if target
                .and_then(root)
                .is_some_and(|global| self.without.contains(&global))
            {
                if let Statement::Atomic {
                    result: Some(result),
                    ..
                } = statement
                {
                    lost.push((result, span));
                }
                return;
            }
            if let Statement::Call {
                function: ref mut callee,
                ref mut arguments,
                result,
            } = statement
            {
                let roots = arguments.iter().map(|&argument| root(argument)).collect();
                if let Some(&made) = callees.get(&(*callee, roots)) {
                    *callee = made;
                    give_nothing_unasked(module, made, arguments, expressions);
                    if let Some(result) = result {
                        expressions[result] = Expression::CallResult(made);
                    }
                }
            }
            block.push(statement, span);
        });
        let facts = Facts::new(module, self.entry);
        let needed = prune::prune(module, &facts, &mut half, outlive);
        for (result, span) in lost {
            if needed.contains(&result) {
                let why = "the result of an atomic on one side is used on the other".to_owned();
                return Err((why, span));
            }
        }
        Ok(half)
    }

    /// Looks for reads of what the other half stores; the private variables that this half uses.
    fn reads(&self, module: &Module, function: &Function) -> Result<Privates, Blocked> {
        let mut privates = Privates::default();
        self.look(module, function, &mut BTreeSet::new(), &mut privates)?;
        Ok(privates)
    }

    fn look(
        &self,
        module: &Module,
        function: &Function,
        seen: &mut BTreeSet<Handle<Function>>,
        privates: &mut Privates,
    ) -> Result<(), Blocked> {
        let is_private = |global: Handle<GlobalVariable>| {
            module.global_variables[global].space == AddressSpace::Private
        };
        for (handle, expression) in function.expressions.iter() {
            let (Expression::Load { pointer: place } | Expression::ImageLoad { image: place, .. }) =
                *expression
            else {
                continue;
            };
            let span = function.expressions.get_span(handle);
            match function.expressions[constant_steps(function, place).0] {
                Expression::GlobalVariable(global) if self.without.contains(&global) => {
                    let name = names(module, &[global]);
                    return Err((
                        format!("one side reads {name}, which the other stores"),
                        span,
                    ));
                }
                Expression::GlobalVariable(global) if is_private(global) => {
                    privates.read.insert(global);
                }
                Expression::FunctionArgument(index)
                    if is_writable_image(module, function.arguments[index as usize].ty) =>
                {
                    let why =
                        "a helper reads a texture that it is handed, which may be the other side's";
                    return Err((why.to_owned(), span));
                }
                _ => {}
            }
        }
        let mut callees = Vec::new();
        visit::statements(&function.body, &mut |statement| match *statement {
            Statement::Store { pointer, .. } => {
                let root = constant_steps(function, pointer).0;
                if let Expression::GlobalVariable(global) = function.expressions[root]
                    && is_private(global)
                {
                    privates.written.insert(global);
                }
            }
            Statement::Call {
                function: callee,
                ref arguments,
                ..
            } => {
                for &argument in arguments {
                    let root = constant_steps(function, argument).0;
                    if let Expression::GlobalVariable(global) = function.expressions[root]
                        && is_private(global)
                    {
                        privates.read.insert(global);
                        privates.written.insert(global);
                    }
                }
                callees.push(callee);
            }
            _ => {}
        });
        for callee in callees {
            if seen.insert(callee) {
                self.look(module, &module.functions[callee], seen, privates)?;
            }
        }
        Ok(())
    }
}

/// Replaces values that a helper takes and does not need any more, so that nobody computes them.
fn give_nothing_unasked(
    module: &Module,
    helper: Handle<Function>,
    arguments: &mut [Handle<Expression>],
    expressions: &mut naga::Arena<Expression>,
) {
    let helper = &module.functions[helper];
    for (index, argument) in arguments.iter_mut().enumerate() {
        let ty = helper.arguments[index].ty;
        let is_it = |e: &Expression| *e == Expression::FunctionArgument(index as u32);
        let is_asked = helper.expressions.iter().any(|(_, e)| is_it(e));
        if !is_asked && module.types[ty].inner.is_constructible(&module.types) {
            *argument = expressions.append(Expression::ZeroValue(ty), Span::UNDEFINED);
        }
    }
}

/// The private variables of a module.
fn privates(module: &Module) -> BTreeSet<Handle<GlobalVariable>> {
    (module.global_variables.iter())
        .filter(|(_, global)| global.space == AddressSpace::Private)
        .map(|(handle, _)| handle)
        .collect()
}

/// The resource that an operand leads to.
fn root(
    function: &Function,
    handed: &[Option<Handle<GlobalVariable>>],
    operand: Handle<Expression>,
) -> Option<Handle<GlobalVariable>> {
    match function.expressions[constant_steps(function, operand).0] {
        Expression::GlobalVariable(global) => Some(global),
        Expression::FunctionArgument(index) => handed.get(index as usize).copied().flatten(),
        _ => None,
    }
}

fn is_writable_image(module: &Module, ty: Handle<naga::Type>) -> bool {
    matches!(
        module.types[ty].inner,
        TypeInner::Image {
            class: naga::ImageClass::Storage { .. },
            ..
        }
    )
}
