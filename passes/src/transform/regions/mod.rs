//! Splits an entry point with barriers into its cooperative and its per-pixel part (see [`plan::regions`](crate::plan::regions)).
//!
//! ```wgsl
//! // before                               // after: main_inner(lid, .., vrcs_lid, ..)
//! let v = textureLoad(src, id.xy, 0);     let v = textureLoad(src, id.xy, 0);
//! tile[lid.x] = v;                        tile[lid.x] = v;
//! workgroupBarrier();                     workgroupBarrier();
//! let sum = tile[lid.x] + tile[0];        if vrcs_on {
//! textureStore(dst, id.xy, sum);              let sum = tile[vrcs_lid.x] + tile[0];
//!                                             textureStore(dst, vrcs_id.xy, sum);
//!                                             vrcs_copy_dst(vrcs_id.xy, sum);
//!                                         }
//! ```
//!
//! *Does*: leaves the cooperative part where it stands, takes everything else out of it, and puts a copy of the per-pixel
//! part behind it, region by region, under a condition that holds no barrier. Values that live from one per-pixel region
//! into another are kept in locals; variables that both parts use get a twin.
//! *Needs*: the entry point as an ordinary function, with its copies already in place; its arguments are doubled.
//! *Guarantees*: handles of the cooperative part keep their meaning; the skeleton keeps its order.

pub mod entry;
mod own;
mod real;
mod room;

use std::collections::BTreeMap;

use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Literal, LocalVariable,
    Module, Span, Statement, Type, front::Typifier, proc::ResolveContext,
};

use crate::{
    analysis::Facts,
    finding::Finding,
    ir::{build::Code, visit},
    options::Barriers,
    plan::regions::{Exchanged, Names, Part, Regions, Variable, skeleton::RegionId},
};
use entry::GroupPrelude;
pub use room::{Memory, check as check_memory};

/// The most invocations of a workgroup whose size an override decides: WebGPU's default limit.
pub const LARGEST_GROUP: u32 = 256;

/// A function while it is split.
struct Split<'s> {
    regions: &'s Regions,
    prelude: &'s GroupPrelude,
    /// The expressions as they were.
    before: naga::Arena<Expression>,
    /// The per-pixel part's arguments.
    arguments: Vec<Handle<Expression>>,
    /// The per-pixel part's locals, where the cooperative part has the author's.
    twins: BTreeMap<Handle<LocalVariable>, Handle<Expression>>,
    /// Private variables that both parts use: the per-pixel part's value between regions, and room for the other's.
    swapped: Vec<Swapped>,
    /// Locals for values that live from one per-pixel region into another.
    kept: BTreeMap<Handle<Expression>, Handle<Expression>>,
    /// Where a region leaves what is exchanged.
    arrays: BTreeMap<(RegionId, Exchanged), Handle<GlobalVariable>>,
    /// The per-pixel part's value of each expression, within the region at hand.
    values: BTreeMap<Handle<Expression>, Handle<Expression>>,
}

/// A private variable that both parts use.
struct Swapped {
    variable: Handle<GlobalVariable>,
    own: Handle<GlobalVariable>,
    room: Handle<Expression>,
}

/// Splits `inner`, which lies in `module`.
///
/// # Errors
/// If it cannot be split; the plan has seen to it that it can.
pub fn split(
    module: &mut Module,
    entry: usize,
    inner: Handle<Function>,
    prelude: &GroupPrelude,
    area: u32,
    barriers: Barriers,
) -> Result<(), Vec<Finding>> {
    let facts = Facts::new(module, entry);
    let mut function = module.functions[inner].clone();
    let regions = Regions::find(&facts, &function, &Names { module }, barriers)?;
    if !regions.masked.is_empty() && prelude.masks.is_none() {
        let finding = Finding::new(
            crate::finding::Code::Defect,
            "the copies of a store need a value that the store itself does not",
        );
        return Err(vec![finding]);
    }
    let types = types(module, &function);
    let mut split = Split {
        regions: &regions,
        prelude,
        before: function.expressions.clone(),
        arguments: Vec::new(),
        twins: BTreeMap::new(),
        swapped: Vec::new(),
        kept: BTreeMap::new(),
        arrays: BTreeMap::new(),
        values: BTreeMap::new(),
    };
    let body = std::mem::take(&mut function.body);
    split.double_arguments(&mut function);
    split.double_variables(module, &mut function, &body);
    split.make_room(module, &mut function, &types, &body, area);
    let mut next = 0;
    function.body = split.skeleton(module, &mut function, &body, &mut next);
    clear_dead(&mut function, &regions, split.before.len());
    module.functions[inner] = function;
    Ok(())
}

/// The types of a function's expressions.
fn types(module: &mut Module, function: &Function) -> Vec<Option<Handle<Type>>> {
    let mut typifier = Typifier::new();
    for (handle, _) in function.expressions.iter() {
        let context =
            ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
        if let Err(error) = typifier.grow(handle, &function.expressions, &context) {
            unreachable!("the validator has typed this expression: {error}");
        }
    }
    let is_kept = |handle: Handle<Expression>| !function.expressions[handle].needs_pre_emit();
    function
        .expressions
        .iter()
        .map(|(handle, _)| {
            is_kept(handle).then(|| typifier.register_type(handle, &mut module.types))
        })
        .collect()
}

/// Takes out what neither part computes any more, so that nothing dead refers to anything.
fn clear_dead(function: &mut Function, regions: &Regions, count: usize) {
    let mut alive: Vec<bool> = vec![false; function.expressions.len()];
    let mut open: Vec<Handle<Expression>> = function
        .local_variables
        .iter()
        .filter_map(|(_, local)| local.init)
        .collect();
    while let Some(handle) = open.pop() {
        if !std::mem::replace(&mut alive[handle.index()], true) {
            visit::operands(&function.expressions[handle], &mut |&operand| {
                open.push(operand)
            });
        }
    }
    let mut dead = Vec::new();
    for (handle, expression) in function.expressions.iter().take(count) {
        let computed = regions.skeleton.home.contains_key(&handle);
        if computed
            && !alive[handle.index()]
            && !expression.needs_pre_emit()
            && !regions.cooperative.expressions.contains(&handle)
        {
            dead.push(handle);
        }
    }
    for handle in dead {
        function.expressions[handle] = Expression::Literal(Literal::U32(0));
        function.named_expressions.swap_remove(&handle);
    }
}

/// Whether an expression is a pointer, or an element of a binding array: it can be written anew anywhere.
fn is_place(expressions: &naga::Arena<Expression>, mut handle: Handle<Expression>) -> bool {
    loop {
        handle = match expressions[handle] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => base,
            Expression::GlobalVariable(_) | Expression::LocalVariable(_) => return true,
            _ => return false,
        };
    }
}

impl Split<'_> {
    fn real(&self) -> &Part {
        &self.regions.cooperative
    }

    fn own(&self) -> &Part {
        &self.regions.per_pixel
    }

    /// The per-pixel part gets the ids of the primary as arguments of its own.
    fn double_arguments(&mut self, function: &mut Function) {
        for index in 0..function.arguments.len() {
            let mut argument = function.arguments[index].clone();
            argument.name = argument.name.map(|name| format!("vrcs_own_{name}"));
            function.arguments.push(argument);
            let number = function.arguments.len() as u32 - 1;
            self.arguments.push(
                function
                    .expressions
                    .append(Expression::FunctionArgument(number), Span::UNDEFINED),
            );
        }
    }

    /// Variables that both parts use get a twin for the per-pixel part.
    fn double_variables(&mut self, module: &mut Module, function: &mut Function, body: &Block) {
        let written = written_privates(module, function, body);
        let both: Vec<Variable> = self
            .own()
            .variables
            .intersection(&self.real().variables)
            .copied()
            .collect();
        for variable in both {
            match variable {
                Variable::Local(local) => {
                    let twin = function.local_variables[local].clone();
                    let name = twin.name.as_deref().unwrap_or("local");
                    let twin = LocalVariable {
                        name: Some(format!("vrcs_own_{name}")),
                        ..twin
                    };
                    let span = function.local_variables.get_span(local);
                    let twin = function.local_variables.append(twin, span);
                    let pointer = function
                        .expressions
                        .append(Expression::LocalVariable(twin), Span::UNDEFINED);
                    self.twins.insert(local, pointer);
                }
                Variable::Private(global) if written.contains(&global) => {
                    let twin = module.global_variables[global].clone();
                    let name = twin.name.clone().unwrap_or_else(|| "private".to_owned());
                    let room = function.local_variables.append(
                        LocalVariable {
                            name: Some(format!("vrcs_real_{name}")),
                            ty: twin.ty,
                            init: None,
                        },
                        Span::UNDEFINED,
                    );
                    let room = function
                        .expressions
                        .append(Expression::LocalVariable(room), Span::UNDEFINED);
                    let own = module.global_variables.append(
                        GlobalVariable {
                            name: Some(format!("vrcs_own_{name}")),
                            ..twin
                        },
                        Span::UNDEFINED,
                    );
                    self.swapped.push(Swapped {
                        variable: global,
                        own,
                        room,
                    });
                }
                Variable::Private(_) => {}
            }
        }
    }

    /// Room for what lives from region to region, and for what is exchanged.
    fn make_room(
        &mut self,
        module: &mut Module,
        function: &mut Function,
        types: &[Option<Handle<Type>>],
        body: &Block,
        area: u32,
    ) {
        let type_of = |handle: Handle<Expression>| match types[handle.index()] {
            Some(ty) => ty,
            None => unreachable!("what is kept is computed"),
        };
        for handle in self.crossing(body) {
            let name = function.named_expressions.get(&handle);
            let name = name.map_or("kept", String::as_str);
            let local = function.local_variables.append(
                LocalVariable {
                    name: Some(format!("vrcs_own_{name}")),
                    ty: type_of(handle),
                    init: None,
                },
                Span::UNDEFINED,
            );
            let pointer = function
                .expressions
                .append(Expression::LocalVariable(local), Span::UNDEFINED);
            self.kept.insert(handle, pointer);
        }
        for (&region, exchanged) in &self.regions.exchanges {
            for &exchanged in exchanged {
                let (ty, name) = match exchanged {
                    Exchanged::Value(handle) => (
                        type_of(handle),
                        function.named_expressions.get(&handle).cloned(),
                    ),
                    Exchanged::Variable(Variable::Local(local)) => {
                        let local = &function.local_variables[local];
                        (local.ty, local.name.clone())
                    }
                    Exchanged::Variable(Variable::Private(global)) => {
                        let global = &module.global_variables[global];
                        (global.ty, global.name.clone())
                    }
                };
                let array = room::array(module, ty, area);
                let array = module.global_variables.append(
                    GlobalVariable {
                        name: Some(format!(
                            "vrcs_exchange_{}",
                            name.as_deref().unwrap_or("value")
                        )),
                        space: AddressSpace::WorkGroup,
                        binding: None,
                        ty: array,
                        init: None,
                        memory_decorations: naga::MemoryDecorations::empty(),
                    },
                    Span::UNDEFINED,
                );
                self.arrays.insert((region, exchanged), array);
            }
        }
    }

    /// Rebuilds a block of the skeleton.
    fn skeleton(
        &mut self,
        module: &mut Module,
        function: &mut Function,
        block: &Block,
        next: &mut u32,
    ) -> Block {
        let mut out = Block::new();
        let mut run: Vec<(u32, &Statement, Span)> = Vec::new();
        let mut taken: Option<RegionId> = None;
        for (statement, &span) in block.span_iter() {
            let number = *next;
            if self.regions.skeleton.nodes[number as usize]
                .region
                .is_some()
            {
                run.push((number, statement, span));
                *next += count(statement);
                continue;
            }
            if !run.is_empty() {
                taken = self.region(module, function, &run, &mut out);
                run.clear();
            }
            *next += 1;
            let rebuilt = visit::map_sub_blocks(statement, &mut |block| {
                self.skeleton(module, function, block, next)
            });
            out.push(rebuilt, span);
            if let Some(region) = taken.take() {
                let mut code = Code::new(&mut module.types, function, span);
                self.take_exchanged_if_on(&mut code, region);
                out.append(&mut code.finish());
            }
        }
        if !run.is_empty() {
            self.region(module, function, &run, &mut out);
        }
        out
    }

    /// Writes a region: the cooperative part, the exchange, the per-pixel part. Gives the region back if what it
    /// exchanged is to be taken behind the barrier that follows.
    fn region(
        &mut self,
        module: &mut Module,
        function: &mut Function,
        run: &[(u32, &Statement, Span)],
        out: &mut Block,
    ) -> Option<RegionId> {
        let &(first, _, span) = run.first()?;
        let id = self.regions.skeleton.nodes[first as usize].region?;
        let region = &self.regions.skeleton.regions[id];
        let is_masked = self.regions.masked.contains_key(&id);
        let exchanges = self.regions.exchanges.contains_key(&id);
        let change = |module: &mut Module, function: &mut Function, out: &mut Block| {
            let mut code = Code::new(&mut module.types, function, span);
            code.call(self.prelude.masks().change_pixel, Vec::new(), false);
            out.append(&mut code.finish());
        };
        if is_masked {
            change(module, function, out);
        }
        for &(number, statement, span) in run {
            self.real_statement(module, function, number, statement, span, out);
        }
        if is_masked && !region.is_last {
            change(module, function, out);
        }
        if exchanges {
            let mut code = Code::new(&mut module.types, function, span);
            if region.needs_entry_barrier {
                code.push(Statement::ControlBarrier(naga::Barrier::WORK_GROUP));
            }
            self.leave_exchanged(&mut code, id);
            if !region.before_barrier {
                code.push(Statement::ControlBarrier(naga::Barrier::WORK_GROUP));
                self.take_exchanged_if_on(&mut code, id);
            }
            out.append(&mut code.finish());
        }
        self.own_region(module, function, id, run, out);
        (exchanges && region.before_barrier).then_some(id)
    }

    /// Each invocation leaves its own values at its own place.
    fn leave_exchanged(&self, code: &mut Code, region: RegionId) {
        for &exchanged in &self.regions.exchanges[&region] {
            let value = match exchanged {
                Exchanged::Value(handle) => handle,
                Exchanged::Variable(Variable::Local(local)) => {
                    let pointer = code.add(Expression::LocalVariable(local));
                    code.load(pointer)
                }
                Exchanged::Variable(Variable::Private(global)) => code.global(global),
            };
            let array = code.add(Expression::GlobalVariable(
                self.arrays[&(region, exchanged)],
            ));
            let index = code.global(self.prelude.lane);
            let pointer = code.add(Expression::Access { base: array, index });
            code.push(Statement::Store { pointer, value });
        }
    }

    /// Whoever has a primary takes its values.
    fn take_exchanged_if_on(&self, code: &mut Code, region: RegionId) {
        let on = code.global(self.prelude.on);
        code.when(on, |code| {
            for &exchanged in &self.regions.exchanges[&region] {
                let array = code.add(Expression::GlobalVariable(
                    self.arrays[&(region, exchanged)],
                ));
                let index = code.global(self.prelude.slot);
                let pointer = code.add(Expression::Access { base: array, index });
                let value = code.load(pointer);
                match exchanged {
                    Exchanged::Value(handle) => {
                        // nobody but the exchange itself may have asked for it
                        if let Some(&pointer) = self.kept.get(&handle) {
                            code.push(Statement::Store { pointer, value });
                        }
                    }
                    Exchanged::Variable(Variable::Local(local)) => {
                        let pointer = self.local(code, local);
                        code.push(Statement::Store { pointer, value });
                    }
                    Exchanged::Variable(Variable::Private(global)) => {
                        let swapped = self.swapped.iter().find(|s| s.variable == global);
                        code.set_global(swapped.map_or(global, |s| s.own), value);
                    }
                }
            }
        });
    }

    /// The per-pixel part's own pointer to a local.
    fn local(&self, code: &mut Code, local: Handle<LocalVariable>) -> Handle<Expression> {
        match self.twins.get(&local) {
            Some(&twin) => twin,
            None => code.add(Expression::LocalVariable(local)),
        }
    }
}

/// The number of statements in a statement, itself included.
fn count(statement: &Statement) -> u32 {
    let mut count = 1;
    visit::sub_blocks(statement, &mut |block| {
        visit::statements(block, &mut |_| count += 1)
    });
    count
}

/// The private variables that a function or its callees write.
fn written_privates(
    module: &Module,
    function: &Function,
    body: &Block,
) -> std::collections::BTreeSet<Handle<GlobalVariable>> {
    let mut written = std::collections::BTreeSet::new();
    visit::statements(body, &mut |statement| match *statement {
        Statement::Store { pointer, .. } => {
            if let Some(global) = function.originating_global(pointer) {
                written.insert(global);
            }
        }
        Statement::Call {
            function: callee,
            ref arguments,
            ..
        } => {
            written.extend(
                arguments
                    .iter()
                    .filter_map(|&a| function.originating_global(a)),
            );
            let callee = &module.functions[callee];
            written.extend(written_privates(module, callee, &callee.body));
        }
        _ => {}
    });
    written.retain(|&global| module.global_variables[global].space == AddressSpace::Private);
    written
}
