//! Reads shaders: text to a validated module, or one clear message.

use naga::{
    Module,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use crate::source::Source;

/// A shader that is not valid. The message is naga's own, with the lines that it is about.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{rendered}")]
pub struct Invalid {
    /// The message.
    pub rendered: String,
}

/// Parses and validates WGSL.
///
/// All of naga's capabilities are allowed: what a device lacks is the device's to say.
///
/// # Errors
/// If it is not valid WGSL.
pub fn wgsl(source: &Source) -> Result<(Module, ModuleInfo), Invalid> {
    let text = source.text();
    let path = source.names().next().unwrap_or("wgsl").to_owned();
    let module = naga::front::wgsl::parse_str(text).map_err(|error| Invalid {
        rendered: error.emit_to_string_with_path(text, path.as_str()),
    })?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|error| Invalid {
            rendered: error.emit_to_string_with_path(text, &path),
        })?;
    Ok((module, info))
}
