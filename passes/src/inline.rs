//! Puts helper functions that have barriers inside into the entry points that call them, before anything else is decided.
//!
//! ```wgsl
//! // before                                    // after
//! fn highest(lane: u32, v: f32) -> f32 {       scratch[lane] = v;
//!     scratch[lane] = v;                       workgroupBarrier();
//!     workgroupBarrier();                      let result = scratch[0];
//!     return scratch[0];                       textureStore(dst, id.xy, vec4(result));
//! }
//! textureStore(dst, id.xy, vec4(highest(lane, v)));
//! ```
//!
//! An entry point is cut into [regions](crate::plan::regions) at its barriers, and a barrier that hides in a call cannot be cut at.
//!
//! *Does*: writes the entry point anew, with the helper's statements in place of the call; what it returns is kept in a local,
//! and its locals begin anew with each call. A `return` in a branch becomes its end: what follows goes into the other branch.
//! *Guarantees*: statements keep their order and their spans, and no barrier comes to stand under another condition than it did;
//! helpers stay in the module, for entry points that are left alone.
//! *Refuses* (leaves the call as it is, for the [skeleton](crate::plan::regions::skeleton) to name): helpers that return out of
//! a loop or a `switch`, and helpers with a ray query among their locals.

use naga::{
    Block, Expression, Function, Handle, LocalVariable, Module, Span, Statement, TypeInner,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use rustc_hash::FxHashMap;

use crate::{
    analysis::{Facts, facts::Effects},
    ir::{build::Code, visit},
};

/// A module whose entry points have all of their barriers themselves.
pub struct Inlined {
    /// The module.
    pub module: Module,
    /// What naga knows of it.
    pub info: ModuleInfo,
}

/// Puts the barriers of helpers into entry points; `None` if no helper has any.
pub fn barriers(module: &Module, entries: &[usize]) -> Option<Inlined> {
    let mut inlined = module.clone();
    let mut is_changed = false;
    for &entry in entries {
        let facts = Facts::new(module, entry);
        let function = &module.entry_points[entry].function;
        if !calls_a_barrier(&facts, function) {
            continue;
        }
        let written = write(module, &facts, function, &mut inlined);
        inlined.entry_points[entry].function = written;
        is_changed = true;
    }
    if !is_changed {
        return None;
    }
    match Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&inlined) {
        Ok(info) => Some(Inlined {
            module: inlined,
            info,
        }),
        Err(error) => unreachable!("a helper in its caller's place: {:?}", error.into_inner()),
    }
}

fn calls_a_barrier(facts: &Facts, function: &Function) -> bool {
    let mut found = false;
    visit::statements(&function.body, &mut |statement| {
        if let Statement::Call { function, .. } = *statement {
            found |= has_barrier(facts, function);
        }
    });
    found
}

fn has_barrier(facts: &Facts, function: Handle<Function>) -> bool {
    let effects = facts.function(function).effects;
    effects.contains(Effects::BARRIER)
}

/// Why a helper cannot stand in its caller's place; `None` if it can.
pub fn unfit(module: &Module, function: &Function) -> Option<&'static str> {
    let is_value = |(_, local): (_, &LocalVariable)| {
        !matches!(
            module.types[local.ty].inner,
            TypeInner::RayQuery { .. } | TypeInner::CooperativeMatrix { .. }
        )
    };
    if !function.local_variables.iter().all(is_value) {
        return Some("it has a ray query among its variables");
    }
    match returns_at_ends(&function.body) {
        true => None,
        false => Some(
            "it returns out of a loop, out of a `switch`, or in some ways through a branch but not in all",
        ),
    }
}

/// Whether all returns can become ends of branches.
fn returns_at_ends(block: &Block) -> bool {
    block.iter().all(|statement| match statement {
        Statement::Block(block) => returns_at_ends(block),
        Statement::If { accept, reject, .. } => {
            // where only some ways through a branch return, what follows would have to stand twice
            let is_plain = |branch: &Block| always_returns(branch) || !may_return(branch);
            let both = is_plain(accept) && is_plain(reject);
            both && returns_at_ends(accept) && returns_at_ends(reject)
        }
        statement => {
            let mut found = false;
            visit::sub_blocks(statement, &mut |block| found |= may_return(block));
            !found
        }
    })
}

fn may_return(block: &Block) -> bool {
    let mut found = false;
    visit::statements(block, &mut |statement| {
        found |= matches!(statement, Statement::Return { .. });
    });
    found
}

fn always_returns(block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Return { .. } => true,
        Statement::Block(block) => always_returns(block),
        Statement::If { accept, reject, .. } => always_returns(accept) && always_returns(reject),
        _ => false,
    })
}

/// Whether a statement gives an expression its value.
fn is_given(expression: &Expression) -> bool {
    matches!(
        expression,
        Expression::CallResult(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. }
            | Expression::RayQueryProceedResult
            | Expression::SubgroupBallotResult
            | Expression::SubgroupOperationResult { .. }
    )
}

/// A function while its statements are written.
struct Frame<'f> {
    function: &'f Function,
    /// What its expressions have become.
    values: FxHashMap<Handle<Expression>, Handle<Expression>>,
    /// What was handed to it; `None` for the entry point, which keeps its arguments.
    arguments: Option<Vec<Handle<Expression>>>,
    /// Where its result goes.
    result: Option<Handle<Expression>>,
}

struct Writer<'w> {
    module: &'w Module,
    facts: &'w Facts,
    names: Vec<(Handle<Expression>, String)>,
}

/// The entry point's function, with its helpers in place.
fn write(module: &Module, facts: &Facts, function: &Function, into: &mut Module) -> Function {
    let mut written = Function {
        name: function.name.clone(),
        arguments: function.arguments.clone(),
        result: function.result.clone(),
        diagnostic_filter_leaf: function.diagnostic_filter_leaf,
        ..Function::default()
    };
    let mut frame = Frame {
        function,
        values: FxHashMap::default(),
        arguments: None,
        result: None,
    };
    // what a variable starts with is no part of the body
    for (handle, local) in function.local_variables.iter() {
        let init = local
            .init
            .map(|init| initial(&mut written, &mut frame, init));
        let span = function.local_variables.get_span(handle);
        let local = LocalVariable {
            init,
            ..local.clone()
        };
        written.local_variables.append(local, span);
    }
    let mut writer = Writer {
        module,
        facts,
        names: Vec::new(),
    };
    let mut code = Code::new(&mut into.types, &mut written, Span::UNDEFINED);
    writer.block(&mut code, &mut frame, &function.body);
    written.body = code.finish();
    for (handle, name) in writer.names {
        if !written.expressions[handle].needs_pre_emit() {
            written.named_expressions.insert(handle, name);
        }
    }
    written
}

/// Copies what a local starts with.
fn initial(
    written: &mut Function,
    frame: &mut Frame,
    handle: Handle<Expression>,
) -> Handle<Expression> {
    if let Some(&value) = frame.values.get(&handle) {
        return value;
    }
    let mut copy = frame.function.expressions[handle].clone();
    visit::operands_mut(&mut copy, &mut |operand| {
        *operand = initial(written, frame, *operand);
    });
    let span = frame.function.expressions.get_span(handle);
    // not noted as the body's: there it would have to be emitted
    written.expressions.append(copy, span)
}

impl Writer<'_> {
    fn block(&mut self, code: &mut Code, frame: &mut Frame, block: &Block) {
        let statements: Vec<(&Statement, Span)> =
            block.span_iter().map(|(s, span)| (s, *span)).collect();
        self.run(code, frame, &statements);
    }

    /// Writes statements that follow one another.
    fn run(&mut self, code: &mut Code, frame: &mut Frame, statements: &[(&Statement, Span)]) {
        for (index, &(statement, span)) in statements.iter().enumerate() {
            code.set_span(span);
            let is_helper = frame.arguments.is_some();
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        self.emit(code, frame, handle);
                    }
                }
                &Statement::Return { value } if is_helper => {
                    if let (Some(value), Some(pointer)) = (value, frame.result) {
                        let value = self.value(code, frame, value);
                        code.push(Statement::Store { pointer, value });
                    }
                    return;
                }
                Statement::Block(block) if is_helper && always_returns(block) => {
                    self.block(code, frame, block);
                    return;
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } if is_helper && (always_returns(accept) || always_returns(reject)) => {
                    let rest = &statements[index + 1..];
                    let condition = self.value(code, frame, *condition);
                    let [accept, reject] = [accept, reject].map(|branch| {
                        code.nested(|code| {
                            self.block(code, frame, branch);
                            if !always_returns(branch) {
                                self.run(code, frame, rest);
                            }
                        })
                    });
                    code.set_span(span);
                    code.push(Statement::If {
                        condition,
                        accept,
                        reject,
                    });
                    return;
                }
                &Statement::Call {
                    function,
                    ref arguments,
                    result,
                } if has_barrier(self.facts, function)
                    && unfit(self.module, &self.module.functions[function]).is_none() =>
                {
                    let arguments = arguments
                        .iter()
                        .map(|&argument| self.value(code, frame, argument))
                        .collect();
                    let returned = self.helper(code, function, arguments);
                    if let (Some(result), Some(returned)) = (result, returned) {
                        frame.values.insert(result, returned);
                        self.keep_name(frame, result, returned);
                    }
                }
                statement => self.statement(code, frame, statement, span),
            }
        }
    }

    /// Writes a helper's body; what it returns.
    fn helper(
        &mut self,
        code: &mut Code,
        function: Handle<Function>,
        arguments: Vec<Handle<Expression>>,
    ) -> Option<Handle<Expression>> {
        let module = self.module;
        let function = &module.functions[function];
        let mut frame = Frame {
            function,
            values: FxHashMap::default(),
            arguments: Some(arguments),
            result: None,
        };
        for (handle, local) in function.local_variables.iter() {
            let value = match local.init {
                Some(init) => self.value(code, &mut frame, init),
                None => code.add(Expression::ZeroValue(local.ty)),
            };
            let name = local.name.as_deref().unwrap_or("local");
            let pointer = code.local(name, local.ty, Some(value));
            let of = function
                .expressions
                .iter()
                .filter(|(_, e)| **e == Expression::LocalVariable(handle));
            frame.values.extend(of.map(|(used, _)| (used, pointer)));
        }
        frame.result = function.result.as_ref().map(|result| {
            let name = function.name.as_deref().unwrap_or("helper");
            code.local(&format!("vrcs_{name}_result"), result.ty, None)
        });
        self.block(code, &mut frame, &function.body);
        frame.result.map(|pointer| code.load(pointer))
    }

    fn statement(&mut self, code: &mut Code, frame: &mut Frame, statement: &Statement, span: Span) {
        let copy = match statement {
            Statement::Block(block) => {
                Statement::Block(code.nested(|code| self.block(code, frame, block)))
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => Statement::If {
                condition: self.value(code, frame, *condition),
                accept: code.nested(|code| self.block(code, frame, accept)),
                reject: code.nested(|code| self.block(code, frame, reject)),
            },
            Statement::Switch { selector, cases } => Statement::Switch {
                selector: self.value(code, frame, *selector),
                cases: cases
                    .iter()
                    .map(|case| naga::SwitchCase {
                        value: case.value,
                        body: code.nested(|code| self.block(code, frame, &case.body)),
                        fall_through: case.fall_through,
                    })
                    .collect(),
            },
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => Statement::Loop {
                body: code.nested(|code| self.block(code, frame, body)),
                continuing: code.nested(|code| self.block(code, frame, continuing)),
                break_if: break_if.map(|condition| self.value(code, frame, condition)),
            },
            simple => {
                let mut copy = simple.clone();
                visit::statement_operands_mut(&mut copy, &mut |operand| {
                    *operand = self.value(code, frame, *operand);
                });
                copy
            }
        };
        code.set_span(span);
        code.push(copy);
    }

    /// What an expression has become.
    fn value(
        &mut self,
        code: &mut Code,
        frame: &mut Frame,
        handle: Handle<Expression>,
    ) -> Handle<Expression> {
        if let Some(&value) = frame.values.get(&handle) {
            return value;
        }
        let expression = &frame.function.expressions[handle];
        if let (Expression::FunctionArgument(index), Some(arguments)) =
            (expression, &frame.arguments)
        {
            return arguments[*index as usize];
        }
        // a constant that is never emitted is written anew for each use: the block that holds one use need not hold the next
        let is_for_all = expression.needs_pre_emit() || is_given(expression);
        let value = self.copy(code, frame, handle);
        if is_for_all {
            frame.values.insert(handle, value);
        }
        value
    }

    /// Writes an expression that is emitted here.
    fn emit(&mut self, code: &mut Code, frame: &mut Frame, handle: Handle<Expression>) {
        let value = self.copy(code, frame, handle);
        frame.values.insert(handle, value);
    }

    fn copy(
        &mut self,
        code: &mut Code,
        frame: &mut Frame,
        handle: Handle<Expression>,
    ) -> Handle<Expression> {
        let mut copy = frame.function.expressions[handle].clone();
        visit::operands_mut(&mut copy, &mut |operand| {
            *operand = self.value(code, frame, *operand);
        });
        let value = code.add_at(copy, frame.function.expressions.get_span(handle));
        self.keep_name(frame, handle, value);
        value
    }

    fn keep_name(&mut self, frame: &Frame, before: Handle<Expression>, after: Handle<Expression>) {
        if let Some(name) = frame.function.named_expressions.get(&before) {
            self.names.push((after, name.clone()));
        }
    }
}
