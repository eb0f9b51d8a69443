//! Compares a module with a fresh parse of its WGSL text.
//!
//! *Guarantees*, if it passes: the same structs, with the same offsets and spans; the same resources at the same bindings,
//! in the same address spaces, of the same types; the same entry points, stages, workgroup sizes and overrides; the
//! same overrides, by number and name; the same number of functions; `enable subgroups;` where it is needed; and text that
//! validates.

use naga::{
    AddressSpace, ArraySize, EntryPoint, Expression, Handle, Module, Override, Type, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};

use super::{EmitError, lengths::is_declared, repair::written_structs};

/// Compares.
///
/// # Errors
/// The first difference.
pub fn audit(module: &Module, text: &str) -> Result<(), EmitError> {
    // directives that naga's front end does not know, and does not need
    let parsed = crate::input::directives::blank(text);
    let written = naga::front::wgsl::parse_str(&parsed).map_err(|error| {
        different(format!(
            "it does not parse: {}",
            error.emit_to_string(&parsed)
        ))
    })?;
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&written)
        .map_err(|error| {
            different(format!(
                "it does not validate: {}",
                error.emit_to_string(&parsed)
            ))
        })?;
    let audit = Audit {
        module,
        written: &written,
    };
    // naga's front end does not ask for this one, and browsers do
    let enables = crate::input::Directives::of(text).enables;
    check(
        !super::repair::uses_subgroups(module) || enables.iter().any(|name| name == "subgroups"),
        || "`enable subgroups;` is missing".to_owned(),
    )?;
    audit.structs()?;
    audit.globals()?;
    audit.overrides()?;
    audit.entries()?;
    if module.functions.len() != written.functions.len() {
        return Err(different("it has another number of functions".to_owned()));
    }
    Ok(())
}

struct Audit<'a> {
    module: &'a Module,
    written: &'a Module,
}

fn different(what: String) -> EmitError {
    EmitError::Audit(what)
}

fn check(same: bool, what: impl FnOnce() -> String) -> Result<(), EmitError> {
    match same {
        true => Ok(()),
        false => Err(different(what())),
    }
}

fn name(name: &Option<String>) -> &str {
    name.as_deref().unwrap_or("an unnamed item")
}

impl Audit<'_> {
    fn structs(&self) -> Result<(), EmitError> {
        let before = written_structs(self.module);
        let after = written_structs(self.written);
        check(before.len() == after.len(), || {
            "it has another number of structs".to_owned()
        })?;
        // what a ray query answers lies in no buffer, so nobody sees how it is laid out, and WGSL has no text for how naga does it
        let special = &self.module.special_types;
        let of_rays = [
            special.ray_desc,
            special.ray_intersection,
            special.ray_vertex_return,
        ];
        let laid_out = before
            .into_iter()
            .zip(after)
            .filter(|&(before, _)| !of_rays.contains(&Some(before)));
        for (before, after) in laid_out {
            check(self.same_type(before, after), || {
                format!(
                    "the layout of {} changes",
                    name(&self.module.types[before].name)
                )
            })?;
        }
        Ok(())
    }

    /// Whether two types have the same form, name apart, down to the offsets.
    fn same_type(&self, before: Handle<Type>, after: Handle<Type>) -> bool {
        let (before, after) = (
            &self.module.types[before].inner,
            &self.written.types[after].inner,
        );
        match (before, after) {
            (
                TypeInner::Struct {
                    members: a,
                    span: span_a,
                },
                TypeInner::Struct {
                    members: b,
                    span: span_b,
                },
            ) => {
                span_a == span_b
                    && a.len() == b.len()
                    && a.iter().zip(b).all(|(a, b)| {
                        a.offset == b.offset && a.binding == b.binding && self.same_type(a.ty, b.ty)
                    })
            }
            (
                TypeInner::Array {
                    base: a,
                    size: size_a,
                    stride: stride_a,
                },
                TypeInner::Array {
                    base: b,
                    size: size_b,
                    stride: stride_b,
                },
            ) => stride_a == stride_b && self.same_size(*size_a, *size_b) && self.same_type(*a, *b),
            (
                TypeInner::BindingArray {
                    base: a,
                    size: size_a,
                },
                TypeInner::BindingArray {
                    base: b,
                    size: size_b,
                },
            ) => self.same_size(*size_a, *size_b) && self.same_type(*a, *b),
            (
                TypeInner::Pointer {
                    base: a,
                    space: space_a,
                },
                TypeInner::Pointer {
                    base: b,
                    space: space_b,
                },
            ) => space_a == space_b && self.same_type(*a, *b),
            (a, b) => a == b,
        }
    }

    fn globals(&self) -> Result<(), EmitError> {
        let (before, after) = (
            &self.module.global_variables,
            &self.written.global_variables,
        );
        check(before.len() == after.len(), || {
            "it has another number of variables".to_owned()
        })?;
        for ((_, before), (_, after)) in before.iter().zip(after.iter()) {
            check(
                before.binding == after.binding
                    && same_space(before.space, after.space)
                    && before.init.is_some() == after.init.is_some()
                    && self.same_type(before.ty, after.ty),
                || format!("the declaration of {} changes", name(&before.name)),
            )?;
        }
        Ok(())
    }

    fn overrides(&self) -> Result<(), EmitError> {
        let (before, after) = (declared(self.module), declared(self.written));
        check(before.len() == after.len(), || {
            "it has another number of overrides".to_owned()
        })?;
        for ((_, before), (_, after)) in before.into_iter().zip(after) {
            // an override with a number is set by it, one without by its name
            check(
                before.id == after.id
                    && (before.id.is_some() || before.name == after.name)
                    && before.init.is_some() == after.init.is_some()
                    && self.same_type(before.ty, after.ty),
                || format!("the override {} changes", name(&before.name)),
            )?;
        }
        Ok(())
    }

    /// Whether two overrides are the same one: by their numbers among those that are declared, or, of those that stand for a computed
    /// length, by what it is computed from.
    fn same_override(&self, before: Handle<Override>, after: Handle<Override>) -> bool {
        let (a, b) = (
            &self.module.overrides[before],
            &self.written.overrides[after],
        );
        if let (false, false) = (is_declared(a), is_declared(b)) {
            return matches!((a.init, b.init), (Some(a), Some(b)) if self.same_expression(a, b));
        }
        let place = |module, handle| declared(module).iter().position(|(h, _)| *h == handle);
        let (a, b) = (place(self.module, before), place(self.written, after));
        a.is_some() && a == b
    }

    fn same_size(&self, before: ArraySize, after: ArraySize) -> bool {
        match (before, after) {
            (ArraySize::Pending(a), ArraySize::Pending(b)) => self.same_override(a, b),
            (a, b) => a == b,
        }
    }

    fn entries(&self) -> Result<(), EmitError> {
        let (before, after) = (&self.module.entry_points, &self.written.entry_points);
        check(before.len() == after.len(), || {
            "it has another number of entry points".to_owned()
        })?;
        for (before, after) in before.iter().zip(after) {
            if after.name.strip_suffix('_') == Some(&before.name) {
                return Err(EmitError::Name(before.name.clone()));
            }
            check(
                before.name == after.name
                    && before.stage == after.stage
                    && self.same_workgroup_size(before, after)
                    && before.function.arguments.len() == after.function.arguments.len()
                    && before
                        .function
                        .arguments
                        .iter()
                        .zip(&after.function.arguments)
                        .all(|(a, b)| a.binding == b.binding && self.same_type(a.ty, b.ty))
                    && self.same_result(before, after),
                || format!("the interface of entry point {} changes", before.name),
            )?;
        }
        Ok(())
    }

    fn same_result(&self, before: &EntryPoint, after: &EntryPoint) -> bool {
        match (&before.function.result, &after.function.result) {
            (None, None) => true,
            (Some(a), Some(b)) => a.binding == b.binding && self.same_type(a.ty, b.ty),
            _ => false,
        }
    }

    fn same_workgroup_size(&self, before: &EntryPoint, after: &EntryPoint) -> bool {
        let sizes = |entry: &EntryPoint| entry.workgroup_size_overrides.unwrap_or_default();
        let (overridden, written) = (sizes(before), sizes(after));
        (0..3).all(|axis| match (overridden[axis], written[axis]) {
            (None, None) => before.workgroup_size[axis] == after.workgroup_size[axis],
            (Some(a), Some(b)) => self.same_expression(a, b),
            _ => false,
        })
    }

    fn same_expression(&self, before: Handle<Expression>, after: Handle<Expression>) -> bool {
        let (before, after) = (
            &self.module.global_expressions[before],
            &self.written.global_expressions[after],
        );
        let operands = |expression: &Expression| {
            let mut operands = Vec::new();
            crate::ir::visit::operands(expression, &mut |&operand| operands.push(operand));
            operands
        };
        let (a, b) = (operands(before), operands(after));
        let same_leaf = match (before, after) {
            (Expression::Literal(a), Expression::Literal(b)) => a == b,
            (Expression::Override(a), Expression::Override(b)) => self.same_override(*a, *b),
            (Expression::Binary { op: a, .. }, Expression::Binary { op: b, .. }) => a == b,
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        };
        same_leaf
            && a.len() == b.len()
            && a.into_iter()
                .zip(b)
                .all(|(a, b)| self.same_expression(a, b))
    }
}

/// The overrides that the text declares.
fn declared(module: &Module) -> Vec<(Handle<Override>, &Override)> {
    let overrides = module.overrides.iter();
    overrides.filter(|(_, item)| is_declared(item)).collect()
}

fn same_space(before: AddressSpace, after: AddressSpace) -> bool {
    before == after
}
