//! The names of the author's resources, where others would take them.
//!
//! naga's writers name functions, with their arguments and variables, before what is global, and give no name twice: a resource `mask`
//! would be written as `mask_4` because an argument of the prelude is called so, and whoever binds by names would not find it.
//!
//! *Does*: gives arguments and variables of functions another name where a resource or an override has theirs. *Guarantees*: nothing but
//! such names changes.

use naga::{Function, Module};
use rustc_hash::FxHashSet;

/// Leaves the names of resources and overrides to them.
pub fn leave_to_resources(module: &mut Module) {
    let globals = module.global_variables.iter();
    let resources = globals.filter(|(_, global)| global.binding.is_some());
    let overrides = module.overrides.iter().map(|(_, of)| &of.name);
    let taken: FxHashSet<String> = resources
        .map(|(_, global)| &global.name)
        .chain(overrides)
        .flatten()
        .cloned()
        .collect();
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entries = module
        .entry_points
        .iter_mut()
        .map(|entry| &mut entry.function);
    functions
        .chain(entries)
        .for_each(|function| rename(function, &taken));
}

fn rename(function: &mut Function, taken: &FxHashSet<String>) {
    let locals = function.local_variables.iter_mut();
    let names = function
        .arguments
        .iter_mut()
        .map(|argument| &mut argument.name)
        .chain(locals.map(|(_, local)| &mut local.name));
    for name in names.flatten() {
        if taken.contains(name) {
            *name = format!("the_{name}");
        }
    }
}
