//! What each function of a module does, callees included: one scan, before anything else looks at the shader.
//!
//! *Needs*: a valid module, so that callees stand before callers.
//! *Guarantees*: nothing is missed; where naga's own table of global uses is too coarse (an atomic on a buffer is to it
//! a read and a write, a pointer handed to a function nothing at all), the statements are looked at.

use std::collections::BTreeSet;

use bitflags::bitflags;
use naga::{
    AddressSpace, Expression, Function, GlobalVariable, Handle, Module, Statement, TypeInner,
};
use rustc_hash::FxHashMap;

use crate::ir::visit;

bitflags! {
    /// Effects that the analysis has to see in their place, in the function that has them.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Effects: u8 {
        /// Stores to a buffer or texture.
        const STORE = 1;
        /// Atomics on a buffer, texture or workgroup variable.
        const ATOMIC = 2;
        /// Barriers and `workgroupUniformLoad`.
        const BARRIER = 4;
        /// Subgroup, quad and cooperative-matrix operations.
        const SUBGROUP = 8;
        /// Reads or writes of `var<workgroup>`.
        const WORKGROUP = 16;
        /// Reads of memory that the entry point writes.
        const READS_WRITTEN = 32;
        /// Ray queries.
        const RAY_QUERY = 64;
    }
}

/// What a function and its callees do.
#[derive(Clone, Debug, Default)]
pub struct FunctionFacts {
    /// Effects on anything but its own variables.
    pub effects: Effects,
    /// Whether it loads from buffers or textures.
    pub reads_memory: bool,
    /// Private variables that it reads.
    pub reads: BTreeSet<Handle<GlobalVariable>>,
    /// Private variables that it writes.
    pub writes: BTreeSet<Handle<GlobalVariable>>,
    /// Workgroup variables that it reads.
    pub group_reads: BTreeSet<Handle<GlobalVariable>>,
    /// Workgroup variables that it writes, atomics among them.
    pub group_writes: BTreeSet<Handle<GlobalVariable>>,
    /// The number of expressions, with those of its callees once for each call.
    pub weight: usize,
}

impl FunctionFacts {
    /// Whether the analysis has to follow a call of it as if it stood in the caller.
    pub fn is_in_place(&self) -> bool {
        !(self.effects - Effects::RAY_QUERY).is_empty()
    }
}

/// What the functions of a module do, seen from one entry point.
#[derive(Debug)]
pub struct Facts {
    functions: Vec<FunctionFacts>,
    /// The entry point.
    pub entry: FunctionFacts,
    /// The parts of each buffer or texture that the entry point writes: the constant steps that lead to the store.
    written: FxHashMap<Handle<GlobalVariable>, Vec<Vec<u32>>>,
}

impl Facts {
    /// Scans a module.
    pub fn new(module: &Module, entry: usize) -> Facts {
        let entry = &module.entry_points[entry].function;
        let mut facts = Facts {
            functions: Vec::with_capacity(module.functions.len()),
            entry: FunctionFacts::default(),
            written: FxHashMap::default(),
        };
        facts.find_written(module, entry, &mut BTreeSet::new());
        for (_, function) in module.functions.iter() {
            let found = facts.scan(module, function);
            facts.functions.push(found);
        }
        facts.entry = facts.scan(module, entry);
        facts
    }

    /// What a function does.
    pub fn function(&self, function: Handle<Function>) -> &FunctionFacts {
        &self.functions[function.index()]
    }

    /// Whether the entry point writes what is behind these constant steps.
    pub fn is_written(&self, global: Handle<GlobalVariable>, steps: &[u32]) -> bool {
        self.written.get(&global).is_some_and(|written| {
            written
                .iter()
                .any(|prefix| prefix.iter().zip(steps).all(|(a, b)| a == b))
        })
    }

    /// Whether the entry point writes any part of a variable.
    pub fn is_written_anywhere(&self, global: Handle<GlobalVariable>) -> bool {
        self.written.contains_key(&global)
    }

    /// The buffers and textures that the entry point writes, in the order of their declaration.
    pub fn written(&self) -> Vec<Handle<GlobalVariable>> {
        let mut written: Vec<_> = self.written.keys().copied().collect();
        written.sort();
        written
    }

    fn find_written(
        &mut self,
        module: &Module,
        function: &Function,
        seen: &mut BTreeSet<Handle<Function>>,
    ) {
        visit::statements(&function.body, &mut |statement| {
            let pointer = match *statement {
                Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => pointer,
                Statement::ImageStore { image, .. } | Statement::ImageAtomic { image, .. } => image,
                Statement::CooperativeStore { ref data, .. } => data.pointer,
                Statement::Call { function, .. } => {
                    if seen.insert(function) {
                        self.find_written(module, &module.functions[function], seen);
                    }
                    return;
                }
                _ => return,
            };
            let (root, steps) = constant_steps(function, pointer);
            if let Expression::GlobalVariable(global) = function.expressions[root]
                && matches!(
                    module.global_variables[global].space,
                    AddressSpace::Storage { .. } | AddressSpace::Handle
                )
            {
                self.written.entry(global).or_default().push(steps);
            }
        });
    }

    fn scan(&self, module: &Module, function: &Function) -> FunctionFacts {
        let mut found = FunctionFacts {
            weight: function.expressions.len(),
            ..FunctionFacts::default()
        };
        for (_, expression) in function.expressions.iter() {
            self.scan_expression(module, function, expression, &mut found);
        }
        visit::statements(&function.body, &mut |statement| {
            self.scan_statement(module, function, statement, &mut found);
        });
        found
    }

    fn scan_expression(
        &self,
        module: &Module,
        function: &Function,
        expression: &Expression,
        found: &mut FunctionFacts,
    ) {
        match *expression {
            Expression::Load { pointer } => {
                let (root, steps) = constant_steps(function, pointer);
                let Expression::GlobalVariable(global) = function.expressions[root] else {
                    return;
                };
                match module.global_variables[global].space {
                    AddressSpace::Private => {
                        found.reads.insert(global);
                    }
                    AddressSpace::WorkGroup => {
                        found.effects |= Effects::WORKGROUP;
                        found.group_reads.insert(global);
                    }
                    AddressSpace::Storage { .. } => {
                        found.reads_memory = true;
                        if self.is_written(global, &steps) {
                            found.effects |= Effects::READS_WRITTEN;
                        }
                    }
                    _ => found.reads_memory = true,
                }
            }
            Expression::ImageLoad { image, .. } => {
                found.reads_memory = true;
                // a texture handed in as an argument may be a written one: its caller is in place, too
                match function.originating_global(image) {
                    Some(global) if !self.is_written_anywhere(global) => {}
                    None if !is_storage_image(module, function, image) => {}
                    _ => found.effects |= Effects::READS_WRITTEN,
                }
            }
            Expression::ImageSample { .. } => found.reads_memory = true,
            Expression::RayQueryGetIntersection { .. }
            | Expression::RayQueryVertexPositions { .. } => {
                found.effects |= Effects::RAY_QUERY;
            }
            Expression::CooperativeLoad { .. } => found.effects |= Effects::SUBGROUP,
            _ => {}
        }
    }

    fn scan_statement(
        &self,
        module: &Module,
        function: &Function,
        statement: &Statement,
        found: &mut FunctionFacts,
    ) {
        match *statement {
            Statement::Store { pointer, .. } => {
                self.scan_write(module, function, pointer, Effects::STORE, found);
            }
            Statement::Atomic { pointer, .. } => {
                self.scan_write(module, function, pointer, Effects::ATOMIC, found);
            }
            Statement::ImageStore { .. } => found.effects |= Effects::STORE,
            Statement::ImageAtomic { .. } => found.effects |= Effects::ATOMIC,
            Statement::ControlBarrier(_)
            | Statement::MemoryBarrier(_)
            | Statement::WorkGroupUniformLoad { .. } => found.effects |= Effects::BARRIER,
            Statement::SubgroupBallot { .. }
            | Statement::SubgroupGather { .. }
            | Statement::SubgroupCollectiveOperation { .. }
            | Statement::CooperativeStore { .. } => found.effects |= Effects::SUBGROUP,
            Statement::RayQuery { .. } | Statement::RayPipelineFunction(_) => {
                found.effects |= Effects::RAY_QUERY;
            }
            Statement::Call {
                function: callee,
                ref arguments,
                ..
            } => {
                let callee = &self.functions[callee.index()];
                found.effects |= callee.effects;
                found.reads_memory |= callee.reads_memory;
                found.reads.extend(&callee.reads);
                found.writes.extend(&callee.writes);
                found.group_reads.extend(&callee.group_reads);
                found.group_writes.extend(&callee.group_writes);
                found.weight = found.weight.saturating_add(callee.weight);
                for &argument in arguments {
                    let (root, _) = constant_steps(function, argument);
                    if let Expression::GlobalVariable(global) = function.expressions[root] {
                        match module.global_variables[global].space {
                            AddressSpace::Private => {
                                found.reads.insert(global);
                                found.writes.insert(global);
                            }
                            AddressSpace::WorkGroup => found.effects |= Effects::WORKGROUP,
                            _ => {}
                        }
                    }
                }
            }
            _ => {}
        }
    }

    fn scan_write(
        &self,
        module: &Module,
        function: &Function,
        pointer: Handle<Expression>,
        effect: Effects,
        found: &mut FunctionFacts,
    ) {
        let (root, _) = constant_steps(function, pointer);
        let Expression::GlobalVariable(global) = function.expressions[root] else {
            return;
        };
        match module.global_variables[global].space {
            AddressSpace::Private => {
                found.writes.insert(global);
            }
            AddressSpace::WorkGroup => {
                found.effects |= Effects::WORKGROUP;
                found.group_writes.insert(global);
            }
            _ => found.effects |= effect,
        }
    }
}

/// Follows a pointer to its root; the steps up to the first computed index.
pub fn constant_steps(
    function: &Function,
    mut pointer: Handle<Expression>,
) -> (Handle<Expression>, Vec<u32>) {
    let mut steps = Vec::new();
    loop {
        match function.expressions[pointer] {
            Expression::AccessIndex { base, index } => {
                steps.push(index);
                pointer = base;
            }
            Expression::Access { base, .. } => {
                // what was collected lies behind the computed index
                steps.clear();
                pointer = base;
            }
            _ => {
                steps.reverse();
                return (pointer, steps);
            }
        }
    }
}

fn is_storage_image(module: &Module, function: &Function, image: Handle<Expression>) -> bool {
    let Expression::FunctionArgument(index) = function.expressions[image] else {
        return true;
    };
    let ty = function.arguments[index as usize].ty;
    matches!(
        module.types[ty].inner,
        TypeInner::Image {
            class: naga::ImageClass::Storage { .. },
            ..
        }
    )
}
