//! How each store's address is found for a duplicate.

use naga::{BinaryOperator, Span};

use super::{CopyPlan, How, Planner, domain::Domain};
use crate::{
    analysis::{
        AccessKind, Address, AtomicKind,
        depends::Depends,
        guard::{Formula, flatten},
        interval::less,
        tangent::{Slope, Tangent},
        term::{Id, Step, Term, TermId, integer},
    },
    finding::{Code, Finding},
    options::Policy,
};

impl Planner<'_> {
    /// Plans the copies of every store.
    pub(super) fn plan_copies(&mut self, domain: &Domain) -> Vec<CopyPlan> {
        let stores = self.stores();
        if !stores.iter().any(|&store| self.is_per_pixel(store)) {
            self.refuse_nothing_per_pixel(&stores);
            return Vec::new();
        }
        let copies: Vec<CopyPlan> = stores
            .into_iter()
            .filter_map(|store| self.plan_copy(store, domain))
            .collect();
        self.warn_of_groups_for_pixels(&copies);
        self.warn_of_scattered(&copies);
        copies
    }

    fn refuse_nothing_per_pixel(&mut self, stores: &[usize]) {
        let mut finding = Finding::new(
            Code::NothingPerPixel,
            "the entry point stores nothing at an address that depends on both axes of its invocation grid",
        );
        if let Some(&store) = stores.first() {
            let (span, axes) = (self.access(store).span, self.axes(store));
            finding = finding.at(span, format!("depends on {}", named(axes)));
        }
        let help = match self.is_line() && self.options.linear.is_none() {
            true => format!(
                "if the dispatch goes over a picture's pixels row by row, tell its width: `--linear {}`; else name another entry point with --entry",
                self.width_by_name().unwrap_or_else(|| "WIDTH".to_owned())
            ),
            false => "name another entry point with --entry".to_owned(),
        };
        self.say(finding.help(help));
    }

    /// Whether workgroups have one row.
    fn is_line(&self) -> bool {
        let [_, height, depth] = self.found.group_size;
        [height, depth]
            .iter()
            .all(|&side| integer(self.found.terms.as_literal(side)) == Some(1))
    }

    /// What the shader divides an id by, as `--linear` takes it: the member of a uniform.
    fn width_by_name(&self) -> Option<String> {
        use BinaryOperator as B;
        let terms = &self.found.terms;
        let divisor = terms.all().find_map(|term| match *term {
            Term::Binary(B::Modulo | B::Divide, left, right) => {
                matches!(terms.get(left), Term::Id(Id::Global(0))).then_some(right)
            }
            _ => None,
        })?;
        let Term::Load(global, path) = terms.get(divisor) else {
            return None;
        };
        let variable = &self.module.global_variables[*global];
        let naga::TypeInner::Struct { members, .. } = &self.module.types[variable.ty].inner else {
            return None;
        };
        match **path {
            [Step::Index(member)] => Some(format!(
                "{}.{}",
                variable.name.as_ref()?,
                members.get(member as usize)?.name.as_ref()?
            )),
            _ => None,
        }
    }

    /// The axes that a store's address depends on.
    pub(super) fn axes(&mut self, store: usize) -> Depends {
        let terms = self.access(store).address.terms();
        terms.into_iter().fold(Depends::empty(), |all, term| {
            all | self.on.of(&mut self.found.terms, term)
        })
    }

    fn is_per_pixel(&mut self, store: usize) -> bool {
        self.axes(store).contains(Depends::X | Depends::Y)
    }

    fn plan_copy(&mut self, store: usize, domain: &Domain) -> Option<CopyPlan> {
        let access = self.access(store);
        let (span, instance, scope) = (access.span, access.instance, access.scope.clone());
        let (kind, global, stored) = (access.kind, access.target.global, access.plain());
        let name = self.name(global);
        let terms = access.address.terms();
        let axes = self.axes(store);
        if let AccessKind::Atomic { function, .. } = kind
            && !kind.replaces()
            && !axes.on_ids_alone()
        {
            return self.plan_weight(store, domain, function);
        }
        let is_atomic = matches!(kind, AccessKind::Atomic { .. }) && !kind.replaces();
        if !axes.contains(Depends::X | Depends::Y) && !is_atomic {
            self.say(
                Finding::new(
                    Code::AddressNotOneToOne,
                    format!("several invocations store to one place of `{name}`"),
                )
                .about(stored)
                .at(span, format!("the address depends on {}", named(axes)))
                .help("move this store to an entry point of its own"),
            );
            return None;
        }
        let tangents = self.tangents_of(store);
        let one_to_one = match tangents.as_deref() {
            Some(tangents) => is_one_to_one(tangents),
            None => self.strides_tell_apart(&terms) || self.wraps_tell_apart(store, &terms, domain),
        };
        let is_copied = self.policy(global) != Policy::Leader;
        if is_copied && !one_to_one && self.refuse_together(store) {
            return None;
        }
        let guards = self.guards_of(store, domain, tangents.as_deref(), one_to_one)?;
        if !is_copied {
            return None;
        }

        let mut needed: Vec<TermId> = Vec::new();
        for guard in &guards {
            guard.conditions(&mut |condition| needed.push(condition));
        }
        let how = match tangents {
            Some(tangents) => {
                for slope in tangents.iter().flat_map(|tangent| tangent.pixel) {
                    needed.extend(slope.symbol.map(|(symbol, _)| symbol));
                }
                How::Offset(tangents)
            }
            None => {
                needed.extend(&terms);
                How::Recompute(terms)
            }
        };
        match self.captures(&needed, instance, &scope) {
            Ok(captures) => Some(CopyPlan {
                access: store,
                how,
                guards,
                captures,
            }),
            Err(blocked) => {
                let cause = self.blocked_span(&blocked);
                self.say(
                    Finding::new(
                        Code::AddressNotRecomputable,
                        format!(
                            "where a duplicate would store in `{name}` cannot be computed: {}",
                            blocked.why
                        ),
                    )
                    .about(stored)
                    .at(span, "the store")
                    .at_another(cause, blocked.why)
                    .help("compute the address from the invocation's ids, uniforms and read-only memory"),
                );
                None
            }
        }
    }

    /// Plans an atomic at a place that is not a function of the ids: a primary's counts for all its pixels.
    fn plan_weight(
        &mut self,
        atomic: usize,
        domain: &Domain,
        function: AtomicKind,
    ) -> Option<CopyPlan> {
        self.guards_of(atomic, domain, None, false)?;
        // what nothing changes by being repeated is there already
        let counts = function == AtomicKind::Sum
            && self.policy(self.access(atomic).target.global) == Policy::Copy;
        counts.then_some(CopyPlan {
            access: atomic,
            how: How::Weigh,
            guards: Vec::new(),
            captures: Vec::new(),
        })
    }

    /// The conditions that are to be asked of each duplicate at a store, beyond the domain; `None` if the store is
    /// refused.
    fn guards_of(
        &mut self,
        store: usize,
        domain: &Domain,
        tangents: Option<&[Tangent]>,
        one_to_one: bool,
    ) -> Option<Vec<Formula>> {
        let access = self.access(store);
        let (span, guards) = (access.span, access.guards.clone());
        let is_buffer = matches!(access.address, Address::Part(_));
        let stored = access.plain();
        let name = self.name(access.target.global);
        let own = tangents.is_some_and(is_identity);
        let mut asked = Vec::new();
        let extra: Vec<Formula> = self
            .relaxed(&guards, |planner, condition| {
                planner.is_positional(condition)
            })
            .into_iter()
            .filter(|formula| !domain.common.contains(formula))
            .filter(|formula| self.tells_pixels_apart(formula))
            .collect();
        for formula in extra {
            let mut condition_span = span;
            formula.conditions(&mut |condition| {
                let found = self.span_of(condition);
                if found.is_defined() {
                    condition_span = found;
                }
            });
            // a part of a condition on vectors, `all(id.xy % 2u == vec2(0u))`, has no place of its own
            if condition_span == span {
                condition_span = self.whole_condition(&formula).unwrap_or(span);
            }
            if !one_to_one {
                self.say(
                    Finding::new(
                        Code::ConditionalOnIds,
                        format!("a store to `{name}` runs only for some ids and does not go to the pixel's own place"),
                    )
                    .about(stored)
                    .at(span, "lost when the invocation that runs it is a duplicate")
                    .at_another(condition_span, "the condition on the ids")
                    .help(match self.works_together() {
                        true => format!("store to `{name}` in an entry point of its own, in a dispatch before or behind this one"),
                        false => format!("`--target {name}=full` has every pixel store there what the original does; or move this store to an entry point of its own"),
                    }),
                );
                return None;
            }
            // a copy that the bounds would have stopped may land in the next row, or in another's block
            if (is_buffer || !own)
                && (self.is_bounds_check(&formula) || self.is_bound_of(store, &formula))
                && !self.has_opposite(store, &formula)
            {
                asked.push(formula);
                continue;
            }
            let finding = Finding::new(
                Code::FollowsPrimary,
                format!(
                    "a store to `{name}` runs only for some ids; its copies follow the primary"
                ),
            );
            let finding = match condition_span == span {
                true => finding,
                false => finding.at(condition_span, "the condition on the ids"),
            };
            self.say(
                finding.at(span, "copied wherever the primary stores")
                    .help("keep both sides of the condition in blocks of their own, or at full rate, where that shows"),
            );
        }
        Some(asked)
    }

    /// Where the condition stands that a formula is a part of.
    fn whole_condition(&mut self, formula: &Formula) -> Option<Span> {
        let conditions: Vec<_> = (self.found.conditions.iter())
            .map(|site| (site.condition, site.span))
            .collect();
        conditions.into_iter().find_map(|(condition, span)| {
            let is_part = [true, false].into_iter().any(|holds| {
                let mut conjuncts = Vec::new();
                let whole = [Formula::Is(condition, holds)];
                flatten(&whole, &mut self.found.terms, &mut conjuncts);
                conjuncts.contains(formula)
            });
            is_part.then_some(span)
        })
    }

    /// Whether a formula may hold for a primary and not for its duplicates. They lie in one layer, so that what asks for the layer alone
    /// holds for all of them or for none.
    fn tells_pixels_apart(&mut self, formula: &Formula) -> bool {
        let mut conditions = Vec::new();
        formula.conditions(&mut |condition| conditions.push(condition));
        conditions.into_iter().any(|condition| {
            let on = self.on.of(&mut self.found.terms, condition);
            on.intersects(Depends::X | Depends::Y)
        })
    }

    /// Whether a formula compares a part of a store's address against something that is the same for all invocations.
    fn is_bound_of(&mut self, store: usize, formula: &Formula) -> bool {
        let Some((lesser, greater, _)) = less(&self.found.terms, formula) else {
            return false;
        };
        let parts = self.access(store).address.terms();
        let parts: Vec<_> = parts.iter().map(|&part| self.polynomial(part)).collect();
        [(lesser, greater), (greater, lesser)]
            .into_iter()
            .any(|(part, bound)| {
                let part = self.polynomial(part);
                part.is_some()
                    && parts.contains(&part)
                    && self.on.of(&mut self.found.terms, bound).is_empty()
            })
    }

    /// Whether a formula compares something that moves with the ids against something that does not.
    fn is_bounds_check(&mut self, formula: &Formula) -> bool {
        use BinaryOperator as B;
        let Formula::Is(condition, _) = *formula else {
            return false;
        };
        let Term::Binary(B::Less | B::LessEqual | B::Greater | B::GreaterEqual, left, right) =
            *self.found.terms.get(condition)
        else {
            return false;
        };
        let mut moves = |term| {
            self.tangents
                .of(&mut self.found.terms, &mut self.on, term)
                .map(|tangent| tangent != Tangent::default())
        };
        matches!((moves(left), moves(right)), (Some(a), Some(b)) if a != b)
    }

    /// Whether another store to the same target runs when this condition does not hold.
    fn has_opposite(&mut self, store: usize, formula: &Formula) -> bool {
        let Formula::Is(condition, holds) = *formula else {
            return false;
        };
        let target = self.access(store).target.clone();
        let opposite = Formula::Is(condition, !holds);
        let others: Vec<_> = self
            .found
            .accesses
            .iter()
            .filter(|a| matches!(a.kind, AccessKind::Store { .. }) && a.target == target)
            .map(|a| a.guards.clone())
            .collect();
        others.iter().any(|guards| {
            let mut conjuncts = Vec::new();
            flatten(guards, &mut self.found.terms, &mut conjuncts);
            conjuncts.contains(&opposite)
        })
    }
}

/// Whether an address moves by exactly one along x and y.
fn is_identity(tangents: &[Tangent]) -> bool {
    let one = Slope {
        constant: 1,
        symbol: None,
    };
    let zero = Slope::default();
    match tangents {
        [x, y, ..] => {
            (x.pixel[0], x.pixel[1]) == (one, zero) && (y.pixel[0], y.pixel[1]) == (zero, one)
        }
        _ => false,
    }
}

/// Whether different pixels of a layer surely have different addresses: two parts that move independently, or one that
/// moves by different strides along x and y (that the longer stride spans a row is the author's business: without
/// that, the original races).
pub(super) fn is_one_to_one(tangents: &[Tangent]) -> bool {
    let numbers = |t: &Tangent| {
        let [x, y, _] = t.pixel;
        (x.symbol.is_none() && y.symbol.is_none()).then_some((x.constant, y.constant))
    };
    for (index, a) in tangents.iter().enumerate() {
        for b in &tangents[index + 1..] {
            match (numbers(a), numbers(b)) {
                (Some((ax, ay)), Some((bx, by))) if ax * by != ay * bx => return true,
                _ => {}
            }
        }
    }
    tangents.iter().any(|t| {
        let [x, y, _] = t.pixel;
        let strides = x.constant.abs() != y.constant.abs() || x.symbol != y.symbol;
        !x.is_zero() && !y.is_zero() && strides
    })
}

fn named(axes: Depends) -> &'static str {
    match (axes.contains(Depends::X), axes.contains(Depends::Y)) {
        (true, true) => "both axes",
        (true, false) => "x alone",
        (false, true) => "y alone",
        (false, false) => "neither x nor y",
    }
}
