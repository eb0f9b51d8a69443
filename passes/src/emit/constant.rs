//! Text for global expressions: workgroup sizes and initialisers that are computed from overrides.

use naga::{BinaryOperator, Expression, Handle, Literal, Module, Scalar, TypeInner, UnaryOperator};

use super::EmitError;

/// An initialiser that naga's writer cannot write.
pub(super) struct LeftOut {
    /// What it initialises.
    pub(super) of: Initialised,
    /// The initialiser, in the module's global expressions.
    pub(super) init: Handle<Expression>,
}

/// What an initialiser belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Initialised {
    /// The override with this number.
    Override(usize),
    /// The global variable with this number.
    Global(usize),
}

/// The module without the initialisers on which naga's writer panics, and what they were.
pub(super) fn without_computed_initialisers(
    module: &Module,
) -> (std::borrow::Cow<'_, Module>, Vec<LeftOut>) {
    let mut left_out = Vec::new();
    for (handle, item) in module.overrides.iter() {
        if let Some(init) = item.init.filter(|&init| !is_writable(module, init)) {
            left_out.push(LeftOut {
                of: Initialised::Override(handle.index()),
                init,
            });
        }
    }
    for (handle, global) in module.global_variables.iter() {
        if let Some(init) = global.init.filter(|&init| !is_writable(module, init)) {
            left_out.push(LeftOut {
                of: Initialised::Global(handle.index()),
                init,
            });
        }
    }
    if left_out.is_empty() {
        return (std::borrow::Cow::Borrowed(module), left_out);
    }
    let mut writable = module.clone();
    for (handle, item) in writable.overrides.iter_mut() {
        if left_out
            .iter()
            .any(|l| l.of == Initialised::Override(handle.index()))
        {
            item.init = None;
        }
    }
    for (handle, global) in writable.global_variables.iter_mut() {
        if left_out
            .iter()
            .any(|l| l.of == Initialised::Global(handle.index()))
        {
            global.init = None;
        }
    }
    (std::borrow::Cow::Owned(writable), left_out)
}

/// Whether naga's writer has text for a global expression.
fn is_writable(module: &Module, handle: Handle<Expression>) -> bool {
    match module.global_expressions[handle] {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_) => true,
        Expression::Compose { ref components, .. } => components
            .iter()
            .all(|&component| is_writable(module, component)),
        Expression::Splat { value, .. } => is_writable(module, value),
        _ => false,
    }
}

/// The WGSL text of a global expression. `override_name` gives the names that the text uses.
pub(super) fn text(
    module: &Module,
    handle: Handle<Expression>,
    override_name: &dyn Fn(usize) -> String,
) -> Result<String, EmitError> {
    let inner = |handle| text(module, handle, override_name);
    let unsupported = || {
        Err(EmitError::NoText(
            "an initialiser that is computed from overrides".to_owned(),
        ))
    };
    Ok(match module.global_expressions[handle] {
        Expression::Literal(literal) => match literal {
            Literal::U32(v) => format!("{v}u"),
            Literal::I32(v) if v == i32::MIN => "i32(-2147483648)".to_owned(),
            Literal::I32(v) => format!("{v}i"),
            Literal::Bool(v) => v.to_string(),
            Literal::F32(v) if v.is_finite() => format!("{v:?}f"),
            Literal::AbstractInt(v) => v.to_string(),
            Literal::AbstractFloat(v) if v.is_finite() => format!("{v:?}"),
            _ => return unsupported(),
        },
        Expression::Override(handle) => override_name(handle.index()),
        Expression::Constant(constant) => inner(module.constants[constant].init)?,
        Expression::Unary { op, expr } => {
            format!("{}({})", unary(op), inner(expr)?)
        }
        Expression::Binary { op, left, right } => {
            format!("({} {} {})", inner(left)?, operator(op), inner(right)?)
        }
        Expression::Select {
            condition,
            accept,
            reject,
        } => format!(
            "select({}, {}, {})",
            inner(reject)?,
            inner(accept)?,
            inner(condition)?
        ),
        Expression::As {
            expr,
            kind,
            convert: Some(width),
        } => format!("{}({})", scalar_name(Scalar { kind, width })?, inner(expr)?),
        Expression::ZeroValue(ty) => match module.types[ty].inner {
            TypeInner::Scalar(scalar) => format!("{}()", scalar_name(scalar)?),
            _ => return unsupported(),
        },
        Expression::Math {
            fun,
            arg,
            arg1,
            arg2,
            arg3: None,
        } => {
            let name = match fun {
                naga::MathFunction::Min => "min",
                naga::MathFunction::Max => "max",
                naga::MathFunction::Clamp => "clamp",
                naga::MathFunction::Abs => "abs",
                _ => return unsupported(),
            };
            let arguments: Result<Vec<_>, _> = [Some(arg), arg1, arg2]
                .into_iter()
                .flatten()
                .map(inner)
                .collect();
            format!("{name}({})", arguments?.join(", "))
        }
        Expression::Compose { ty, ref components } => {
            let TypeInner::Vector { size, scalar } = module.types[ty].inner else {
                return unsupported();
            };
            let parts: Result<Vec<_>, _> = components.iter().map(|&c| inner(c)).collect();
            format!(
                "vec{}<{}>({})",
                size as u8,
                scalar_name(scalar)?,
                parts?.join(", ")
            )
        }
        Expression::Splat { size, value } => format!("vec{}({})", size as u8, inner(value)?),
        _ => return unsupported(),
    })
}

fn scalar_name(scalar: Scalar) -> Result<&'static str, EmitError> {
    Ok(match scalar {
        Scalar::U32 => "u32",
        Scalar::I32 => "i32",
        Scalar::F32 => "f32",
        Scalar::F16 => "f16",
        Scalar::BOOL => "bool",
        other => return Err(EmitError::NoText(format!("a constant of type {other:?}"))),
    })
}

/// A unary operator in WGSL.
pub(crate) fn unary(op: UnaryOperator) -> &'static str {
    match op {
        UnaryOperator::Negate => "-",
        UnaryOperator::LogicalNot => "!",
        UnaryOperator::BitwiseNot => "~",
    }
}

/// A binary operator in WGSL.
pub(crate) fn operator(op: BinaryOperator) -> &'static str {
    match op {
        BinaryOperator::Add => "+",
        BinaryOperator::Subtract => "-",
        BinaryOperator::Multiply => "*",
        BinaryOperator::Divide => "/",
        BinaryOperator::Modulo => "%",
        BinaryOperator::Equal => "==",
        BinaryOperator::NotEqual => "!=",
        BinaryOperator::Less => "<",
        BinaryOperator::LessEqual => "<=",
        BinaryOperator::Greater => ">",
        BinaryOperator::GreaterEqual => ">=",
        BinaryOperator::And => "&",
        BinaryOperator::ExclusiveOr => "^",
        BinaryOperator::InclusiveOr => "|",
        BinaryOperator::LogicalAnd => "&&",
        BinaryOperator::LogicalOr => "||",
        BinaryOperator::ShiftLeft => "<<",
        BinaryOperator::ShiftRight => ">>",
    }
}
