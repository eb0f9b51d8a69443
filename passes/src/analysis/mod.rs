//! Everything that is decided about a shader is decided from here, on the untouched module.
//!
//! [`facts`] scans what each function does. [`walk`] then runs the entry point symbolically, through every call, and
//! notes each store, each read of memory that the shader writes, each atomic, barrier and subgroup operation, with the
//! [terms](term) of its address and the [guards](guard) on the way to it. [`depends`] tells what a term depends on and
//! [`tangent`] how it moves with the ids; [`polynomial`] and [`interval`] tell places apart.

pub mod corner;
mod dead;
pub mod depends;
pub mod env;
mod evaluate;
pub mod facts;
pub mod guard;
pub mod interval;
pub mod polynomial;
pub mod tangent;
pub mod term;
pub mod walk;

use naga::{
    Expression, Function, GlobalVariable, Handle, LocalVariable, Module, Range, Span, Statement,
};

pub use facts::Facts;

use crate::ir::statements::StatementId;
use guard::Formula;
use term::{LoopId, Step, TermId};

/// A function of the module, or the entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FunctionRef {
    /// The entry point that is rewritten.
    Entry,
    /// A function.
    Function(Handle<Function>),
}

impl FunctionRef {
    /// The function itself.
    pub fn get(self, module: &Module, entry: usize) -> &Function {
        match self {
            FunctionRef::Entry => &module.entry_points[entry].function,
            FunctionRef::Function(handle) => &module.functions[handle],
        }
    }
}

/// A function on one path of calls from the entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct InstanceId(pub u32);

impl InstanceId {
    /// The entry point itself.
    pub const ENTRY: InstanceId = InstanceId(0);
}

/// What is known of a function on one path of calls.
#[derive(Debug)]
pub struct Instance {
    /// The function.
    pub function: FunctionRef,
    /// The call that leads to it; `None` for the entry point.
    pub caller: Option<(InstanceId, StatementId)>,
    /// The calls inside it that were followed in place.
    pub calls: Vec<Call>,
    /// The term of each expression that has one.
    pub values: Vec<Option<TermId>>,
}

/// A call that was followed in place.
#[derive(Debug)]
pub struct Call {
    /// The statement.
    pub statement: StatementId,
    /// What it leads to.
    pub callee: InstanceId,
    /// What can be named there.
    pub scope: Scope,
}

/// What can be named at a statement.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// The expressions that have been emitted in enclosing blocks.
    pub expressions: Vec<Range<Expression>>,
    /// What the function's local variables hold.
    pub locals: Vec<(Handle<LocalVariable>, TermId)>,
}

/// Where a resource is read or written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A texel.
    Texel {
        /// The coordinate, component by component.
        coordinate: Vec<TermId>,
        /// The layer of an arrayed texture.
        layer: Option<TermId>,
    },
    /// A part of a buffer.
    Part(Vec<Step>),
}

impl Address {
    /// The terms that make up the address.
    pub fn terms(&self) -> Vec<TermId> {
        match self {
            Address::Texel { coordinate, layer } => {
                coordinate.iter().copied().chain(*layer).collect()
            }
            Address::Part(steps) => steps
                .iter()
                .filter_map(|step| match *step {
                    Step::Dynamic(index) => Some(index),
                    Step::Index(_) => None,
                })
                .collect(),
        }
    }
}

/// A texture or buffer, or one element of a binding array.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Target {
    /// The variable.
    pub global: Handle<GlobalVariable>,
    /// The element of a binding array of textures.
    pub element: Vec<Step>,
}

/// What an access does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AccessKind {
    /// A store.
    Store {
        /// The value.
        value: Handle<Expression>,
    },
    /// A load from memory that the shader writes.
    Load {
        /// What was loaded.
        value: Handle<Expression>,
    },
    /// An atomic.
    Atomic {
        /// Whether its result is used.
        used: bool,
        /// What it does.
        function: AtomicKind,
    },
}

impl AccessKind {
    /// Whether it changes what is there.
    pub fn writes(self) -> bool {
        !matches!(self, AccessKind::Load { .. })
    }

    /// Whether what is there afterwards is a value of the invocation's, whatever was there before.
    pub fn replaces(self) -> bool {
        matches!(
            self,
            AccessKind::Store { .. }
                | AccessKind::Atomic {
                    function: AtomicKind::Exchange,
                    ..
                }
        )
    }
}

/// What an atomic does, as far as it matters when one invocation stands for several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtomicKind {
    /// It adds or subtracts an integer: n times is once with n times the value.
    Sum,
    /// `min`, `max`, `and`, `or` of integers: again and again is once.
    Once,
    /// It takes what is there and leaves another value: at a place that is the invocation's own, a load and a store.
    Exchange,
    /// Anything else, by its WGSL name.
    Other(&'static str),
}

/// An access to memory that the shader writes, on one path of calls.
#[derive(Debug)]
pub struct Access {
    /// The function.
    pub instance: InstanceId,
    /// The statement; for a load, the `Emit` that evaluates it.
    pub statement: StatementId,
    /// What it does.
    pub kind: AccessKind,
    /// The resource.
    pub target: Target,
    /// The place in the resource.
    pub address: Address,
    /// The conditions on the way to it, through all calls.
    pub guards: Vec<Formula>,
    /// The loops around it, through all calls.
    pub loops: Vec<LoopId>,
    /// What can be named there.
    pub scope: Scope,
    /// Where it stands in the source.
    pub span: Span,
}

impl Access {
    /// The resource, if it is a store and no atomic.
    pub fn plain(&self) -> Option<Handle<GlobalVariable>> {
        matches!(self.kind, AccessKind::Store { .. }).then_some(self.target.global)
    }
}

/// A statement that ties invocations to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tie {
    /// A barrier, or `workgroupUniformLoad`.
    Barrier,
    /// A read or write of `var<workgroup>`.
    WorkGroup(Handle<GlobalVariable>),
    /// A subgroup or quad operation, by its WGSL name.
    Subgroup(&'static str),
}

/// Where a tie stands.
#[derive(Debug)]
pub struct TieSite {
    /// What it is.
    pub tie: Tie,
    /// The function.
    pub instance: InstanceId,
    /// The statement.
    pub statement: StatementId,
    /// Where it stands in the source.
    pub span: Span,
}

/// A condition in the source.
#[derive(Clone, Copy, Debug)]
pub struct ConditionSite {
    /// The condition.
    pub condition: TermId,
    /// Where it stands in the source.
    pub span: Span,
}

/// The span of a statement for a reader: naga gives built-in statements only their callee's word, so the spans of the operands that
/// are written behind it are added; a `let` further up is not.
pub fn statement_span(function: &Function, statement: &Statement, span: Span) -> Span {
    let mut whole = span;
    crate::ir::visit::statement_operands(statement, &mut |&operand| {
        let of = function.expressions.get_span(operand);
        let is_behind = match (span.to_range(), of.to_range()) {
            (Some(own), Some(of)) => of.start >= own.start,
            _ => !span.is_defined(),
        };
        // a variable's span is its declaration, far away
        if is_behind && !function.expressions[operand].needs_pre_emit() {
            whole.subsume(of);
        }
    });
    whole
}
