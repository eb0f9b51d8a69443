//! Cuts a function with barriers into regions.
//!
//! *Does*: numbers the statements as [`rebuild`](crate::ir::statements::rebuild) does, tells which of them are the
//! *skeleton* that all invocations walk through together (barriers, what holds a barrier, what jumps past one), and
//! gathers what stands between into regions, each of which lies in a [stretch](Stretches): what is written to workgroup memory in one,
//! nobody else may read in another that is joined to it by a way without a barrier.
//! *Refuses*: calls of functions with barriers inside that could not be [put into their callers](crate::inline).

use std::collections::{BTreeMap, BTreeSet};

use naga::{Block, Expression, Function, Handle, Span, Statement};

use super::Names;
use crate::{
    analysis::{Facts, facts::Effects},
    finding::{Code, Finding},
    inline,
    ir::visit,
};

/// A region, by its place in [`Skeleton::regions`].
pub type RegionId = usize;

/// A run of statements without a barrier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// The [stretch](Stretches) that it lies in.
    pub stretch: usize,
    /// Whether no barrier can follow, so that statements in it may return.
    pub is_last: bool,
    /// Whether a barrier of workgroup memory stands right behind it.
    pub before_barrier: bool,
    /// Whether it is run again without another barrier than the one behind it on the way.
    pub needs_entry_barrier: bool,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Node {
    /// The statement around it.
    pub parent: Option<u32>,
    /// The region that it lies in; `None` for the skeleton.
    pub region: Option<RegionId>,
    /// For a jump, what it leaves or repeats.
    pub target: Option<u32>,
    /// Where it stands in the source.
    pub span: Span,
}

/// A function's statements, told apart.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// The statements, by number.
    pub nodes: Vec<Node>,
    /// The regions, in the order of the text.
    pub regions: Vec<Region>,
    /// Where one can get from where without a barrier.
    pub stretches: Stretches,
    /// The region of each expression that one computes.
    pub home: BTreeMap<Handle<Expression>, RegionId>,
    /// The statement that gives each expression: its `Emit`, its call, its atomic.
    pub giver: BTreeMap<Handle<Expression>, u32>,
}

/// Pieces of the skeleton in which no barrier stands, and which of them follow one another without a barrier between. All invocations
/// of a workgroup take the same way through the skeleton, so two pieces that no such way joins are never under way together: the two
/// arms of an `if`, or what stands before a barrier in one arm and what comes after the `if`.
#[derive(Clone, Debug, Default)]
pub struct Stretches {
    /// Those that follow each at once.
    next: Vec<Vec<usize>>,
}

impl Stretches {
    fn fresh(&mut self) -> usize {
        self.next.push(Vec::new());
        self.next.len() - 1
    }

    /// A new one that follows another.
    fn after(&mut self, from: usize) -> usize {
        let fresh = self.fresh();
        self.lead(from, fresh);
        fresh
    }

    fn lead(&mut self, from: usize, to: usize) {
        self.next[from].push(to);
    }

    /// Those that invocations may be in while others are still in one, or already in it: it, and those that lead to it or that it leads to.
    pub fn together_with(&self, stretch: usize) -> BTreeSet<usize> {
        let mut previous = vec![Vec::new(); self.next.len()];
        for (from, next) in self.next.iter().enumerate() {
            next.iter().for_each(|&to| previous[to].push(from));
        }
        let mut found = reached(&self.next, stretch);
        found.extend(reached(&previous, stretch));
        found
    }
}

/// What can be reached in a graph from a node on, the node too.
fn reached(edges: &[Vec<usize>], from: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::from([from]);
    let mut open = vec![from];
    while let Some(node) = open.pop() {
        open.extend(edges[node].iter().filter(|&&to| found.insert(to)));
    }
    found
}

/// A loop or switch of the skeleton that the walk is inside of.
struct Around {
    statement: u32,
    is_loop: bool,
    breaks: usize,
    continues: usize,
}

struct Walk<'w> {
    facts: &'w Facts,
    names: &'w Names<'w>,
    found: Skeleton,
    around: Vec<Around>,
    findings: Vec<Finding>,
}

impl Skeleton {
    /// Cuts a function into regions.
    ///
    /// # Errors
    /// Calls that hide a barrier.
    pub fn find(
        facts: &Facts,
        function: &Function,
        names: &Names,
    ) -> Result<Skeleton, Vec<Finding>> {
        let mut walk = Walk {
            facts,
            names,
            found: Skeleton {
                nodes: Vec::new(),
                regions: Vec::new(),
                stretches: Stretches::default(),
                home: BTreeMap::new(),
                giver: BTreeMap::new(),
            },
            around: Vec::new(),
            findings: Vec::new(),
        };
        let first = walk.found.stretches.fresh();
        walk.block(&function.body, None, first, true, false);
        if !walk.findings.is_empty() {
            return Err(walk.findings);
        }
        Ok(walk.found)
    }

    /// Whether `outer` is `inner` or stands around it.
    pub fn is_inside(&self, mut inner: u32, outer: u32) -> bool {
        loop {
            if inner == outer {
                return true;
            }
            match self.nodes[inner as usize].parent {
                Some(parent) => inner = parent,
                None => return false,
            }
        }
    }
}

impl Walk<'_> {
    /// Walks a block of the skeleton from a stretch on; the stretch at its end. `last`: no barrier can follow the block.
    /// `again`: the block is a loop's body.
    fn block(
        &mut self,
        block: &Block,
        parent: Option<u32>,
        mut stretch: usize,
        last: bool,
        again: bool,
    ) -> usize {
        let last_barrier = block.iter().rposition(has_barrier);
        let ends_here = |index: usize| {
            last && block
                .iter()
                .skip(index + 1)
                .all(|s| matches!(s, Statement::Return { .. }))
        };
        let barriers = block.iter().filter(|s| is_barrier(s)).count();
        let mut open: Option<RegionId> = None;
        for (index, (statement, &span)) in block.span_iter().enumerate() {
            let behind = last && last_barrier.is_none_or(|barrier| index > barrier);
            if !self.is_skeleton(statement, behind) {
                let region = *open.get_or_insert_with(|| {
                    self.found.regions.push(Region {
                        stretch,
                        is_last: behind,
                        before_barrier: false,
                        needs_entry_barrier: again || !self.around.is_empty(),
                    });
                    self.found.regions.len() - 1
                });
                self.inside(statement, span, parent, region);
                continue;
            }
            if let Some(region) = open.take() {
                let region = &mut self.found.regions[region];
                region.before_barrier = is_group_barrier(statement);
                // the way around a loop leads through its other barriers
                region.needs_entry_barrier &= !(region.before_barrier && barriers > 1);
            }
            stretch = self.skeleton(statement, span, parent, stretch, ends_here(index));
        }
        stretch
    }

    /// Whether all invocations have to walk through a statement together.
    fn is_skeleton(&mut self, statement: &Statement, behind: bool) -> bool {
        let mut hidden = None;
        let mut each = |statement: &Statement| {
            if let Statement::Call { function, .. } = *statement
                && self
                    .facts
                    .function(function)
                    .effects
                    .contains(Effects::BARRIER)
            {
                hidden = Some(function);
            }
        };
        each(statement);
        visit::sub_blocks(statement, &mut |block| visit::statements(block, &mut each));
        if let Some(function) = hidden {
            let module = self.names.module;
            let why = inline::unfit(module, &module.functions[function]);
            let why = why.map(|why| format!(", and cannot be put into its caller's place: {why}"));
            let finding = Finding::new(
                Code::WorkgroupMemory,
                format!(
                    "the helper function `{}` has a barrier inside{}",
                    self.names.function(function),
                    why.unwrap_or_default()
                ),
            )
            .at(
                module.functions.get_span(function),
                "every invocation of the workgroup has to get through here",
            )
            .help("let it return at its end alone, or move the barrier into the entry point, and what stands before and behind it into functions of their own");
            if !self.findings.contains(&finding) {
                self.findings.push(finding);
            }
        }
        has_barrier(statement) || jumps_out(statement, behind)
    }

    fn enter(&mut self, span: Span, parent: Option<u32>, region: Option<RegionId>) -> u32 {
        self.found.nodes.push(Node {
            parent,
            region,
            target: None,
            span,
        });
        self.found.nodes.len() as u32 - 1
    }

    /// Walks a statement of the skeleton.
    fn skeleton(
        &mut self,
        statement: &Statement,
        span: Span,
        parent: Option<u32>,
        stretch: usize,
        last: bool,
    ) -> usize {
        let number = self.enter(span, parent, None);
        match statement {
            Statement::Block(block) => self.block(block, Some(number), stretch, last, false),
            Statement::If { accept, reject, .. } => {
                let end = self.found.stretches.fresh();
                for arm in [accept, reject] {
                    let start = self.found.stretches.after(stretch);
                    let falls = self.block(arm, Some(number), start, last, false);
                    self.found.stretches.lead(falls, end);
                }
                end
            }
            Statement::Switch { cases, .. } => {
                let end = self.found.stretches.fresh();
                self.around.push(Around {
                    statement: number,
                    is_loop: false,
                    breaks: end,
                    continues: end,
                });
                let mut before = None;
                for case in cases {
                    let start = self.found.stretches.after(stretch);
                    if let Some(before) = before {
                        self.found.stretches.lead(before, start);
                    }
                    let falls = self.block(&case.body, Some(number), start, last, false);
                    self.found.stretches.lead(falls, end);
                    before = case.fall_through.then_some(falls);
                }
                self.around.pop();
                end
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                let start = self.found.stretches.after(stretch);
                let [middle, end] = [(); 2].map(|()| self.found.stretches.fresh());
                self.around.push(Around {
                    statement: number,
                    is_loop: true,
                    breaks: end,
                    continues: middle,
                });
                let falls = self.block(body, Some(number), start, false, true);
                self.found.stretches.lead(falls, middle);
                let falls = self.block(continuing, Some(number), middle, false, true);
                self.found.stretches.lead(falls, start);
                if break_if.is_some() {
                    self.found.stretches.lead(falls, end);
                }
                self.around.pop();
                end
            }
            Statement::Break | Statement::Continue => {
                let is_break = matches!(statement, Statement::Break);
                let target = self.around.iter().rev().find(|a| is_break || a.is_loop);
                if let Some(target) = target {
                    let to = if is_break {
                        target.breaks
                    } else {
                        target.continues
                    };
                    self.found.nodes[number as usize].target = Some(target.statement);
                    self.found.stretches.lead(stretch, to);
                }
                self.found.stretches.fresh()
            }
            Statement::WorkGroupUniformLoad { result, .. } => {
                self.found.giver.insert(*result, number);
                self.found.stretches.fresh()
            }
            // nothing follows a return
            Statement::Return { .. } => self.found.stretches.fresh(),
            statement if is_group_barrier(statement) => self.found.stretches.fresh(),
            _ => stretch,
        }
    }

    /// Numbers a statement of a region, and what is inside it.
    fn inside(&mut self, statement: &Statement, span: Span, parent: Option<u32>, region: RegionId) {
        let number = self.enter(span, parent, Some(region));
        let mut gives = |handle: Handle<Expression>| {
            self.found.home.insert(handle, region);
            self.found.giver.insert(handle, number);
        };
        match *statement {
            Statement::Emit(ref range) => range.clone().for_each(gives),
            Statement::Call { result, .. } | Statement::Atomic { result, .. } => {
                result.into_iter().for_each(gives);
            }
            Statement::RayQuery {
                fun: naga::RayQueryFunction::Proceed { result },
                ..
            }
            | Statement::SubgroupBallot { result, .. }
            | Statement::SubgroupGather { result, .. }
            | Statement::SubgroupCollectiveOperation { result, .. } => gives(result),
            Statement::Break | Statement::Continue => {
                let is_break = matches!(statement, Statement::Break);
                let target = self.around.iter().rev().find(|a| is_break || a.is_loop);
                self.found.nodes[number as usize].target = target.map(|a| a.statement);
            }
            _ => {}
        }
        let is_loop = matches!(statement, Statement::Loop { .. });
        if is_loop || matches!(statement, Statement::Switch { .. }) {
            self.around.push(Around {
                statement: number,
                is_loop,
                breaks: 0,
                continues: 0,
            });
        }
        visit::sub_blocks(statement, &mut |block| {
            for (statement, &span) in block.span_iter() {
                self.inside(statement, span, Some(number), region);
            }
        });
        if is_loop || matches!(statement, Statement::Switch { .. }) {
            self.around.pop();
        }
    }
}

fn is_barrier(statement: &Statement) -> bool {
    matches!(
        statement,
        Statement::ControlBarrier(_)
            | Statement::MemoryBarrier(_)
            | Statement::WorkGroupUniformLoad { .. }
    )
}

/// Whether a statement makes writes to workgroup memory visible.
fn is_group_barrier(statement: &Statement) -> bool {
    match statement {
        Statement::ControlBarrier(flags) => flags.contains(naga::Barrier::WORK_GROUP),
        Statement::WorkGroupUniformLoad { .. } => true,
        _ => false,
    }
}

fn has_barrier(statement: &Statement) -> bool {
    let mut found = is_barrier(statement);
    visit::sub_blocks(statement, &mut |block| {
        visit::statements(block, &mut |inner| found |= is_barrier(inner));
    });
    found
}

/// Whether a statement may leave what stands around it: by a jump to something outside, or by a return before the last
/// barrier.
fn jumps_out(statement: &Statement, may_return: bool) -> bool {
    leaves(statement, may_return, false, false)
}

/// Whether something inside a statement jumps past it, where `break` or `continue` is caught around it.
fn leaves(statement: &Statement, may_return: bool, breaks: bool, continues: bool) -> bool {
    let (breaks, continues) = match statement {
        Statement::Return { .. } => return !may_return,
        Statement::Break => return !breaks,
        Statement::Continue => return !continues,
        Statement::Loop { .. } => (true, true),
        Statement::Switch { .. } => (true, continues),
        _ => (breaks, continues),
    };
    let mut out = false;
    visit::sub_blocks(statement, &mut |block| {
        out |= block
            .iter()
            .any(|inner| leaves(inner, may_return, breaks, continues));
    });
    out
}
