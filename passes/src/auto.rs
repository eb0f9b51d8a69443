//! Chooses the mode for a shader.
//!
//! *Does*: looks at what the shader takes from its workgroup. *Guarantees*: every mode that is chosen gives the same picture; the
//! choice is one of speed, and is told with its reason.

use naga::{AddressSpace, BuiltIn, Function, Module, ShaderStage, Statement, valid::ModuleInfo};

use crate::{
    Entries,
    finding::{Code, Finding},
    ir::visit,
    options::Mode,
};

/// The mode for the entry points that are to be rewritten, and why.
pub fn mode(module: &Module, info: &ModuleInfo, entries: Entries) -> (Mode, &'static str) {
    let is_meant = |name: &str| match entries {
        Entries::Named(meant) => meant == name,
        Entries::PerPixel => true,
    };
    for (index, entry) in module.entry_points.iter().enumerate() {
        if entry.stage != ShaderStage::Compute || !is_meant(&entry.name) {
            continue;
        }
        if works_together(module, info, index) {
            return (
                Mode::Tiled,
                "the shader has barriers or workgroup memory, so a workgroup has to be a tile",
            );
        }
        if takes(module, &entry.function.arguments, BuiltIn::WorkGroupId) {
            return (
                Mode::Tiled,
                "the shader reads its workgroup's number, so its data are likely by tile, and the waves of a tile read them together",
            );
        }
    }
    (
        Mode::List,
        "nothing ties the shader to tiles, and a list has at most one partial wave",
    )
}

/// Whether the invocations of an entry point work together: it has workgroup memory or barriers.
pub fn works_together(module: &Module, info: &ModuleInfo, entry: usize) -> bool {
    let uses = info.get_entry_point(entry);
    let shares = module.global_variables.iter().any(|(handle, global)| {
        global.space == AddressSpace::WorkGroup && !uses[handle].is_empty()
    });
    shares || has_barrier(module, &module.entry_points[entry].function)
}

fn has_barrier(module: &Module, function: &Function) -> bool {
    let mut found = false;
    visit::statements(&function.body, &mut |statement| match *statement {
        Statement::ControlBarrier(_)
        | Statement::MemoryBarrier(_)
        | Statement::WorkGroupUniformLoad { .. } => found = true,
        Statement::Call { function, .. } if !found => {
            found = has_barrier(module, &module.functions[function]);
        }
        _ => {}
    });
    found
}

/// That an entry point whose invocations work together was to be rewritten for a mode in which they cannot.
pub(crate) fn needs_tiles(name: &str, mode: Mode) -> Finding {
    let mode = format!("{mode:?}").to_lowercase();
    Finding::new(
        Code::NeedsTiles,
        format!(
            "the invocations of `{name}` work together through barriers or workgroup memory, which mode `{mode}` does not keep"
        ),
    )
    .help("choose mode `tiled`, in which every workgroup is a tile; mode `auto` does so")
}

fn takes(module: &Module, arguments: &[naga::FunctionArgument], builtin: BuiltIn) -> bool {
    let is_it = |binding: &Option<naga::Binding>| *binding == Some(naga::Binding::BuiltIn(builtin));
    arguments
        .iter()
        .any(|argument| match &module.types[argument.ty].inner {
            naga::TypeInner::Struct { members, .. } => {
                members.iter().any(|member| is_it(&member.binding))
            }
            _ => is_it(&argument.binding),
        })
}
