//! The symbolic walk: runs an entry point once, through every call, without values.
//!
//! *Does*: follows each statement in order; both branches of each `if`; each loop's body once, with its variables
//! standing for any iteration. Notes every access to memory that the shader writes, and every barrier, workgroup
//! variable and subgroup operation.
//! *Needs*: a valid module.
//! *Guarantees*: every statement of every function on a path to an effect is met exactly once for each path of calls,
//! so that [statement numbers](crate::ir::statements) agree with those of a rebuild.
//! *Refuses*: nothing; past [`MAX_INSTANCES`] paths of calls it stops and says so.

mod arguments;
mod calls;
mod control;
mod width;

use naga::{
    Block, Expression, Function, Handle, LocalVariable, Module, Range, Span, Statement,
    valid::{FunctionInfo, ModuleInfo},
};

use super::{
    Access, AccessKind, Address, AtomicKind, ConditionSite, FunctionRef, Instance, InstanceId,
    Scope, Target, Tie, TieSite,
    env::{Changes, Env, Variable},
    evaluate::{Root, Value},
    facts::Facts,
    guard::Formula,
    statement_span,
    term::{LoopId, Opacity, TermId, Terms},
};
use crate::ir::statements::{Numbering, StatementId};
pub use width::Width;

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
    /// The width of the picture, where the dispatch numbers its pixels row by row.
    pub width: Option<TermId>,
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
    pub(super) accesses: Vec<Access>,
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
    width: Option<&Width>,
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
    let entry = &module.entry_points[entry];
    walk.terms.sides = (entry.workgroup_size_overrides.is_none()).then_some(entry.workgroup_size);
    let width = width.map(|width| walk.width(width));
    walk.terms.width = width;
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
        width,
        instances: walk.instances,
        accesses: walk.accesses,
        ties: walk.ties,
        conditions: walk.conditions,
        truncated: walk.truncated,
    }
}

impl<'a> Walk<'a> {
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
            self.drop_dead_loads(&frame, instance);
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
                    // what needs no emission has no term yet
                    self.value(frame, value);
                    self.note_access(frame, AccessKind::Store { value }, target, address, span);
                }
            }
            Statement::Atomic {
                pointer,
                ref fun,
                value,
                result,
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
                            function: self.atomic_kind(frame, fun, value),
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
                fun,
                value,
            } => {
                let span = statement_span(frame.function, statement, span);
                if let Some(target) = self.written_texture(frame, image) {
                    let address = self.texel(frame, coordinate, array_index);
                    let kind = AccessKind::Atomic {
                        used: false,
                        function: self.atomic_kind(frame, &fun, value),
                    };
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

    fn atomic_kind(
        &self,
        frame: &Frame<'a>,
        function: &naga::AtomicFunction,
        value: Handle<Expression>,
    ) -> AtomicKind {
        use naga::AtomicFunction as A;
        let inner = frame.info[value].ty.inner_with(&self.module.types);
        let is_integer = matches!(
            inner.scalar_kind(),
            Some(naga::ScalarKind::Sint | naga::ScalarKind::Uint)
        );
        match function {
            A::Add | A::Subtract if is_integer => AtomicKind::Sum,
            A::Min | A::Max | A::And | A::InclusiveOr if is_integer => AtomicKind::Once,
            A::Add => AtomicKind::Other("atomicAdd"),
            A::Subtract => AtomicKind::Other("atomicSub"),
            A::Min => AtomicKind::Other("atomicMin"),
            A::Max => AtomicKind::Other("atomicMax"),
            A::And => AtomicKind::Other("atomicAnd"),
            A::InclusiveOr => AtomicKind::Other("atomicOr"),
            A::ExclusiveOr => AtomicKind::Other("atomicXor"),
            A::Exchange { compare: None } if is_integer => AtomicKind::Exchange,
            A::Exchange { compare: None } => AtomicKind::Other("atomicExchange"),
            A::Exchange { compare: Some(_) } => AtomicKind::Other("atomicCompareExchangeWeak"),
        }
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
                self.value(frame, value);
                self.note_access(frame, AccessKind::Store { value }, target, address, span);
            }
            Root::WorkGroup(global) => self.note_tie(frame, Tie::WorkGroup(global), span),
            Root::Unfollowed => {}
        }
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

    pub(in crate::analysis) fn note_access(
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

    pub(in crate::analysis) fn note_tie(&mut self, frame: &Frame<'a>, tie: Tie, span: Span) {
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
