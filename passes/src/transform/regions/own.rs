//! The per-pixel part: a copy of what it needs, region by region, with the primary's ids.

use std::collections::BTreeSet;

use naga::{Block, Expression, Function, Handle, Module, Span, Statement};

use super::{Split, count, is_place};
use crate::{
    ir::{build::Code, visit},
    plan::regions::skeleton::RegionId,
};

impl Split<'_> {
    /// The values that live from one per-pixel region into another.
    pub(super) fn crossing(&self, body: &Block) -> BTreeSet<Handle<Expression>> {
        let mut crossing = BTreeSet::new();
        let mut number = 0;
        visit::statements(body, &mut |statement| {
            if let Some(region) = self.regions.skeleton.nodes[number].region {
                self.each_operand(number as u32, statement, &mut |operand| {
                    self.cross(operand, region, &mut crossing);
                });
            }
            number += 1;
        });
        crossing
    }

    /// Calls `visit` with the operands of a statement of the per-pixel part, and of what it emits.
    fn each_operand(
        &self,
        number: u32,
        statement: &Statement,
        visit: &mut dyn FnMut(Handle<Expression>),
    ) {
        if let Statement::Emit(range) = statement {
            for handle in range.clone().filter(|h| self.own().expressions.contains(h)) {
                visit::operands(&self.before[handle], &mut |&operand| visit(operand));
            }
        } else if self.own().statements.contains(&number) {
            visit::statement_operands(statement, &mut |&operand| visit(operand));
        }
    }

    /// Notes what an operand needs from other regions.
    fn cross(
        &self,
        operand: Handle<Expression>,
        region: RegionId,
        into: &mut BTreeSet<Handle<Expression>>,
    ) {
        if is_place(&self.before, operand) {
            visit::operands(&self.before[operand], &mut |&inner| {
                self.cross(inner, region, into)
            });
            return;
        }
        if self
            .regions
            .skeleton
            .home
            .get(&operand)
            .is_some_and(|&home| home != region)
        {
            into.insert(operand);
        }
    }

    /// Writes the per-pixel part of a region.
    pub(super) fn own_region(
        &mut self,
        module: &mut Module,
        function: &mut Function,
        region: RegionId,
        run: &[(u32, &Statement, Span)],
        out: &mut Block,
    ) {
        let is_needed = |number: u32, statement: &Statement| match statement {
            Statement::Emit(range) => {
                let mut emitted = range.clone();
                emitted.any(|h| self.own().expressions.contains(&h) && !is_place(&self.before, h))
            }
            _ => self.own().statements.contains(&number),
        };
        let Some(&(_, _, span)) = run.iter().find(|&&(n, s, _)| is_needed(n, s)) else {
            return;
        };
        self.values.clear();
        let crossing = self.crossing_into(region, run);
        let mut code = Code::new(&mut module.types, function, span);
        let on = code.global(self.prelude.on);
        let is_last = self.regions.skeleton.regions[region].is_last;
        code.when(on, |code| {
            for swapped in &self.swapped {
                let real = code.global(swapped.variable);
                code.push(Statement::Store {
                    pointer: swapped.room,
                    value: real,
                });
                let own = code.global(swapped.own);
                code.set_global(swapped.variable, own);
            }
            for handle in crossing {
                let value = code.load(self.kept[&handle]);
                self.values.insert(handle, value);
            }
            for &(number, statement, span) in run {
                self.own_statement(code, number, statement, span);
            }
            if !is_last {
                for swapped in &self.swapped {
                    let own = code.global(swapped.variable);
                    code.set_global(swapped.own, own);
                    let real = code.load(swapped.room);
                    code.set_global(swapped.variable, real);
                }
            }
        });
        out.append(&mut code.finish());
        self.keep_names(function);
    }

    fn crossing_into(
        &self,
        region: RegionId,
        run: &[(u32, &Statement, Span)],
    ) -> BTreeSet<Handle<Expression>> {
        let mut crossing = BTreeSet::new();
        for &(number, statement, _) in run {
            let mut next = number;
            let mut each = |statement: &Statement| {
                self.each_operand(next, statement, &mut |operand| {
                    self.cross(operand, region, &mut crossing);
                });
                next += 1;
            };
            each(statement);
            visit::sub_blocks(statement, &mut |block| visit::statements(block, &mut each));
        }
        crossing
    }

    /// The author's names for what was copied.
    fn keep_names(&self, function: &mut Function) {
        for (before, &after) in &self.values {
            let is_load = self.kept.contains_key(before)
                && matches!(function.expressions[after], Expression::Load { .. });
            if let Some(name) = function.named_expressions.get(before).cloned()
                && !function.expressions[after].needs_pre_emit()
                && !is_load
            {
                function.named_expressions.insert(after, name);
            }
        }
    }

    fn own_block(&mut self, code: &mut Code, block: &Block, next: &mut u32) -> Block {
        code.nested(|code| {
            for (statement, &span) in block.span_iter() {
                self.own_statement(code, *next, statement, span);
                *next += count(statement);
            }
        })
    }

    fn own_statement(&mut self, code: &mut Code, number: u32, statement: &Statement, span: Span) {
        if let Statement::Emit(range) = statement {
            code.set_span(span);
            for handle in range.clone() {
                self.own_expression(code, handle);
            }
            return;
        }
        if !self.own().statements.contains(&number) {
            return;
        }
        code.set_span(span);
        let mut next = number + 1;
        let copy = match statement {
            Statement::Block(block) => Statement::Block(self.own_block(code, block, &mut next)),
            Statement::If {
                condition,
                accept,
                reject,
            } => Statement::If {
                condition: self.operand(code, *condition),
                accept: self.own_block(code, accept, &mut next),
                reject: self.own_block(code, reject, &mut next),
            },
            Statement::Switch { selector, cases } => Statement::Switch {
                selector: self.operand(code, *selector),
                cases: cases
                    .iter()
                    .map(|case| naga::SwitchCase {
                        value: case.value,
                        body: self.own_block(code, &case.body, &mut next),
                        fall_through: case.fall_through,
                    })
                    .collect(),
            },
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let body = self.own_block(code, body, &mut next);
                let continuing = self.own_block(code, continuing, &mut next);
                Statement::Loop {
                    body,
                    continuing,
                    break_if: break_if.map(|condition| self.operand(code, condition)),
                }
            }
            simple => self.own_simple(code, simple),
        };
        code.set_span(span);
        code.push(copy);
        let mut given = Vec::new();
        visit::statement_operands(statement, &mut |&operand| {
            let gives = self.regions.skeleton.giver.get(&operand) == Some(&number);
            if gives {
                given.push(operand);
            }
        });
        for handle in given {
            self.keep(code, handle);
        }
    }

    /// A statement without blocks, on the primary's values; results are new ones.
    fn own_simple(&mut self, code: &mut Code, statement: &Statement) -> Statement {
        let mut operands = Vec::new();
        visit::statement_operands(statement, &mut |&operand| operands.push(operand));
        let mut mapped = Vec::with_capacity(operands.len());
        for operand in operands {
            let own = match self.is_given_by(operand, statement) {
                true => {
                    let own = code.add(self.before[operand].clone());
                    self.values.insert(operand, own);
                    own
                }
                false => self.operand(code, operand),
            };
            mapped.push(own);
        }
        let mut copy = statement.clone();
        let mut mapped = mapped.into_iter();
        visit::statement_operands_mut(&mut copy, &mut |slot| {
            if let Some(own) = mapped.next() {
                *slot = own;
            }
        });
        copy
    }

    fn is_given_by(&self, operand: Handle<Expression>, statement: &Statement) -> bool {
        match *statement {
            Statement::Call { result, .. } | Statement::Atomic { result, .. } => {
                result == Some(operand)
            }
            Statement::RayQuery {
                fun: naga::RayQueryFunction::Proceed { result },
                ..
            } => result == operand,
            _ => false,
        }
    }

    /// Computes the per-pixel part's value of an expression that is emitted here.
    fn own_expression(&mut self, code: &mut Code, handle: Handle<Expression>) {
        // a place is written where it is used
        if !self.own().expressions.contains(&handle) || is_place(&self.before, handle) {
            return;
        }
        let own = self.copied(code, handle);
        self.values.insert(handle, own);
        self.keep(code, handle);
    }

    fn copied(&self, code: &mut Code, handle: Handle<Expression>) -> Handle<Expression> {
        let mut copy = self.before[handle].clone();
        let mut operands = Vec::new();
        visit::operands(&copy, &mut |&operand| operands.push(operand));
        let mut mapped = Vec::with_capacity(operands.len());
        for operand in operands {
            mapped.push(self.operand(code, operand));
        }
        let mut mapped = mapped.into_iter();
        visit::operands_mut(&mut copy, &mut |slot| {
            if let Some(own) = mapped.next() {
                *slot = own;
            }
        });
        code.add(copy)
    }

    /// Keeps a value for later regions.
    fn keep(&self, code: &mut Code, handle: Handle<Expression>) {
        if let (Some(&pointer), Some(&value)) = (self.kept.get(&handle), self.values.get(&handle)) {
            code.push(Statement::Store { pointer, value });
        }
    }

    /// The per-pixel part's value of an operand.
    fn operand(&self, code: &mut Code, handle: Handle<Expression>) -> Handle<Expression> {
        if let Some(&own) = self.values.get(&handle) {
            return own;
        }
        match self.before[handle] {
            Expression::FunctionArgument(index) => self.arguments[index as usize],
            Expression::LocalVariable(local) => self.local(code, local),
            Expression::Access { .. } | Expression::AccessIndex { .. } => self.copied(code, handle),
            // the same for both parts: constants, other variables, and what the skeleton gives
            _ => handle,
        }
    }
}
