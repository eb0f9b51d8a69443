//! How what is stored lies against the grid of invocations: at pixels whose neighbours are others.

use super::{CopyPlan, How, Planner};
use crate::{
    analysis::{
        Address,
        depends::Depends,
        term::{Id, Term, TermId, integer},
    },
    finding::{Code, Finding},
};

impl Planner<'_> {
    /// Warns where neighbours in the grid of invocations are no neighbours in a texture: a line of invocations that covers several
    /// rows (as FidelityFX has them), or workgroups that are dealt out over the picture by their numbers.
    pub(super) fn warn_of_scattered(&mut self, copies: &[CopyPlan]) {
        let sides = self.found.group_size;
        let sides = sides.map(|side| integer(self.found.terms.as_literal(side)));
        let is_line = matches!(sides, [Some(2..), Some(1), Some(1)]);
        for copy in copies {
            let access = self.access(copy.access);
            let (span, global) = (access.span, access.target.global);
            let (Address::Texel { coordinate, .. }, How::Recompute(_)) =
                (&access.address, &copy.how)
            else {
                continue;
            };
            let &[_, row, ..] = coordinate.as_slice() else {
                continue;
            };
            let by_group = self.has_id(&[row], |id| matches!(id, Id::Group(0)));
            let depends = self.on.of(&mut self.found.terms, row);
            if !depends.contains(Depends::X) || !(is_line || by_group) {
                continue;
            }
            let name = self.name(global);
            self.say(
                Finding::new(
                    Code::Scattered,
                    format!("neighbours of the dispatch are no neighbours in `{name}`, so a block that shares a rate is no block of the picture"),
                )
                .at(span, "the row changes along x of the dispatch")
                .help(match is_line {
                    true => "give the workgroup two sides, such as 8 x 8, and find the pixel by `global_invocation_id.xy`; else give rates by invocation, not by pixel",
                    false => "find the pixel by `global_invocation_id.xy`; else give rates by invocation, not by pixel",
                }),
            );
            return;
        }
    }

    /// Whether an id of some kind has a part in terms, what is not followed included.
    fn has_id(&self, terms: &[TermId], is: impl Fn(Id) -> bool) -> bool {
        self.found.terms.is_any_below(terms, |term| match *term {
            Term::Id(id) => is(id),
            Term::LoopVar { .. } | Term::LoopExit { .. } => true,
            _ => false,
        })
    }
}
