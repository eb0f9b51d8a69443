//! Decides what is done with each store, or why the shader is refused. Nothing is changed here.
//!
//! *Does*: turns what the [walk](crate::analysis::walk) found into an [`EntryPlan`]: how each store's address is found
//! for a duplicate, what has to be captured for it, which pixels belong to the shader's domain.
//! *Guarantees*: a plan is made only if the contract can be kept for every store; else all reasons are given at once.

mod addresses;
mod apart;
mod captures;
mod classes;
mod domain;
mod exchanges;
mod hazards;
mod iterations;
mod layout;
pub mod regions;
mod together;
mod wraps;

use naga::{Function, GlobalVariable, Handle, Module, Span, valid::ModuleInfo};

use crate::{
    analysis::{
        Access, AccessKind, Facts,
        depends::Dependence,
        guard::Formula,
        tangent::{Tangent, Tangents},
        term::TermId,
        walk::{Found, Width, walk},
    },
    finding::{Code, Finding, Severity},
    options::{Options, Policy},
};

pub use captures::{Capture, CaptureSource};
pub use regions::GroupPlan;

/// What is done with one entry point.
pub struct EntryPlan<'a> {
    /// What the analysis found.
    pub found: Found<'a>,
    /// What each store becomes.
    pub copies: Vec<CopyPlan>,
    /// What makes a pixel part of the shader's domain; all pixels are if nothing is asked.
    pub domain: Vec<Formula>,
    /// The resources that it stores to, in the order of their declaration.
    pub targets: Vec<TargetPlan>,
    /// What of the entry point runs for every pixel, [apart](crate::full) from what is planned here.
    pub full: Option<Handle<Function>>,
    /// What is done besides if invocations work together.
    pub group: Option<GroupPlan>,
    /// Warnings.
    pub warnings: Vec<Finding>,
}

/// What is done with one target.
#[derive(Clone, Copy, Debug)]
pub struct TargetPlan {
    /// The resource.
    pub global: Handle<GlobalVariable>,
    /// What becomes of its stores.
    pub policy: Policy,
}

/// How a store is repeated for a duplicate.
#[derive(Debug)]
pub struct CopyPlan {
    /// The access, by its number in [`Found::accesses`].
    pub access: usize,
    /// How the duplicate's address is found.
    pub how: How,
    /// Conditions that are asked of each duplicate.
    pub guards: Vec<Formula>,
    /// Values of the primary that the above need.
    pub captures: Vec<Capture>,
}

/// How a duplicate's address is found.
#[derive(Clone, Debug, PartialEq)]
pub enum How {
    /// The primary's address plus `tangent · delta`, for each computed part of the address.
    Offset(Vec<Tangent>),
    /// Each computed part of the address anew, from the duplicate's ids.
    Recompute(Vec<TermId>),
    /// The primary's own: an atomic sum, once more with its value times the number of duplicates.
    Weigh,
}

/// What was found, and what answers questions about it.
struct Planner<'a> {
    module: &'a Module,
    entry: usize,
    options: &'a Options,
    found: Found<'a>,
    on: Dependence<'a>,
    tangents: Tangents,
    findings: Vec<Finding>,
}

/// Plans the rewrite of entry point number `entry`.
///
/// # Errors
/// All reasons to refuse it.
pub fn plan<'a>(
    module: &'a Module,
    info: &'a ModuleInfo,
    facts: &'a Facts,
    entry: usize,
    options: &'a Options,
) -> Result<EntryPlan<'a>, Vec<Finding>> {
    let width = linear_width(module, entry, options).map_err(|finding| vec![finding])?;
    let found = walk(module, info, facts, entry, width.as_ref());
    let mut planner = Planner {
        module,
        entry,
        options,
        tangents: Tangents::new(found.group_size),
        found,
        on: Dependence::new(facts),
        findings: Vec::new(),
    };
    planner.check_policies(facts);
    let domain = planner.domain();
    planner.check_hazards(&domain);
    let group = planner.plan_group(facts, options.barriers);
    let copies = planner.plan_copies(&domain);
    let (refusals, warnings): (Vec<_>, Vec<_>) = planner
        .findings
        .into_iter()
        .partition(|finding| finding.code.severity() == Severity::Refusal);
    if !refusals.is_empty() {
        let nothing = |finding: &Finding| finding.code == Code::NothingPerPixel;
        // where no pixel is stored, what else stands against a rewrite is no matter: it stays as it is
        return Err(match refusals.iter().position(nothing) {
            Some(index) => vec![refusals[index].clone()],
            None => refusals,
        });
    }
    let targets = facts
        .written()
        .into_iter()
        // a store that a constant rules out stores nothing
        .filter(|&global| {
            let stored = |access: &Access| access.target.global == global && access.kind.writes();
            planner.found.accesses.iter().any(stored)
        })
        .map(|global| TargetPlan {
            global,
            policy: options.policy(name_of(module, global)),
        })
        .collect();
    Ok(EntryPlan {
        found: planner.found,
        copies,
        domain: domain.shared,
        targets,
        full: None,
        group,
        warnings,
    })
}

/// The width that the options give a one-dimensional dispatch.
fn linear_width(
    module: &Module,
    entry: usize,
    options: &Options,
) -> Result<Option<Width>, Finding> {
    let Some(linear) = &options.linear else {
        return Ok(None);
    };
    let unfit = |why: String| Err(Finding::new(Code::UnfitOption, why));
    let entry = &module.entry_points[entry];
    let overrides = entry.workgroup_size_overrides.unwrap_or_default();
    let is_line = |axis: usize| entry.workgroup_size[axis] == 1 && overrides[axis].is_none();
    if !is_line(1) || !is_line(2) {
        let why = format!(
            "`{}` has workgroups of more than one row, so its pixels are not numbered row by row",
            entry.name
        );
        return Err(Finding::new(Code::UnfitOption, why).help(
            "leave `--linear` out: a shader whose workgroups have two sides finds its pixel without it",
        ));
    }
    match Width::find(module, linear) {
        Ok(width) => Ok(Some(width)),
        Err(why) => unfit(format!("`{linear}` is no width: {why}")),
    }
}

/// The name of a variable; empty if it has none.
fn name_of(module: &Module, global: Handle<GlobalVariable>) -> &str {
    module.global_variables[global]
        .name
        .as_deref()
        .unwrap_or_default()
}

impl Planner<'_> {
    fn say(&mut self, finding: Finding) {
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }

    /// What becomes of what is stored to a variable.
    fn policy(&self, global: Handle<GlobalVariable>) -> Policy {
        self.options.policy(name_of(self.module, global))
    }

    /// The stores and atomics, by their number among the accesses.
    fn stores(&self) -> Vec<usize> {
        self.found
            .accesses
            .iter()
            .enumerate()
            .filter(|(_, access)| !matches!(access.kind, AccessKind::Load { .. }))
            .map(|(index, _)| index)
            .collect()
    }

    fn access(&self, index: usize) -> &Access {
        &self.found.accesses[index]
    }

    /// The name of a variable, as the author wrote it.
    fn name(&self, global: Handle<GlobalVariable>) -> String {
        self.module.global_variables[global]
            .name
            .clone()
            .unwrap_or_else(|| "an unnamed resource".to_owned())
    }

    /// Where a term was first computed in the source.
    fn span_of(&self, term: TermId) -> Span {
        for condition in &self.found.conditions {
            if condition.condition == term {
                return condition.span;
            }
        }
        for instance in &self.found.instances {
            let function = instance.function.get(self.module, self.entry);
            for ((handle, _), value) in function.expressions.iter().zip(&instance.values) {
                let span = function.expressions.get_span(handle);
                if *value == Some(term) && span.is_defined() {
                    return span;
                }
            }
        }
        Span::UNDEFINED
    }
}
