//! Slices an entry point backwards, from what it does to workgroup memory and from its stores.
//!
//! *Does*: first finds, region by region, the values that only the invocation itself can have (`Reach`): results of
//! atomics on workgroup memory, workgroup memory that is written without a barrier between, and whatever is made of them or
//! chosen by them. Then follows both slices to their fixed point. Variables are taken as a whole: who needs a variable
//! needs all stores to it.
//! *Guarantees*: the per-pixel slice holds no write to workgroup memory and no value of that first kind; where it needs one
//! from another region, there is an exchange. A region in which a store needs one is masked, with all of its stores.
//! *Refuses*: cooperative work that needs what is stored to a target; helpers that do both.

use std::collections::{BTreeMap, BTreeSet};

use naga::{AddressSpace, Expression, Function, GlobalVariable, Handle, Statement};

use super::{
    Exchanged, Names, Part, Regions, Variable,
    skeleton::{RegionId, Skeleton},
};
use crate::{
    analysis::{
        Facts,
        facts::{Effects, constant_steps},
    },
    finding::{Code, Finding},
    ir::visit,
    options::Barriers,
};

/// What a pointer leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Root {
    Variable(Variable),
    WorkGroup(Handle<GlobalVariable>),
    Memory(Handle<GlobalVariable>),
    None,
}

/// What is asked of a function while it is sliced.
struct Slicer<'s> {
    facts: &'s Facts,
    function: &'s Function,
    names: &'s Names<'s>,
    skeleton: Skeleton,
    statements: Vec<&'s Statement>,
    /// The statements that may write each variable.
    writers: BTreeMap<Variable, Vec<u32>>,
    /// The jumps that leave or repeat each loop or switch.
    jumps: BTreeMap<u32, Vec<u32>>,
    /// The workgroup variables that are written while invocations may be in each stretch.
    written: BTreeMap<usize, BTreeSet<Handle<GlobalVariable>>>,
    reach: Reach,
    masked: BTreeMap<RegionId, Vec<u32>>,
    findings: Vec<Finding>,
}

/// What only the invocation itself can have, within a region.
#[derive(Default)]
struct Reach {
    values: BTreeSet<Handle<Expression>>,
    variables: BTreeSet<(RegionId, Variable)>,
    /// Statements inside which such a value decides.
    inside: BTreeSet<u32>,
    /// Stores that need such a value.
    stores: BTreeSet<u32>,
    /// Regions that such a value may end.
    returns: BTreeSet<RegionId>,
}

/// One of the slices, while it grows.
struct Growing {
    part: Part,
    per_pixel: bool,
    exchanges: BTreeMap<RegionId, BTreeSet<Exchanged>>,
    open: Vec<Need>,
}

#[derive(Clone, Copy)]
enum Need {
    Statement(u32),
    Value(Handle<Expression>),
    Variable(Variable),
}

/// Slices a function whose skeleton is known.
///
/// # Errors
/// All reasons for which it cannot be done.
pub fn slice(
    facts: &Facts,
    function: &Function,
    names: &Names,
    skeleton: Skeleton,
    barriers: Barriers,
) -> Result<Regions, Vec<Finding>> {
    let mut statements = Vec::with_capacity(skeleton.nodes.len());
    visit::statements(&function.body, &mut |statement| statements.push(statement));
    let mut slicer = Slicer {
        facts,
        function,
        names,
        skeleton,
        statements,
        writers: BTreeMap::new(),
        jumps: BTreeMap::new(),
        written: BTreeMap::new(),
        reach: Reach::default(),
        masked: BTreeMap::new(),
        findings: Vec::new(),
    };
    slicer.scan();
    slicer.find_reach();
    slicer.find_masked(barriers);
    let per_pixel = slicer.grow(true, slicer.per_pixel_roots());
    let mut roots = slicer.cooperative_roots();
    for exchanged in per_pixel.exchanges.values().flatten() {
        roots.push(match *exchanged {
            Exchanged::Value(value) => Need::Value(value),
            Exchanged::Variable(variable) => Need::Variable(variable),
        });
    }
    let cooperative = slicer.grow(false, roots);
    slicer.check_cooperative(&cooperative.part);
    match slicer.findings.is_empty() {
        true => Ok(Regions {
            skeleton: slicer.skeleton,
            cooperative: cooperative.part,
            per_pixel: per_pixel.part,
            exchanges: per_pixel.exchanges,
            masked: slicer.masked,
        }),
        false => Err(slicer.findings),
    }
}

impl Slicer<'_> {
    fn region(&self, statement: u32) -> Option<RegionId> {
        self.skeleton.nodes[statement as usize].region
    }

    fn numbers(&self) -> std::ops::Range<u32> {
        0..self.statements.len() as u32
    }

    /// What a pointer, or an expression that is none, leads to.
    fn root(&self, pointer: Handle<Expression>) -> Root {
        let (root, _) = constant_steps(self.function, pointer);
        match self.function.expressions[root] {
            Expression::LocalVariable(local) => Root::Variable(Variable::Local(local)),
            Expression::GlobalVariable(global) => {
                match self.names.module.global_variables[global].space {
                    AddressSpace::Private => Root::Variable(Variable::Private(global)),
                    AddressSpace::WorkGroup => Root::WorkGroup(global),
                    _ => Root::Memory(global),
                }
            }
            _ => Root::None,
        }
    }

    /// The variables that a statement may write.
    fn writes(&self, statement: &Statement) -> Vec<Variable> {
        let variable = |pointer| match self.root(pointer) {
            Root::Variable(variable) => Some(variable),
            _ => None,
        };
        match *statement {
            Statement::Store { pointer, .. } | Statement::RayQuery { query: pointer, .. } => {
                variable(pointer).into_iter().collect()
            }
            Statement::Call {
                function,
                ref arguments,
                ..
            } => {
                let facts = self.facts.function(function);
                let privates = facts.writes.iter().map(|&g| Variable::Private(g));
                let handed = arguments.iter().filter_map(|&argument| variable(argument));
                privates.chain(handed).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The variables that a statement reads besides its operands.
    fn reads(&self, statement: &Statement) -> Vec<Variable> {
        match *statement {
            Statement::Call {
                function,
                ref arguments,
                ..
            } => {
                let facts = self.facts.function(function);
                let privates = facts.reads.iter().map(|&g| Variable::Private(g));
                let handed = arguments
                    .iter()
                    .filter_map(|&argument| match self.root(argument) {
                        Root::Variable(variable) => Some(variable),
                        _ => None,
                    });
                privates.chain(handed).collect()
            }
            Statement::RayQuery { .. } => self.writes(statement),
            _ => Vec::new(),
        }
    }

    /// The workgroup variables that a statement writes.
    fn group_writes(&self, statement: &Statement) -> Vec<Handle<GlobalVariable>> {
        match *statement {
            Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => {
                match self.root(pointer) {
                    Root::WorkGroup(global) => vec![global],
                    _ => Vec::new(),
                }
            }
            Statement::Call { function, .. } => {
                let facts = self.facts.function(function);
                facts.group_writes.iter().copied().collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether a statement stores to a target.
    fn is_store(&self, statement: &Statement) -> bool {
        match *statement {
            Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => {
                matches!(self.root(pointer), Root::Memory(_))
            }
            Statement::ImageStore { .. } | Statement::ImageAtomic { .. } => true,
            Statement::Call { function, .. } => {
                let effects = self.facts.function(function).effects;
                effects.intersects(Effects::STORE | Effects::ATOMIC)
            }
            _ => false,
        }
    }

    fn scan(&mut self) {
        for number in self.numbers() {
            let statement = self.statements[number as usize];
            for variable in self.writes(statement) {
                self.writers.entry(variable).or_default().push(number);
            }
            if let Some(target) = self.skeleton.nodes[number as usize].target {
                self.jumps.entry(target).or_default().push(number);
            }
            let written = self.group_writes(statement);
            if let Some(region) = self.region(number)
                && !written.is_empty()
            {
                let stretch = self.skeleton.regions[region].stretch;
                for stretch in self.skeleton.stretches.together_with(stretch) {
                    self.written.entry(stretch).or_default().extend(&written);
                }
            }
        }
    }

    /// Whether workgroup memory is written while it is read.
    fn is_contested(&self, region: RegionId, global: Handle<GlobalVariable>) -> bool {
        let stretch = self.skeleton.regions[region].stretch;
        self.written
            .get(&stretch)
            .is_some_and(|w| w.contains(&global))
    }

    fn find_reach(&mut self) {
        loop {
            let size = |reach: &Reach| {
                reach.values.len()
                    + reach.variables.len()
                    + reach.inside.len()
                    + reach.stores.len()
                    + reach.returns.len()
            };
            let before = size(&self.reach);
            for number in self.numbers() {
                if let Some(region) = self.region(number) {
                    self.reach_statement(number, region);
                }
            }
            if size(&self.reach) == before {
                return;
            }
        }
    }

    fn reach_statement(&mut self, number: u32, region: RegionId) {
        let statement = self.statements[number as usize];
        let node = &self.skeleton.nodes[number as usize];
        let target = node.target;
        let chosen = node.parent.is_some_and(|p| self.reach.inside.contains(&p))
            || self.reach.returns.contains(&region);
        let mut own = chosen;
        visit::statement_operands(statement, &mut |&operand| own |= self.has(region, operand));
        for variable in self.reads(statement) {
            own |= self.reach.variables.contains(&(region, variable));
        }
        match *statement {
            Statement::Emit(ref range) => {
                for handle in range.clone() {
                    if self.is_own(region, handle) {
                        self.reach.values.insert(handle);
                    }
                }
                return;
            }
            Statement::Atomic {
                result: Some(result),
                ..
            } if !self.is_store(statement) => {
                self.reach.values.insert(result);
            }
            Statement::Call {
                function, result, ..
            } => {
                let facts = self.facts.function(function);
                own |= !facts.group_writes.is_empty()
                    || facts
                        .group_reads
                        .iter()
                        .any(|&g| self.is_contested(region, g));
                if own {
                    self.reach.values.extend(result);
                }
            }
            Statement::RayQuery {
                fun: naga::RayQueryFunction::Proceed { result },
                ..
            } if own => {
                self.reach.values.insert(result);
            }
            Statement::If { .. }
            | Statement::Switch { .. }
            | Statement::Loop { .. }
            | Statement::Block(_) => {
                if own {
                    self.reach.inside.insert(number);
                }
                return;
            }
            Statement::Break | Statement::Continue => {
                if chosen {
                    self.reach.inside.extend(target);
                }
                return;
            }
            Statement::Return { .. } => {
                if chosen {
                    self.reach.returns.insert(region);
                }
                return;
            }
            _ => {}
        }
        if own {
            for variable in self.writes(statement) {
                self.reach.variables.insert((region, variable));
            }
            if self.is_store(statement) {
                self.reach.stores.insert(number);
            }
        }
    }

    /// Whether a value is one of the first kind, seen from its own region.
    fn has(&self, region: RegionId, handle: Handle<Expression>) -> bool {
        self.reach.values.contains(&handle) && self.skeleton.home.get(&handle) == Some(&region)
    }

    fn is_own(&self, region: RegionId, handle: Handle<Expression>) -> bool {
        let expression = &self.function.expressions[handle];
        if let Expression::Load { pointer } = *expression {
            let own = match self.root(pointer) {
                Root::Variable(variable) => self.reach.variables.contains(&(region, variable)),
                Root::WorkGroup(global) => self.is_contested(region, global),
                _ => false,
            };
            if own {
                return true;
            }
        }
        let mut own = false;
        visit::operands(expression, &mut |&operand| own |= self.has(region, operand));
        own
    }

    /// A region with a store that needs a value of the first kind is masked, with all of its stores, so that they keep
    /// their order.
    fn find_masked(&mut self, barriers: Barriers) {
        let regions: BTreeSet<RegionId> = self
            .reach
            .stores
            .iter()
            .filter_map(|&number| self.region(number))
            .collect();
        for number in self.numbers() {
            let statement = self.statements[number as usize];
            let Some(region) = self.region(number) else {
                continue;
            };
            if !self.is_store(statement) {
                continue;
            }
            if !self.group_writes(statement).is_empty() {
                self.refuse_both(number);
            }
            if barriers == Barriers::Split && !regions.contains(&region) {
                continue;
            }
            self.masked.entry(region).or_default().push(number);
            let has_result = match *statement {
                Statement::Call { result, .. } | Statement::Atomic { result, .. } => {
                    result.is_some()
                }
                _ => false,
            };
            if has_result {
                self.refuse_result(number);
            }
        }
    }

    fn refuse_both(&mut self, number: u32) {
        let finding = Finding::new(
            Code::WorkgroupMemory,
            format!(
                "{} writes to workgroup memory and to a target",
                self.called(number)
            ),
        )
        .at(
            self.skeleton.nodes[number as usize].span,
            "every invocation has to do the one, only primaries the other",
        )
        .help("make two functions of it");
        self.findings.push(finding);
    }

    fn refuse_result(&mut self, number: u32) {
        let finding = Finding::new(
            Code::WorkgroupMemory,
            format!(
                "{} stores to a target under values of its own invocation, and gives a result",
                self.called(number)
            ),
        )
        .at(
            self.skeleton.nodes[number as usize].span,
            "only primaries may store, and all invocations need the result",
        )
        .help("return the value, and store it in the entry point");
        self.findings.push(finding);
    }

    fn called(&self, number: u32) -> String {
        match *self.statements[number as usize] {
            Statement::Call { function, .. } => {
                format!("the helper function `{}`", self.names.function(function))
            }
            _ => "a statement".to_owned(),
        }
    }

    fn per_pixel_roots(&self) -> Vec<Need> {
        let mut roots = Vec::new();
        let mut with_stores = BTreeSet::new();
        for number in self.numbers() {
            let Some(region) = self.region(number) else {
                continue;
            };
            if self.is_store(self.statements[number as usize]) && !self.masked.contains_key(&region)
            {
                roots.push(Need::Statement(number));
                with_stores.insert(region);
            }
        }
        roots.extend(self.returns(&with_stores));
        roots
    }

    /// The returns inside regions; they decide what behind them runs.
    fn returns(&self, regions: &BTreeSet<RegionId>) -> Vec<Need> {
        self.numbers()
            .filter(|&number| {
                matches!(self.statements[number as usize], Statement::Return { .. })
                    && self.region(number).is_some_and(|r| regions.contains(&r))
            })
            .map(Need::Statement)
            .collect()
    }

    fn cooperative_roots(&self) -> Vec<Need> {
        let mut roots = Vec::new();
        for number in self.numbers() {
            let statement = self.statements[number as usize];
            match self.region(number) {
                None => roots.push(Need::Statement(number)),
                // what is written behind the last barrier can only be read by masked stores
                Some(region) => {
                    let counts =
                        !self.skeleton.regions[region].is_last || self.masked.contains_key(&region);
                    if counts && !self.group_writes(statement).is_empty() {
                        roots.push(Need::Statement(number));
                    }
                }
            }
        }
        let masked: BTreeSet<RegionId> = self.masked.keys().copied().collect();
        roots.extend(self.masked.values().flatten().map(|&n| Need::Statement(n)));
        roots.extend(self.returns(&masked));
        roots
    }

    fn grow(&self, per_pixel: bool, roots: Vec<Need>) -> Growing {
        let mut growing = Growing {
            part: Part::default(),
            per_pixel,
            exchanges: BTreeMap::new(),
            open: roots,
        };
        while let Some(need) = growing.open.pop() {
            match need {
                Need::Statement(number) => self.need_statement(&mut growing, number),
                Need::Value(handle) => self.need_value(&mut growing, handle),
                Need::Variable(variable) => self.need_variable(&mut growing, variable),
            }
        }
        growing
    }

    fn need_statement(&self, growing: &mut Growing, number: u32) {
        // all invocations walk through the skeleton together; its conditions are the cooperative part's
        let is_skeleton = self.region(number).is_none();
        if is_skeleton && growing.per_pixel || !growing.part.statements.insert(number) {
            return;
        }
        let statement = self.statements[number as usize];
        visit::statement_operands(statement, &mut |&operand| {
            growing.open.push(Need::Value(operand))
        });
        let reads = self.reads(statement);
        growing.open.extend(reads.into_iter().map(Need::Variable));
        if let Some(parent) = self.skeleton.nodes[number as usize].parent {
            growing.open.push(Need::Statement(parent));
        }
        let jumps = self.jumps.get(&number).into_iter().flatten();
        growing
            .open
            .extend(jumps.map(|&jump| Need::Statement(jump)));
    }

    fn need_value(&self, growing: &mut Growing, handle: Handle<Expression>) {
        let Some(&giver) = self.skeleton.giver.get(&handle) else {
            // what needs no computing: a variable's value is asked for by its load
            return;
        };
        let Some(&region) = self.skeleton.home.get(&handle) else {
            // given by the skeleton, and the same for all
            return;
        };
        if growing.per_pixel && self.reach.values.contains(&handle) {
            let exchanged = Exchanged::Value(handle);
            growing
                .exchanges
                .entry(region)
                .or_default()
                .insert(exchanged);
            return;
        }
        if !growing.part.expressions.insert(handle) {
            return;
        }
        growing.open.push(Need::Statement(giver));
        let expression = &self.function.expressions[handle];
        visit::operands(expression, &mut |&operand| {
            growing.open.push(Need::Value(operand))
        });
        if let Expression::Load { pointer } = *expression
            && let Root::Variable(variable) = self.root(pointer)
        {
            growing.open.push(Need::Variable(variable));
        }
    }

    fn need_variable(&self, growing: &mut Growing, variable: Variable) {
        if !growing.part.variables.insert(variable) {
            return;
        }
        for &writer in self.writers.get(&variable).into_iter().flatten() {
            let region = self.region(writer);
            match region {
                Some(region)
                    if growing.per_pixel && self.reach.variables.contains(&(region, variable)) =>
                {
                    let exchanged = Exchanged::Variable(variable);
                    growing
                        .exchanges
                        .entry(region)
                        .or_default()
                        .insert(exchanged);
                }
                _ => growing.open.push(Need::Statement(writer)),
            }
        }
    }

    /// Cooperative work runs for all invocations before the targets hold all that the original would have stored.
    fn check_cooperative(&mut self, part: &Part) {
        let mut findings = Vec::new();
        for &handle in &part.expressions {
            let global = match self.function.expressions[handle] {
                Expression::Load { pointer } => match self.root(pointer) {
                    Root::Memory(global) => {
                        let (_, steps) = constant_steps(self.function, pointer);
                        self.facts.is_written(global, &steps).then_some(global)
                    }
                    _ => None,
                },
                Expression::ImageLoad { image, .. } => match self.root(image) {
                    Root::Memory(global) if self.is_written_image(global) => Some(global),
                    _ => None,
                },
                _ => None,
            };
            if let Some(global) = global {
                let finding = Finding::new(
                    Code::ReadsOthersOutput,
                    format!(
                        "`{}` is stored to, and read for the whole workgroup",
                        self.names.global(global)
                    ),
                )
                .at(
                    self.function.expressions.get_span(handle),
                    "goes into workgroup memory, or into an exchange",
                )
                .help("read from a second resource that this dispatch does not write, as a ping-pong pair does");
                findings.push(finding);
            }
        }
        let masked: BTreeSet<u32> = self.masked.values().flatten().copied().collect();
        for &number in &part.statements {
            let Statement::Call { function, .. } = *self.statements[number as usize] else {
                continue;
            };
            let effects = self.facts.function(function).effects;
            let stores =
                self.is_store(self.statements[number as usize]) && !masked.contains(&number);
            if stores || effects.contains(Effects::READS_WRITTEN) {
                let finding = Finding::new(
                    Code::ReadsOthersOutput,
                    format!(
                        "the helper function `{}` works on a target, and its result is needed for the whole workgroup",
                        self.names.function(function)
                    ),
                )
                .at(
                    self.skeleton.nodes[number as usize].span,
                    "needed for workgroup memory, or for an exchange",
                );
                findings.push(finding);
            }
        }
        self.findings.append(&mut findings);
    }

    fn is_written_image(&self, global: Handle<GlobalVariable>) -> bool {
        let module = self.names.module;
        let ty = module.global_variables[global].ty;
        let is_storage = matches!(
            module.types[ty].inner,
            naga::TypeInner::Image {
                class: naga::ImageClass::Storage { .. },
                ..
            }
        );
        is_storage && self.facts.is_written_anywhere(global)
    }
}
