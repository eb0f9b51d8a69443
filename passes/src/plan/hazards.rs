//! What makes invocations depend on each other: barriers, workgroup memory, subgroups, atomics, reads of what others
//! write. Under variable-rate execution most invocations do not run, and those that do share subgroups with others than
//! before.

use naga::Span;

use super::{Planner, addresses::is_one_to_one, apart::Meet, domain::Domain};
use crate::{
    analysis::{Access, AccessKind, Address, AtomicKind, Facts, Tie, term::Step},
    finding::{Code, Finding},
    options::{Atomics, Policy},
};

impl Planner<'_> {
    /// Says what stands in the way of any rewrite.
    pub(super) fn check_hazards(&mut self, domain: &Domain) {
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
                AccessKind::Atomic { used, function } => self.check_atomic(index, used, function),
                AccessKind::Load { .. } => self.check_read(index, domain),
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

    /// Whether the entry point's invocations work together: by barriers, workgroup memory or subgroups.
    pub(super) fn works_together(&self) -> bool {
        !self.found.ties.is_empty()
    }

    /// Holds the options' targets against the shader's, and refuses those that are to be.
    pub(super) fn check_policies(&mut self, facts: &Facts) {
        let is_changed = self.options.linear.is_some()
            || facts
                .written()
                .into_iter()
                .any(|global| self.policy(global) == Policy::Leader)
            || self.options.atomics == Atomics::Weight;
        let tie = self.found.ties.first().map(|tie| tie.span);
        if let (Some(tie), true) = (tie, is_changed) {
            self.say(
                Finding::new(
                    Code::UnfitOption,
                    "atomics, `leader` targets and one-dimensional dispatches are not rewritten where invocations work together",
                )
                .at(tie, "works together with others here")
                .help("leave these options out, and do what they are for in an entry point of its own"),
            );
        }
        for global in facts.written() {
            if self.policy(global) != Policy::Refuse {
                continue;
            }
            let name = self.name(global);
            let store = self
                .found
                .accesses
                .iter()
                .find(|access| access.target.global == global && access.kind.writes());
            let span = store.map_or(Span::UNDEFINED, |store| store.span);
            self.say(
                Finding::new(
                    Code::PolicyRefuses,
                    format!("the entry point stores to `{name}`, whose policy is `refuse`"),
                )
                .at(span, "stores here")
                .help(format!("leave `--target {name}=refuse` out, or move this store to an entry point of its own")),
            );
        }
    }

    fn check_atomic(&mut self, index: usize, used: bool, function: AtomicKind) {
        let access = self.access(index);
        let (span, name) = (access.span, self.name(access.target.global));
        let refusal = |why: String| Finding::new(Code::Atomic, why);
        if function == AtomicKind::Exchange {
            self.check_exchange(index);
            return;
        }
        if let AtomicKind::Other(function) = function {
            self.say(
                refusal(format!(
                    "`{function}` on `{name}` cannot stand for the pixels that do not run"
                ))
                .at(span, "runs once for each primary")
                .help("move it to an entry point of its own"),
            );
        } else if used {
            self.say(
                refusal(format!(
                    "the result of an atomic on `{name}` is used, and pixels that do not run get none"
                ))
                .at(span, "runs once for each primary")
                .help("move what needs the result to an entry point of its own"),
            );
        } else if self.options.atomics == Atomics::Refuse {
            self.say(
                refusal(format!(
                    "an atomic on `{name}` would count primaries instead of pixels"
                ))
                .at(span, "runs once for each primary")
                .help(match self.works_together() {
                    true => "count in an entry point of its own, in a dispatch before or behind this one",
                    false => "`--atomics weight` has each primary count for all its pixels",
                }),
            );
        }
    }

    /// A read of memory that the shader writes is safe if it is a read of the invocation's own place.
    fn check_read(&mut self, index: usize, domain: &Domain) {
        let read = self.access(index);
        let (global, accesses) = (read.target.global, &self.found.accesses);
        let writes: Vec<usize> = (0..accesses.len())
            .filter(|&other| accesses[other].target.global == global)
            .filter(|&other| accesses[other].kind.writes())
            .collect();
        let is_same =
            |&store: &usize| accesses[store].kind.replaces() && same_place(read, &accesses[store]);
        let (span, name) = (read.span, self.name(global));
        let (same, others): (Vec<usize>, Vec<usize>) =
            writes.iter().partition(|store| is_same(store));
        let is_shared = same.iter().any(|&store| self.is_shared(store));
        let meet = match self.meet_any(index, &others, domain) {
            Meet::Perhaps if self.options.apart.contains(&name) => {
                if self.refuse_word(index, &others) {
                    return;
                }
                Meet::Never
            }
            meet => meet,
        };
        let own = match meet {
            Meet::Never if same.is_empty() => return, // nobody stores there
            Meet::Never | Meet::Own => !is_shared,
            Meet::Perhaps => false,
        };
        if own && self.policy(global) == Policy::Leader {
            self.say(
                Finding::new(
                    Code::SharedState,
                    format!("`{name}` is read and written by each primary; duplicates keep what they had"),
                )
                .at(span, "reads what an earlier dispatch, or this invocation, left here")
                .help("a pixel goes on from where it stopped when it is a primary again"),
            );
            return;
        }
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
                ) && store.target.global == global
            })
            .map(|store| store.span);
        let mut finding = Finding::new(
            Code::ReadsOthersOutput,
            match is_shared {
                true => format!("`{name}` is read at a place that several pixels write"),
                false => format!("`{name}` is read at another place than this invocation's own, while others write it"),
            },
        )
        .at(span, "reads another invocation's output");
        if let Some(store) = store {
            finding = finding.at(
                store,
                match is_shared {
                    true => "stores there",
                    false => "the invocation's own place",
                },
            );
        }
        let help = "read from a second resource that this dispatch does not write, as a ping-pong pair does";
        let is_sure = is_shared || self.meet_surely(index, &others).is_some();
        self.say(finding.help(match is_sure {
            true => help.to_owned(),
            false => format!("{help}; or give your word with `--apart {name}` that no pixel, whatever its data, stores where another reads"),
        }));
    }

    /// Two pixels, of which the first surely reads where the second stores.
    fn meet_surely(&mut self, read: usize, stores: &[usize]) -> Option<[[u32; 2]; 2]> {
        let mut stores = stores.iter();
        stores.find_map(|&store| self.reads_what_another_stores(read, store))
    }

    /// Refuses the author's word that a read lies apart from stores, where two pixels show that it does not.
    fn refuse_word(&mut self, read: usize, stores: &[usize]) -> bool {
        let Some([reader, writer]) = self.meet_surely(read, stores) else {
            return false;
        };
        let (span, name) = (
            self.access(read).span,
            self.name(self.access(read).target.global),
        );
        let [reader, writer] = [reader, writer].map(|[x, y]| format!("({x}, {y})"));
        self.say(
            Finding::new(
                Code::ReadsOthersOutput,
                format!("`{name}` is read where another pixel stores, against the word that it is not"),
            )
            .at(span, format!("pixel {reader} reads here what pixel {writer} stores"))
            .help(format!("leave `--apart {name}` out, and read from a second resource that this dispatch does not write")),
        );
        true
    }
}

impl Planner<'_> {
    /// Whether several pixels have a store's place for their own.
    fn is_shared(&mut self, store: usize) -> bool {
        let is_own = self
            .tangents_of(store)
            .is_some_and(|tangents| is_one_to_one(&tangents));
        !is_own && self.meet_together(store).is_some()
    }

    /// Where a read and any of several writes meet.
    fn meet_any(&mut self, read: usize, writes: &[usize], domain: &Domain) -> Meet {
        let mut found = Meet::Never;
        for &write in writes {
            // an atomic at a place that others share is no pixel's own
            match self.meet(read, write, domain) {
                Meet::Perhaps => return Meet::Perhaps,
                Meet::Own if !self.access(write).kind.replaces() => return Meet::Perhaps,
                Meet::Own => found = Meet::Own,
                Meet::Never => {}
            }
        }
        found
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
