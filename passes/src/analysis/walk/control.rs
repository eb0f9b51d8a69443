//! Control flow: branches, switches and loops, and what is known where their ways meet again.

use std::collections::BTreeSet;

use naga::{Block, Expression, Handle, Span, Statement, SwitchCase, SwitchValue};

use super::{BreakTarget, Exit, Frame, Outcome, Walk, conditions_of};
use crate::analysis::{
    env::{Changes, Variable, changed},
    evaluate::{Root, Value},
    facts::{Effects, constant_steps},
    guard::{self, Formula},
    term::{Loop, LoopId, LoopVariable, Operands, Term, TermId},
};

impl<'a> Walk<'a> {
    /// Joins two branches.
    pub(super) fn branch(
        &mut self,
        frame: &mut Frame<'a>,
        condition: TermId,
        accept: &'a Block,
        reject: &'a Block,
    ) -> bool {
        if let Some(naga::Literal::Bool(holds)) = self.terms.as_literal(condition)
            && !self.works_together()
        {
            return self.only_branch(frame, holds, accept, reject);
        }
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

    /// Walks the one branch that a constant leaves, on this path of calls; what the other would do is never done.
    fn only_branch(
        &mut self,
        frame: &mut Frame<'a>,
        holds: bool,
        accept: &'a Block,
        reject: &'a Block,
    ) -> bool {
        if !holds {
            frame.numbering.skip(accept);
        }
        let outcome = self.block(frame, if holds { accept } else { reject });
        if holds {
            frame.numbering.skip(reject);
        }
        self.guards.extend(outcome.passed);
        outcome.falls
    }

    /// Whether invocations work together: what the regions between barriers are made of is looked for everywhere.
    fn works_together(&self) -> bool {
        let ties = Effects::BARRIER | Effects::WORKGROUP | Effects::SUBGROUP;
        self.facts.entry.effects.intersects(ties)
    }

    /// Walks a block under a condition, and takes its changes off. What it passed starts with the condition.
    pub(super) fn guarded(
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

    pub(super) fn switch(
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
    pub(super) fn join_switch(&mut self, exits: Vec<(Formula, Exit)>, exhaustive: bool) -> bool {
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

    pub(super) fn iterate(
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
    pub(super) fn merge_exits(&mut self, exits: &[Exit]) {
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
    pub(super) fn leave(&mut self, way: impl Fn(&mut BreakTarget) -> Option<&mut Vec<Exit>>) {
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
    pub(super) fn find_stored(
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
            let (root, _) = constant_steps(frame.function, pointer);
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
}
