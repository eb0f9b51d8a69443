//! Calls: which functions are followed, and what stands for those that are not.

use naga::{Expression, Function, Handle, Module, TypeInner};

use super::{Exit, Frame, MAX_FOLLOWED_WEIGHT, MAX_INSTANCES, Walk, conditions_of};
use crate::analysis::{
    Call, FunctionRef, Instance, InstanceId,
    env::{Changes, Variable, changed},
    evaluate::{Root, Value},
    facts::Effects,
    guard,
    term::{Opacity, Term, TermId, Terms, followed},
};

impl<'a> Walk<'a> {
    pub(super) fn call(
        &mut self,
        frame: &mut Frame<'a>,
        function: Handle<Function>,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) {
        let facts = self.facts.function(function);
        let arguments: Vec<Value> = arguments.iter().map(|&a| self.value(frame, a)).collect();
        let has_pointers = arguments.iter().any(|a| matches!(a, Value::Place(_)));
        let value = if crate::graded::is_of_group(self.module, function) {
            // it gives what the group has in common, which is no number of the author's
            let unknown = self.terms.opaque(Opacity::Unfollowed, Vec::new());
            Some(unknown)
        } else if facts.is_in_place() {
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
    pub(super) fn call_in_place(
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
    pub(super) fn call_pure(
        &mut self,
        function: Handle<Function>,
        arguments: Vec<Value>,
    ) -> Option<TermId> {
        let result = self.module.functions[function].result.as_ref()?;
        if crate::graded::calls_of_group(self.module, function) {
            // what its group has in common is no number of the author's, whatever is made of it
            let operands = arguments.iter().filter_map(|argument| match argument {
                Value::Term(term) => Some(*term),
                Value::Place(_) => None,
            });
            let operands = operands.collect();
            return Some(self.terms.opaque(Opacity::Unfollowed, operands));
        }
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
    pub(super) fn clobber(
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

    /// Makes the state after a call what the returns left, and gives the result.
    pub(super) fn join_returns(&mut self, frame: &Frame<'a>) -> Option<TermId> {
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

    pub(super) fn leave_function(&mut self, frame: &mut Frame<'a>, value: Option<TermId>) {
        frame.returns.push(Exit {
            changes: self.env.changes_since(frame.env_base),
            guards: self.guards[frame.guard_base..].to_vec(),
            value,
            in_loop: self.targets[frame.target_base..]
                .iter()
                .any(|target| target.is_loop.is_some()),
        });
    }
}

/// Whether a type holds integers or booleans, of which addresses and conditions are made.
fn holds_followed(module: &Module, ty: Handle<naga::Type>) -> bool {
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => followed(scalar),
        TypeInner::Array { base, .. } => holds_followed(module, base),
        TypeInner::Struct { ref members, .. } => members
            .iter()
            .any(|member| holds_followed(module, member.ty)),
        _ => false,
    }
}
