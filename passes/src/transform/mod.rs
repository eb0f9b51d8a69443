//! Carries out a [plan](crate::plan), in one fixed order: bindings, prelude, copies, clones of helpers, the entry point
//! as an ordinary function, the new entry point.
//!
//! *Guarantees*: only appends to the module; the author's functions, types, globals, constants, overrides and other entry
//! points stay what and where they were.

pub mod bindings;
pub mod copies;
pub mod prologue;
pub mod recompute;
pub mod specialise;

use naga::{Function, Handle, Module, valid::ModuleInfo};

use crate::{analysis::FunctionRef, ir::import::Imports, options::Options, plan::EntryPlan};
use copies::Copies;
use specialise::Specialise;

/// Rewrites one entry point of `module`, a copy of `original` that may already hold other rewritten entry points. Gives the
/// clones that were made, and what each was made from.
pub fn apply(
    module: &mut Module,
    original: &Module,
    info: &ModuleInfo,
    entry: usize,
    plan: &mut EntryPlan,
    imports: &mut Imports,
    options: &Options,
) -> Vec<(FunctionRef, Handle<Function>)> {
    let found = &mut plan.found;
    let prologue = prologue::import(
        module,
        imports,
        options,
        &mut found.terms,
        found.group_size,
        entry,
        &plan.domain,
    );
    let mut copies = Copies::new(
        &mut found.terms,
        found.group_size,
        entry,
        &prologue,
        options.max_rate,
    );
    let specialise = Specialise::new(
        original,
        info,
        entry,
        &found.instances,
        &found.accesses,
        &plan.copies,
    );
    let (inner, clones) = specialise.run(module, &mut copies);
    let function = prologue::entry_function(
        module,
        &found.terms,
        found.group_size,
        entry,
        &prologue,
        inner,
    );
    let rewritten = &mut module.entry_points[entry];
    rewritten.function = function;
    let [width, height] = options.tile;
    rewritten.workgroup_size = [width, height, 1];
    rewritten.workgroup_size_overrides = None;
    clones
}
