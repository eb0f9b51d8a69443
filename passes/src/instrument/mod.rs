//! Instrumented builds of a shader, for whoever checks a rewrite: which invocation stores where, and how often each place
//! is stored to.
//!
//! Both are made on any module, rewritten or not, and know nothing of the [analysis](crate::analysis): what they report is
//! what ran. The original's [log](log_stores) tells every address that an invocation used, in order; the rewritten
//! shader's [counts](count_stores) tell how often each place was written.
//!
//! What the subgroups do is counted by builds of their own: [`subgroups`].
//!
//! *Does*: puts a call in front of every store to a buffer or texture. The stores themselves stay.
//! *Guarantees*: an address outside its resource is told apart, never clamped into it.

mod address;
pub mod subgroups;

use std::collections::BTreeSet;

use naga::{
    Binding, Block, BuiltIn, Expression, Function, FunctionArgument, GlobalVariable, Handle,
    Module, ResourceBinding, Scalar, Span, Statement, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use crate::ir::{
    build::{self, Code},
    import::Imports,
    statements::rebuild,
    visit,
};

/// The size of a resource that a shader stores to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A texture: width, height, depth or layers.
    Texture([u32; 3]),
    /// A buffer, in bytes.
    Buffer(u32),
}

/// What is stored where.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// The variable.
    pub global: Handle<GlobalVariable>,
    /// Bytes written, for a buffer; 1 for a texel.
    pub size: u32,
    /// For each unit of a place (a texel, or two bytes), whether nothing of the value is in it: it lies between the members
    /// of a struct.
    pub padding: Vec<bool>,
    /// What is done there, if it is no plain store.
    pub atomic: Option<Atomic>,
    /// Where it stands in the source.
    pub span: Span,
}

/// An atomic on a 32-bit integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Atomic {
    /// What it does.
    pub function: naga::AtomicFunction,
    /// Whether it is one of an `i32`.
    pub is_signed: bool,
}

/// An instrumented module.
#[derive(Clone, Debug)]
pub struct Instrumented {
    /// The module.
    pub module: Module,
    /// Where the log or the counts are bound: a storage buffer, read and written.
    pub binding: ResourceBinding,
    /// The stores, by the number that the log names them with.
    pub sites: Vec<Site>,
}

/// A place outside its resource, in a log.
pub const OUTSIDE: u32 = u32::MAX;

const LOG: &str = include_str!("log.wgsl");
/// What logs, in there.
const LOG_STORES: &str = "vrcs_log";

/// Words of the log for a store.
pub const STORE_WORDS: u32 = 5;

/// How large the log is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogSize {
    /// The invocations of the dispatch, on each axis.
    pub grid: [u32; 3],
    /// The most stores of one invocation that the log holds.
    pub slots: u32,
}

impl LogSize {
    /// The words of the log: for each invocation, x fastest, the number of its stores, then for each of `slots` stores
    /// the site, the place, the path (a number that is the same for two stores in the same iterations of the loops around them, on the
    /// same path of calls), the place in a buffer with each index confined to its array, and the value of an atomic.
    pub fn words(&self) -> u64 {
        let invocations: u64 = self.grid.iter().map(|&n| u64::from(n)).product();
        invocations * u64::from(self.words_each())
    }

    /// The words of each invocation.
    pub fn words_each(&self) -> u32 {
        1 + STORE_WORDS * self.slots
    }
}

/// Logs each store of an entry point: the site, and the place as a texel number or a byte offset.
///
/// `shapes` gives the size of each resource.
///
/// # Panics
/// If a resource that is stored to has no shape.
pub fn log_stores(
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
    size: LogSize,
    shapes: &dyn Fn(Handle<GlobalVariable>) -> Option<Shape>,
) -> Instrumented {
    let [width, height, _] = size.grid;
    let text = format!(
        "const WIDTH: u32 = {width}u;\nconst HEIGHT: u32 = {height}u;\nconst SLOTS: u32 = {}u;\n{LOG}",
        size.slots
    );
    instrument(module, info, entry, &text, LOG_STORES, shapes, &|_| 0)
}

/// Counts the stores to each place: a texture has a word for each texel, a buffer one for each two bytes. `base` gives
/// the word at which each resource starts.
///
/// # Panics
/// If a resource that is stored to has no shape.
pub fn count_stores(
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
    shapes: &dyn Fn(Handle<GlobalVariable>) -> Option<Shape>,
    base: &dyn Fn(Handle<GlobalVariable>) -> u32,
) -> Instrumented {
    const UNUSED: &str =
        "const WIDTH: u32 = 0u;\nconst HEIGHT: u32 = 0u;\nconst SLOTS: u32 = 0u;\n";
    let text = format!("{UNUSED}{LOG}");
    instrument(module, info, entry, &text, "vrcs_count", shapes, base)
}

fn instrument(
    module: &Module,
    info: &ModuleInfo,
    entry: usize,
    text: &str,
    hook: &str,
    shapes: &dyn Fn(Handle<GlobalVariable>) -> Option<Shape>,
    base: &dyn Fn(Handle<GlobalVariable>) -> u32,
) -> Instrumented {
    let prelude = match naga::front::wgsl::parse_str(text) {
        Ok(prelude) => prelude,
        Err(error) => unreachable!("{}", error.emit_to_string(text)),
    };
    // what the stores call has to stand before them, so the author's functions move up
    let mut instrumented = Module {
        functions: naga::Arena::new(),
        doc_comments: None,
        ..module.clone()
    };
    let binding = free_binding(module);
    let mut imports = Imports::default();
    imports.placements.insert("vrcs_log_words", binding);
    let logs = hook == LOG_STORES;
    let hook = imports.function(&prelude, &mut instrumented, hook);
    let begin = imports.function(&prelude, &mut instrumented, "vrcs_begin");
    let paths = logs.then(|| Paths {
        here: imports.function(&prelude, &mut instrumented, "vrcs_here"),
        go_on: imports.function(&prelude, &mut instrumented, "vrcs_go_on"),
        go_back: imports.function(&prelude, &mut instrumented, "vrcs_go_back"),
        storing: storing(module),
        steps: 0,
    });

    let mut cx = Context {
        original: module,
        hook,
        shapes,
        base,
        moved: Vec::with_capacity(module.functions.len()),
        stores: true,
        atomics: logs,
        paths,
        sites: Vec::new(),
    };
    let reachable = reachable(module, entry);
    for (handle, function) in module.functions.iter() {
        let mut function = function.clone();
        // other entry points may store to what this one does not even bind
        cx.stores = reachable.contains(&handle);
        cx.function(&mut instrumented, &mut function, &info[handle]);
        let span = module.functions.get_span(handle);
        cx.moved.push(instrumented.functions.append(function, span));
    }
    cx.stores = true;
    let mut entry_point = module.entry_points[entry].clone();
    let function = &mut entry_point.function;
    cx.function(&mut instrumented, function, info.get_entry_point(entry));
    begin_entry(&mut instrumented, function, begin);
    instrumented.entry_points = vec![entry_point];
    Instrumented {
        sites: cx.sites,
        module: instrumented,
        binding,
    }
}

/// The functions that an entry point may call.
fn reachable(module: &Module, entry: usize) -> BTreeSet<Handle<Function>> {
    let mut found = BTreeSet::new();
    let mut open = vec![&module.entry_points[entry].function];
    while let Some(function) = open.pop() {
        visit::statements(&function.body, &mut |statement| {
            if let Statement::Call { function, .. } = *statement
                && found.insert(function)
            {
                open.push(&module.functions[function]);
            }
        });
    }
    found
}

/// A binding number that the module leaves free, in the group that it uses most.
fn free_binding(module: &Module) -> ResourceBinding {
    let bindings = || {
        module
            .global_variables
            .iter()
            .filter_map(|(_, g)| g.binding)
    };
    let group = bindings().map(|binding| binding.group).min().unwrap_or(0);
    let binding = bindings()
        .filter(|binding| binding.group == group)
        .map(|binding| binding.binding + 1)
        .max()
        .unwrap_or(0);
    ResourceBinding { group, binding }
}

struct Context<'c> {
    original: &'c Module,
    hook: Handle<Function>,
    shapes: &'c dyn Fn(Handle<GlobalVariable>) -> Option<Shape>,
    base: &'c dyn Fn(Handle<GlobalVariable>) -> u32,
    /// Where the author's functions are now.
    moved: Vec<Handle<Function>>,
    /// Whether the function at hand is instrumented.
    stores: bool,
    /// Whether atomics are, too.
    atomics: bool,
    /// How paths are told, if they are.
    paths: Option<Paths>,
    sites: Vec<Site>,
}

/// What tells the path to a store: the iterations of loops, and the calls.
struct Paths {
    here: Handle<Function>,
    go_on: Handle<Function>,
    go_back: Handle<Function>,
    /// The author's functions that store something, themselves or through others.
    storing: BTreeSet<Handle<Function>>,
    /// How many loops and calls there are so far.
    steps: u32,
}

/// The functions that store something besides their own variables. Callees stand before their callers.
fn storing(module: &Module) -> BTreeSet<Handle<Function>> {
    let mut found = BTreeSet::new();
    for (handle, function) in module.functions.iter() {
        let mut calls = false;
        visit::statements(&function.body, &mut |statement| {
            calls |= match *statement {
                Statement::Store { pointer, .. } => !is_local(function, pointer),
                Statement::ImageStore { .. }
                | Statement::Atomic { .. }
                | Statement::ImageAtomic { .. } => true,
                Statement::Call { function, .. } => found.contains(&function),
                _ => false,
            };
        });
        if calls {
            found.insert(handle);
        }
    }
    found
}

fn is_local(function: &Function, mut pointer: Handle<Expression>) -> bool {
    loop {
        match function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                pointer = base;
            }
            Expression::LocalVariable(_) => return true,
            _ => return false,
        }
    }
}

impl Context<'_> {
    /// Puts a call in front of each store, and sends calls to where the functions have moved.
    fn function(&mut self, module: &mut Module, function: &mut Function, info: &FunctionInfo) {
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::CallResult(callee) = expression {
                *callee = self.moved[callee.index()];
            }
        }
        let body = std::mem::take(&mut function.body);
        function.body = rebuild(&body, &mut |_, mut statement, span, block| {
            let path = self.enter(module, function, &mut statement, span, block);
            if let Statement::Call { function, .. } = &mut statement {
                *function = self.moved[function.index()];
            }
            let pointer = match statement {
                Statement::Store { pointer, .. } => Some(pointer),
                Statement::ImageStore { image, .. } => Some(image),
                Statement::Atomic { pointer, .. } if self.atomics => Some(pointer),
                Statement::ImageAtomic { image, .. } if self.atomics => Some(image),
                _ => None,
            };
            if let Some(pointer) = pointer
                && self.stores
                && let Some(destination) =
                    address::destination(self.original, function, &statement, pointer)
            {
                let Some(shape) = (self.shapes)(destination.global) else {
                    unreachable!("every resource that is stored to has a shape");
                };
                let number = self.sites.len() as u32;
                let atomic = match statement {
                    Statement::Atomic { fun, value, .. }
                    | Statement::ImageAtomic { fun, value, .. } => Some((fun, value)),
                    _ => None,
                };
                self.sites.push(Site {
                    global: destination.global,
                    size: destination.size,
                    padding: destination.padding.clone(),
                    atomic: atomic.map(|(function, value)| Atomic {
                        function,
                        is_signed: info[value].ty.inner_with(&module.types).scalar_kind()
                            == Some(naga::ScalarKind::Sint),
                    }),
                    span: crate::analysis::statement_span(function, &statement, span),
                });
                let mut code = Code::new(&mut module.types, function, span);
                let [place, confined] = destination.write(&mut code, info, &statement, shape);
                let base = (self.base)(destination.global);
                let mut arguments = [number, base, destination.size]
                    .map(|n| code.u32(n))
                    .to_vec();
                arguments.extend([place, confined]);
                arguments.push(match atomic {
                    Some((_, value)) => code.add(Expression::As {
                        expr: value,
                        kind: naga::ScalarKind::Uint,
                        convert: None,
                    }),
                    None => code.u32(0),
                });
                code.call(self.hook, arguments, false);
                block.append(&mut code.finish());
            }
            block.push(statement, span);
            if let (Some(path), Some(paths)) = (path, &self.paths) {
                let mut code = Code::new(&mut module.types, function, span);
                code.call(paths.go_back, vec![path], false);
                block.append(&mut code.finish());
            }
        });
    }

    /// Has a loop's iterations, or a call, make a step of the path, where something is stored inside. Gives the path before.
    fn enter(
        &mut self,
        module: &mut Module,
        function: &mut Function,
        statement: &mut Statement,
        span: Span,
        block: &mut Block,
    ) -> Option<Handle<Expression>> {
        let paths = self.paths.as_mut()?;
        let is_entered = self.stores
            && match statement {
                Statement::Loop { body, .. } => holds_call(body, self.hook, &paths.go_on),
                Statement::Call { function, .. } => paths.storing.contains(function),
                _ => false,
            };
        if !is_entered {
            return None;
        }
        paths.steps += 1;
        let mut code = Code::new(&mut module.types, function, span);
        let before = code.value_of(paths.here, Vec::new());
        let step = code.u32(paths.steps);
        let mut enter = code.finish();
        let mut code = Code::new(&mut module.types, function, span);
        code.call(paths.go_on, vec![step], false);
        let mut go_on = code.finish();
        match statement {
            Statement::Loop { body, .. } => {
                go_on.append(body);
                *body = go_on;
            }
            _ => enter.append(&mut go_on),
        }
        block.append(&mut enter);
        Some(before)
    }
}

/// Whether a block that has been rebuilt logs something, or makes a step of the path.
fn holds_call(block: &Block, hook: Handle<Function>, go_on: &Handle<Function>) -> bool {
    let mut found = false;
    visit::statements(block, &mut |statement| {
        if let Statement::Call { function, .. } = statement {
            found |= *function == hook || function == go_on;
        }
    });
    found
}

/// Tells the log which invocation this is.
fn begin_entry(module: &mut Module, function: &mut Function, begin: Handle<Function>) {
    let ids = build::numeric(&mut module.types, build::vector_size(3), Scalar::U32);
    let is_gid =
        |binding: &Option<Binding>| *binding == Some(Binding::BuiltIn(BuiltIn::GlobalInvocationId));
    let mut place = None;
    for (index, argument) in function.arguments.iter().enumerate() {
        if is_gid(&argument.binding) {
            place = Some((index, None));
        }
        if let TypeInner::Struct { members, .. } = &module.types[argument.ty].inner
            && let Some(member) = members.iter().position(|member| is_gid(&member.binding))
        {
            place = Some((index, Some(member as u32)));
        }
    }
    let (argument, member) = place.unwrap_or_else(|| {
        function.arguments.push(FunctionArgument {
            name: Some("vrcs_gid".to_owned()),
            ty: ids,
            binding: Some(Binding::BuiltIn(BuiltIn::GlobalInvocationId)),
        });
        (function.arguments.len() - 1, None)
    });
    let mut code = Code::new(&mut module.types, function, Span::UNDEFINED);
    let mut gid = code.add(Expression::FunctionArgument(argument as u32));
    if let Some(member) = member {
        gid = code.at(gid, member);
    }
    code.call(begin, vec![gid], false);
    let mut body = code.finish();
    body.append(&mut function.body);
    function.body = body;
}
