//! What the rewriter makes of a shader, entry point by entry point, without rewriting it.
//!
//! *Does*: analyses and plans each compute entry point and tells, in the shader's own words: what it stores, how a duplicate's
//! address is found and why so, which conditions bound its domain, which ids are remapped, what stops it.

mod words;

use naga::{
    BuiltIn, GlobalVariable, Handle, Module, ShaderStage, Span, TypeInner, valid::ModuleInfo,
};
use serde::{Deserialize, Serialize};

use crate::{
    Entries, Options, Rewritten,
    analysis::{
        Facts,
        guard::Formula,
        tangent::{Slope, Tangent},
    },
    deep,
    finding::Code,
    full,
    options::Policy,
    plan::{self, EntryPlan, How, regions::report::Group},
    source::Source,
    told::{Told, ToldPlace},
};

/// What is made of an entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// It is rewritten.
    Rewritten,
    /// It stores nothing per pixel, and is left as it is.
    NothingPerPixel,
    /// It is refused.
    Refused,
}

/// An entry point, explained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Explained {
    /// Its name.
    pub name: String,
    /// Its workgroup size; `null` on an axis where an `override` decides.
    pub workgroup_size: [Option<u32>; 3],
    /// What is made of it.
    pub verdict: Verdict,
    /// How it was taken apart, if its invocations work together and it is rewritten.
    #[serde(default)]
    pub group: Option<Group>,
    /// The ids that it takes, which the rewritten shader remaps as one set.
    pub remapped: Vec<String>,
    /// What makes a pixel part of its domain; every pixel is if there is none.
    pub domain: Vec<String>,
    /// What it stores.
    pub stores: Vec<Store>,
    /// What stops it, and what its author should know.
    pub findings: Vec<Told>,
}

/// A store, on one path of calls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Store {
    /// The resource.
    pub target: String,
    /// Where the store stands.
    pub place: Option<ToldPlace>,
    /// How a duplicate's address is found: `offset`, `recomputed` or `weighed`; `full` if every pixel stores for itself.
    pub how: String,
    /// Why so: how the address moves, or what it is made of.
    pub why: String,
    /// Conditions that are asked of each duplicate.
    pub guards: Vec<String>,
    /// Values of the primary that the above need.
    pub captures: Vec<String>,
}

/// Explains every compute entry point of a module, or the one with a name.
pub fn explain(
    module: &Module,
    info: &ModuleInfo,
    source: &Source,
    entry: Option<&str>,
    options: &Options,
) -> Vec<Explained> {
    deep::run_if_deep(deep::of_module(module), || {
        let entries = module.entry_points.iter().enumerate();
        entries
            .filter(|(_, e)| e.stage == ShaderStage::Compute)
            .filter(|(_, e)| entry.is_none_or(|name| e.name == name))
            .map(|(index, _)| explain_entry(module, info, source, index, options))
            .collect()
    })
}

fn explain_entry(
    module: &Module,
    info: &ModuleInfo,
    source: &Source,
    index: usize,
    options: &Options,
) -> Explained {
    let entry = &module.entry_points[index];
    let overrides = entry.workgroup_size_overrides.unwrap_or_default();
    let mut explained = Explained {
        name: entry.name.clone(),
        workgroup_size: std::array::from_fn(|axis| {
            overrides[axis]
                .is_none()
                .then_some(entry.workgroup_size[axis])
        }),
        verdict: Verdict::Rewritten,
        group: None,
        remapped: remapped(module, index),
        domain: Vec::new(),
        stores: Vec::new(),
        findings: Vec::new(),
    };
    let describe = |explained: &mut Explained, module: &Module, plan: &EntryPlan| {
        let words = Words {
            module,
            source,
            entry: index,
            plan,
        };
        explained.domain = plan.domain.iter().map(|f| words.formula(f)).collect();
        explained.stores = words.stores();
        let warnings = plan.warnings.iter().map(|f| Told::new(f, source));
        explained.findings.extend(warnings);
    };
    let mut is_planned = false;
    let name = Entries::Named(&entry.name);
    let rewritten = crate::rewrite_and_look(module, info, name, options, &mut |module, plan| {
        describe(&mut explained, module, plan);
        is_planned = true;
    });
    if let Ok(rewritten) = &rewritten {
        let entry = rewritten.manifest.entries.first();
        explained.group = entry.and_then(|entry| entry.group.clone());
    }
    if let Err(refusal) = &rewritten {
        explained.verdict = match refusal.findings.as_slice() {
            [only] if only.code == Code::NothingPerPixel => Verdict::NothingPerPixel,
            _ => Verdict::Refused,
        };
        let told: Vec<Told> = (refusal.findings.iter())
            .map(|finding| Told::new(finding, source))
            .collect();
        explained.findings.splice(0..0, told);
    }
    // what is `full` is not copied: its stores are the original's
    let split = full::split(module, &[(index, options)]).ok().flatten();
    if !is_planned && rewritten.is_err() {
        // a refusal that comes before any plan, such as a place that is taken, does not keep from telling the rest
        let (module, info) = (split.as_ref()).map_or((module, info), |s| (&s.module, &s.info));
        let facts = Facts::new(module, index);
        if let Ok(plan) = plan::plan(module, info, &facts, index, options) {
            describe(&mut explained, module, &plan);
        }
    }
    let full = match &rewritten {
        Ok(rewritten) => full_targets(module, rewritten),
        Err(_) => split
            .and_then(|split| split.full.get(&index).map(|full| full.targets.clone()))
            .unwrap_or_default(),
    };
    for (global, span) in full::stores(module, index, &full) {
        explained.stores.push(Store {
            target: module.global_variables[global]
                .name
                .clone()
                .unwrap_or_default(),
            place: told_place(source, span),
            how: "full".to_owned(),
            why: "every pixel stores what the original does, before anything is left out"
                .to_owned(),
            guards: Vec::new(),
            captures: Vec::new(),
        });
    }
    explained
}

/// The targets that have the policy `full`, asked for or not.
fn full_targets(module: &Module, rewritten: &Rewritten) -> Vec<Handle<GlobalVariable>> {
    let targets = rewritten.manifest.entries.iter();
    let targets = targets.flat_map(|entry| &entry.targets);
    let full: Vec<_> = targets.filter(|t| t.policy == Policy::Full).collect();
    let is_full = |global: &GlobalVariable| {
        let at = global.binding.map(|at| (at.group, at.binding));
        full.iter()
            .any(|target| at == Some((target.group, target.binding)))
    };
    let globals = module.global_variables.iter();
    globals
        .filter(|(_, global)| is_full(global))
        .map(|(handle, _)| handle)
        .collect()
}

/// The id builtins that an entry point takes, by their WGSL names.
fn remapped(module: &Module, entry: usize) -> Vec<String> {
    let name = |binding: &Option<naga::Binding>| match binding.as_ref()?.to_built_in()? {
        BuiltIn::GlobalInvocationId => Some("global_invocation_id"),
        BuiltIn::LocalInvocationId => Some("local_invocation_id"),
        BuiltIn::LocalInvocationIndex => Some("local_invocation_index"),
        BuiltIn::WorkGroupId => Some("workgroup_id"),
        BuiltIn::NumWorkGroups => Some("num_workgroups"),
        _ => None,
    };
    let mut found = Vec::new();
    for argument in &module.entry_points[entry].function.arguments {
        found.extend(name(&argument.binding));
        if let TypeInner::Struct { members, .. } = &module.types[argument.ty].inner {
            found.extend(members.iter().filter_map(|member| name(&member.binding)));
        }
    }
    found.into_iter().map(str::to_owned).collect()
}

fn told_place(source: &Source, span: Span) -> Option<ToldPlace> {
    let place = source.place(span)?;
    Some(ToldPlace {
        file: place.file,
        line: place.line,
        column: place.column,
        snippet: source.snippet(span).unwrap_or_default(),
        text: String::new(),
    })
}

/// The author's words for what a plan is made of.
struct Words<'w> {
    module: &'w Module,
    source: &'w Source,
    entry: usize,
    plan: &'w EntryPlan<'w>,
}

impl Words<'_> {
    fn stores(&self) -> Vec<Store> {
        let copies = self.plan.copies.iter().map(|copy| {
            let access = &self.plan.found.accesses[copy.access];
            debug_assert!(access.kind.writes());
            let (how, why) = self.how(&copy.how);
            Store {
                target: self.module.global_variables[access.target.global]
                    .name
                    .clone()
                    .unwrap_or_default(),
                place: told_place(self.source, access.span),
                how: how.to_owned(),
                why,
                guards: copy.guards.iter().map(|f| self.formula(f)).collect(),
                captures: copy.captures.iter().map(|c| self.term(c.term)).collect(),
            }
        });
        copies.collect()
    }

    fn how(&self, how: &How) -> (&'static str, String) {
        match how {
            How::Offset(tangents) => {
                let axis = |axis: usize| self.direction(tangents, axis);
                (
                    "offset",
                    format!("d(address)/dx = {}, d(address)/dy = {}", axis(0), axis(1)),
                )
            }
            How::Weigh => (
                "weighed",
                "the value times the number of duplicates, at the primary's own place".to_owned(),
            ),
            How::Recompute(terms) => {
                let words: Vec<String> = terms.iter().map(|&term| self.term(term)).collect();
                (
                    "recomputed",
                    format!(
                        "the address does not move evenly; `{}` is computed anew for each duplicate",
                        words.join(", ")
                    ),
                )
            }
        }
    }

    fn direction(&self, tangents: &[Tangent], axis: usize) -> String {
        let slopes: Vec<String> = tangents
            .iter()
            .map(|tangent| self.slope(tangent.pixel[axis]))
            .collect();
        match slopes.as_slice() {
            [only] => only.clone(),
            several => format!("({})", several.join(", ")),
        }
    }

    fn slope(&self, slope: Slope) -> String {
        let Some((symbol, factor)) = slope.symbol else {
            return slope.constant.to_string();
        };
        let symbol = match factor {
            1 => self.term(symbol),
            factor => format!("{factor} * {}", self.term(symbol)),
        };
        match slope.constant {
            0 => symbol,
            constant => format!("{constant} + {symbol}"),
        }
    }

    fn formula(&self, formula: &Formula) -> String {
        let parts = |parts: &[Formula], word: &str| {
            let parts: Vec<String> = parts.iter().map(|part| self.formula(part)).collect();
            match parts.len() {
                1 => parts.concat(),
                _ => format!("({})", parts.join(word)),
            }
        };
        match formula {
            Formula::Is(condition, true) => self.term(*condition),
            Formula::Is(condition, false) => match self.term(*condition) {
                words if words.starts_with('(') => format!("not {words}"),
                words => format!("not ({words})"),
            },
            Formula::All(all) => parts(all, " and "),
            Formula::Any(any) => parts(any, " or "),
        }
    }
}
