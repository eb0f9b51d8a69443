//! Takes out of a function what none of its effects needs.
//!
//! *Does*: marks what stores, atomics and calls with effects need, through variables and control flow, up to a fixed point; the
//! rest goes: statements, and the expressions that only they used. Variables are taken as a whole.
//! *Guarantees*: what is left has the same effects, in the same order, under the same conditions; spans stay. A loop without
//! effects is taken to end. Every `return` before others stays, for it keeps later effects from happening.

use std::collections::BTreeSet;

use naga::{
    AddressSpace, Arena, Block, Expression, Function, GlobalVariable, Handle, LocalVariable,
    Module, Range, Statement,
};
use rustc_hash::FxHashMap;

use crate::{
    analysis::{
        Facts,
        facts::{Effects, constant_steps},
    },
    ir::{
        statements::{Numbering, StatementId, rebuild},
        visit,
    },
};

/// What is needed, as far as it is known.
struct Needed<'n> {
    module: &'n Module,
    facts: &'n Facts,
    function: &'n Function,
    expressions: BTreeSet<Handle<Expression>>,
    locals: BTreeSet<Handle<LocalVariable>>,
    privates: BTreeSet<Handle<GlobalVariable>>,
    statements: BTreeSet<StatementId>,
}

/// Prunes a function of `module`; the facts know its callees. `outlive` are the private variables that somebody may read when
/// it has returned. Gives the expressions that are needed, by their handles before.
pub fn prune(
    module: &Module,
    facts: &Facts,
    function: &mut Function,
    outlive: &BTreeSet<Handle<GlobalVariable>>,
) -> BTreeSet<Handle<Expression>> {
    if function.result.is_none() {
        without_last_returns(&mut function.body);
    }
    let before = function.clone();
    let mut needed = Needed {
        module,
        facts,
        function: &before,
        expressions: BTreeSet::new(),
        locals: BTreeSet::new(),
        privates: outlive.clone(),
        statements: BTreeSet::new(),
    };
    for (_, local) in before.local_variables.iter() {
        if let Some(init) = local.init {
            needed.expression(init);
        }
    }
    loop {
        let known = needed.size();
        needed.block(&before.body, &mut Numbering::default(), Around::default());
        if needed.size() == known {
            break;
        }
    }
    let Needed {
        expressions,
        statements,
        ..
    } = needed;
    rewrite(function, &expressions, &statements);
    if function.result.is_none() {
        naga::proc::ensure_block_returns(&mut function.body);
    }
    expressions
}

/// Takes out returns behind which nothing stands: a front end ends each branch with one, which would keep the branch.
fn without_last_returns(block: &mut Block) {
    while let Some(Statement::Return { value: None }) = block.last() {
        let last = block.len() - 1;
        block.cull(last..);
    }
    match block.last_mut() {
        Some(Statement::Block(inner)) => without_last_returns(inner),
        Some(Statement::If { accept, reject, .. }) => {
            without_last_returns(accept);
            without_last_returns(reject);
        }
        Some(Statement::Switch { cases, .. }) => {
            for case in cases.iter_mut().filter(|case| !case.fall_through) {
                without_last_returns(&mut case.body);
            }
        }
        _ => {}
    }
}

/// Whether what a statement would leave or repeat is needed.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    /// The loop or switch that a `break` leaves.
    left: bool,
    /// The loop that a `continue` repeats.
    repeated: bool,
}

impl Needed<'_> {
    fn size(&self) -> usize {
        self.expressions.len() + self.locals.len() + self.privates.len() + self.statements.len()
    }

    fn expression(&mut self, handle: Handle<Expression>) {
        if !self.expressions.insert(handle) {
            return;
        }
        match self.function.expressions[handle] {
            Expression::LocalVariable(local) => {
                self.locals.insert(local);
            }
            Expression::GlobalVariable(global) => {
                self.privates.insert(global);
            }
            _ => {}
        }
        let mut operands = Vec::new();
        visit::operands(&self.function.expressions[handle], &mut |&operand| {
            operands.push(operand);
        });
        for operand in operands {
            self.expression(operand);
        }
    }

    fn statement(&mut self, statement: &Statement) {
        let mut operands = Vec::new();
        visit::statement_operands(statement, &mut |&operand| operands.push(operand));
        for operand in operands {
            self.expression(operand);
        }
        if let Statement::Call { function, .. } = *statement {
            self.privates.extend(&self.facts.function(function).reads);
        }
    }

    /// Whether a block has anything that is needed.
    fn block(&mut self, block: &Block, numbering: &mut Numbering, around: Around) -> bool {
        let mut any = false;
        for statement in block {
            let id = numbering.enter();
            let is_needed = match *statement {
                Statement::Emit(_) => continue,
                Statement::Break => around.left,
                Statement::Continue => around.repeated,
                Statement::Loop { .. } => {
                    let known = self.statements.contains(&id);
                    let inside = Around {
                        left: known,
                        repeated: known,
                    };
                    self.inside(statement, numbering, inside) || known
                }
                Statement::Switch { .. } => {
                    let known = self.statements.contains(&id);
                    let inside = Around {
                        left: known,
                        ..around
                    };
                    self.inside(statement, numbering, inside) || known
                }
                Statement::Block(_) | Statement::If { .. } => {
                    self.inside(statement, numbering, around)
                }
                ref simple => self.has_effect(simple),
            };
            if is_needed {
                self.statements.insert(id);
                self.statement(statement);
            }
            any |= is_needed;
        }
        any
    }

    fn inside(&mut self, statement: &Statement, numbering: &mut Numbering, around: Around) -> bool {
        let mut blocks = Vec::new();
        visit::sub_blocks(statement, &mut |block| blocks.push(block));
        let mut any = false;
        for block in blocks {
            any |= self.block(block, numbering, around);
        }
        any
    }

    /// Whether a statement without blocks has an effect that is needed.
    fn has_effect(&self, statement: &Statement) -> bool {
        match *statement {
            Statement::Store { pointer, .. } => self.is_place_needed(pointer),
            Statement::Call {
                function,
                ref arguments,
                result,
            } => {
                let callee = self.facts.function(function);
                // a helper's variables of rays are its own
                let effects = callee.effects - Effects::READS_WRITTEN - Effects::RAY_QUERY;
                !effects.is_empty()
                    || callee
                        .writes
                        .iter()
                        .any(|global| self.privates.contains(global))
                    || result.is_some_and(|result| self.expressions.contains(&result))
                    || arguments
                        .iter()
                        .any(|&argument| self.is_needed_pointer(argument))
            }
            _ => true,
        }
    }

    /// Whether what a pointer leads to is needed.
    fn is_place_needed(&self, pointer: Handle<Expression>) -> bool {
        let root = constant_steps(self.function, pointer).0;
        match self.function.expressions[root] {
            Expression::LocalVariable(local) => self.locals.contains(&local),
            Expression::GlobalVariable(global)
                if self.module.global_variables[global].space == AddressSpace::Private =>
            {
                self.privates.contains(&global)
            }
            _ => true,
        }
    }

    /// Whether an argument is a pointer to something that is needed.
    fn is_needed_pointer(&self, argument: Handle<Expression>) -> bool {
        let root = constant_steps(self.function, argument).0;
        match self.function.expressions[root] {
            Expression::LocalVariable(local) => self.locals.contains(&local),
            Expression::GlobalVariable(global) => {
                self.module.global_variables[global].space == AddressSpace::Private
                    && self.privates.contains(&global)
            }
            Expression::FunctionArgument(index) => matches!(
                self.module.types[self.function.arguments[index as usize].ty].inner,
                naga::TypeInner::Pointer { .. } | naga::TypeInner::ValuePointer { .. }
            ),
            _ => false,
        }
    }
}

/// Leaves a function with what is needed.
fn rewrite(
    function: &mut Function,
    needed: &BTreeSet<Handle<Expression>>,
    statements: &BTreeSet<StatementId>,
) {
    let before = std::mem::take(&mut function.expressions);
    let mut after: Arena<Expression> = Arena::new();
    let mut moved: FxHashMap<Handle<Expression>, Handle<Expression>> = FxHashMap::default();
    for (handle, expression) in before.iter() {
        if !needed.contains(&handle) {
            continue;
        }
        let mut expression = expression.clone();
        visit::operands_mut(&mut expression, &mut |operand| *operand = moved[operand]);
        moved.insert(handle, after.append(expression, before.get_span(handle)));
    }
    function.expressions = after;
    for (_, local) in function.local_variables.iter_mut() {
        local.init = local.init.map(|init| moved[&init]);
    }
    function.named_expressions = std::mem::take(&mut function.named_expressions)
        .into_iter()
        .filter_map(|(handle, name)| Some((*moved.get(&handle)?, name)))
        .collect();
    let expressions = &function.expressions;
    let body = std::mem::take(&mut function.body);
    function.body = rebuild(&body, &mut |id, mut statement, span, block| {
        if let Statement::Emit(range) = statement {
            let mut left = range.filter_map(|handle| moved.get(&handle).copied());
            let Some(first) = left.next() else { return };
            let last = left.last().unwrap_or(first);
            let range = first.index() as u32..last.index() as u32 + 1;
            let emit = Statement::Emit(Range::from_index_range(range, expressions));
            block.push(emit, span);
            return;
        }
        if !statements.contains(&id) {
            return;
        }
        // an atomic's or a call's result that nobody uses stays: its statement gives it
        visit::statement_operands_mut(&mut statement, &mut |operand| *operand = moved[operand]);
        block.push(statement, span);
    });
}
