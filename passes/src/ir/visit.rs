//! The one operand visitor over naga's IR.
//!
//! naga has no visitor of its own, and every hand-written match over its expressions and statements rots with each of
//! its releases. So there is exactly one here, and everything else in this crate goes through it. Every variant and
//! every field is named and there is no `_` arm: a naga that adds an operand breaks the build on this page, which is
//! where it should.
//!
//! *Guarantees*: operands come in the order in which the IR declares them; sub-blocks of a statement are not entered
//! (see [`sub_blocks`]).

use naga::{
    AtomicFunction, Block, CooperativeData, Expression, Function, GatherMode, GlobalVariable,
    Handle, ImageQuery, RayPipelineFunction, RayQueryFunction, SampleLevel, Span, Statement,
};

/// Writes the two visitors, shared and exclusive, from one list of operands.
macro_rules! visitors {
    ($on_expression:ident, $on_statement:ident, $on_data:ident, $on_atomic:ident, $($exclusive:tt)?) => {
        /// Calls `visit` on every operand of an expression.
        pub fn $on_expression(
            expression: &$($exclusive)? Expression,
            visit: &mut dyn FnMut(&$($exclusive)? Handle<Expression>),
        ) {
            match expression {
                Expression::Literal(_literal) => {}
                Expression::Constant(_constant) => {}
                Expression::Override(_override) => {}
                Expression::ZeroValue(_ty) => {}
                Expression::FunctionArgument(_index) => {}
                Expression::GlobalVariable(_global) => {}
                Expression::LocalVariable(_local) => {}
                Expression::CallResult(_function) => {}
                Expression::AtomicResult { ty: _, comparison: _ } => {}
                Expression::WorkGroupUniformLoadResult { ty: _ } => {}
                Expression::RayQueryProceedResult => {}
                Expression::SubgroupBallotResult => {}
                Expression::SubgroupOperationResult { ty: _ } => {}
                Expression::Compose { ty: _, components } => {
                    for component in components {
                        visit(component);
                    }
                }
                Expression::Access { base, index } => {
                    visit(base);
                    visit(index);
                }
                Expression::AccessIndex { base, index: _ } => visit(base),
                Expression::Splat { size: _, value } => visit(value),
                Expression::Swizzle { size: _, vector, pattern: _ } => visit(vector),
                Expression::Load { pointer } => visit(pointer),
                Expression::ImageSample {
                    image,
                    sampler,
                    gather: _,
                    coordinate,
                    array_index,
                    offset,
                    level,
                    depth_ref,
                    clamp_to_edge: _,
                } => {
                    visit(image);
                    visit(sampler);
                    visit(coordinate);
                    if let Some(operand) = array_index {
                        visit(operand);
                    }
                    if let Some(operand) = offset {
                        visit(operand);
                    }
                    match level {
                        SampleLevel::Auto | SampleLevel::Zero => {}
                        SampleLevel::Exact(level) => visit(level),
                        SampleLevel::Bias(bias) => visit(bias),
                        SampleLevel::Gradient { x, y } => {
                            visit(x);
                            visit(y);
                        }
                    }
                    if let Some(operand) = depth_ref {
                        visit(operand);
                    }
                }
                Expression::ImageLoad { image, coordinate, array_index, sample, level } => {
                    visit(image);
                    visit(coordinate);
                    if let Some(operand) = array_index {
                        visit(operand);
                    }
                    if let Some(operand) = sample {
                        visit(operand);
                    }
                    if let Some(operand) = level {
                        visit(operand);
                    }
                }
                Expression::ImageQuery { image, query } => {
                    visit(image);
                    match query {
                        ImageQuery::Size { level } => {
                            if let Some(operand) = level {
                                visit(operand);
                            }
                        }
                        ImageQuery::NumLevels | ImageQuery::NumLayers | ImageQuery::NumSamples => {}
                    }
                }
                Expression::Unary { op: _, expr } => visit(expr),
                Expression::Binary { op: _, left, right } => {
                    visit(left);
                    visit(right);
                }
                Expression::Select { condition, accept, reject } => {
                    visit(condition);
                    visit(accept);
                    visit(reject);
                }
                Expression::Derivative { axis: _, ctrl: _, expr } => visit(expr),
                Expression::Relational { fun: _, argument } => visit(argument),
                Expression::Math { fun: _, arg, arg1, arg2, arg3 } => {
                    visit(arg);
                    if let Some(operand) = arg1 {
                        visit(operand);
                    }
                    if let Some(operand) = arg2 {
                        visit(operand);
                    }
                    if let Some(operand) = arg3 {
                        visit(operand);
                    }
                }
                Expression::As { expr, kind: _, convert: _ } => visit(expr),
                Expression::ArrayLength(array) => visit(array),
                Expression::RayQueryVertexPositions { query, committed: _ } => visit(query),
                Expression::RayQueryGetIntersection { query, committed: _ } => visit(query),
                Expression::CooperativeLoad { columns: _, rows: _, role: _, data } => {
                    $on_data(data, visit);
                }
                Expression::CooperativeMultiplyAdd { a, b, c } => {
                    visit(a);
                    visit(b);
                    visit(c);
                }
            }
        }

        /// Calls `visit` on every expression that a statement refers to, results that it fills included. The ranges
        /// of [`Statement::Emit`] and the blocks inside the statement are not operands.
        pub fn $on_statement(
            statement: &$($exclusive)? Statement,
            visit: &mut dyn FnMut(&$($exclusive)? Handle<Expression>),
        ) {
            match statement {
                Statement::Emit(_range) => {}
                Statement::Block(_block) => {}
                Statement::If { condition, accept: _, reject: _ } => visit(condition),
                Statement::Switch { selector, cases: _ } => visit(selector),
                Statement::Loop { body: _, continuing: _, break_if } => {
                    if let Some(operand) = break_if {
                        visit(operand);
                    }
                }
                Statement::Break => {}
                Statement::Continue => {}
                Statement::Return { value } => {
                    if let Some(operand) = value {
                        visit(operand);
                    }
                }
                Statement::Kill => {}
                Statement::ControlBarrier(_flags) => {}
                Statement::MemoryBarrier(_flags) => {}
                Statement::Store { pointer, value } => {
                    visit(pointer);
                    visit(value);
                }
                Statement::ImageStore { image, coordinate, array_index, value } => {
                    visit(image);
                    visit(coordinate);
                    if let Some(operand) = array_index {
                        visit(operand);
                    }
                    visit(value);
                }
                Statement::Atomic { pointer, fun, value, result } => {
                    visit(pointer);
                    $on_atomic(fun, visit);
                    visit(value);
                    if let Some(operand) = result {
                        visit(operand);
                    }
                }
                Statement::ImageAtomic { image, coordinate, array_index, fun, value } => {
                    visit(image);
                    visit(coordinate);
                    if let Some(operand) = array_index {
                        visit(operand);
                    }
                    $on_atomic(fun, visit);
                    visit(value);
                }
                Statement::WorkGroupUniformLoad { pointer, result } => {
                    visit(pointer);
                    visit(result);
                }
                Statement::Call { function: _, arguments, result } => {
                    for argument in arguments {
                        visit(argument);
                    }
                    if let Some(operand) = result {
                        visit(operand);
                    }
                }
                Statement::RayQuery { query, fun } => {
                    visit(query);
                    match fun {
                        RayQueryFunction::Initialize { acceleration_structure, descriptor } => {
                            visit(acceleration_structure);
                            visit(descriptor);
                        }
                        RayQueryFunction::Proceed { result } => visit(result),
                        RayQueryFunction::GenerateIntersection { hit_t } => visit(hit_t),
                        RayQueryFunction::ConfirmIntersection | RayQueryFunction::Terminate => {}
                    }
                }
                Statement::RayPipelineFunction(RayPipelineFunction::TraceRay {
                    acceleration_structure,
                    descriptor,
                    payload,
                }) => {
                    visit(acceleration_structure);
                    visit(descriptor);
                    visit(payload);
                }
                Statement::SubgroupBallot { result, predicate } => {
                    visit(result);
                    if let Some(operand) = predicate {
                        visit(operand);
                    }
                }
                Statement::SubgroupGather { mode, argument, result } => {
                    match mode {
                        GatherMode::BroadcastFirst | GatherMode::QuadSwap(_) => {}
                        GatherMode::Broadcast(lane)
                        | GatherMode::Shuffle(lane)
                        | GatherMode::ShuffleDown(lane)
                        | GatherMode::ShuffleUp(lane)
                        | GatherMode::ShuffleXor(lane)
                        | GatherMode::QuadBroadcast(lane) => visit(lane),
                    }
                    visit(argument);
                    visit(result);
                }
                Statement::SubgroupCollectiveOperation { op: _, collective_op: _, argument, result } => {
                    visit(argument);
                    visit(result);
                }
                Statement::CooperativeStore { target, data } => {
                    visit(target);
                    $on_data(data, visit);
                }
            }
        }

        fn $on_data(
            data: &$($exclusive)? CooperativeData,
            visit: &mut dyn FnMut(&$($exclusive)? Handle<Expression>),
        ) {
            let CooperativeData { pointer, stride, row_major: _ } = data;
            visit(pointer);
            visit(stride);
        }

        fn $on_atomic(
            function: &$($exclusive)? AtomicFunction,
            visit: &mut dyn FnMut(&$($exclusive)? Handle<Expression>),
        ) {
            match function {
                AtomicFunction::Add
                | AtomicFunction::Subtract
                | AtomicFunction::And
                | AtomicFunction::ExclusiveOr
                | AtomicFunction::InclusiveOr
                | AtomicFunction::Min
                | AtomicFunction::Max => {}
                AtomicFunction::Exchange { compare } => {
                    if let Some(operand) = compare {
                        visit(operand);
                    }
                }
            }
        }
    };
}

visitors!(
    operands,
    statement_operands,
    cooperative_operands,
    atomic_operands,
);
visitors!(
    operands_mut,
    statement_operands_mut,
    cooperative_operands_mut,
    atomic_operands_mut,
    mut
);

/// Calls `visit` on every block directly inside a statement, in program order.
pub fn sub_blocks<'a>(statement: &'a Statement, visit: &mut dyn FnMut(&'a Block)) {
    match statement {
        Statement::Block(block) => visit(block),
        Statement::If {
            condition: _,
            accept,
            reject,
        } => {
            visit(accept);
            visit(reject);
        }
        Statement::Switch { selector: _, cases } => {
            for case in cases {
                visit(&case.body);
            }
        }
        Statement::Loop {
            body,
            continuing,
            break_if: _,
        } => {
            visit(body);
            visit(continuing);
        }
        Statement::Emit(_)
        | Statement::Break
        | Statement::Continue
        | Statement::Return { .. }
        | Statement::Kill
        | Statement::ControlBarrier(_)
        | Statement::MemoryBarrier(_)
        | Statement::Store { .. }
        | Statement::ImageStore { .. }
        | Statement::Atomic { .. }
        | Statement::ImageAtomic { .. }
        | Statement::WorkGroupUniformLoad { .. }
        | Statement::Call { .. }
        | Statement::RayQuery { .. }
        | Statement::RayPipelineFunction(_)
        | Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. }
        | Statement::CooperativeStore { .. } => {}
    }
}

/// A copy of a statement, with what `map` makes of each block directly inside it, in program order.
pub fn map_sub_blocks(statement: &Statement, map: &mut dyn FnMut(&Block) -> Block) -> Statement {
    match statement {
        Statement::Block(block) => Statement::Block(map(block)),
        Statement::If {
            condition,
            accept,
            reject,
        } => Statement::If {
            condition: *condition,
            accept: map(accept),
            reject: map(reject),
        },
        Statement::Switch { selector, cases } => Statement::Switch {
            selector: *selector,
            cases: cases
                .iter()
                .map(|case| naga::SwitchCase {
                    value: case.value,
                    body: map(&case.body),
                    fall_through: case.fall_through,
                })
                .collect(),
        },
        Statement::Loop {
            body,
            continuing,
            break_if,
        } => Statement::Loop {
            body: map(body),
            continuing: map(continuing),
            break_if: *break_if,
        },
        simple @ (Statement::Emit(_)
        | Statement::Break
        | Statement::Continue
        | Statement::Return { .. }
        | Statement::Kill
        | Statement::ControlBarrier(_)
        | Statement::MemoryBarrier(_)
        | Statement::Store { .. }
        | Statement::ImageStore { .. }
        | Statement::Atomic { .. }
        | Statement::ImageAtomic { .. }
        | Statement::WorkGroupUniformLoad { .. }
        | Statement::Call { .. }
        | Statement::RayQuery { .. }
        | Statement::RayPipelineFunction(_)
        | Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. }
        | Statement::CooperativeStore { .. }) => simple.clone(),
    }
}

/// Calls `visit` on every statement of `block` and of the blocks inside it, outer before inner, in program order.
pub fn statements<'a>(block: &'a Block, visit: &mut dyn FnMut(&'a Statement)) {
    for statement in block {
        visit(statement);
        sub_blocks(statement, &mut |inner| statements(inner, visit));
    }
}

/// As [`statements`], with the place of each in the source.
pub fn spanned_statements<'a>(block: &'a Block, visit: &mut dyn FnMut(&'a Statement, Span)) {
    for (statement, &span) in block.span_iter() {
        visit(statement, span);
        sub_blocks(statement, &mut |inner| spanned_statements(inner, visit));
    }
}

/// Calls `visit` on every global variable that a function names, once for each mention.
pub fn globals(function: &Function, visit: &mut dyn FnMut(Handle<GlobalVariable>)) {
    for (_, expression) in function.expressions.iter() {
        if let Expression::GlobalVariable(global) = *expression {
            visit(global);
        }
    }
}
