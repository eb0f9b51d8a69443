//! Counts the subgroups that come to the work for primaries, in a rewritten shader whose invocations work together.
//!
//! ```wgsl
//! vrcs_count_subgroup(3u);            // those that come by
//! if vrcs_on {
//!     vrcs_count_subgroup(4u);        // those that have a primary, and work
//!     ..
//! }
//! ```
//!
//! *Does*: finds what was put under "this invocation has a primary" by the [split](crate::transform::regions), and what was
//! put under "this invocation's own pixel is a primary" by masking, and counts at each the subgroups in front of it and inside,
//! by an atomic of the first invocation of each.
//! *Needs*: a device with subgroup operations.
//! *Guarantees*: a subgroup is counted each time that any of its invocations comes, however many do.

use naga::{
    Expression, Function, GlobalVariable, Handle, Module, ResourceBinding, Span, Statement,
};

use super::{free_binding, reachable};
use crate::ir::{build::Code, import::Imports, statements::rebuild};

const TEXT: &str = include_str!("subgroups.wgsl");

/// A module that counts its subgroups.
#[derive(Clone, Debug)]
pub struct Counted {
    /// The module.
    pub module: Module,
    /// Where the counts are bound: a storage buffer, read and written, of [`Counted::words`] words.
    pub binding: ResourceBinding,
    /// The places where subgroups are counted, in the order of the text.
    pub works: Vec<Work>,
}

impl Counted {
    /// The words of the counts: for each of [`Counted::works`] the subgroups that came by, and those that went in.
    pub fn words(&self) -> u32 {
        2 * self.works.len() as u32
    }
}

/// Work that is done for primaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Whether a whole region waits for a primary, or a single store does.
    pub kind: WorkKind,
    /// Where it stands in the source.
    pub span: Span,
}

/// What waits for a primary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkKind {
    /// The per-pixel part of a region: a subgroup without a primary skips it.
    Region,
    /// A store of a masked region: all that leads to it is done by every subgroup.
    MaskedStore,
}

/// Counts the subgroups of a rewritten entry point.
pub fn count_subgroups(module: &Module, entry: usize) -> Counted {
    let prelude = match naga::front::wgsl::parse_str(TEXT) {
        Ok(prelude) => prelude,
        Err(error) => unreachable!("{}", error.emit_to_string(TEXT)),
    };
    // what is called has to stand before its callers, so the module's own functions move up
    let mut counted = Module {
        functions: naga::Arena::new(),
        doc_comments: None,
        ..module.clone()
    };
    let binding = free_binding(module);
    let mut imports = Imports::default();
    imports.placements.insert("vrcs_subgroups", binding);
    let hook = imports.function(&prelude, &mut counted, "vrcs_count_subgroup");
    let named = |name: &str| {
        let found = |(_, global): &(_, &GlobalVariable)| global.name.as_deref() == Some(name);
        module.global_variables.iter().find(found).map(|(h, _)| h)
    };
    let mut cx = Context {
        hook,
        on: named("vrcs_on"),
        is_primary: named("vrcs_is_primary"),
        moved: Vec::with_capacity(module.functions.len()),
        works: Vec::new(),
    };
    let reachable = reachable(module, entry);
    for (handle, function) in module.functions.iter() {
        let mut function = function.clone();
        cx.function(&mut counted, &mut function, reachable.contains(&handle));
        let span = module.functions.get_span(handle);
        cx.moved.push(counted.functions.append(function, span));
    }
    let mut entry_point = module.entry_points[entry].clone();
    cx.function(&mut counted, &mut entry_point.function, true);
    counted.entry_points = vec![entry_point];
    Counted {
        module: counted,
        binding,
        works: cx.works,
    }
}

struct Context {
    hook: Handle<Function>,
    on: Option<Handle<GlobalVariable>>,
    is_primary: Option<Handle<GlobalVariable>>,
    /// Where the module's functions are now.
    moved: Vec<Handle<Function>>,
    works: Vec<Work>,
}

impl Context {
    fn function(&mut self, module: &mut Module, function: &mut Function, is_reachable: bool) {
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::CallResult(callee) = expression {
                *callee = self.moved[callee.index()];
            }
        }
        // finding one's duplicates is no work for a primary
        let is_ours = function.name.as_deref() == Some("vrcs_group_masks");
        let body = std::mem::take(&mut function.body);
        function.body = rebuild(&body, &mut |_, mut statement, span, block| {
            if let Statement::Call { function, .. } = &mut statement {
                *function = self.moved[function.index()];
            }
            if let Statement::If {
                condition,
                ref mut accept,
                ..
            } = statement
                && is_reachable
                && !is_ours
                && let Some(kind) = self.kind(function, condition)
            {
                let word = 2 * self.works.len() as u32;
                self.works.push(Work { kind, span });
                block.append(&mut self.count(module, function, word, span));
                let mut inside = self.count(module, function, word + 1, span);
                inside.append(accept);
                *accept = inside;
            }
            block.push(statement, span);
        });
    }

    /// What a condition lets wait.
    fn kind(&self, function: &Function, condition: Handle<Expression>) -> Option<WorkKind> {
        let Expression::Load { pointer } = function.expressions[condition] else {
            return None;
        };
        let Expression::GlobalVariable(global) = function.expressions[pointer] else {
            return None;
        };
        match Some(global) {
            global if global == self.on => Some(WorkKind::Region),
            global if global == self.is_primary => Some(WorkKind::MaskedStore),
            _ => None,
        }
    }

    fn count(
        &self,
        module: &mut Module,
        function: &mut Function,
        word: u32,
        span: Span,
    ) -> naga::Block {
        let mut code = Code::new(&mut module.types, function, span);
        let word = code.u32(word);
        code.call(self.hook, vec![word], false);
        code.finish()
    }
}
