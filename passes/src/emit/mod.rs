//! A module as text or SPIR-V that means the same as the module.
//!
//! [`write()`] writes any language. The rest of this page is about WGSL; the others are naga's own work, with a map of their
//! bindings.
//!
//! naga's WGSL writer leaves things out without a word: `@size` and `@align`, workgroup sizes that overrides decide,
//! `enable subgroups;`. It puts an underscore behind names that end in a digit, overrides included, which the host
//! sets by name. It leaves out of what an array is whose length an override decides. And it panics on ray queries and on initialisers that are computed from overrides.
//!
//! *Does*: writes the text, puts back what was left out, then [compares](audit) a fresh parse of it with the
//! module.
//! *Guarantees*: text that parses, with the same structs byte for byte, the same bindings, entry points, workgroup sizes
//! and overrides.
//! *Refuses*: what WGSL text cannot say; SPIR-V or the module itself can still be used.

pub mod audit;
pub(crate) mod constant;
mod lengths;
#[cfg(any(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl"))]
mod native;
#[cfg(not(any(feature = "spirv", feature = "hlsl", feature = "msl", feature = "glsl")))]
#[path = "no_native.rs"]
mod native;
mod repair;
mod shallow;
mod target;

use naga::{Expression, Module, Statement, valid::ModuleInfo};

use crate::{deep, input::Directives, ir::visit, manifest::Output};

pub use target::{Form, Language, Target, Written};

/// Why a module cannot be written.
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
    /// An entry point has the name of a built-in function that the shader calls.
    #[error(
        "the entry point `{0}` cannot keep its name in WGSL text, which calls the built-in function `{0}`: give it another name, or write SPIR-V"
    )]
    Name(String),
    /// There is no such entry point.
    #[error("no entry point is called `{0}`")]
    NoEntry(String),
    /// The language holds one entry point, and several could be written.
    #[error("GLSL holds one entry point; choose one of {}", .0.join(", "))]
    OneEntry(Vec<String>),
    /// An override has no value, or there is none of a name.
    #[error("the shader's overrides: {0}")]
    Constants(String),
    /// naga's back end for a language cannot write the module.
    #[error("{} cannot be written for this shader: {why}", .language.name())]
    BackEnd {
        /// The language.
        language: Language,
        /// What it says.
        why: String,
    },
}

/// Writes a module in any language.
///
/// `directives` are what the author's WGSL text said; only WGSL has them.
///
/// # Errors
/// If the language cannot say what the module says.
pub fn write(
    module: &Module,
    info: &ModuleInfo,
    target: Target,
    form: &Form,
    directives: &Directives,
) -> Result<Written, EmitError> {
    match target.language() {
        Language::Wgsl => {
            wgsl_with(module, info, directives).map(|text| Written::text(text, Output::wgsl()))
        }
        _ => native::write(module, info, target, form),
    }
}

/// Writes a module as SPIR-V 1.3: words in little-endian order, and the map of its bindings.
///
/// ```
/// # let source = vrcs_passes::Source::new("a.wgsl", "@compute @workgroup_size(8, 8) fn main() {}");
/// let (module, info) = vrcs_passes::input::wgsl(&source)?;
/// # if cfg!(feature = "spirv") {
/// let written = vrcs_passes::emit::spirv(&module, &info, &vrcs_passes::emit::Form::default())?;
/// assert_eq!(&written.bytes[..4], &0x0723_0203u32.to_le_bytes());
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If SPIR-V cannot say what the module says.
pub fn spirv(module: &Module, info: &ModuleInfo, form: &Form) -> Result<Written, EmitError> {
    native::write(module, info, Language::SpirV.into(), form)
}

/// Writes a module as HLSL for shader model 6.0. Registers are the bindings' numbers, spaces their groups.
///
/// # Errors
/// If HLSL cannot say what the module says.
pub fn hlsl(module: &Module, info: &ModuleInfo, form: &Form) -> Result<Written, EmitError> {
    native::write(module, info, Language::Hlsl.into(), form)
}

/// Writes a module as Metal Shading Language 2.4. Buffers, textures and samplers are numbered from 0 in the order of their
/// declaration.
///
/// # Errors
/// If MSL cannot say what the module says.
pub fn msl(module: &Module, info: &ModuleInfo, form: &Form) -> Result<Written, EmitError> {
    native::write(module, info, Language::Msl.into(), form)
}

/// Writes an entry point as GLSL 4.50. Uniform buffers, storage buffers, images and textures are numbered from 0, each kind for
/// itself.
///
/// # Errors
/// If GLSL cannot say what the entry point says, or if it is not told which of several is wanted.
pub fn glsl(module: &Module, info: &ModuleInfo, form: &Form) -> Result<Written, EmitError> {
    native::write(module, info, Language::Glsl.into(), form)
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
        let (writable, lengths) = lengths::numbered(writable);
        let writable = shallow::shallow(writable);
        let flags = naga::back::wgsl::WriterFlags::empty();
        let text = naga::back::wgsl::write_string(&writable, info, flags)
            .map_err(|error| EmitError::Writer(error.to_string()))?;
        let text = repair::repair(text, module, &left_out, &lengths)?;
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
