//! The rules of naga's IR that its validator does not check.
//!
//! naga 30 accepts modules that break these, and its back ends then write wrong code, name variables that do not exist, or
//! panic. Everything that this crate makes is checked here before naga sees it:
//!
//! - rule 1: an expression that is computed is emitted before its use, in a block that encloses the use;
//! - rule 2: an expression is emitted at most once in a function (naga: at most once on a path);
//! - rule 4: a result is given by exactly one statement (naga: on a path, and but for calls and atomics by at least one anywhere);
//! - rule 6: a called function stands before its caller (naga's validator panics otherwise);
//! - rule 7: no two resources of the module share a binding, whichever entry points use them (naga: those of one entry point).
//!
//! Two that naga checks, too, because the others cannot be asked without them:
//!
//! - rule 3: what needs no emission (literals, arguments, variables) and results of statements are not emitted;
//! - rule 5: an operand stands before the expression that uses it.
//!
//! [`follows`] checks two more, of a rewritten module against the original:
//!
//! - rule 8: the author's functions, types, constants, overrides, globals and other entry points are what they were;
//! - rule 9: in a clone, the author's statements stand in the same order, each once, with nothing but calls and stores to
//!   private variables of ours between them. What it was made from has conditions that are [settled](crate::transform::settled) as literals.
//!
//! [`barriers`] checks one more, of an entry point with barriers:
//!
//! 10. a barrier stands under the author's own conditions only, and nothing of ours returns before one, but for the test
//!     whether the whole workgroup has nothing to do.
//!
//! *Not checked*: types of operands, control flow, capabilities: naga's validator does that. Whether the author's own
//! conditions are uniform: [`plan::regions`](crate::plan::regions) does that.

use std::fmt;

use naga::{Block, Expression, Function, Handle, Module, Statement};
use rustc_hash::FxHashMap;

use super::visit;

/// A broken rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The rule's number, as the module's documentation lists them.
    pub rule: u8,
    /// The function, or `module`.
    pub within: String,
    /// What is wrong.
    pub what: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rule {} in {}: {}", self.rule, self.within, self.what)
    }
}

/// Checks rules 1 to 7.
///
/// # Errors
/// The first rule that is broken.
pub fn check(module: &Module) -> Result<(), Broken> {
    for (handle, function) in module.functions.iter() {
        let name = function.name.clone().unwrap_or_default();
        check_function(function, &name, Some(handle))?;
    }
    for entry in &module.entry_points {
        check_function(&entry.function, &entry.name, None)?;
    }
    check_bindings(module)
}

fn check_bindings(module: &Module) -> Result<(), Broken> {
    let mut taken = FxHashMap::default();
    for (handle, global) in module.global_variables.iter() {
        let Some(binding) = global.binding else {
            continue;
        };
        if taken.insert(binding, handle).is_some() {
            return Err(Broken {
                rule: 7,
                within: "module".to_owned(),
                what: format!(
                    "binding {} of group {} is taken twice",
                    binding.binding, binding.group
                ),
            });
        }
    }
    Ok(())
}

/// How an expression comes into being.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Always there.
    PreEmitted,
    /// By an `Emit`.
    Emitted,
    /// By the statement that it is the result of.
    Result,
}

fn kind(expression: &Expression) -> Kind {
    match expression {
        e if e.needs_pre_emit() => Kind::PreEmitted,
        Expression::CallResult(_)
        | Expression::AtomicResult { .. }
        | Expression::WorkGroupUniformLoadResult { .. }
        | Expression::RayQueryProceedResult
        | Expression::SubgroupBallotResult
        | Expression::SubgroupOperationResult { .. } => Kind::Result,
        _ => Kind::Emitted,
    }
}

struct FunctionCheck<'f> {
    function: &'f Function,
    name: &'f str,
    handle: Option<Handle<Function>>,
    in_scope: Vec<bool>,
    given: Vec<bool>,
}

fn check_function(
    function: &Function,
    name: &str,
    handle: Option<Handle<Function>>,
) -> Result<(), Broken> {
    let count = function.expressions.len();
    let mut check = FunctionCheck {
        function,
        name,
        handle,
        in_scope: vec![false; count],
        given: vec![false; count],
    };
    for (handle, expression) in function.expressions.iter() {
        let mut late = None;
        visit::operands(expression, &mut |&operand| {
            if operand >= handle {
                late = Some(operand);
            }
        });
        if let Some(operand) = late {
            return Err(check.broken(5, format!("{handle:?} uses {operand:?}, which comes later")));
        }
        if kind(expression) == Kind::PreEmitted {
            check.in_scope[handle.index()] = true;
        }
    }
    check.block(&function.body)
}

impl FunctionCheck<'_> {
    fn broken(&self, rule: u8, what: String) -> Broken {
        Broken {
            rule,
            within: self.name.to_owned(),
            what,
        }
    }

    fn block(&mut self, block: &Block) -> Result<(), Broken> {
        let mut entered: Vec<Handle<Expression>> = Vec::new();
        for statement in block {
            self.statement(statement, &mut entered)?;
        }
        for handle in entered {
            self.in_scope[handle.index()] = false;
        }
        Ok(())
    }

    fn statement(
        &mut self,
        statement: &Statement,
        entered: &mut Vec<Handle<Expression>>,
    ) -> Result<(), Broken> {
        if let Statement::Emit(range) = statement {
            for handle in range.clone() {
                self.emit(handle)?;
                entered.push(handle);
            }
            return Ok(());
        }
        if let Statement::Call { function, .. } = *statement
            && self.handle.is_some_and(|own| function >= own)
        {
            return Err(self.broken(6, format!("{function:?} is called before it is defined")));
        }
        let mut results = Vec::new();
        let mut missing = None;
        // `break if` looks into the loop, whose blocks are checked on their own
        let looks_inside = matches!(statement, Statement::Loop { .. });
        visit::statement_operands(statement, &mut |&operand| {
            let is_given = kind(&self.function.expressions[operand]) == Kind::Result
                && gives(statement, operand);
            if is_given {
                results.push(operand);
            } else if !self.in_scope[operand.index()] && !looks_inside {
                missing = Some(operand);
            }
        });
        if let Some(operand) = missing {
            return Err(self.broken(1, format!("{operand:?} is used where it is not in scope")));
        }
        for result in results {
            if std::mem::replace(&mut self.given[result.index()], true) {
                return Err(self.broken(4, format!("{result:?} is given twice")));
            }
            self.in_scope[result.index()] = true;
            entered.push(result);
        }
        if let Statement::Loop {
            body,
            continuing,
            break_if,
        } = statement
        {
            return self.iterate(body, continuing, *break_if);
        }
        let mut outcome = Ok(());
        visit::sub_blocks(statement, &mut |block| {
            if outcome.is_ok() {
                outcome = self.block(block);
            }
        });
        outcome
    }

    /// What a loop's body emits can be named in its `continuing` block, and both in `break if`.
    fn iterate(
        &mut self,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<(), Broken> {
        let mut entered: Vec<Handle<Expression>> = Vec::new();
        for statement in body.iter().chain(continuing) {
            self.statement(statement, &mut entered)?;
        }
        if let Some(condition) = break_if
            && !self.in_scope[condition.index()]
        {
            return Err(self.broken(1, format!("{condition:?} is used where it is not in scope")));
        }
        for handle in entered {
            self.in_scope[handle.index()] = false;
        }
        Ok(())
    }

    fn emit(&mut self, handle: Handle<Expression>) -> Result<(), Broken> {
        let expression = &self.function.expressions[handle];
        if kind(expression) != Kind::Emitted {
            return Err(self.broken(3, format!("{handle:?} must not be emitted")));
        }
        if std::mem::replace(&mut self.given[handle.index()], true) {
            return Err(self.broken(2, format!("{handle:?} is emitted twice")));
        }
        let mut missing = None;
        visit::operands(expression, &mut |&operand| {
            if !self.in_scope[operand.index()] {
                missing = Some(operand);
            }
        });
        if let Some(operand) = missing {
            return Err(self.broken(
                1,
                format!("{handle:?} uses {operand:?}, which is not in scope"),
            ));
        }
        self.in_scope[handle.index()] = true;
        Ok(())
    }
}

/// Whether a statement gives a result, rather than using it.
fn gives(statement: &Statement, operand: Handle<Expression>) -> bool {
    match *statement {
        Statement::Call { result, .. } | Statement::Atomic { result, .. } => {
            result == Some(operand)
        }
        Statement::WorkGroupUniformLoad { result, .. }
        | Statement::SubgroupBallot { result, .. }
        | Statement::SubgroupGather { result, .. }
        | Statement::SubgroupCollectiveOperation { result, .. } => result == operand,
        Statement::RayQuery { ref fun, .. } => {
            matches!(*fun, naga::RayQueryFunction::Proceed { result } if result == operand)
        }
        _ => false,
    }
}

/// Checks rules 8 and 9 of a rewritten module against the original. `clones` pairs each clone with what it was made
/// from.
///
/// # Errors
/// The first rule that is broken.
pub fn follows(
    original: &Module,
    rewritten: &Module,
    rewritten_entries: &[usize],
    clones: &[(&Function, &Function)],
) -> Result<(), Broken> {
    let broken = |rule, within: &str, what: &str| {
        Err(Broken {
            rule,
            within: within.to_owned(),
            what: what.to_owned(),
        })
    };
    let same = original
        .types
        .iter()
        .zip(rewritten.types.iter())
        .all(|((_, a), (_, b))| a == b)
        && starts_with(original.constants.iter(), rewritten.constants.iter())
        && starts_with(original.overrides.iter(), rewritten.overrides.iter())
        && starts_with(
            original.global_variables.iter(),
            rewritten.global_variables.iter(),
        );
    if !same {
        return broken(8, "module", "a declaration of the author's has changed");
    }
    for ((_, before), (_, after)) in original.functions.iter().zip(rewritten.functions.iter()) {
        if !is_same_function(before, after) {
            let name = before.name.as_deref().unwrap_or_default();
            return broken(8, name, "a function of the author's has changed");
        }
    }
    for (index, (before, after)) in original
        .entry_points
        .iter()
        .zip(&rewritten.entry_points)
        .enumerate()
    {
        let untouched = rewritten_entries.contains(&index)
            || (is_same_function(&before.function, &after.function)
                && before.workgroup_size == after.workgroup_size);
        if !untouched || before.name != after.name || before.stage != after.stage {
            return broken(
                8,
                &before.name,
                "an entry point that was left alone has changed",
            );
        }
    }
    for (before, after) in clones {
        if !(Both { before, after }).keeps_statements(&before.body, &after.body) {
            let name = after.name.as_deref().unwrap_or_default();
            return broken(9, name, "the author's statements have changed");
        }
    }
    Ok(())
}

/// Checks rule 10 of an entry point that was split: `before` is the author's, `split` what it became in `module`, `entry`
/// the new entry point.
///
/// # Errors
/// If the rule is broken.
pub fn barriers(
    before: &Function,
    module: &Module,
    split: Handle<Function>,
    entry: &Function,
) -> Result<(), Broken> {
    let broken = |within: &str, what: &str| {
        Err(Broken {
            rule: 10,
            within: within.to_owned(),
            what: what.to_owned(),
        })
    };
    let function = &module.functions[split];
    let name = function.name.as_deref().unwrap_or_default();
    let is_authors = |condition: Handle<Expression>| condition.index() < before.expressions.len();
    if !are_barriers_under(module, &function.body, true, &is_authors) {
        return broken(name, "a barrier stands under a condition of ours");
    }
    // what stands behind the last barrier may return as it likes
    let early = |body: &Block| -> u32 {
        let last = body.iter().rposition(|s| has_barrier(module, s));
        let before_last = body.iter().take(last.unwrap_or(0));
        before_last.map(count_returns).sum()
    };
    if early(&function.body) > early(&before.body) {
        return broken(name, "a return of ours stands before a barrier");
    }
    if !are_barriers_under(module, &entry.body, true, &|_| false) {
        return broken("the new entry point", "a barrier stands under a condition");
    }
    Ok(())
}

fn count_returns(statement: &Statement) -> u32 {
    let mut count = u32::from(matches!(statement, Statement::Return { .. }));
    for block in blocks(statement) {
        visit::statements(block, &mut |s| {
            count += u32::from(matches!(s, Statement::Return { .. }))
        });
    }
    count
}

/// Whether a statement or what it calls has a barrier.
fn has_barrier(module: &Module, statement: &Statement) -> bool {
    match *statement {
        Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } => true,
        Statement::Call { function, .. } => {
            let callee = &module.functions[function];
            callee.body.iter().any(|s| has_barrier(module, s))
        }
        _ => blocks(statement)
            .iter()
            .any(|block| block.iter().any(|s| has_barrier(module, s))),
    }
}

/// Whether all barriers in a block stand under conditions that `is_allowed` accepts, where what is around is `allowed`.
fn are_barriers_under(
    module: &Module,
    block: &Block,
    allowed: bool,
    is_allowed: &dyn Fn(Handle<Expression>) -> bool,
) -> bool {
    block.iter().all(|statement| {
        if !has_barrier(module, statement) {
            return true;
        }
        let inside = match *statement {
            Statement::If { condition, .. } => allowed && is_allowed(condition),
            Statement::Switch { selector, .. } => allowed && is_allowed(selector),
            Statement::Loop { break_if, .. } => allowed && break_if.is_none_or(is_allowed),
            _ => allowed,
        };
        let blocks = blocks(statement);
        match blocks.is_empty() {
            true => allowed,
            false => blocks
                .into_iter()
                .all(|block| are_barriers_under(module, block, inside, is_allowed)),
        }
    })
}

fn starts_with<'t, T: PartialEq + 't>(
    before: impl Iterator<Item = (Handle<T>, &'t T)>,
    mut after: impl Iterator<Item = (Handle<T>, &'t T)>,
) -> bool {
    before
        .map(|(_, item)| item)
        .all(|item| after.next().is_some_and(|(_, other)| item == other))
}

fn is_same_function(before: &Function, after: &Function) -> bool {
    before.name == after.name
        && before.expressions.len() == after.expressions.len()
        && starts_with(before.expressions.iter(), after.expressions.iter())
        && (Both { before, after }).are_same(&before.body, &after.body)
}

/// A function, and what it has become.
#[derive(Clone, Copy)]
struct Both<'f> {
    before: &'f Function,
    after: &'f Function,
}

impl Both<'_> {
    fn are_same(self, before: &Block, after: &Block) -> bool {
        before.len() == after.len()
            && before.iter().zip(after).all(|(a, b)| {
                self.are_same_alone(a, b)
                    && callee(a) == callee(b)
                    && blocks(a)
                        .into_iter()
                        .zip(blocks(b))
                        .all(|(a, b)| self.are_same(a, b))
            })
    }

    /// Whether `after` holds the statements of `before` in order, with only insertions of ours between them.
    fn keeps_statements(self, before: &Block, after: &Block) -> bool {
        let mut after = after.iter();
        before.iter().all(|statement| {
            after
                .by_ref()
                .find(|other| {
                    self.are_same_but_insertions(statement, other) || !is_insertion(other)
                })
                .is_some_and(|other| self.are_same_but_insertions(statement, other))
        }) && after.all(is_insertion)
    }

    /// Whether two statements are the same but for insertions inside them; a call may go to a clone.
    fn are_same_but_insertions(self, before: &Statement, after: &Statement) -> bool {
        self.are_same_alone(before, after)
            && blocks(before)
                .into_iter()
                .zip(blocks(after))
                .all(|(a, b)| self.keeps_statements(a, b))
    }

    /// Whether two statements are the same apart from the blocks inside them and from what they call.
    fn are_same_alone(self, before: &Statement, after: &Statement) -> bool {
        let operands = |statement: &Statement| {
            let mut operands = Vec::new();
            visit::statement_operands(statement, &mut |&operand| operands.push(operand));
            operands
        };
        let emitted = |statement: &Statement| match statement {
            Statement::Emit(range) => Some(range.index_range()),
            _ => None,
        };
        let cases = |statement: &Statement| match statement {
            Statement::Switch { cases, .. } => {
                cases.iter().map(|c| (c.value, c.fall_through)).collect()
            }
            _ => Vec::new(),
        };
        let (of_before, of_after) = (operands(before), operands(after));
        std::mem::discriminant(before) == std::mem::discriminant(after)
            && of_before.len() == of_after.len()
            && of_before
                .iter()
                .zip(&of_after)
                .all(|(&a, &b)| self.is_same_operand(a, b))
            && emitted(before) == emitted(after)
            && cases(before) == cases(after)
            && blocks(before).len() == blocks(after).len()
    }

    /// Whether two operands are one expression, or the same literal: those that are put in stand elsewhere.
    fn is_same_operand(self, before: Handle<Expression>, after: Handle<Expression>) -> bool {
        let literal = |function: &Function, operand| match function.expressions[operand] {
            Expression::Literal(literal) => Some(literal),
            _ => None,
        };
        let given = literal(self.before, before);
        before == after || given.is_some() && given == literal(self.after, after)
    }
}

/// Insertions are emissions, calls without a result, and stores.
fn is_insertion(statement: &Statement) -> bool {
    matches!(
        statement,
        Statement::Emit(_) | Statement::Call { result: None, .. } | Statement::Store { .. }
    )
}

fn blocks(statement: &Statement) -> Vec<&Block> {
    let mut blocks = Vec::new();
    visit::sub_blocks(statement, &mut |block| blocks.push(block));
    blocks
}

fn callee(statement: &Statement) -> Option<Handle<Function>> {
    match *statement {
        Statement::Call { function, .. } => Some(function),
        _ => None,
    }
}
