//! Shaders with barriers: which part of the work every invocation does under its own ids, and which part is done once for
//! each primary.
//!
//! All invocations of a workgroup have to meet at its barriers, so none can leave early. But the work between two barriers
//! falls into two parts. What ends in workgroup memory is *cooperative*: every invocation does it, with its real ids, as the
//! author wrote it. What ends in a target is *per-pixel*: only invocations that have a primary do it, with the ids of that
//! primary, and since primaries sit in the low lanes, whole subgroups skip it. After the last barrier nothing is left to the
//! others, and they return.
//!
//! ```wgsl
//! // before                              // after
//! batch[lane] = lights[base + lane];     batch[lane] = lights[base + lane];
//! workgroupBarrier();                    workgroupBarrier();
//! let albedo = textureLoad(..);          if vrcs_on {
//! for (..) { sum += batch[i]; }              let albedo = textureLoad(..);
//! textureStore(dst, id.xy, sum);             for (..) { sum += batch[i]; }
//!                                            textureStore(dst, id.xy, sum); vrcs_copy_dst(id.xy, sum);
//!                                        }
//! ```
//!
//! *Does*: cuts the entry point at its barriers into [regions](skeleton), and slices it backwards twice: from what it does to
//! workgroup memory, and from its stores ([`mod@slice`]). A statement may be in both slices; then it runs twice, with either set of
//! ids, on variables of its own. What the per-pixel slice needs and cannot compute itself (an atomic's result, workgroup
//! memory that others write before the next barrier) is *exchanged*: each invocation leaves its own value in a workgroup
//! array, and takes its primary's. A region whose stores themselves need such a value is *masked*: every invocation runs it
//! with its real ids, and stores if its own pixel is a primary.
//! *Guarantees*: the tile is the workgroup, so a primary's local ids lie in it, and reads of workgroup memory at `lid +
//! offset` find what they would have found.
//! *Refuses*: barriers that not all invocations reach; helper functions with barriers that cannot be put into their
//! [callers](crate::inline); cooperative work that needs what the
//! shader stores to its targets.

pub mod report;
pub mod skeleton;
pub mod slice;
pub mod uniform;

use std::collections::{BTreeMap, BTreeSet};

use naga::{Expression, Function, GlobalVariable, Handle, LocalVariable};

use super::Planner;
use crate::{
    analysis::{Facts, Tie, term::integer},
    auto,
    finding::{Code, Finding},
    options::{Barriers, Mode},
};
use report::Group;
use skeleton::{RegionId, Skeleton};

/// A variable of one invocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variable {
    /// A local of the entry point.
    Local(Handle<LocalVariable>),
    /// A `var<private>`.
    Private(Handle<GlobalVariable>),
}

/// What is exchanged at the end of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Exchanged {
    /// A value that the region computes.
    Value(Handle<Expression>),
    /// What a variable holds.
    Variable(Variable),
}

/// What one of the two parts consists of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// The statements, by number.
    pub statements: BTreeSet<u32>,
    /// The expressions that it computes.
    pub expressions: BTreeSet<Handle<Expression>>,
    /// The variables that it uses.
    pub variables: BTreeSet<Variable>,
}

/// An entry point with barriers, taken apart.
#[derive(Clone, Debug)]
pub struct Regions {
    /// Its statements and regions.
    pub skeleton: Skeleton,
    /// What every invocation does, with its real ids.
    pub cooperative: Part,
    /// What is done for each primary.
    pub per_pixel: Part,
    /// What is exchanged, by the region at whose end it is.
    pub exchanges: BTreeMap<RegionId, BTreeSet<Exchanged>>,
    /// The regions that are masked, with the stores in them.
    pub masked: BTreeMap<RegionId, Vec<u32>>,
}

impl Regions {
    /// Takes an entry point's function apart. `facts` are those of its module.
    ///
    /// # Errors
    /// All reasons for which it cannot be done.
    pub fn find(
        facts: &Facts,
        function: &Function,
        names: &Names,
        barriers: Barriers,
    ) -> Result<Regions, Vec<Finding>> {
        let skeleton = Skeleton::find(facts, function, names)?;
        slice::slice(facts, function, names, skeleton, barriers)
    }
}

/// What things are called, for the author.
pub struct Names<'a> {
    /// The module.
    pub module: &'a naga::Module,
}

impl Names<'_> {
    /// The name of a variable.
    pub fn global(&self, global: Handle<GlobalVariable>) -> &str {
        let name = self.module.global_variables[global].name.as_deref();
        name.unwrap_or("an unnamed variable")
    }

    /// The name of a function.
    pub fn function(&self, function: Handle<Function>) -> &str {
        let name = self.module.functions[function].name.as_deref();
        name.unwrap_or("an unnamed function")
    }
}

/// What is done with an entry point whose invocations work together.
#[derive(Clone, Debug)]
pub struct GroupPlan {
    /// Whether a region is masked.
    pub is_masked: bool,
    /// The workgroup size, where no override decides.
    pub size: [Option<u32>; 3],
    /// What the manifest tells.
    pub report: Group,
}

impl Planner<'_> {
    /// Takes the entry point apart if its invocations work together.
    pub(super) fn plan_group(&mut self, facts: &Facts, barriers: Barriers) -> Option<GroupPlan> {
        let ties = &self.found.ties;
        let works_together = ties
            .iter()
            .any(|site| matches!(site.tie, Tie::Barrier | Tie::WorkGroup(_)));
        if !works_together {
            return None;
        }
        let function = &self.module.entry_points[self.entry].function;
        if self.options.mode != Mode::Tiled {
            let name = &self.module.entry_points[self.entry].name;
            let finding = auto::needs_tiles(name, self.options.mode);
            self.say(finding.at(report::first_barrier(function), "they meet here"));
            return None;
        }
        let size = self
            .found
            .group_size
            .map(|size| integer(self.found.terms.as_literal(size)).map(|size| size as u32));
        if size[2] != Some(1) {
            self.say(
                Finding::new(
                    Code::WorkgroupMemory,
                    "the workgroup has a depth, and its invocations work together",
                )
                .at(report::first_barrier(function), "they meet here")
                .help("a tile is flat: dispatch one layer of workgroups for each layer instead"),
            );
            return None;
        }
        let names = Names {
            module: self.module,
        };
        let regions = Regions::find(facts, function, &names, barriers).and_then(|regions| {
            uniform::check(self.module, facts, function, &regions.skeleton)?;
            Ok(regions)
        });
        match regions {
            Err(findings) => {
                findings.into_iter().for_each(|finding| self.say(finding));
                None
            }
            Ok(regions) => {
                let (findings, report) = regions.report(function, &names);
                findings.into_iter().for_each(|finding| self.say(finding));
                Some(GroupPlan {
                    is_masked: !regions.masked.is_empty(),
                    size,
                    report,
                })
            }
        }
    }
}
