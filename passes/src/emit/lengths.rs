//! Arrays whose length an override decides: `var<workgroup> row: array<f32, WIDTH * HEIGHT>`.
//!
//! naga's writer leaves their base type out, and gives a name to an override that its front end made up for a computed
//! length. *Does*: has the writer write a number instead, which is no other array's length, and puts the author's
//! expression in its place. Overrides without a name or number, which nobody can set, are not declared.

use std::{borrow::Cow, collections::HashSet, num::NonZeroU32};

use naga::{ArraySize, Handle, Module, Override, Type, TypeInner};

use super::{EmitError, constant};

/// A number that stands for a length.
pub(super) struct Length {
    number: NonZeroU32,
    of: Handle<Override>,
}

/// The module with numbers in place of lengths that overrides decide, and what they stand for.
pub(super) fn numbered(module: Cow<Module>) -> (Cow<Module>, Vec<Length>) {
    let mut taken = HashSet::new();
    let mut pending = Vec::new();
    for (handle, ty) in module.types.iter() {
        match ty.inner {
            TypeInner::Array {
                size: ArraySize::Constant(length),
                ..
            } => {
                taken.insert(length);
            }
            TypeInner::Array {
                size: ArraySize::Pending(of),
                ..
            } => pending.push((handle, of)),
            _ => {}
        }
    }
    if pending.is_empty() {
        return (module, Vec::new());
    }
    let mut module = module.into_owned();
    let mut free = (0..u32::MAX / 2)
        .rev()
        .filter_map(NonZeroU32::new)
        .filter(|number| !taken.contains(number));
    let lengths = pending
        .into_iter()
        .zip(&mut free)
        .map(|((handle, of), number)| {
            let mut ty: Type = module.types[handle].clone();
            if let TypeInner::Array { size, .. } = &mut ty.inner {
                *size = ArraySize::Constant(number);
            }
            module.types.replace(handle, ty);
            Length { number, of }
        })
        .collect();
    (Cow::Owned(module), lengths)
}

/// Whether the author can have written an override, or it was made up for a length.
pub(super) fn is_declared(item: &Override) -> bool {
    item.name.is_some() || item.id.is_some() || item.init.is_none()
}

/// Puts the lengths into a line. `override_name` gives the names that the text uses.
pub(super) fn put(
    line: &mut String,
    lengths: &[Length],
    module: &Module,
    override_name: &dyn Fn(usize) -> String,
) -> Result<(), EmitError> {
    for length in lengths {
        let written = format!(", {}>", length.number);
        if !line.contains(&written) {
            continue;
        }
        let item = &module.overrides[length.of];
        let text = match item.init {
            Some(init) if !is_declared(item) => constant::text(module, init, override_name)?,
            _ => override_name(length.of.index()),
        };
        *line = line.replace(&written, &format!(", {text}>"));
    }
    Ok(())
}
