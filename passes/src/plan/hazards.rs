//! What makes invocations depend on each other: barriers, workgroup memory, subgroups, atomics, reads of what others
//! write. Under variable-rate execution most invocations do not run, and those that do share subgroups with others than
//! before.

use super::Planner;
use crate::{
    analysis::{Access, AccessKind, Address, Tie, term::Step},
    finding::{Code, Finding},
};

impl Planner<'_> {
    /// Says what stands in the way of any rewrite.
    pub(super) fn check_hazards(&mut self) {
        if self.found.truncated {
            self.say(
                Finding::new(
                    Code::TooManyPaths,
                    "there are too many paths of calls to this shader's stores",
                )
                .help("return the value from the helper functions and store it in the entry point"),
            );
        }
        self.check_ties();
        for index in 0..self.found.accesses.len() {
            match self.access(index).kind {
                AccessKind::Atomic { .. } => self.refuse_atomic(index),
                AccessKind::Load => self.check_read(index),
                AccessKind::Store { .. } => {}
            }
        }
    }

    fn check_ties(&mut self) {
        let ties: Vec<_> = self.found.ties.iter().map(|t| (t.tie, t.span)).collect();
        for (tie, span) in ties {
            match tie {
                // the regions between the barriers say what can be done
                Tie::Barrier | Tie::WorkGroup(_) => {}
                Tie::Subgroup(operation) => self.say(
                    Finding::new(
                        Code::SubgroupOperation,
                        format!("the result of `{operation}` depends on which invocations share a subgroup"),
                    )
                    .at(span, "other pixels share a subgroup when only primaries run")
                    .help("use workgroup memory, or leave this entry point as it is"),
                ),
            }
        }
    }

    fn refuse_atomic(&mut self, index: usize) {
        let access = self.access(index);
        let (span, name) = (access.span, self.name(access.target.global));
        self.say(
            Finding::new(
                Code::Atomic,
                format!("an atomic on `{name}` would count primaries instead of pixels"),
            )
            .at(span, "runs once for each primary"),
        );
    }

    /// A read of memory that the shader writes is safe if it is a read of the invocation's own place.
    fn check_read(&mut self, index: usize) {
        let read = self.access(index);
        let own =
            self.found.accesses.iter().any(|store| {
                matches!(store.kind, AccessKind::Store { .. }) && same_place(read, store)
            });
        let (span, name) = (read.span, self.name(read.target.global));
        if own {
            self.say(
                Finding::new(
                    Code::SharedState,
                    format!("`{name}` is read and written by each pixel; its duplicates take their primary's value"),
                )
                .at(span, "reads what an earlier dispatch, or this invocation, left here")
                .help(
                    "frames that accumulate here look blocky while an area stays coarse: rotate the primaries, \
                     or keep such areas at full rate",
                ),
            );
            return;
        }
        let store = self
            .found
            .accesses
            .iter()
            .find(|store| {
                matches!(
                    store.kind,
                    AccessKind::Store { .. } | AccessKind::Atomic { .. }
                ) && store.target.global == read.target.global
            })
            .map(|store| store.span);
        let mut finding = Finding::new(
            Code::ReadsOthersOutput,
            format!("`{name}` is read at another place than this invocation's own, while others write it"),
        )
        .at(span, "reads another invocation's output");
        if let Some(store) = store {
            finding = finding.at(store, "the invocation's own place");
        }
        self.say(finding.help(
            "read from a second resource that this dispatch does not write, as a ping-pong pair does",
        ));
    }
}

/// Whether a read and a store go to the same place, or one to a part of the other's.
fn same_place(read: &Access, store: &Access) -> bool {
    if read.target != store.target {
        return false;
    }
    match (&read.address, &store.address) {
        (Address::Part(a), Address::Part(b)) => {
            let shared = a.len().min(b.len());
            let computed = |steps: &[Step]| steps.iter().any(|s| matches!(s, Step::Dynamic(_)));
            a[..shared] == b[..shared] && !computed(&a[shared..]) && !computed(&b[shared..])
        }
        (a, b) => a == b,
    }
}
