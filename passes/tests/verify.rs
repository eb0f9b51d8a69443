//! The rules that naga's validator does not check: each module here is one that naga accepts, or dies of, and that
//! `verify` rejects. If naga starts to check a rule, its test says so. Rules 3 and 5 naga checks, too.

use naga::{
    Block, Expression, Function, Handle, Literal, LocalVariable, Module, Range, ResourceBinding,
    Span, Statement, UnaryOperator,
    valid::{Capabilities, ValidationFlags, Validator},
};
use vrcs_passes::{Source, input, ir::verify};

const NONE: Span = Span::UNDEFINED;

/// A module with one entry point, to break.
fn module() -> Module {
    let source = Source::new(
        "test",
        "
        @group(0) @binding(0) var<storage, read_write> out: array<f32, 4>;
        @group(0) @binding(1) var<uniform> factor: f32;
        fn helper(x: f32) -> f32 { return x * factor; }
        fn effect() { out[1] = 1.0; }
        @compute @workgroup_size(1) fn main() {
            let a = factor + 1.0;
            if a > 2.0 { out[0] = a; }
            out[2] = helper(a);
        }
        ",
    );
    input::wgsl(&source).expect("a valid shader").0
}

fn naga_accepts(module: &Module) -> bool {
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(module)
        .is_ok()
}

fn broken_rule(module: &Module) -> Option<u8> {
    verify::check(module).err().map(|broken| broken.rule)
}

fn main_of(module: &mut Module) -> &mut Function {
    &mut module.entry_points[0].function
}

/// Puts a statement in front of a function's body.
fn prepend(function: &mut Function, statement: Statement) {
    let mut block = Block::new();
    block.push(statement, NONE);
    function.body.splice(0..0, block);
}

/// Appends `-operand`, without emitting it.
fn negated(function: &mut Function, expr: Handle<Expression>) -> Handle<Expression> {
    function.expressions.append(
        Expression::Unary {
            op: UnaryOperator::Negate,
            expr,
        },
        NONE,
    )
}

/// A float literal in a function.
fn literal(function: &mut Function) -> Handle<Expression> {
    function
        .expressions
        .append(Expression::Literal(Literal::F32(1.0)), NONE)
}

/// A local variable's pointer.
fn local(module: &mut Module) -> Handle<Expression> {
    let float = module
        .types
        .iter()
        .find(|(_, ty)| ty.inner == naga::TypeInner::Scalar(naga::Scalar::F32))
        .map(|(handle, _)| handle)
        .expect("f32");
    let function = main_of(module);
    let variable = function.local_variables.append(
        LocalVariable {
            name: None,
            ty: float,
            init: None,
        },
        NONE,
    );
    function
        .expressions
        .append(Expression::LocalVariable(variable), NONE)
}

#[test]
fn a_valid_module_breaks_no_rule() {
    let module = module();
    assert!(naga_accepts(&module));
    assert_eq!(verify::check(&module), Ok(()));
}

/// A block that emits an expression and stores it.
fn emit_and_store(pointer: Handle<Expression>, value: Handle<Expression>) -> Block {
    let mut block = Block::new();
    block.push(Statement::Emit(Range::new_from_bounds(value, value)), NONE);
    block.push(Statement::Store { pointer, value }, NONE);
    block
}

#[test]
fn rule_1_what_is_used_has_been_emitted() {
    let mut module = module();
    let pointer = local(&mut module);
    let function = main_of(&mut module);
    let one = literal(function);
    let never_emitted = negated(function, one);
    let value = negated(function, never_emitted);
    prepend(function, Statement::Block(emit_and_store(pointer, value)));
    assert!(naga_accepts(&module), "naga checks this now");
    assert_eq!(broken_rule(&module), Some(1));
}

#[test]
fn rule_1_a_sibling_block_is_out_of_scope() {
    let mut module = module();
    let pointer = local(&mut module);
    let function = main_of(&mut module);
    let one = literal(function);
    let elsewhere = negated(function, one);
    let value = negated(function, elsewhere);
    let condition = function
        .expressions
        .append(Expression::Literal(Literal::Bool(true)), NONE);
    let accept = emit_and_store(pointer, elsewhere);
    let reject = emit_and_store(pointer, value);
    prepend(
        function,
        Statement::If {
            condition,
            accept,
            reject,
        },
    );
    assert!(naga_accepts(&module), "naga checks this now");
    assert_eq!(broken_rule(&module), Some(1));
}

#[test]
fn rule_2_nothing_is_emitted_twice() {
    let mut module = module();
    let function = main_of(&mut module);
    let one = literal(function);
    let value = negated(function, one);
    let condition = function
        .expressions
        .append(Expression::Literal(Literal::Bool(true)), NONE);
    let emit = || {
        let mut block = Block::new();
        block.push(Statement::Emit(Range::new_from_bounds(value, value)), NONE);
        block
    };
    prepend(
        function,
        Statement::If {
            condition,
            accept: emit(),
            reject: emit(),
        },
    );
    assert!(naga_accepts(&module), "naga checks this now");
    assert_eq!(broken_rule(&module), Some(2));
}

#[test]
fn rule_3_results_are_not_emitted() {
    let mut module = module();
    let function = main_of(&mut module);
    let result = function
        .expressions
        .append(Expression::SubgroupBallotResult, NONE);
    let emit = Statement::Emit(Range::new_from_bounds(result, result));
    prepend(function, emit);
    assert!(!naga_accepts(&module), "this one naga checks, too");
    assert_eq!(broken_rule(&module), Some(3));
}

#[test]
fn rule_3_literals_are_not_emitted() {
    let mut module = module();
    let function = main_of(&mut module);
    let one = literal(function);
    let emit = Statement::Emit(Range::new_from_bounds(one, one));
    prepend(function, emit);
    assert!(!naga_accepts(&module), "this one naga checks, too");
    assert_eq!(broken_rule(&module), Some(3));
}

#[test]
fn rule_4_a_result_is_given_once() {
    let mut module = module();
    let function = main_of(&mut module);
    let result = function
        .expressions
        .append(Expression::SubgroupBallotResult, NONE);
    let condition = function
        .expressions
        .append(Expression::Literal(Literal::Bool(true)), NONE);
    let ballot = || {
        let mut block = Block::new();
        let statement = Statement::SubgroupBallot {
            result,
            predicate: None,
        };
        block.push(statement, NONE);
        block
    };
    prepend(
        function,
        Statement::If {
            condition,
            accept: ballot(),
            reject: ballot(),
        },
    );
    assert!(naga_accepts(&module), "naga checks this now");
    assert_eq!(broken_rule(&module), Some(4));
}

#[test]
fn rule_4_a_call_gives_its_result_once() {
    let mut module = module();
    let (helper, _) = module.functions.iter().next().expect("the helper");
    let function = main_of(&mut module);
    let argument = literal(function);
    let result = function
        .expressions
        .append(Expression::CallResult(helper), NONE);
    for _ in 0..2 {
        let call = Statement::Call {
            function: helper,
            arguments: vec![argument],
            result: Some(result),
        };
        prepend(function, call);
    }
    assert!(!naga_accepts(&module), "this one naga checks, too");
    assert_eq!(broken_rule(&module), Some(4));
}

#[test]
fn rule_5_operands_come_first() {
    let mut module = module();
    let function = main_of(&mut module);
    let value = literal(function);
    let first = negated(function, value);
    let second = negated(function, value);
    function.expressions[first] = Expression::Unary {
        op: UnaryOperator::Negate,
        expr: second,
    };
    assert!(!naga_accepts(&module), "this one naga checks, too");
    assert_eq!(broken_rule(&module), Some(5));
}

#[test]
fn rule_6_a_function_stands_before_its_callers() {
    // naga's validator panics on this one
    let mut module = module();
    let (helper, effect) = {
        let mut functions = module.functions.iter().map(|(handle, _)| handle);
        (
            functions.next().expect("the helper"),
            functions.next().expect("the effect"),
        )
    };
    module.functions[helper].body.splice(0..0, {
        let mut block = Block::new();
        block.push(
            Statement::Call {
                function: effect,
                arguments: Vec::new(),
                result: None,
            },
            NONE,
        );
        block
    });
    assert_eq!(broken_rule(&module), Some(6));
}

#[test]
fn rule_7_bindings_are_taken_once() {
    let mut module = module();
    let mut globals = module.global_variables.iter_mut();
    let (_, _) = globals.next().expect("a variable");
    let (_, factor) = globals.next().expect("another");
    factor.binding = Some(ResourceBinding {
        group: 0,
        binding: 0,
    });
    drop(globals);
    // naga asks each entry point for itself, and the shader's own may use only one of the two
    module.entry_points.clear();
    assert!(naga_accepts(&module), "naga checks this now");
    assert_eq!(broken_rule(&module), Some(7));
}

#[test]
fn rule_8_the_authors_functions_stay_what_they_were() {
    let before = module();
    let mut after = module();
    let (helper, _) = after.functions.iter().next().expect("the helper");
    after.functions[helper].name = Some("other".to_owned());
    assert!(naga_accepts(&after));
    let broken = verify::follows(&before, &after, &[], &[]);
    assert_eq!(broken.map_err(|broken| broken.rule), Err(8));
    assert_eq!(verify::follows(&before, &before, &[], &[]), Ok(()));
}

#[test]
fn rule_9_the_authors_statements_keep_their_order() {
    let module = module();
    let before = &module.entry_points[0].function;
    let mut after = before.clone();
    assert_eq!(
        verify::follows(&module, &module, &[0], &[(before, &after)]),
        Ok(())
    );
    // the last store goes
    let last = after
        .body
        .iter()
        .rposition(|statement| matches!(statement, Statement::Store { .. }))
        .expect("a store");
    after.body.cull(last..=last);
    let mut without = module.clone();
    without.entry_points[0].function = after.clone();
    assert!(naga_accepts(&without));
    let broken = verify::follows(&module, &module, &[0], &[(before, &after)]);
    assert_eq!(broken.map_err(|broken| broken.rule), Err(9));
}

/// An entry point with a barrier, and a module in which a function is what it was split into: so far the same.
fn split() -> (Module, Handle<Function>) {
    let text = "
        var<workgroup> shared_row: array<f32, 8>;
        @group(0) @binding(0) var<storage, read_write> out: array<f32>;
        @compute @workgroup_size(8) fn main(@builtin(local_invocation_index) lane: u32) {
            shared_row[lane] = f32(lane);
            workgroupBarrier();
            out[lane] = shared_row[7u - lane];
        }
        ";
    let mut module = naga::front::wgsl::parse_str(text).expect("a valid shader");
    let mut function = module.entry_points[0].function.clone();
    function.name = Some("split".to_owned());
    for argument in &mut function.arguments {
        argument.binding = None;
    }
    let handle = module.functions.append(function, Span::UNDEFINED);
    (module, handle)
}

fn broken_barrier(module: &Module, split: Handle<Function>, entry: &Function) -> Option<u8> {
    let before = &module.entry_points[0].function;
    let broken = verify::barriers(before, module, split, entry);
    broken.err().map(|broken| broken.rule)
}

/// Puts what stands at the barrier's place into a block of its own, with `wrap` around it.
fn wrap_barrier(function: &mut Function, wrap: impl FnOnce(Block) -> Statement) {
    let at = function
        .body
        .iter()
        .position(|statement| matches!(statement, Statement::ControlBarrier(_)))
        .expect("a barrier");
    let barrier = Block::from_vec(vec![function.body[at].clone()]);
    let wrapped = Block::from_vec(vec![wrap(barrier)]);
    function.body.splice(at..=at, wrapped);
}

#[test]
fn rule_10_a_barrier_stands_under_no_condition_of_ours() {
    let (mut module, split) = split();
    let new_entry = Function::default();
    assert_eq!(broken_barrier(&module, split, &new_entry), None);
    let function = &mut module.functions[split];
    let ours = literal(function);
    wrap_barrier(function, |accept| Statement::If {
        condition: ours,
        accept,
        reject: Block::new(),
    });
    assert_eq!(broken_barrier(&module, split, &new_entry), Some(10));
}

#[test]
fn rule_10_nothing_of_ours_returns_before_a_barrier() {
    let (mut module, split) = split();
    let new_entry = Function::default();
    let function = &mut module.functions[split];
    let ours = literal(function);
    let leave = Statement::If {
        condition: ours,
        accept: Block::from_vec(vec![Statement::Return { value: None }]),
        reject: Block::new(),
    };
    // behind the last barrier it may
    let mut late = module.clone();
    late.functions[split]
        .body
        .push(leave.clone(), Span::UNDEFINED);
    assert_eq!(broken_barrier(&late, split, &new_entry), None);
    prepend(&mut module.functions[split], leave);
    assert_eq!(broken_barrier(&module, split, &new_entry), Some(10));
}

#[test]
fn rule_10_the_new_entry_point_calls_what_has_barriers_under_no_condition() {
    let (module, split) = split();
    let mut entry = Function::default();
    let lane = module.functions[split].arguments[0].ty;
    let argument = entry
        .expressions
        .append(Expression::ZeroValue(lane), Span::UNDEFINED);
    let call = Statement::Call {
        function: split,
        arguments: vec![argument],
        result: None,
    };
    entry.body.push(call.clone(), Span::UNDEFINED);
    assert_eq!(broken_barrier(&module, split, &entry), None);
    let condition = literal(&mut entry);
    entry.body = Block::from_vec(vec![Statement::If {
        condition,
        accept: Block::from_vec(vec![call]),
        reject: Block::new(),
    }]);
    assert_eq!(broken_barrier(&module, split, &entry), Some(10));
}
