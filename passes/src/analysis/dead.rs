//! Loads whose value is dropped: `select(a[i], b[i], true)` reads `a`, and nothing comes of it.
//!
//! A helper that reads one of two buffers by a constant argument loads both. On each path of calls one of them does not count:
//! no value depends on what other invocations left there.
//!
//! *Guarantees*: a load is dropped only if no statement and no other expression can see its value, on this path of calls.

use naga::{Expression, Handle, Literal};

use super::{
    AccessKind, InstanceId,
    evaluate::Value,
    walk::{Frame, Walk},
};
use crate::ir::visit;

impl<'a> Walk<'a> {
    /// Takes out the loads of an instance whose values nothing sees.
    pub(super) fn drop_dead_loads(&mut self, frame: &Frame<'a>, instance: InstanceId) {
        let is_load = |kind: &AccessKind| matches!(kind, AccessKind::Load { .. });
        let mut own = self.accesses.iter().filter(|a| a.instance == instance);
        if !own.any(|access| is_load(&access.kind)) || !self.has_chosen(frame) {
            return;
        }
        let seen = self.seen(frame);
        self.accesses.retain(|access| match access.kind {
            AccessKind::Load { value } if access.instance == instance => seen[value.index()],
            _ => true,
        });
    }

    /// Whether a constant chooses for any `select` of a function on this path of calls.
    fn has_chosen(&self, frame: &Frame<'a>) -> bool {
        let mut expressions = frame.function.expressions.iter();
        expressions.any(|(_, expression)| self.chosen(frame, expression).is_some())
    }

    /// What a `select` gives whose condition is a constant on this path of calls.
    fn chosen(&self, frame: &Frame<'a>, expression: &Expression) -> Option<Handle<Expression>> {
        let Expression::Select {
            condition,
            accept,
            reject,
        } = *expression
        else {
            return None;
        };
        let Some(Value::Term(term)) = frame.values[condition.index()] else {
            return None;
        };
        match self.terms.as_literal(term) {
            Some(Literal::Bool(true)) => Some(accept),
            Some(Literal::Bool(false)) => Some(reject),
            _ => None,
        }
    }

    /// For each expression, whether a statement sees its value.
    fn seen(&self, frame: &Frame<'a>) -> Vec<bool> {
        let function = frame.function;
        let mut seen = vec![false; function.expressions.len()];
        visit::statements(&function.body, &mut |statement| {
            visit::statement_operands(statement, &mut |&operand| seen[operand.index()] = true);
        });
        for (_, local) in function.local_variables.iter() {
            if let Some(init) = local.init {
                seen[init.index()] = true;
            }
        }
        // operands stand before what uses them
        let expressions: Vec<_> = function.expressions.iter().collect();
        for (handle, expression) in expressions.into_iter().rev() {
            if !seen[handle.index()] {
                continue;
            }
            match self.chosen(frame, expression) {
                Some(chosen) => seen[chosen.index()] = true,
                None => visit::operands(expression, &mut |&operand| seen[operand.index()] = true),
            }
        }
        seen
    }
}
