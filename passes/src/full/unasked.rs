//! The policy `full` for targets of which nothing was said, and that `copy` cannot serve.
//!
//! *Does*: where all that stands against an entry point are stores that duplicates would lose (`if all(id == vec3(0))`), that
//! several pixels make at one place, or whose place cannot be computed anew, has their targets stored for every pixel.
//! *Guarantees*: the halves are [separate](super), and the rest was planned without a finding; so each invocation's stores to these targets
//! are the original's, in the original's number. What was taken is in the manifest, and a warning tells it.
//! *Leaves as it was*: what the options name a policy for; atomics; modes that do not visit every pixel; one-dimensional dispatches; an
//! entry point of which no other target is copied, or of which nothing would be saved.
//!
//! # What is saved
//!
//! Statements are weighed by the expressions that they compute, with a callee's for a call, and eight times as much for each loop around them.
//! What the stores of every pixel need runs for every pixel; what the other stores need runs again, for primaries. With both weighed,
//! and the whole, what *both* need and what the others need *alone* is known. Where a half of the pixels are primaries, half of what the
//! others need alone is saved and half of what both need is lost: where both need as much as that, nothing is gained.

use std::collections::{BTreeMap, BTreeSet};

use naga::{Block, Function, GlobalVariable, Handle, Module, Statement};

use super::{Half, Split};
use crate::{
    Code, Finding, Options,
    analysis::Facts,
    ir::visit,
    options::{Mode, Policy},
    plan::{self, TargetPlan},
};

/// How often a loop is taken to run.
const ITERATIONS: u64 = 8;

/// What was taken for an entry point.
#[derive(Clone, Debug)]
pub struct Taken {
    /// The options, with the policies that were taken.
    pub options: Options,
    /// A warning for each store.
    pub warnings: Vec<Finding>,
}

/// Whether every pixel storing for itself may answer all of an entry point's findings.
pub fn may_answer(findings: &[Finding], mode: Mode) -> bool {
    let is_lost = |finding: &Finding| finding.stored.is_some();
    // each mode finds the same
    mode != Mode::Graded && !findings.is_empty() && findings.iter().all(is_lost)
}

/// What is taken for an entry point that was refused; `None` if it stays refused for what it was.
///
/// # Errors
/// What it was refused for, if nothing would be saved, with that said.
pub fn take(
    module: &Module,
    index: usize,
    options: &Options,
    findings: &[Finding],
) -> Result<Option<Taken>, Vec<Finding>> {
    if options.mode != Mode::Tiled
        || options.linear.is_some()
        || !may_answer(findings, options.mode)
    {
        return Ok(None);
    }
    let Some(targets) = unnamed(module, options, findings) else {
        return Ok(None);
    };
    let mut with = options.clone();
    for name in targets.values() {
        with.targets.insert((*name).to_owned(), Policy::Full);
    }
    let Ok(Some(split)) = super::split(module, &[(index, &with)]) else {
        return Ok(None);
    };
    if !is_copied_besides(&split, index, &with) {
        return Ok(None);
    }
    let Some(cost) = Cost::of(module, &split, index) else {
        return Ok(None);
    };
    if cost.saves_nothing() {
        let why = format!(
            "; `full` could do that, but {} of the {} statements that other stores need would run twice, so that nothing would be saved",
            cost.both, cost.others
        );
        let say = |finding: &Finding| {
            let mut finding = finding.clone();
            finding.message += &why;
            finding
        };
        return Err(findings.iter().map(say).collect());
    }
    let warnings = findings
        .iter()
        .map(|finding| warning(finding, &targets, &cost));
    let mut once: Vec<Finding> = Vec::new();
    for warning in warnings {
        if !once.contains(&warning) {
            once.push(warning);
        }
    }
    Ok(Some(Taken {
        options: with,
        warnings: once,
    }))
}

/// The targets of findings by their names; `None` if one of them was spoken of, or cannot be.
fn unnamed<'m>(
    module: &'m Module,
    options: &Options,
    findings: &[Finding],
) -> Option<BTreeMap<Handle<GlobalVariable>, &'m str>> {
    let mut targets = BTreeMap::new();
    for finding in findings {
        let global = finding.stored?;
        let name = module.global_variables[global].name.as_deref()?;
        let namesakes = module.global_variables.iter();
        let namesakes = namesakes.filter(|(_, g)| g.name.as_deref() == Some(name));
        if options.targets.contains_key(name) || namesakes.count() != 1 {
            return None;
        }
        targets.insert(global, name);
    }
    Some(targets)
}

/// Whether the rest can be rewritten, and copies something.
fn is_copied_besides(split: &Split, index: usize, options: &Options) -> bool {
    let facts = Facts::new(&split.module, index);
    let copied = |target: &TargetPlan| target.policy == Policy::Copy;
    match plan::plan(&split.module, &split.info, &facts, index, options) {
        Ok(plan) => !plan.copies.is_empty() && plan.targets.iter().any(copied),
        Err(_) => false,
    }
}

/// What every pixel's stores cost.
struct Cost {
    /// Statements of the entry point and of what it calls, and those of its slice.
    all: u64,
    own: u64,
    /// Statements that both halves have, and those of the other half.
    both: u64,
    others: u64,
    whole_weight: u64,
    own_weight: u64,
    rest_weight: u64,
}

impl Cost {
    fn of(module: &Module, split: &Split, index: usize) -> Option<Cost> {
        let full = split.full.get(&index)?;
        let mut scratch = module.clone();
        let original = &module.entry_points[index].function;
        // as the halves are, without what nothing needs
        let whole = Half::new(index, &[])
            .of(&mut scratch, original, &[], &BTreeSet::new())
            .ok()?;
        let whole = Weights::of(&scratch, &whole);
        let own = Weights::of(&split.module, &split.module.functions[full.function]);
        let rest = Weights::of(&split.module, &split.module.entry_points[index].function);
        Some(Cost {
            all: whole.statements,
            own: own.statements,
            both: (own.statements + rest.statements).saturating_sub(whole.statements),
            others: rest.statements,
            whole_weight: whole.weight,
            own_weight: own.weight,
            rest_weight: rest.weight,
        })
    }

    /// Whether both halves need as much as the others need alone.
    fn saves_nothing(&self) -> bool {
        let both = (self.own_weight + self.rest_weight).saturating_sub(self.whole_weight);
        let alone = self.rest_weight.saturating_sub(both);
        both >= alone
    }
}

/// What a function and its callees amount to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Weights {
    /// Statements, those of a callee once for each call.
    statements: u64,
    /// Expressions that are computed, and effects, as often as they are taken to run.
    weight: u64,
}

impl Weights {
    fn of(module: &Module, function: &Function) -> Weights {
        Weights::of_block(module, &function.body, 1, &mut BTreeMap::new())
    }

    fn of_block(
        module: &Module,
        block: &Block,
        times: u64,
        known: &mut BTreeMap<Handle<Function>, Weights>,
    ) -> Weights {
        let mut all = Weights::default();
        for statement in block {
            let mut times = times;
            match statement {
                Statement::Emit(range) => {
                    let computed = range.clone().count() as u64;
                    all.weight = all.weight.saturating_add(times.saturating_mul(computed));
                    continue;
                }
                Statement::Block(_) => {}
                Statement::Loop { .. } => {
                    times = times.saturating_mul(ITERATIONS);
                    all.statements = all.statements.saturating_add(1);
                }
                Statement::Call { function, .. } => {
                    let callee = match known.get(function) {
                        Some(&callee) => callee,
                        None => {
                            let body = &module.functions[*function].body;
                            let callee = Weights::of_block(module, body, 1, known);
                            known.insert(*function, callee);
                            callee
                        }
                    };
                    let weight = times.saturating_mul(callee.weight.saturating_add(1));
                    all.weight = all.weight.saturating_add(weight);
                    all.statements = all.statements.saturating_add(callee.statements + 1);
                }
                _ => {
                    all.weight = all.weight.saturating_add(times);
                    all.statements = all.statements.saturating_add(1);
                }
            }
            visit::sub_blocks(statement, &mut |inner| {
                let inner = Weights::of_block(module, inner, times, known);
                all.weight = all.weight.saturating_add(inner.weight);
                all.statements = all.statements.saturating_add(inner.statements);
            });
        }
        all
    }
}

/// That a target is stored for every pixel, for a reason that it was to be refused for.
fn warning(
    finding: &Finding,
    targets: &BTreeMap<Handle<GlobalVariable>, &str>,
    cost: &Cost,
) -> Finding {
    let name = finding.stored.and_then(|global| targets.get(&global));
    let name = name.copied().unwrap_or_default();
    let mut warning = Finding::new(
        Code::StoredForEveryPixel,
        format!(
            "`{name}` is stored for every pixel, since {}; what that needs, {} of {} statements, is not saved",
            finding.message, cost.own, cost.all
        ),
    );
    warning.labels.clone_from(&finding.labels);
    if let (Code::ConditionalOnIds, Some(first)) = (finding.code, warning.labels.first_mut()) {
        first.text =
            "a copy would be lost when the invocation that runs it is a duplicate".to_owned();
    }
    warning.help(format!(
        "`--target {name}=full` says that this is meant; `--target {name}=copy` refuses the shader instead. Invocations beyond the logical extent do not run: where they store there, too, give it whole workgroups"
    ))
}
