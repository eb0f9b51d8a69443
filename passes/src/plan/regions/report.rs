//! What the author is told of an entry point's regions.

use naga::{Function, Span, Statement};
use serde::{Deserialize, Serialize};

use super::{Exchanged, Names, Regions, Variable};
use crate::{
    finding::{Code, Finding},
    ir::visit,
};

/// How an entry point with barriers, or with workgroup memory, was taken apart.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Group {
    /// The regions between its barriers.
    pub regions: u32,
    /// Those of them in which work is done for primaries only, so that subgroups retire.
    pub per_pixel: u32,
    /// Those in which every invocation runs, and only primaries store.
    pub masked: u32,
    /// The values that are handed on through workgroup memory, by name.
    pub exchanged: Vec<String>,
    /// Bytes of workgroup memory that the author's variables take.
    pub author_memory: u32,
    /// Bytes of workgroup memory that were added.
    pub added_memory: u32,
}

impl Regions {
    /// The findings, and what is counted.
    pub fn report(&self, function: &Function, names: &Names) -> (Vec<Finding>, Group) {
        let mut findings = Vec::new();
        let mut group = Group {
            regions: self.skeleton.regions.len() as u32,
            per_pixel: self.per_pixel_regions().len() as u32,
            masked: self.masked.len() as u32,
            ..Group::default()
        };
        for &exchanged in self.exchanges.values().flatten() {
            let (name, span) = match exchanged {
                Exchanged::Value(handle) => (
                    function.named_expressions.get(&handle).cloned(),
                    function.expressions.get_span(handle),
                ),
                Exchanged::Variable(Variable::Local(local)) => (
                    function.local_variables[local].name.clone(),
                    function.local_variables.get_span(local),
                ),
                Exchanged::Variable(Variable::Private(global)) => (
                    Some(names.global(global).to_owned()),
                    names.module.global_variables.get_span(global),
                ),
            };
            let called = match &name {
                Some(name) => format!("`{name}`"),
                None => "a value".to_owned(),
            };
            group
                .exchanged
                .push(name.unwrap_or_else(|| "a value".to_owned()));
            findings.push(
                Finding::new(
                    Code::Exchanged,
                    format!("{called} is handed to the invocation that shades for it through workgroup memory"),
                )
                .at(span, "only the invocation itself can know it")
                .help("to save the memory, compute it from the ids behind the barrier"),
            );
        }
        for stores in self.masked.values() {
            let mut finding = Finding::new(
                Code::MaskedRegion,
                "a region works for the whole workgroup and stores what it finds out: no wave retires there",
            );
            for &store in stores {
                finding = finding.at(
                    self.skeleton.nodes[store as usize].span,
                    "every invocation gets here, and only primaries store",
                );
            }
            findings.push(finding.help(
                "put a barrier between the work on workgroup memory and the work on the pixel",
            ));
        }
        (findings, group)
    }

    /// The regions in which something is done for primaries only.
    pub fn per_pixel_regions(&self) -> Vec<usize> {
        let mut regions: Vec<usize> = self
            .per_pixel
            .statements
            .iter()
            .filter_map(|&number| self.skeleton.nodes[number as usize].region)
            .chain(
                self.per_pixel
                    .expressions
                    .iter()
                    .filter_map(|handle| self.skeleton.home.get(handle).copied()),
            )
            .collect();
        regions.sort_unstable();
        regions.dedup();
        regions
    }
}

/// Where the first barrier of a function stands.
pub fn first_barrier(function: &Function) -> Span {
    let mut found = Span::UNDEFINED;
    fn look(block: &naga::Block, found: &mut Span) {
        for (statement, &span) in block.span_iter() {
            let is_barrier = matches!(
                statement,
                Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. }
            );
            if is_barrier && !found.is_defined() {
                *found = span;
            }
            visit::sub_blocks(statement, &mut |block| look(block, found));
        }
    }
    look(&function.body, &mut found);
    found
}
