//! Chooses where the added resources are bound.
//!
//! *Does*: takes the lowest bind group that nothing in the module uses.
//! *Guarantees*: no group of the author's is touched, for that would change its layout; no entry point of the module
//! uses the chosen one.
//! *Refuses*: a module that uses all groups that the device has.

use naga::{Module, ResourceBinding};

use crate::{
    finding::{Code, Finding},
    options::Options,
};

/// Where the added resources are bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// The parameters, a uniform buffer.
    pub params: ResourceBinding,
    /// The coordinate buffer, a read-only storage buffer.
    pub coords: ResourceBinding,
}

/// Chooses a placement.
///
/// # Errors
/// If no group is free.
pub fn place(module: &Module, options: &Options) -> Result<Placement, Finding> {
    let used = |group| {
        module
            .global_variables
            .iter()
            .any(|(_, global)| global.binding.is_some_and(|b| b.group == group))
    };
    let groups = options.max_bind_groups;
    match (0..groups).find(|&group| !used(group)) {
        Some(group) => Ok(Placement {
            params: ResourceBinding { group, binding: 0 },
            coords: ResourceBinding { group, binding: 1 },
        }),
        None => Err(Finding::new(
            Code::NoFreeGroup,
            format!("the shader uses all {groups} bind groups; one has to be free for the parameters and the coordinate buffer"),
        )
        .help("move the bindings of two groups into one")),
    }
}
