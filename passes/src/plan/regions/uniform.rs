//! Whether all invocations of a workgroup reach each barrier.
//!
//! naga does not ask, and neither does a driver; a browser does (WGSL, "uniformity analysis"). A condition of the
//! [skeleton](super::skeleton) has to have the same value in all invocations of a workgroup, or the original is not valid.
//!
//! *Does*: finds the values that may differ: those made of the ids within the group, of memory that anyone writes, of what
//! was chosen under such a condition. Variables are taken as a whole, wherever they are stored to.
//! *Refuses*: a barrier, or a jump past one, under a condition that may differ.

use std::collections::BTreeSet;

use naga::{
    AddressSpace, Binding, BuiltIn, Expression, Function, Handle, ImageClass, LocalVariable,
    Module, Span, Statement, TypeInner,
};

use super::skeleton::Skeleton;
use crate::{
    analysis::{Facts, facts::constant_steps},
    finding::{Code, Finding},
    ir::visit,
};

struct Uniformity<'u> {
    module: &'u Module,
    facts: &'u Facts,
    function: &'u Function,
    skeleton: &'u Skeleton,
    statements: Vec<&'u Statement>,
    /// Values that may differ.
    values: BTreeSet<Handle<Expression>>,
    /// Variables that may differ.
    locals: BTreeSet<Handle<LocalVariable>>,
    /// Statements inside which not all invocations may be.
    split: BTreeSet<u32>,
}

/// Checks the conditions of a skeleton.
///
/// # Errors
/// Each condition that may differ.
pub fn check(
    module: &Module,
    facts: &Facts,
    function: &Function,
    skeleton: &Skeleton,
) -> Result<(), Vec<Finding>> {
    let mut statements = Vec::with_capacity(skeleton.nodes.len());
    visit::statements(&function.body, &mut |statement| statements.push(statement));
    let mut uniformity = Uniformity {
        module,
        facts,
        function,
        skeleton,
        statements,
        values: BTreeSet::new(),
        locals: BTreeSet::new(),
        split: BTreeSet::new(),
    };
    loop {
        let before = uniformity.size();
        uniformity.widen();
        if uniformity.size() == before {
            break;
        }
    }
    uniformity.findings()
}

impl Uniformity<'_> {
    fn size(&self) -> usize {
        self.values.len() + self.locals.len() + self.split.len()
    }

    fn differs(&self, handle: Handle<Expression>) -> bool {
        self.values.contains(&handle)
    }

    /// One pass over everything.
    fn widen(&mut self) {
        for (handle, expression) in self.function.expressions.iter() {
            if self.may_differ(handle, expression) {
                self.values.insert(handle);
            }
        }
        for number in 0..self.statements.len() {
            self.widen_statement(number as u32);
        }
    }

    fn widen_statement(&mut self, number: u32) {
        let node = &self.skeleton.nodes[number as usize];
        let inside_split = node
            .parent
            .is_some_and(|parent| self.split.contains(&parent));
        match *self.statements[number as usize] {
            Statement::If { condition, .. } if self.differs(condition) => {
                self.split.insert(number);
            }
            Statement::Switch { selector, .. } if self.differs(selector) => {
                self.split.insert(number);
            }
            Statement::Loop {
                break_if: Some(condition),
                ..
            } if self.differs(condition) => {
                self.split.insert(number);
            }
            Statement::Break | Statement::Continue if inside_split => {
                self.split.extend(node.target);
            }
            Statement::Store { pointer, value }
                if inside_split || self.differs(pointer) || self.differs(value) =>
            {
                self.spoil(pointer);
            }
            Statement::Call { ref arguments, .. } => {
                arguments.iter().for_each(|&argument| self.spoil(argument));
            }
            Statement::RayQuery { query, .. } => self.spoil(query),
            _ => {}
        }
        if inside_split {
            self.split.insert(number);
        }
    }

    /// Notes that what a pointer leads to may differ.
    fn spoil(&mut self, pointer: Handle<Expression>) {
        let (root, _) = constant_steps(self.function, pointer);
        if let Expression::LocalVariable(local) = self.function.expressions[root]
            && self.is_pointer(pointer)
        {
            self.locals.insert(local);
        }
    }

    fn is_pointer(&self, handle: Handle<Expression>) -> bool {
        let (root, _) = constant_steps(self.function, handle);
        matches!(
            self.function.expressions[root],
            Expression::LocalVariable(_) | Expression::GlobalVariable(_)
        )
    }

    fn may_differ(&self, handle: Handle<Expression>, expression: &Expression) -> bool {
        match *expression {
            Expression::FunctionArgument(index) => {
                let argument = &self.function.arguments[index as usize];
                // a struct of builtins may differ as a whole; its members are told apart
                argument.binding.as_ref().is_none_or(within_group)
            }
            Expression::AccessIndex { base, index } => match self.member(base, index) {
                Some(differs) => differs,
                None => self.differs(base),
            },
            Expression::Load { pointer } => {
                let (root, steps) = constant_steps(self.function, pointer);
                let differs = match self.function.expressions[root] {
                    Expression::LocalVariable(local) => self.locals.contains(&local),
                    Expression::GlobalVariable(global) => {
                        match self.module.global_variables[global].space {
                            AddressSpace::Uniform | AddressSpace::Immediate => false,
                            AddressSpace::Storage { .. } => self.facts.is_written(global, &steps),
                            AddressSpace::Private => self.facts.entry.writes.contains(&global),
                            _ => true,
                        }
                    }
                    _ => true,
                };
                differs || self.differs(pointer)
            }
            Expression::ImageLoad { image, .. } => self.is_written_image(image) || self.any(handle),
            Expression::CallResult(callee) => {
                let facts = self.facts.function(callee);
                !facts.effects.is_empty()
                    || facts
                        .reads
                        .iter()
                        .any(|g| self.facts.entry.writes.contains(g))
                    || self.call_of(handle).is_none_or(|arguments| {
                        arguments
                            .iter()
                            .any(|&argument| self.differs(argument) || self.is_pointer(argument))
                    })
            }
            Expression::AtomicResult { .. }
            | Expression::SubgroupBallotResult
            | Expression::SubgroupOperationResult { .. }
            | Expression::RayQueryProceedResult
            | Expression::RayQueryGetIntersection { .. }
            | Expression::RayQueryVertexPositions { .. }
            | Expression::CooperativeLoad { .. }
            | Expression::CooperativeMultiplyAdd { .. } => true,
            Expression::WorkGroupUniformLoadResult { .. } => false,
            _ => self.any(handle),
        }
    }

    /// Whether a member of a struct of builtins may differ; `None` if it is none.
    fn member(&self, base: Handle<Expression>, index: u32) -> Option<bool> {
        let Expression::FunctionArgument(argument) = self.function.expressions[base] else {
            return None;
        };
        let ty = self.function.arguments[argument as usize].ty;
        let TypeInner::Struct { members, .. } = &self.module.types[ty].inner else {
            return None;
        };
        let binding = members[index as usize].binding.as_ref();
        Some(binding.is_none_or(within_group))
    }

    fn any(&self, handle: Handle<Expression>) -> bool {
        let mut differs = false;
        visit::operands(&self.function.expressions[handle], &mut |&operand| {
            differs |= self.differs(operand);
        });
        differs
    }

    fn is_written_image(&self, image: Handle<Expression>) -> bool {
        let (root, _) = constant_steps(self.function, image);
        match self.function.expressions[root] {
            Expression::GlobalVariable(global) => {
                let ty = self.module.global_variables[global].ty;
                let is_storage = matches!(
                    self.module.types[ty].inner,
                    TypeInner::Image {
                        class: ImageClass::Storage { .. },
                        ..
                    }
                );
                is_storage && self.facts.is_written_anywhere(global)
            }
            _ => true,
        }
    }

    fn call_of(&self, result: Handle<Expression>) -> Option<&[Handle<Expression>]> {
        let giver = *self.skeleton.giver.get(&result)?;
        match self.statements[giver as usize] {
            Statement::Call { arguments, .. } => Some(arguments),
            _ => None,
        }
    }

    fn findings(&self) -> Result<(), Vec<Finding>> {
        let mut findings = Vec::new();
        for (number, statement) in self.statements.iter().enumerate() {
            let node = &self.skeleton.nodes[number];
            let condition = match **statement {
                Statement::If { condition, .. } => Some(condition),
                Statement::Switch { selector, .. } => Some(selector),
                Statement::Loop { break_if, .. } => break_if,
                _ => None,
            };
            let Some(condition) = condition.filter(|&c| node.region.is_none() && self.differs(c))
            else {
                continue;
            };
            let (inner, is_jump) = self.reason(number as u32);
            let of_condition = self.function.expressions.get_span(condition);
            let span = if of_condition.is_defined() {
                of_condition
            } else {
                node.span
            };
            let (message, label) = match is_jump {
                false => (
                    "a barrier stands under a condition that may differ within a workgroup",
                    "not every invocation gets here",
                ),
                true => (
                    "an invocation may leave before a barrier, under a condition that may differ within a workgroup",
                    "the others wait for it at the next barrier",
                ),
            };
            findings.push(
                Finding::new(Code::WorkgroupMemory, message)
                    .at(span, "comes from an invocation's id, or from memory that is written")
                    .at(inner, label)
                    .help(
                        "take the condition from a uniform, from `workgroup_id`, or from `workgroupUniformLoad`; \
                         wrap the work between the barriers in it, not the barriers",
                    ),
            );
        }
        match findings.is_empty() {
            true => Ok(()),
            false => Err(findings),
        }
    }

    /// What makes a statement part of the skeleton, and whether it is a jump.
    fn reason(&self, outer: u32) -> (Span, bool) {
        let mut jump = Span::UNDEFINED;
        for (number, statement) in self.statements.iter().enumerate() {
            let number = number as u32;
            let node = &self.skeleton.nodes[number as usize];
            if number == outer || node.region.is_some() || !self.skeleton.is_inside(number, outer) {
                continue;
            }
            match statement {
                Statement::ControlBarrier(_)
                | Statement::MemoryBarrier(_)
                | Statement::WorkGroupUniformLoad { .. } => return (node.span, false),
                Statement::Return { .. } | Statement::Break | Statement::Continue => {
                    jump = node.span;
                }
                _ => {}
            }
        }
        (jump, true)
    }
}

/// Whether a builtin differs within a workgroup.
fn within_group(binding: &Binding) -> bool {
    !matches!(
        binding.to_built_in(),
        Some(BuiltIn::WorkGroupId | BuiltIn::NumWorkGroups | BuiltIn::WorkGroupSize)
    )
}
