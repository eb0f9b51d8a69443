//! In the place of the native back ends where the crate was built without any.

use naga::{Module, valid::ModuleInfo};

use super::{EmitError, Form, Target, Written};

/// Tells that the language was left out.
pub(super) fn write(
    _: &Module,
    _: &ModuleInfo,
    target: Target,
    _: &Form,
) -> Result<Written, EmitError> {
    Err(EmitError::BackEnd {
        language: target.language(),
        why: format!(
            "vrcs-passes was built without its feature `{}`",
            target.language()
        ),
    })
}
