//! The symbolic walk: runs an entry point once, through every call, without values.
//!
//! *Does*: follows each statement in order; both branches of each `if`; each loop's body once, with its variables
//! standing for any iteration. Notes every access to memory that the shader writes, and every barrier, workgroup
//! variable and subgroup operation.
//! *Needs*: a valid module.
//! *Guarantees*: every statement of every function on a path to an effect is met exactly once for each path of calls,
//! so that [statement numbers](crate::ir::statements) agree with those of a rebuild.
//! *Refuses*: nothing; past [`MAX_INSTANCES`] paths of calls it stops and says so.

use std::collections::BTreeSet;

use naga::{
    Block, Expression, Function, Handle, LocalVariable, Module, Range, Span, Statement, SwitchCase,
    SwitchValue, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use super::{
    Access, AccessKind, Address, Call, ConditionSite, FunctionRef, Instance, InstanceId, Scope,
    Target, Tie, TieSite,
    env::{Changes, Env, Variable, changed},
    evaluate::{Root, Value},
    facts::{Effects, Facts},
    guard::{self, Formula},
    statement_span,
    term::{Id, Loop, LoopId, LoopVariable, Opacity, Operands, Term, TermId, Terms},
};
use crate::ir::statements::{Numbering, StatementId};

/// More paths of calls than this are not followed.
pub const MAX_INSTANCES: usize = 4096;

/// Calls of functions heavier than this, in expressions, are not followed for their result.
const MAX_FOLLOWED_WEIGHT: usize = 1500;

/// What the walk has found.
pub struct Found<'a> {
    /// The value graph.
    pub terms: Terms<'a>,
    /// The original workgroup size.
    pub group_size: [TermId; 3],
    /// The functions on a path to an effect, once for each path; the entry point first.
    pub instances: Vec<Instance>,
    /// Accesses to memory that the shader writes.
    pub accesses: Vec<Access>,
    /// What ties invocations to each other.
    pub ties: Vec<TieSite>,
    /// Where each condition stands.
    pub conditions: Vec<ConditionSite>,
    /// Whether there were more paths of calls than [`MAX_INSTANCES`].
    pub truncated: bool,
}

/// The walk's state.
pub(super) struct Walk<'a> {
    pub(super) module: &'a Module,
    info: &'a ModuleInfo,
    entry: usize,
    pub(super) facts: &'a Facts,
    pub(super) terms: Terms<'a>,
    pub(super) env: Env,
    guards: Vec<Formula>,
    targets: Vec<BreakTarget>,
    instances: Vec<Instance>,
    accesses: Vec<Access>,
    ties: Vec<TieSite>,
    conditions: Vec<ConditionSite>,
    frames: u32,
    truncated: bool,
}

/// One call of a function.
pub(super) struct Frame<'a> {
    pub(super) id: u32,
    pub(super) of: FunctionRef,
    pub(super) function: &'a Function,
    pub(super) info: &'a FunctionInfo,
    pub(super) arguments: Vec<Value>,
    pub(super) values: Vec<Option<Value>>,
    instance: Option<InstanceId>,
    numbering: Numbering,
    statement: StatementId,
    scope: Vec<Range<Expression>>,
    guard_base: usize,
    target_base: usize,
    env_base: usize,
    returns: Vec<Exit>,
}

/// A way out of a loop, a switch case or a function.
struct Exit {
    /// What variables hold.
    changes: Changes,
    /// The conditions since the start.
    guards: Vec<Formula>,
    /// What is returned.
    value: Option<TermId>,
    /// Whether it lies inside a loop that started since.
    in_loop: bool,
}

/// What `break` leaves.
struct BreakTarget {
    is_loop: Option<LoopId>,
    guard_base: usize,
    env_base: usize,
    breaks: Vec<Exit>,
    continues: Vec<Exit>,
}

/// How a block ended.
struct Outcome {
    /// Whether control can reach its end.
    falls: bool,
    /// What then holds.
    passed: Vec<Formula>,
}

/// Walks entry point number `entry`.
pub fn walk<'a>(
    module: &'a Module,
    info: &'a ModuleInfo,
    facts: &'a Facts,
    entry: usize,
) -> Found<'a> {
    let mut walk = Walk {
        module,
        info,
        entry,
        facts,
        terms: Terms::new(module),
        env: Env::default(),
        guards: Vec::new(),
        targets: Vec::new(),
        instances: Vec::new(),
        accesses: Vec::new(),
        ties: Vec::new(),
        conditions: Vec::new(),
        frames: 0,
        truncated: false,
    };
    let group_size = walk.group_size();
    let arguments = walk.entry_arguments(group_size);
    walk.instances.push(Instance {
        function: FunctionRef::Entry,
        caller: None,
        calls: Vec::new(),
        values: Vec::new(),
    });
    walk.run(FunctionRef::Entry, arguments, Some(InstanceId::ENTRY));
    Found {
        terms: walk.terms,
        group_size,
        instances: walk.instances,
        accesses: walk.accesses,
        ties: walk.ties,
        conditions: walk.conditions,
        truncated: walk.truncated,
    }
}

impl<'a> Walk<'a> {
    fn group_size(&mut self) -> [TermId; 3] {
        let entry = &self.module.entry_points[self.entry];
        let overrides = entry.workgroup_size_overrides.unwrap_or_default();
        std::array::from_fn(|axis| match overrides[axis] {
            Some(size) => {
                let size = self.terms.global_expression(size);
                self.terms.unsigned(size)
            }
            None => self
                .terms
                .literal(naga::Literal::U32(entry.workgroup_size[axis])),
        })
    }

    fn entry_arguments(&mut self, group_size: [TermId; 3]) -> Vec<Value> {
        let function = &self.module.entry_points[self.entry].function;
        let mut arguments = Vec::with_capacity(function.arguments.len());
        for argument in &function.arguments {
            let term = match (&argument.binding, &self.module.types[argument.ty].inner) {
                (Some(binding), _) => self.builtin(binding, group_size),
                (None, TypeInner::Struct { members, .. }) => {
                    let parts = members
                        .iter()
                        .map(|member| match &member.binding {
                            Some(binding) => self.builtin(binding, group_size),
                            None => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
                        })
                        .collect();
                    self.terms
                        .compose(super::term::Composite::Type(argument.ty), parts)
                }
                _ => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
            };
            arguments.push(Value::Term(term));
        }
        arguments
    }

    fn builtin(&mut self, binding: &naga::Binding, group_size: [TermId; 3]) -> TermId {
        use naga::BuiltIn as B;
        let scalar = naga::Scalar::U32;
        let mut vector = |id: &dyn Fn(u8) -> Id| {
            let parts = (0..3)
                .map(|axis| self.terms.intern(Term::Id(id(axis))))
                .collect();
            self.terms.vector(scalar, parts)
        };
        match binding.to_built_in() {
            Some(B::GlobalInvocationId) => vector(&Id::Global),
            Some(B::LocalInvocationId) => vector(&Id::Local),
            Some(B::WorkGroupId) => vector(&Id::Group),
            Some(B::NumWorkGroups) => vector(&Id::GroupCount),
            Some(B::LocalInvocationIndex) => self.terms.intern(Term::Id(Id::LocalIndex)),
            Some(B::WorkGroupSize) => self.terms.vector(scalar, group_size.to_vec()),
            Some(B::SubgroupId | B::SubgroupSize | B::SubgroupInvocationId | B::NumSubgroups) => {
                self.terms.opaque(Opacity::Subgroup, Vec::new())
            }
            _ => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    /// Runs a function; its result, if it has one.
    fn run(
        &mut self,
        of: FunctionRef,
        arguments: Vec<Value>,
        instance: Option<InstanceId>,
    ) -> Option<TermId> {
        let (function, info) = match of {
            FunctionRef::Entry => (
                &self.module.entry_points[self.entry].function,
                self.info.get_entry_point(self.entry),
            ),
            FunctionRef::Function(handle) => (&self.module.functions[handle], &self.info[handle]),
        };
        self.frames += 1;
        let mut frame = Frame {
            id: self.frames,
            of,
            function,
            info,
            arguments,
            values: vec![None; function.expressions.len()],
            instance,
            numbering: Numbering::default(),
            statement: StatementId(0),
            scope: Vec::new(),
            guard_base: self.guards.len(),
            target_base: self.targets.len(),
            env_base: self.env.mark(),
            returns: Vec::new(),
        };
        // a variable that a pointer may lead to must exist before a callee sees it
        for (local, _) in function.local_variables.iter() {
            let variable = Variable::Local {
                frame: frame.id,
                local,
            };
            self.variable(&mut frame, variable);
        }
        if of == FunctionRef::Entry {
            let privates = self.facts.entry.reads.union(&self.facts.entry.writes);
            for &global in privates {
                self.variable(&mut frame, Variable::Private(global));
            }
        }
        let outcome = self.block(&mut frame, &function.body);
        if outcome.falls {
            self.leave_function(&mut frame, None);
        }
        self.guards.truncate(frame.guard_base);
        if let Some(instance) = instance {
            self.instances[instance.0 as usize].values = frame
                .values
                .iter()
                .map(|value| match value {
                    Some(Value::Term(term)) => Some(*term),
                    _ => None,
                })
                .collect();
        }
        self.join_returns(&frame)
    }

    /// Makes the state after a call what the returns left, and gives the result.
    fn join_returns(&mut self, frame: &Frame<'a>) -> Option<TermId> {
        self.env.rewind(frame.env_base);
        let own = |variable: &Variable| matches!(variable, Variable::Local { frame: of, .. } if *of == frame.id);
        let exits = &frame.returns;
        let last = exits.last()?;
        let gated = exits.iter().all(|exit| !exit.in_loop);
        let conditions: Vec<TermId> = if gated {
            exits
                .iter()
                .map(|exit| guard::all(&exit.guards, &mut self.terms))
                .collect()
        } else {
            conditions_of(exits)
        };
        let join = |terms: &mut Terms, values: Vec<TermId>| {
            if !gated {
                return terms.merge(values, conditions.clone());
            }
            let mut values = values.into_iter().zip(&conditions).rev();
            let Some((mut joined, _)) = values.next() else {
                unreachable!("a function with a result returns");
            };
            for (value, &condition) in values {
                joined = terms.select(condition, value, joined);
            }
            joined
        };
        let mut after = Changes::new();
        for variable in changed(exits.iter().map(|exit| exit.changes.as_slice())) {
            if own(&variable) {
                continue;
            }
            let values: Option<Vec<_>> = exits
                .iter()
                .map(|exit| self.env.after(&exit.changes, variable))
                .collect();
            if let Some(values) = values {
                after.push((variable, join(&mut self.terms, values)));
            }
        }
        self.env.apply(&after);
        last.value?;
        let values: Vec<_> = exits.iter().filter_map(|exit| exit.value).collect();
        Some(join(&mut self.terms, values))
    }

    fn leave_function(&mut self, frame: &mut Frame<'a>, value: Option<TermId>) {
        frame.returns.push(Exit {
            changes: self.env.changes_since(frame.env_base),
            guards: self.guards[frame.guard_base..].to_vec(),
            value,
            in_loop: self.targets[frame.target_base..]
                .iter()
                .any(|target| target.is_loop.is_some()),
        });
    }

    fn block(&mut self, frame: &mut Frame<'a>, block: &'a Block) -> Outcome {
        let guards = self.guards.len();
        let scope = frame.scope.len();
        let mut falls = true;
        let mut statements = block.span_iter();
        for (statement, &span) in statements.by_ref() {
            frame.statement = frame.numbering.enter();
            if !self.statement(frame, statement, span) {
                falls = false;
                break;
            }
        }
        // what stands behind a `return` is never reached, but it has numbers
        for (statement, _) in statements {
            frame.numbering.enter();
            crate::ir::visit::sub_blocks(statement, &mut |inner| frame.numbering.skip(inner));
        }
        frame.scope.truncate(scope);
        let passed = self.guards.split_off(guards);
        Outcome { falls, passed }
    }

    /// Walks a statement; whether control can go on behind it.
    fn statement(&mut self, frame: &mut Frame<'a>, statement: &'a Statement, span: Span) -> bool {
        match *statement {
            Statement::Emit(ref range) => {
                for handle in range.clone() {
                    self.value(frame, handle);
                }
                frame.scope.push(range.clone());
            }
            Statement::Block(ref block) => {
                let outcome = self.block(frame, block);
                self.guards.extend(outcome.passed);
                return outcome.falls;
            }
            Statement::If {
                condition,
                ref accept,
                ref reject,
            } => {
                let span = self.condition_span(frame, condition, span);
                let condition = self.term(frame, condition);
                self.note_condition(condition, span);
                return self.branch(frame, condition, accept, reject);
            }
            Statement::Switch {
                selector,
                ref cases,
            } => {
                let span = self.condition_span(frame, selector, span);
                let selector = self.term(frame, selector);
                return self.switch(frame, selector, cases, span);
            }
            Statement::Loop {
                ref body,
                ref continuing,
                break_if,
            } => return self.iterate(frame, body, continuing, break_if),
            Statement::Break => {
                self.leave(|target| Some(&mut target.breaks));
                return false;
            }
            Statement::Continue => {
                self.leave(|target| target.is_loop.map(|_| &mut target.continues));
                return false;
            }
            Statement::Return { value } => {
                let value = value.map(|value| self.term(frame, value));
                self.leave_function(frame, value);
                return false;
            }
            Statement::Kill => return false,
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                self.note_tie(frame, Tie::Barrier, span);
            }
            Statement::Store { pointer, value } => {
                self.store(frame, statement, pointer, value, span)
            }
            Statement::ImageStore {
                image,
                coordinate,
                array_index,
                value,
            } => {
                let span = statement_span(frame.function, statement, span);
                if let Some(target) = self.written_texture(frame, image) {
                    let address = self.texel(frame, coordinate, array_index);
                    self.note_access(frame, AccessKind::Store { value }, target, address, span);
                }
            }
            Statement::Atomic {
                pointer, result, ..
            } => {
                let span = statement_span(frame.function, statement, span);
                let place = self.place(frame, pointer);
                match place.root {
                    Root::WorkGroup(global) => self.note_tie(frame, Tie::WorkGroup(global), span),
                    Root::Memory(global) => {
                        let target = Target {
                            global,
                            element: Vec::new(),
                        };
                        let address = Address::Part(place.steps.clone());
                        let kind = AccessKind::Atomic {
                            used: result.is_some_and(|result| is_used(frame.function, result)),
                        };
                        self.note_access(frame, kind, target, address, span);
                    }
                    _ => {}
                }
                self.give(frame, result, Opacity::Atomic);
            }
            Statement::ImageAtomic {
                image,
                coordinate,
                array_index,
                ..
            } => {
                let span = statement_span(frame.function, statement, span);
                if let Some(target) = self.written_texture(frame, image) {
                    let address = self.texel(frame, coordinate, array_index);
                    let kind = AccessKind::Atomic { used: false };
                    self.note_access(frame, kind, target, address, span);
                }
            }
            Statement::WorkGroupUniformLoad { result, .. } => {
                self.note_tie(frame, Tie::Barrier, span);
                self.give(frame, Some(result), Opacity::WorkGroup);
            }
            Statement::Call {
                function,
                ref arguments,
                result,
            } => self.call(frame, function, arguments, result),
            Statement::RayQuery { ref fun, .. } => {
                if let naga::RayQueryFunction::Proceed { result } = *fun {
                    self.give(frame, Some(result), Opacity::RayQuery);
                }
            }
            Statement::RayPipelineFunction(_) => {}
            Statement::SubgroupBallot { result, .. } => {
                self.note_tie(frame, Tie::Subgroup("subgroupBallot"), span);
                self.give(frame, Some(result), Opacity::Subgroup);
            }
            Statement::SubgroupGather {
                ref mode, result, ..
            } => {
                self.note_tie(frame, Tie::Subgroup(gather_name(mode)), span);
                self.give(frame, Some(result), Opacity::Subgroup);
            }
            Statement::SubgroupCollectiveOperation {
                op,
                collective_op,
                result,
                ..
            } => {
                self.note_tie(
                    frame,
                    Tie::Subgroup(collective_name(op, collective_op)),
                    span,
                );
                self.give(frame, Some(result), Opacity::Subgroup);
            }
            Statement::CooperativeStore { .. } => {
                self.note_tie(frame, Tie::Subgroup("coopStore"), span);
            }
        }
        true
    }

    /// Sets the result of a statement that gives a value of its own.
    fn give(&mut self, frame: &mut Frame<'a>, result: Option<Handle<Expression>>, why: Opacity) {
        let Some(result) = result else { return };
        let value = self.terms.opaque(why, Vec::new());
        self.set_result(frame, result, value);
    }

    fn set_result(&mut self, frame: &mut Frame<'a>, result: Handle<Expression>, value: TermId) {
        frame.values[result.index()] = Some(Value::Term(value));
        frame.scope.push(Range::new_from_bounds(result, result));
    }

    fn store(
        &mut self,
        frame: &mut Frame<'a>,
        statement: &Statement,
        pointer: Handle<Expression>,
        value: Handle<Expression>,
        span: Span,
    ) {
        let place = self.place(frame, pointer);
        match place.root {
            Root::Variable(variable) => {
                let value = self.term(frame, value);
                let whole = self.variable(frame, variable);
                let whole = self.with_part(whole, &place.steps, value);
                self.env.set(variable, whole);
            }
            Root::Memory(global) => {
                let target = Target {
                    global,
                    element: Vec::new(),
                };
                let address = Address::Part(place.steps.clone());
                let span = statement_span(frame.function, statement, span);
                self.note_access(frame, AccessKind::Store { value }, target, address, span);
            }
            Root::WorkGroup(global) => self.note_tie(frame, Tie::WorkGroup(global), span),
            Root::Unfollowed => {}
        }
    }

    /// Joins two branches.
    fn branch(
        &mut self,
        frame: &mut Frame<'a>,
        condition: TermId,
        accept: &'a Block,
        reject: &'a Block,
    ) -> bool {
        let (accepted, accept_changes) = self.guarded(frame, Formula::Is(condition, true), accept);
        let (rejected, reject_changes) = self.guarded(frame, Formula::Is(condition, false), reject);
        match (accepted.falls, rejected.falls) {
            (true, true) => {
                self.env
                    .join(&mut self.terms, condition, &accept_changes, &reject_changes);
                // unless something returned on the way, both ways lead here and nothing is known
                if accepted.passed.len() > 1 || rejected.passed.len() > 1 {
                    self.guards.push(Formula::Any(vec![
                        Formula::All(accepted.passed),
                        Formula::All(rejected.passed),
                    ]));
                }
                true
            }
            (true, false) => {
                self.env.apply(&accept_changes);
                self.guards.extend(accepted.passed);
                true
            }
            (false, true) => {
                self.env.apply(&reject_changes);
                self.guards.extend(rejected.passed);
                true
            }
            (false, false) => false,
        }
    }

    /// Walks a block under a condition, and takes its changes off. What it passed starts with the condition.
    fn guarded(
        &mut self,
        frame: &mut Frame<'a>,
        guard: Formula,
        block: &'a Block,
    ) -> (Outcome, Changes) {
        let mark = self.env.mark();
        self.guards.push(guard.clone());
        let mut outcome = self.block(frame, block);
        self.guards.pop();
        outcome.passed.insert(0, guard);
        (outcome, self.env.rewind(mark))
    }

    fn switch(
        &mut self,
        frame: &mut Frame<'a>,
        selector: TermId,
        cases: &'a [SwitchCase],
        span: Span,
    ) -> bool {
        // the condition of each case; the default's is that no other holds
        let mut chosen = Vec::with_capacity(cases.len());
        let mut shared = Vec::new();
        for case in cases {
            let condition = match case.value {
                SwitchValue::I32(value) => Some(naga::Literal::I32(value)),
                SwitchValue::U32(value) => Some(naga::Literal::U32(value)),
                SwitchValue::Default => None,
            };
            let condition = condition.map(|value| {
                let value = self.terms.literal(value);
                self.terms.binary(
                    naga::BinaryOperator::Equal,
                    Operands::Integers,
                    selector,
                    value,
                )
            });
            if let Some(condition) = condition {
                self.note_condition(condition, span);
            }
            // `case 1, 2: {..}` is an empty case 1 that falls into case 2
            shared.push(condition);
            if case.fall_through && case.body.is_empty() {
                chosen.push(None);
            } else {
                chosen.push(Some(std::mem::take(&mut shared)));
            }
        }
        let all: Vec<TermId> = chosen
            .iter()
            .flatten()
            .flatten()
            .flatten()
            .copied()
            .collect();
        let formula = |shared: &[Option<TermId>]| {
            let others = || {
                let mine: Vec<TermId> = shared.iter().flatten().copied().collect();
                all.iter()
                    .filter(|condition| !mine.contains(condition))
                    .map(|&condition| Formula::Is(condition, false))
                    .collect()
            };
            match shared {
                [Some(only)] => Formula::Is(*only, true),
                shared if shared.contains(&None) => Formula::All(others()),
                shared => Formula::Any(
                    shared
                        .iter()
                        .flatten()
                        .map(|&condition| Formula::Is(condition, true))
                        .collect(),
                ),
            }
        };
        let mark = self.env.mark();
        let mut exits: Vec<(Formula, Exit)> = Vec::new();
        let mut fallen: Option<Changes> = None;
        for (case, shared) in cases.iter().zip(&chosen) {
            let Some(shared) = shared else {
                frame.numbering.skip(&case.body);
                continue;
            };
            let formula = formula(shared);
            self.targets.push(BreakTarget {
                is_loop: None,
                guard_base: self.guards.len(),
                env_base: mark,
                breaks: Vec::new(),
                continues: Vec::new(),
            });
            if let Some(changes) = fallen.take() {
                // two ways into this case, which cannot be told apart
                let conditions: Vec<_> = all.clone();
                for (variable, value) in changes {
                    if let Some(base) = self.env.get(variable) {
                        let merged = self.terms.merge(vec![value, base], conditions.clone());
                        self.env.set(variable, merged);
                    }
                }
            }
            self.guards.push(formula.clone());
            let outcome = self.block(frame, &case.body);
            self.guards.pop();
            let Some(target) = self.targets.pop() else {
                unreachable!("the switch's own target");
            };
            if outcome.falls {
                let changes = self.env.changes_since(mark);
                if case.fall_through {
                    fallen = Some(changes);
                } else {
                    let mut guards = vec![formula.clone()];
                    guards.extend(outcome.passed);
                    exits.push((
                        formula.clone(),
                        Exit {
                            changes,
                            guards,
                            value: None,
                            in_loop: false,
                        },
                    ));
                }
            }
            exits.extend(
                target
                    .breaks
                    .into_iter()
                    .map(|exit| (formula.clone(), exit)),
            );
            self.env.rewind(mark);
        }
        // if every case goes on without a condition of its own, nothing is known behind the switch
        let whole = |formula: &Formula| {
            exits
                .iter()
                .any(|(of, exit)| of == formula && exit.guards.len() == 1)
        };
        let exhaustive = chosen
            .iter()
            .flatten()
            .all(|shared| whole(&formula(shared)));
        self.join_switch(exits, exhaustive)
    }

    /// Joins the ways out of a switch, as a chain of selects where each is taken under its own conditions.
    /// `exhaustive`: whether every case leads here whatever else holds.
    fn join_switch(&mut self, exits: Vec<(Formula, Exit)>, exhaustive: bool) -> bool {
        if exits.is_empty() {
            return false;
        }
        let conditions: Vec<TermId> = exits
            .iter()
            .map(|(_, exit)| guard::all(&exit.guards, &mut self.terms))
            .collect();
        for variable in changed(exits.iter().map(|(_, exit)| exit.changes.as_slice())) {
            let mut joined = None;
            for ((_, exit), &condition) in exits.iter().zip(&conditions).rev() {
                let value = self.env.after(&exit.changes, variable);
                joined = match (value, joined) {
                    (Some(value), Some(rest)) => Some(self.terms.select(condition, value, rest)),
                    (Some(value), None) => Some(value),
                    (None, rest) => rest,
                };
            }
            if let Some(joined) = joined {
                self.env.set(variable, joined);
            }
        }
        if !exhaustive {
            let ways = exits
                .into_iter()
                .map(|(_, exit)| Formula::All(exit.guards))
                .collect();
            self.guards.push(Formula::Any(ways));
        }
        true
    }

    fn iterate(
        &mut self,
        frame: &mut Frame<'a>,
        body: &'a Block,
        continuing: &'a Block,
        break_if: Option<Handle<Expression>>,
    ) -> bool {
        let mut changing = BTreeSet::new();
        self.find_stored(frame, body, &mut changing);
        self.find_stored(frame, continuing, &mut changing);
        let changing: Vec<Variable> = changing.into_iter().collect();

        let of = LoopId(self.terms.loops.len() as u32);
        let mut variables = Vec::with_capacity(changing.len());
        for &variable in &changing {
            let before = self.variable(frame, variable);
            variables.push(LoopVariable {
                before,
                next: None,
                after: Vec::new(),
            });
        }
        self.terms.loops.push(Loop {
            variables,
            conditions: Vec::new(),
        });

        let mark = self.env.mark();
        for (number, &variable) in changing.iter().enumerate() {
            let value = self.terms.intern(Term::LoopVar {
                of,
                var: number as u32,
                part: Box::new([]),
            });
            self.env.set(variable, value);
        }
        let inside = self.env.mark();
        let guard_base = self.guards.len();
        self.targets.push(BreakTarget {
            is_loop: Some(of),
            guard_base,
            env_base: inside,
            breaks: Vec::new(),
            continues: Vec::new(),
        });
        let outcome = self.block(frame, body);
        let mut continues = self
            .targets
            .last_mut()
            .map(|target| std::mem::take(&mut target.continues))
            .unwrap_or_default();
        if outcome.falls {
            continues.push(Exit {
                changes: self.env.changes_since(inside),
                guards: outcome.passed,
                value: None,
                in_loop: false,
            });
        }
        self.env.rewind(inside);
        if continues.is_empty() {
            frame.numbering.skip(continuing);
        } else {
            self.merge_exits(&continues);
            self.block(frame, continuing);
            if let Some(condition) = break_if {
                let span = self.condition_span(frame, condition, Span::UNDEFINED);
                let condition = self.term(frame, condition);
                self.note_condition(condition, span);
                self.guards.push(Formula::Is(condition, true));
                self.leave(|target| Some(&mut target.breaks));
                self.guards.pop();
            }
            for (number, &variable) in changing.iter().enumerate() {
                let next = self.env.get(variable);
                self.terms.loops[of.0 as usize].variables[number].next = next;
            }
        }
        let Some(target) = self.targets.pop() else {
            unreachable!("the loop's own target");
        };
        self.env.rewind(inside);
        let conditions = conditions_of(&target.breaks);
        self.terms.loops[of.0 as usize].conditions = conditions;
        let mut after = Changes::new();
        for (number, &variable) in changing.iter().enumerate() {
            let values: Vec<_> = target
                .breaks
                .iter()
                .filter_map(|exit| self.env.after(&exit.changes, variable))
                .collect();
            let of_variable = &mut self.terms.loops[of.0 as usize].variables[number];
            of_variable.after = values;
            let unchanged = of_variable.after.iter().all(|&v| v == of_variable.before);
            let value = match unchanged {
                true => of_variable.before,
                false => self.terms.intern(Term::LoopExit {
                    of,
                    var: number as u32,
                    part: Box::new([]),
                }),
            };
            after.push((variable, value));
        }
        self.env.rewind(mark);
        self.env.apply(&after);
        !target.breaks.is_empty()
    }

    /// Makes the state that of one of several exits.
    fn merge_exits(&mut self, exits: &[Exit]) {
        let conditions = conditions_of(exits);
        for variable in changed(exits.iter().map(|exit| exit.changes.as_slice())) {
            let values: Option<Vec<_>> = exits
                .iter()
                .map(|exit| self.env.after(&exit.changes, variable))
                .collect();
            if let Some(values) = values {
                let merged = self.terms.merge(values, conditions.clone());
                self.env.set(variable, merged);
            }
        }
    }

    /// Leaves the innermost target for which `way` has a list.
    fn leave(&mut self, way: impl Fn(&mut BreakTarget) -> Option<&mut Vec<Exit>>) {
        for target in self.targets.iter_mut().rev() {
            let (guard_base, env_base) = (target.guard_base, target.env_base);
            if let Some(exits) = way(target) {
                exits.push(Exit {
                    changes: self.env.changes_since(env_base),
                    guards: self.guards[guard_base..].to_vec(),
                    value: None,
                    in_loop: false,
                });
                return;
            }
        }
    }

    /// The variables that a block may store to.
    fn find_stored(
        &mut self,
        frame: &mut Frame<'a>,
        block: &'a Block,
        into: &mut BTreeSet<Variable>,
    ) {
        let mut pointers = Vec::new();
        let mut calls = Vec::new();
        crate::ir::visit::statements(block, &mut |statement| match *statement {
            Statement::Store { pointer, .. } => pointers.push(pointer),
            Statement::Call {
                function,
                ref arguments,
                ..
            } => {
                calls.push(function);
                pointers.extend(arguments.iter().copied());
            }
            _ => {}
        });
        for function in calls {
            let writes = &self.facts.function(function).writes;
            into.extend(writes.iter().map(|&global| Variable::Private(global)));
        }
        for pointer in pointers {
            let (root, _) = super::facts::constant_steps(frame.function, pointer);
            let is_root = matches!(
                frame.function.expressions[root],
                Expression::LocalVariable(_)
                    | Expression::GlobalVariable(_)
                    | Expression::FunctionArgument(_)
            );
            if is_root
                && let Value::Place(place) = self.value(frame, root)
                && let Root::Variable(variable) = place.root
            {
                into.insert(variable);
            }
        }
    }

    fn call(
        &mut self,
        frame: &mut Frame<'a>,
        function: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) {
        let facts = self.facts.function(function);
        let arguments: Vec<Value> = arguments.iter().map(|&a| self.value(frame, a)).collect();
        let has_pointers = arguments.iter().any(|a| matches!(a, Value::Place(_)));
        let value = if facts.is_in_place() {
            self.call_in_place(frame, function, arguments)
        } else if facts.effects.contains(Effects::RAY_QUERY) {
            self.clobber(function, &arguments, Opacity::RayQuery)
        } else if has_pointers || !facts.writes.is_empty() || !facts.reads.is_empty() {
            if facts.weight <= MAX_FOLLOWED_WEIGHT {
                self.run(FunctionRef::Function(function), arguments, None)
            } else {
                self.clobber(function, &arguments, Opacity::Effect)
            }
        } else {
            self.call_pure(function, arguments)
        };
        if let (Some(result), Some(value)) = (result, value) {
            self.set_result(frame, result, value);
        }
    }

    /// A function with effects: followed as if it stood here, as an instance of its own.
    fn call_in_place(
        &mut self,
        frame: &mut Frame<'a>,
        function: Handle<Function>,
        arguments: Vec<Value>,
    ) -> Option<TermId> {
        if self.instances.len() >= MAX_INSTANCES {
            self.truncated = true;
            return self.clobber(function, &arguments, Opacity::Effect);
        }
        let callee = InstanceId(self.instances.len() as u32);
        self.instances.push(Instance {
            function: FunctionRef::Function(function),
            caller: frame.instance.map(|caller| (caller, frame.statement)),
            calls: Vec::new(),
            values: Vec::new(),
        });
        let scope = self.scope(frame);
        if let Some(caller) = frame.instance {
            self.instances[caller.0 as usize].calls.push(Call {
                statement: frame.statement,
                callee,
                scope,
            });
        }
        self.run(FunctionRef::Function(function), arguments, Some(callee))
    }

    /// A pure function: its result is a term of its own, and what its body comes to is kept beside it.
    fn call_pure(&mut self, function: Handle<Function>, arguments: Vec<Value>) -> Option<TermId> {
        let result = self.module.functions[function].result.as_ref()?;
        let terms = arguments
            .iter()
            .map(|argument| match argument {
                Value::Term(term) => *term,
                Value::Place(_) => unreachable!("pure functions have no pointers"),
            })
            .collect();
        let call = self.terms.intern(Term::Call(function, terms));
        if !self.terms.expansions.contains_key(&call)
            && self.facts.function(function).weight <= MAX_FOLLOWED_WEIGHT
            && holds_followed(self.module, result.ty)
            && let Some(expansion) = self.run(FunctionRef::Function(function), arguments, None)
        {
            self.terms.expansions.insert(call, expansion);
        }
        Some(call)
    }

    /// A function that is not followed: all that it may write becomes unknown.
    fn clobber(
        &mut self,
        function: Handle<Function>,
        arguments: &[Value],
        why: Opacity,
    ) -> Option<TermId> {
        let facts = self.facts.function(function);
        let mut operands = Vec::new();
        let mut written: Vec<Variable> =
            facts.writes.iter().map(|&g| Variable::Private(g)).collect();
        for argument in arguments {
            match argument {
                Value::Term(term) => operands.push(*term),
                Value::Place(place) => {
                    if let Root::Variable(variable) = place.root {
                        written.push(variable);
                        operands.extend(self.env.get(variable));
                    }
                }
            }
        }
        for &global in &facts.reads {
            operands.extend(self.env.get(Variable::Private(global)));
        }
        for variable in written {
            let unknown = self.terms.opaque(why, operands.clone());
            self.env.set(variable, unknown);
        }
        self.module.functions[function].result.as_ref()?;
        Some(self.terms.opaque(why, operands))
    }

    fn scope(&self, frame: &Frame<'a>) -> Scope {
        let locals = frame
            .function
            .local_variables
            .iter()
            .filter_map(|(local, _): (Handle<LocalVariable>, _)| {
                let variable = Variable::Local {
                    frame: frame.id,
                    local,
                };
                self.env.get(variable).map(|value| (local, value))
            })
            .collect();
        Scope {
            expressions: frame.scope.clone(),
            locals,
        }
    }

    pub(super) fn note_access(
        &mut self,
        frame: &Frame<'a>,
        kind: AccessKind,
        target: Target,
        address: Address,
        span: Span,
    ) {
        // only functions on a path to an effect are followed as instances, and only they have accesses
        let Some(instance) = frame.instance else {
            return;
        };
        let scope = self.scope(frame);
        self.accesses.push(Access {
            instance,
            statement: frame.statement,
            kind,
            target,
            address,
            guards: self.guards.clone(),
            loops: self.targets.iter().filter_map(|t| t.is_loop).collect(),
            scope,
            span,
        });
    }

    pub(super) fn note_tie(&mut self, frame: &Frame<'a>, tie: Tie, span: Span) {
        let Some(instance) = frame.instance else {
            return;
        };
        self.ties.push(TieSite {
            tie,
            instance,
            statement: frame.statement,
            span,
        });
    }

    fn note_condition(&mut self, condition: TermId, span: Span) {
        if span.is_defined() {
            self.conditions.push(ConditionSite { condition, span });
        }
    }

    /// Where a condition stands: the expression, or the statement where a load of a local has no span of its own.
    fn condition_span(
        &self,
        frame: &Frame<'a>,
        condition: Handle<Expression>,
        statement: Span,
    ) -> Span {
        let span = frame.function.expressions.get_span(condition);
        if span.is_defined() { span } else { statement }
    }
}

/// Everything that has a say in which exit is taken.
fn conditions_of(exits: &[Exit]) -> Vec<TermId> {
    let mut conditions = Vec::new();
    for exit in exits {
        for guard in &exit.guards {
            guard.conditions(&mut |condition| {
                if !conditions.contains(&condition) {
                    conditions.push(condition);
                }
            });
        }
    }
    conditions
}

/// Whether a type holds integers or booleans, of which addresses and conditions are made.
fn holds_followed(module: &Module, ty: Handle<naga::Type>) -> bool {
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => {
            super::term::followed(scalar)
        }
        TypeInner::Array { base, .. } => holds_followed(module, base),
        TypeInner::Struct { ref members, .. } => members
            .iter()
            .any(|member| holds_followed(module, member.ty)),
        _ => false,
    }
}

/// Whether anything in a function uses the result of an atomic.
fn is_used(function: &Function, result: Handle<Expression>) -> bool {
    let mut used = false;
    for (_, expression) in function.expressions.iter() {
        crate::ir::visit::operands(expression, &mut |&operand| used |= operand == result);
    }
    crate::ir::visit::statements(&function.body, &mut |statement| {
        let gives = matches!(statement, Statement::Atomic { result: Some(r), .. } if *r == result);
        if !gives {
            crate::ir::visit::statement_operands(statement, &mut |&operand| {
                used |= operand == result;
            });
        }
    });
    used
}

fn gather_name(mode: &naga::GatherMode) -> &'static str {
    use naga::GatherMode as G;
    match mode {
        G::BroadcastFirst => "subgroupBroadcastFirst",
        G::Broadcast(_) => "subgroupBroadcast",
        G::Shuffle(_) => "subgroupShuffle",
        G::ShuffleDown(_) => "subgroupShuffleDown",
        G::ShuffleUp(_) => "subgroupShuffleUp",
        G::ShuffleXor(_) => "subgroupShuffleXor",
        G::QuadBroadcast(_) => "quadBroadcast",
        G::QuadSwap(naga::Direction::X) => "quadSwapX",
        G::QuadSwap(naga::Direction::Y) => "quadSwapY",
        G::QuadSwap(naga::Direction::Diagonal) => "quadSwapDiagonal",
    }
}

fn collective_name(
    op: naga::SubgroupOperation,
    collective: naga::CollectiveOperation,
) -> &'static str {
    use naga::{CollectiveOperation as C, SubgroupOperation as S};
    match (op, collective) {
        (S::All, _) => "subgroupAll",
        (S::Any, _) => "subgroupAny",
        (S::Add, C::Reduce) => "subgroupAdd",
        (S::Add, C::InclusiveScan) => "subgroupInclusiveAdd",
        (S::Add, C::ExclusiveScan) => "subgroupExclusiveAdd",
        (S::Mul, C::Reduce) => "subgroupMul",
        (S::Mul, C::InclusiveScan) => "subgroupInclusiveMul",
        (S::Mul, C::ExclusiveScan) => "subgroupExclusiveMul",
        (S::Max, _) => "subgroupMax",
        (S::Min, _) => "subgroupMin",
        (S::And, _) => "subgroupAnd",
        (S::Or, _) => "subgroupOr",
        (S::Xor, _) => "subgroupXor",
    }
}
