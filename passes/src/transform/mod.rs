//! Carries out a [plan](crate::plan), in one fixed order: bindings, prelude, copies, clones of helpers, the entry point
//! as an ordinary function, the new entry point.
//!
//! *Guarantees*: only appends to the module; the author's functions, types, globals, constants, overrides and other entry
//! points stay what and where they were.

pub mod bindings;
pub mod copies;
pub mod prologue;
pub mod recompute;
pub mod regions;
pub mod settled;
pub mod specialise;

use naga::{Function, Handle, Module, valid::ModuleInfo};

use crate::{
    analysis::{FunctionRef, InstanceId, walk::Found},
    finding::Finding,
    ir::import::Imports,
    options::{MaxRate, Options},
    plan::{CopyPlan, EntryPlan},
};
use copies::Copies;
use prologue::{Asked, EveryPixel, Prologue};
use settled::Settled;
use specialise::Specialise;

/// What was made for an entry point.
pub struct Applied {
    /// The clones, and what each was made from.
    pub clones: Vec<(FunctionRef, Handle<Function>)>,
    /// The entry point's conditions that are literals now.
    pub settled: Vec<Settled>,
    /// The entry point as an ordinary function, if it was split: it has the author's statements twice, or not at all.
    pub split: Option<Handle<Function>>,
}

/// Rewrites one entry point of `module`, a copy of `original` that may already hold other rewritten entry points. Gives the
/// clones that were made, and what each was made from.
///
/// # Errors
/// If what is added to a shader with barriers does not fit into workgroup memory.
pub fn apply(
    module: &mut Module,
    original: &Module,
    info: &ModuleInfo,
    entry: usize,
    plan: &mut EntryPlan,
    imports: &mut Imports,
    options: &Options,
) -> Result<Applied, Vec<Finding>> {
    if plan.group.is_some() {
        return apply_to_group(module, original, info, entry, plan, imports, options);
    }
    let found = &mut plan.found;
    let settled = settled::settled(
        &original.entry_points[entry].function,
        &found.instances[InstanceId::ENTRY.0 as usize].values,
        &plan.domain,
        &mut found.terms,
    );
    let domain = Asked {
        formulas: &plan.domain,
        stands_for_guards: !settled.is_empty(),
    };
    let prologue = prologue::import(
        module,
        imports,
        options,
        &mut found.terms,
        found.group_size,
        entry,
        domain,
    );
    let (inner, clones) = insert_copies(
        module,
        original,
        info,
        entry,
        found,
        &plan.copies,
        &settled,
        &prologue,
        options.max_rate,
    );
    let every = plan
        .full
        .map(|function| EveryPixel::import(module, imports, options, function));
    let function = prologue::entry_function(
        module,
        &found.terms,
        found.group_size,
        entry,
        &prologue,
        every,
        inner,
    );
    let rewritten = &mut module.entry_points[entry];
    rewritten.function = function;
    rewritten.workgroup_size = crate::manifest::workgroup_size(options);
    rewritten.workgroup_size_overrides = None;
    Ok(Applied {
        clones,
        settled,
        split: None,
    })
}

/// Makes the entry point an ordinary function that copies what it stores, its helpers with it. Gives the function, and the clones
/// with what each was made from.
#[allow(
    clippy::too_many_arguments,
    reason = "all that both ways to rewrite share"
)]
fn insert_copies(
    module: &mut Module,
    original: &Module,
    info: &ModuleInfo,
    entry: usize,
    found: &mut Found,
    plans: &[CopyPlan],
    settled: &[Settled],
    prologue: &Prologue,
    max_rate: MaxRate,
) -> (Handle<Function>, Vec<(FunctionRef, Handle<Function>)>) {
    let mut copies = Copies::new(
        &mut found.terms,
        found.group_size,
        entry,
        prologue,
        max_rate,
    );
    let specialise = Specialise::new(
        original,
        info,
        entry,
        &found.instances,
        &found.accesses,
        plans,
        settled,
    );
    specialise.run(module, &mut copies)
}

/// Rewrites an entry point whose invocations work together: the workgroup stays as it is, and the tile is the workgroup.
fn apply_to_group(
    module: &mut Module,
    original: &Module,
    info: &ModuleInfo,
    entry: usize,
    plan: &mut EntryPlan,
    imports: &mut Imports,
    options: &Options,
) -> Result<Applied, Vec<Finding>> {
    let Some(group) = &mut plan.group else {
        unreachable!("only entry points whose invocations work together come here");
    };
    let found = &mut plan.found;
    let tile = match group.size {
        [Some(width), Some(height), _] => [width, height],
        _ => [regions::LARGEST_GROUP, 1],
    };
    let options = Options {
        tile,
        ..options.clone()
    };
    let wanted = regions::entry::Wanted {
        options: &options,
        group_size: found.group_size,
        entry,
        domain: &plan.domain,
        is_masked: group.is_masked,
    };
    let (prologue, prelude) = regions::entry::import(module, imports, &mut found.terms, &wanted);
    let (inner, clones) = insert_copies(
        module,
        original,
        info,
        entry,
        found,
        &plan.copies,
        // invocations outside the domain stay for the others
        &[],
        &prologue,
        options.max_rate,
    );
    regions::split(
        module,
        entry,
        inner,
        &prelude,
        tile[0] * tile[1],
        options.barriers,
    )?;
    let function = regions::entry::entry_function(
        module,
        &found.terms,
        found.group_size,
        entry,
        &prologue,
        &prelude,
        inner,
    );
    let name = &original.entry_points[entry].name;
    let author = original.global_variables.len();
    let memory = regions::check_memory(module, &function, name, author, &options)
        .map_err(|finding| vec![finding])?;
    group.report.author_memory = memory.author;
    group.report.added_memory = memory.added;
    module.entry_points[entry].function = function;
    Ok(Applied {
        clones: clones
            .into_iter()
            .filter(|&(_, clone)| clone != inner)
            .collect(),
        settled: Vec::new(),
        split: Some(inner),
    })
}
