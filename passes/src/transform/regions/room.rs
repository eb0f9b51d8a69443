//! Workgroup memory: what the author takes, what exchanges take, and whether there is room for both.

use std::collections::BTreeSet;

use naga::{
    AddressSpace, ArraySize, Expression, Function, GlobalVariable, Handle, Module, Statement, Type,
    TypeInner, proc::Layouter,
};

use crate::{
    finding::{Code, Finding},
    ir::{build, visit},
    options::Options,
};

/// Bytes of workgroup memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// The author's variables.
    pub author: u32,
    /// What the rewriter adds.
    pub added: u32,
}

/// The type of a workgroup array with a place for each invocation.
pub(super) fn array(module: &mut Module, base: Handle<Type>, area: u32) -> Handle<Type> {
    let mut layouter = Layouter::default();
    let stride = match layouter.update(module.to_ctx()) {
        Ok(()) => layouter[base].to_stride(),
        Err(error) => unreachable!("the module was valid: {error}"),
    };
    let size = match std::num::NonZeroU32::new(area) {
        Some(area) => ArraySize::Constant(area),
        None => unreachable!("a workgroup has invocations"),
    };
    build::intern(&mut module.types, TypeInner::Array { base, size, stride })
}

/// Counts the workgroup memory of an entry point, whose variables from `author` on are ours.
///
/// # Errors
/// If it needs more than the device has.
pub fn check(
    module: &Module,
    function: &Function,
    name: &str,
    author: usize,
    options: &Options,
) -> Result<Memory, Finding> {
    let mut used = BTreeSet::new();
    collect(module, function, &mut used, &mut BTreeSet::new());
    let mut layouter = Layouter::default();
    if let Err(error) = layouter.update(module.to_ctx()) {
        unreachable!("the module was valid: {error}");
    }
    let mut memory = Memory::default();
    let mut parts = Vec::new();
    for global in used {
        let variable = &module.global_variables[global];
        let bytes = layouter[variable.ty].size.next_multiple_of(16);
        let is_added = global.index() >= author;
        match is_added {
            true => memory.added += bytes,
            false => memory.author += bytes,
        }
        let name = variable.name.as_deref().unwrap_or("a variable");
        parts.push((
            format!("`{name}` {bytes}"),
            is_added,
            module.global_variables.get_span(global),
        ));
    }
    let limit = options.max_workgroup_memory;
    if memory.author + memory.added <= limit {
        return Ok(memory);
    }
    let listed: Vec<&str> = parts.iter().map(|(part, ..)| part.as_str()).collect();
    let mut finding = Finding::new(
        Code::OverLimit,
        format!(
            "`{name}` needs {} bytes of workgroup memory, and the device has {limit}: {} of the author's and {} for exchanges ({})",
            memory.author + memory.added,
            memory.author,
            memory.added,
            listed.join(", "),
        ),
    );
    for (part, is_added, span) in &parts {
        if !is_added {
            finding = finding.at(*span, format!("{part} bytes"));
        }
    }
    Err(finding.help(
        "make what is exchanged smaller, or compute it from the ids, or raise `max_workgroup_memory` to what the device has",
    ))
}

/// The workgroup variables that a function reaches.
fn collect(
    module: &Module,
    function: &Function,
    used: &mut BTreeSet<Handle<GlobalVariable>>,
    seen: &mut BTreeSet<Handle<Function>>,
) {
    for (_, expression) in function.expressions.iter() {
        if let Expression::GlobalVariable(global) = *expression
            && module.global_variables[global].space == AddressSpace::WorkGroup
        {
            used.insert(global);
        }
    }
    visit::statements(&function.body, &mut |statement| {
        if let Statement::Call { function, .. } = *statement
            && seen.insert(function)
        {
            collect(module, &module.functions[function], used, seen);
        }
    });
}
