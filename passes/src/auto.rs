//! Chooses the mode for a shader.
//!
//! *Does*: looks at what the shader takes from its workgroup. *Guarantees*: every mode that is chosen gives the same picture; the
//! choice is one of speed, and is told with its reason.

use naga::{AddressSpace, BuiltIn, Module, ShaderStage, valid::ModuleInfo};

use crate::{Entries, options::Mode};

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
        let uses = info.get_entry_point(index);
        let shares = module.global_variables.iter().any(|(handle, global)| {
            global.space == AddressSpace::WorkGroup && !uses[handle].is_empty()
        });
        if shares {
            return (
                Mode::Tiled,
                "the shader has workgroup memory, so a workgroup has to be a tile",
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
