//! `atomicExchange` at the invocation's own place: what was there is read, another value is stored.
//!
//! A pass that draws up what others have scattered, and clears it for the next frame, does so. If nobody else can touch the place,
//! it is a target that the invocation also reads at its own pixel, and is treated as one.
//!
//! *Refuses*: shaders whose invocations work together, a place that is not one-to-one with the invocation, a place in a loop, and
//! places a known number apart where that number may lead to another invocation's: who comes first would decide.

use naga::BinaryOperator;

use super::{Planner, addresses::is_one_to_one};
use crate::{
    analysis::{
        Access, AccessKind, Address, AtomicKind,
        tangent::Tangent,
        term::{Step, Term, TermId, integer},
    },
    finding::{Code, Finding},
    options::Policy,
};

/// A sum of terms with factors, and a number.
#[derive(Default)]
struct Sum {
    terms: Vec<(TermId, i64)>,
    number: i64,
}

impl Planner<'_> {
    /// Says whether an exchange can stand for a load and a store of the invocation's own place.
    pub(super) fn check_exchange(&mut self, index: usize) {
        let access = self.access(index);
        let (span, global) = (access.span, access.target.global);
        let name = self.name(global);
        if let Some(why) = self.why_not_own(index) {
            self.say(
                Finding::new(
                    Code::Atomic,
                    format!("`atomicExchange` on `{name}` cannot stand for the pixels that do not run: {why}"),
                )
                .at(span, "runs once for each primary")
                .help("exchange at the invocation's own place alone, or move it to an entry point of its own"),
            );
            return;
        }
        let what = match self.policy(global) {
            Policy::Leader => {
                format!("`{name}` is taken from by each primary; duplicates keep what they had")
            }
            _ => format!(
                "`{name}` is taken from by each pixel; what its duplicates had is replaced unread"
            ),
        };
        self.say(
            Finding::new(Code::SharedState, what)
                .at(
                    span,
                    "reads what an earlier dispatch left here, and replaces it",
                )
                .help("what others have scattered over a block is seen at its primary alone"),
        );
    }

    /// Why the place of an exchange may be another invocation's.
    fn why_not_own(&mut self, index: usize) -> Option<&'static str> {
        // the parts between barriers may run twice, once for the workgroup and once for the pixels
        if !self.found.ties.is_empty() {
            return Some("the invocations of a workgroup work together");
        }
        let access = self.access(index);
        if !access.loops.is_empty() {
            return Some("it stands in a loop");
        }
        let Some(tangents) = self.tangents_of(index) else {
            return Some("its place does not move as the ids do");
        };
        if !is_one_to_one(&tangents) {
            return Some("several invocations exchange at one place");
        }
        let global = self.access(index).target.global;
        let others: Vec<usize> = (0..self.found.accesses.len())
            .filter(|&other| other != index && self.access(other).target.global == global)
            .collect();
        for other in others {
            let access = self.access(other);
            if let AccessKind::Atomic { function, .. } = access.kind
                && function != AtomicKind::Exchange
            {
                return Some("other atomics of this shader may change the place first");
            }
            if access.kind.writes() && self.may_be_anothers(index, other, &tangents) {
                return Some(
                    "the shader writes near it, and that may be another invocation's place",
                );
            }
        }
        None
    }

    /// How the parts of an access's address move with the pixel, if all of them do.
    pub(super) fn tangents_of(&mut self, index: usize) -> Option<Vec<Tangent>> {
        let terms = self.access(index).address.terms();
        terms
            .into_iter()
            .map(|term| self.tangents.of(&mut self.found.terms, &mut self.on, term))
            .map(|tangent| tangent.filter(Tangent::is_pixel_only))
            .collect()
    }

    /// Whether two places are a known number apart that another invocation's place may be, too.
    fn may_be_anothers(&mut self, a: usize, b: usize, tangents: &[Tangent]) -> bool {
        let (Some(a), Some(b)) = (steps(self.access(a)), steps(self.access(b))) else {
            return true; // a texel's neighbour
        };
        if a.len() != b.len() {
            return false; // one is a part of the other's place, or lies in another member
        }
        let mut dynamic = 0;
        for (a, b) in a.into_iter().zip(b) {
            match (a, b) {
                (Step::Index(a), Step::Index(b)) if a != b => return false,
                (Step::Dynamic(a), Step::Dynamic(b)) => {
                    let apart = self.apart(a, b);
                    let [x, y, _] = tangents[dynamic].pixel;
                    dynamic += 1;
                    let stride = match (x.symbol, y.symbol) {
                        (None, None) => gcd(x.constant, y.constant),
                        (None, Some(_)) => x.constant.abs(),
                        (Some(_), None) => y.constant.abs(),
                        (Some(_), Some(_)) => 1,
                    };
                    match apart {
                        Some(0) | None => {}
                        Some(number) if stride > 1 && number % stride != 0 => return false,
                        Some(_) => return true,
                    }
                }
                (Step::Index(_), Step::Index(_)) => {}
                _ => return true,
            }
        }
        false
    }

    /// The number by which two terms differ, if they differ by a number.
    fn apart(&self, a: TermId, b: TermId) -> Option<i64> {
        let mut sum = Sum::default();
        self.gather(a, 1, &mut sum);
        self.gather(b, -1, &mut sum);
        let is_known = sum.terms.iter().all(|&(_, factor)| factor == 0);
        is_known.then_some(sum.number)
    }

    fn gather(&self, term: TermId, factor: i64, sum: &mut Sum) {
        let terms = &self.found.terms;
        if let Some(number) = integer(terms.as_literal(term)) {
            sum.number = sum.number.wrapping_add(number.wrapping_mul(factor));
            return;
        }
        match *terms.get(term) {
            Term::Binary(BinaryOperator::Add, left, right) => {
                self.gather(left, factor, sum);
                self.gather(right, factor, sum);
            }
            Term::Binary(BinaryOperator::Subtract, left, right) => {
                self.gather(left, factor, sum);
                self.gather(right, -factor, sum);
            }
            Term::As(_, None | Some(4), inner) => self.gather(inner, factor, sum),
            _ => match sum.terms.iter_mut().find(|(known, _)| *known == term) {
                Some((_, known)) => *known += factor,
                None => sum.terms.push((term, factor)),
            },
        }
    }
}

fn steps(access: &Access) -> Option<Vec<Step>> {
    match &access.address {
        Address::Part(steps) => Some(steps.clone()),
        Address::Texel { .. } => None,
    }
}

fn gcd(a: i64, b: i64) -> i64 {
    match b {
        0 => a.abs(),
        _ => gcd(b, a % b),
    }
}
