//! The workgroup size of an entry point, where `override` constants decide it.
//!
//! *Refuses*: a size that divides by zero whatever the overrides are. naga finds that out only when a pipeline is made; a rewritten
//! shader may have a size of its own, and would then be a pipeline where the author's is none.

use naga::{
    BinaryOperator, Expression, Handle, Literal, Module, back::PipelineConstants,
    back::pipeline_constants::process_overrides, valid::ModuleInfo,
};

use crate::finding::{Code, Finding};

/// The workgroup size of an entry point if no override is set; ones where overrides have no value of their own.
pub(crate) fn by_default(module: &Module, info: &ModuleInfo, index: usize) -> [u32; 3] {
    let entry = &module.entry_points[index];
    if entry.workgroup_size_overrides.is_none() {
        return entry.workgroup_size;
    }
    let which = Some((entry.stage, entry.name.as_str()));
    match process_overrides(module, info, which, &PipelineConstants::default()) {
        Ok((module, _)) => module.entry_points[0].workgroup_size,
        Err(_) => [1; 3],
    }
}

/// Whether there are values of the overrides for which the workgroup size of an entry point is one.
pub(crate) fn check(module: &Module, index: usize) -> Result<(), Finding> {
    let entry = &module.entry_points[index];
    let sizes = entry.workgroup_size_overrides.unwrap_or_default();
    for size in sizes.into_iter().flatten() {
        let Some(zero) = division_by_zero(module, size) else {
            continue;
        };
        let span = module.global_expressions.get_span(zero);
        let what = format!(
            "the workgroup size of `{}` divides by zero, whatever its overrides are",
            entry.name
        );
        return Err(Finding::new(Code::NoWorkgroupSize, what)
            .at(span, "divides by zero")
            .help("no pipeline can be made of such an entry point; divide by something else"));
    }
    Ok(())
}

/// The division by a zero in a global expression.
fn division_by_zero(module: &Module, handle: Handle<Expression>) -> Option<Handle<Expression>> {
    match module.global_expressions[handle] {
        Expression::Binary { op, left, right } => {
            let divides = matches!(op, BinaryOperator::Divide | BinaryOperator::Modulo);
            if divides && is_zero(module, right) {
                return Some(handle);
            }
            division_by_zero(module, left).or_else(|| division_by_zero(module, right))
        }
        Expression::Unary { expr, .. } | Expression::As { expr, .. } => {
            division_by_zero(module, expr)
        }
        Expression::Select {
            condition,
            accept,
            reject,
        } => [condition, accept, reject]
            .into_iter()
            .find_map(|operand| division_by_zero(module, operand)),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => [Some(arg), arg1, arg2, arg3]
            .into_iter()
            .flatten()
            .find_map(|operand| division_by_zero(module, operand)),
        _ => None,
    }
}

fn is_zero(module: &Module, handle: Handle<Expression>) -> bool {
    match module.global_expressions[handle] {
        Expression::Literal(Literal::U32(0) | Literal::I32(0)) | Expression::ZeroValue(_) => true,
        Expression::Constant(constant) => is_zero(module, module.constants[constant].init),
        _ => false,
    }
}
