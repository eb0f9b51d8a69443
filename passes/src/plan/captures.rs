//! What a copy needs of the primary: values that do not depend on the ids and cannot be, or need not be, computed
//! again.
//!
//! A loop's counter has the same value for a primary and its duplicates while both are in the same iteration, but only
//! the primary knows it: it is captured. So is a uniform that the shader has at hand already.

use naga::{Expression, Handle, LocalVariable, Span};
use rustc_hash::FxHashSet;

use super::Planner;
use crate::{
    analysis::{
        InstanceId, Scope,
        term::{Opacity, Term, TermId},
    },
    ir::statements::StatementId,
};

/// A value of the primary, and where it is at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// The value.
    pub term: TermId,
    /// Where it is.
    pub source: CaptureSource,
}

/// Where a captured value is at hand.
#[derive(Clone, Debug, PartialEq)]
pub enum CaptureSource {
    /// An expression that can be named at the store.
    Expression(Handle<Expression>),
    /// A local variable that holds it at the store.
    Local(Handle<LocalVariable>),
    /// It is at hand at a call on the way to the store.
    Caller {
        /// The function that calls.
        instance: InstanceId,
        /// The call.
        statement: StatementId,
        /// Where it is there.
        source: Box<CaptureSource>,
    },
}

/// Why a term cannot be computed for a duplicate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blocked {
    /// The part of the term that stops it.
    pub(super) term: TermId,
    /// Why, for the author.
    pub(super) why: &'static str,
}

impl Planner<'_> {
    /// Finds what computing `terms` for a duplicate takes, at a place in the shader.
    pub(super) fn captures(
        &mut self,
        terms: &[TermId],
        instance: InstanceId,
        scope: &Scope,
    ) -> Result<Vec<Capture>, Blocked> {
        let mut gather = Gather {
            here: Some((instance, scope)),
            captures: Vec::new(),
            seen: FxHashSet::default(),
        };
        for &term in terms {
            gather.need(self, term)?;
        }
        Ok(gather.captures)
    }

    /// Whether a term can be computed from the ids alone, before the shader has run.
    pub(super) fn is_computable_up_front(&mut self, term: TermId) -> bool {
        let mut gather = Gather {
            here: None,
            captures: Vec::new(),
            seen: FxHashSet::default(),
        };
        gather.need(self, term).is_ok()
    }

    /// Where a value is at hand.
    fn find(&self, term: TermId, instance: InstanceId, scope: &Scope) -> Option<CaptureSource> {
        let of = &self.found.instances[instance.0 as usize];
        let function = of.function.get(self.module, self.entry);
        let has = |handle: Handle<Expression>| of.values[handle.index()] == Some(term);
        let emitted = scope
            .expressions
            .iter()
            .flat_map(Clone::clone)
            .find(|&h| has(h));
        let argument = || {
            function
                .expressions
                .iter()
                .find(|&(h, e)| matches!(e, Expression::FunctionArgument(_)) && has(h))
                .map(|(h, _)| h)
        };
        if let Some(handle) = emitted.or_else(argument) {
            return Some(CaptureSource::Expression(handle));
        }
        if let Some(&(local, _)) = scope.locals.iter().find(|&&(_, value)| value == term) {
            return Some(CaptureSource::Local(local));
        }
        let (caller, statement) = of.caller?;
        let call = self.found.instances[caller.0 as usize]
            .calls
            .iter()
            .find(|call| call.callee == instance)?;
        match self.find(term, caller, &call.scope)? {
            further_up @ CaptureSource::Caller { .. } => Some(further_up),
            source => Some(CaptureSource::Caller {
                instance: caller,
                statement,
                source: Box::new(source),
            }),
        }
    }

    /// The span of what stops a term from being computed.
    pub(super) fn blocked_span(&self, blocked: &Blocked) -> Span {
        self.span_of(blocked.term)
    }
}

struct Gather<'s> {
    /// Where captures can be taken; nowhere before the shader has run.
    here: Option<(InstanceId, &'s Scope)>,
    captures: Vec<Capture>,
    seen: FxHashSet<TermId>,
}

impl Gather<'_> {
    fn need(&mut self, planner: &mut Planner, term: TermId) -> Result<(), Blocked> {
        if !self.seen.insert(term) {
            return Ok(());
        }
        let blocked = |why| Err(Blocked { term, why });
        match planner.found.terms.get(term) {
            Term::Literal(_) | Term::Constant(_) | Term::Override(_) | Term::Zero(_) => {
                return Ok(());
            }
            _ => {}
        }
        if let Some((instance, scope)) = self.here
            && planner.on.of(&mut planner.found.terms, term).is_empty()
            && let Some(source) = planner.find(term, instance, scope)
        {
            self.captures.push(Capture { term, source });
            return Ok(());
        }
        match planner.found.terms.get(term) {
            Term::Opaque { why, .. } => match why {
                Opacity::Written(_) => {
                    return blocked("it is read from memory that the shader writes");
                }
                Opacity::Atomic => return blocked("an atomic gave it"),
                Opacity::WorkGroup => return blocked("it is read from workgroup memory"),
                Opacity::Subgroup => return blocked("a subgroup operation gave it"),
                Opacity::RayQuery => return blocked("a ray query gave it"),
                Opacity::Effect => return blocked("a function with effects of its own gave it"),
                Opacity::Beyond => {
                    return blocked("an index lies beyond the end of what it indexes");
                }
                Opacity::Unfollowed => {
                    return blocked("it comes about in a way that is not followed");
                }
            },
            Term::LoopVar { .. } | Term::LoopExit { .. } => {
                return blocked("a loop changes it from iteration to iteration");
            }
            Term::Merge { .. } => return blocked("it depends on how a loop was left"),
            Term::Insert(..) | Term::Update(..) => {
                return blocked("it is an element of an array that is filled at run time");
            }
            _ => {}
        }
        let mut operands = Vec::new();
        planner
            .found
            .terms
            .operands(term, &mut |operand| operands.push(operand));
        for operand in operands {
            self.need(planner, operand)?;
        }
        Ok(())
    }
}
