//! tmp
#![allow(missing_docs)]
pub mod analysis;
pub mod finding;
pub mod ir;
pub mod manifest;
pub mod options;
pub mod plan;
pub mod prelude;
pub mod source;
pub mod transform;

use naga::{
    Module, ShaderStage,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use analysis::Facts;
pub use finding::{Code, Color, Finding, Refusal, Severity};
use manifest::Manifest;
pub use options::Options;
pub use source::Source;

/// Which entry points to rewrite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries<'e> {
    /// The one with this name.
    Named(&'e str),
    /// Every compute entry point that stores per pixel.
    PerPixel,
}

impl<'e> From<&'e str> for Entries<'e> {
    fn from(name: &'e str) -> Entries<'e> {
        Entries::Named(name)
    }
}

/// A module with rewritten entry points.
#[derive(Clone, Debug)]
pub struct Rewritten {
    /// The module.
    pub module: Module,
    /// What naga knows of it.
    pub info: ModuleInfo,
    /// What is needed to dispatch it.
    pub manifest: Manifest,
    /// Findings that did not stop the rewrite, with the name of their entry point.
    pub warnings: Vec<(String, Finding)>,
    /// Compute entry points that store nothing per pixel, left as they are.
    pub left_alone: Vec<(String, Finding)>,
}

pub fn rewrite<'e>(
    module: &Module,
    info: &ModuleInfo,
    entries: impl Into<Entries<'e>>,
    options: &Options,
) -> Result<Rewritten, Refusal> {
    let chosen = choose(module, entries.into())?;
    let placement = transform::bindings::place(module, options)?;
    let mut rewritten = module.clone();
    let mut imports = transform::prologue::imports(placement);
    let mut refusals = Vec::new();
    let mut warnings = Vec::new();
    let mut left_alone = Vec::new();
    let mut manifest = Manifest {
        version: manifest::VERSION,
        generator: concat!("vrcs ", env!("CARGO_PKG_VERSION")).to_owned(),
        preconditions: manifest::preconditions(),
        entries: Vec::new(),
    };
    let only_one = chosen.len() == 1;
    for index in chosen {
        let name = &module.entry_points[index].name;
        let facts = Facts::new(module, index);
        match plan::plan(module, info, &facts, index) {
            Ok(mut plan) => {
                transform::apply(
                    &mut rewritten,
                    module,
                    info,
                    index,
                    &mut plan,
                    &mut imports,
                    options,
                );
                manifest.entries.push(manifest::entry(
                    module,
                    info,
                    index,
                    options,
                    placement,
                    &plan.targets,
                ));
                warnings.extend(plan.warnings.drain(..).map(|w| (name.clone(), w)));
            }
            Err(findings) => match findings.as_slice() {
                [only] if only.code == Code::NothingPerPixel && !only_one => {
                    left_alone.push((name.clone(), only.clone()));
                }
                _ => refusals.extend(findings),
            },
        }
    }
    if refusals.is_empty() && manifest.entries.is_empty() {
        refusals.extend(left_alone.iter().map(|(_, finding)| finding.clone()));
    }
    if !refusals.is_empty() {
        return Err(Refusal { findings: refusals });
    }
    let info =
        match Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&rewritten) {
            Ok(info) => info,
            Err(e) => panic!("{:?}", e.into_inner()),
        };
    Ok(Rewritten {
        module: rewritten,
        info,
        manifest,
        warnings,
        left_alone,
    })
}

fn choose(module: &Module, entries: Entries) -> Result<Vec<usize>, Refusal> {
    let compute: Vec<usize> = module
        .entry_points
        .iter()
        .enumerate()
        .filter(|(_, entry)| entry.stage == ShaderStage::Compute)
        .map(|(index, _)| index)
        .collect();
    if compute.is_empty() {
        return Err(Finding::new(
            Code::NoComputeEntry,
            "the module has no compute entry point",
        )
        .into());
    }
    match entries {
        Entries::PerPixel => Ok(compute),
        Entries::Named(name) => {
            let found = compute
                .iter()
                .find(|&&index| module.entry_points[index].name == name);
            match found {
                Some(&index) => Ok(vec![index]),
                None => Err(Finding::new(
                    Code::UnknownEntry,
                    format!("no compute entry point is called `{name}`"),
                )
                .into()),
            }
        }
    }
}
pub mod emit;
pub mod instrument;
