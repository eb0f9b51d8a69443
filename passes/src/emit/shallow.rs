//! Expressions that nest so deep that no front end would read them back get names on the way.
//!
//! naga's writer puts a sum of three hundred terms into three hundred pairs of parentheses; its own parser stops at 200,
//! Tint at 512.

use std::borrow::Cow;

use naga::{Expression, Function, Module};

use crate::ir::visit;

/// How deep an expression may nest.
const MOST: usize = 48;

/// The module with names for what nests too deep.
pub(super) fn shallow(module: Cow<'_, Module>) -> Cow<'_, Module> {
    let is_deep = |function: &Function| !to_name(function).is_empty();
    let any = module.functions.iter().any(|(_, f)| is_deep(f))
        || module.entry_points.iter().any(|e| is_deep(&e.function));
    if !any {
        return module;
    }
    let mut module = module.into_owned();
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entries = module.entry_points.iter_mut().map(|e| &mut e.function);
    for function in functions.chain(entries) {
        for handle in to_name(function) {
            function.named_expressions.insert(handle, "part".to_owned());
        }
    }
    Cow::Owned(module)
}

/// The expressions to name, so that none between two names nests deeper than [`MOST`].
fn to_name(function: &Function) -> Vec<naga::Handle<Expression>> {
    let mut depths: Vec<usize> = Vec::new();
    let mut found = Vec::new();
    for (handle, expression) in function.expressions.iter() {
        let mut depth = 0;
        visit::operands(expression, &mut |operand| {
            depth = depth.max(depths[operand.index()] + 1);
        });
        // places in memory have no name of their own
        let can_be_named = matches!(
            expression,
            Expression::Binary { .. }
                | Expression::Unary { .. }
                | Expression::Math { .. }
                | Expression::Select { .. }
                | Expression::As { .. }
                | Expression::Compose { .. }
                | Expression::Splat { .. }
                | Expression::Load { .. }
        );
        if function.named_expressions.contains_key(&handle) {
            depth = 0;
        } else if depth >= MOST && can_be_named {
            found.push(handle);
            depth = 0;
        }
        depths.push(depth);
    }
    found
}
