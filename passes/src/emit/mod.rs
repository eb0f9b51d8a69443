//! A module as WGSL text that means the same as the module.
//!
//! naga's WGSL writer leaves things out without a word: `@size` and `@align`, workgroup sizes that overrides decide,
//! `enable subgroups;`. It puts an underscore behind names that end in a digit, overrides included, which the host
//! sets by name. And it panics on ray queries and on initialisers that are computed from overrides.
//!
//! *Does*: writes the text, puts back what was left out, then [compares](audit) a fresh parse of it with the
//! module.
//! *Guarantees*: text that parses, with the same structs byte for byte, the same bindings, entry points, workgroup sizes
//! and overrides.
//! *Refuses*: what WGSL text cannot say; SPIR-V or the module itself can still be used.

pub mod audit;
mod constant;
mod repair;
mod shallow;

use naga::{Expression, Module, Statement, valid::ModuleInfo};

use crate::{deep, input::Directives, ir::visit};

/// Why a module cannot be written as WGSL.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EmitError {
    /// naga's writer has no text for this.
    #[error("WGSL text cannot be written for {0}; write SPIR-V, or hand over the module itself")]
    NoText(String),
    /// naga's writer failed.
    #[error("the WGSL writer failed: {0}")]
    Writer(String),
    /// The text does not say what the module says.
    #[error("the WGSL text would not mean the same as the module: {0}")]
    Audit(String),
}

/// Writes a module as WGSL.
///
/// # Errors
/// If there is no text that means the same.
pub fn wgsl(module: &Module, info: &ModuleInfo) -> Result<String, EmitError> {
    wgsl_with(module, info, &Directives::default())
}

/// Writes a module as WGSL, with the [directives](Directives) that its author wrote.
///
/// # Errors
/// If there is no text that means the same.
pub fn wgsl_with(
    module: &Module,
    info: &ModuleInfo,
    directives: &Directives,
) -> Result<String, EmitError> {
    deep::run_if_deep(deep::of_module(module), || {
        refuse_what_panics(module)?;
        let (writable, left_out) = constant::without_computed_initialisers(module);
        let writable = shallow::shallow(writable);
        let flags = naga::back::wgsl::WriterFlags::empty();
        let text = naga::back::wgsl::write_string(&writable, info, flags)
            .map_err(|error| EmitError::Writer(error.to_string()))?;
        let text = repair::repair(text, module, &left_out)?;
        let text = repair::put_directives(text, directives);
        audit::audit(module, &text)?;
        Ok(text)
    })
}

fn refuse_what_panics(module: &Module) -> Result<(), EmitError> {
    let functions = module
        .functions
        .iter()
        .map(|(_, function)| function)
        .chain(module.entry_points.iter().map(|entry| &entry.function));
    for function in functions {
        let mut ray_query = function.expressions.iter().any(|(_, expression)| {
            matches!(
                expression,
                Expression::RayQueryGetIntersection { .. }
                    | Expression::RayQueryVertexPositions { .. }
            )
        });
        visit::statements(&function.body, &mut |statement| {
            ray_query |= matches!(statement, Statement::RayQuery { .. });
        });
        if ray_query {
            let name = function.name.as_deref().unwrap_or("an entry point");
            return Err(EmitError::NoText(format!("the ray queries in {name}")));
        }
    }
    Ok(())
}
