//! What an entry point starts with: its workgroup size and its builtins.

use naga::{BinaryOperator, Literal, TypeInner};

use super::Walk;
use crate::analysis::{
    evaluate::Value,
    term::{Composite, Id, Opacity, Operands, Term, TermId},
};

impl Walk<'_> {
    pub(super) fn group_size(&mut self) -> [TermId; 3] {
        let entry = &self.module.entry_points[self.entry];
        let overrides = entry.workgroup_size_overrides.unwrap_or_default();
        std::array::from_fn(|axis| match overrides[axis] {
            Some(size) => {
                let size = self.terms.global_expression(size);
                self.terms.unsigned(size)
            }
            None => self
                .terms
                .literal(naga::Literal::U32(entry.workgroup_size[axis])),
        })
    }

    pub(super) fn entry_arguments(&mut self, group_size: [TermId; 3]) -> Vec<Value> {
        let function = &self.module.entry_points[self.entry].function;
        let mut arguments = Vec::with_capacity(function.arguments.len());
        for argument in &function.arguments {
            let term = match (&argument.binding, &self.module.types[argument.ty].inner) {
                (Some(binding), _) => self.builtin(binding, group_size),
                (None, TypeInner::Struct { members, .. }) => {
                    let parts = members
                        .iter()
                        .map(|member| match &member.binding {
                            Some(binding) => self.builtin(binding, group_size),
                            None => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
                        })
                        .collect();
                    self.terms.compose(Composite::Type(argument.ty), parts)
                }
                _ => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
            };
            arguments.push(Value::Term(term));
        }
        arguments
    }

    pub(super) fn builtin(&mut self, binding: &naga::Binding, group_size: [TermId; 3]) -> TermId {
        use naga::BuiltIn as B;
        let scalar = naga::Scalar::U32;
        if let Some(width) = self.terms.width
            && let Some(term) = self.linear_builtin(binding, width, group_size)
        {
            return term;
        }
        let [_, height, depth] = group_size.map(|size| self.terms.as_literal(size));
        let one = Some(Literal::U32(1));
        let mut vector = |id: &dyn Fn(u8) -> Id| {
            let parts = (0..3)
                .map(|axis| self.terms.intern(Term::Id(id(axis))))
                .collect();
            self.terms.vector(scalar, parts)
        };
        match binding.to_built_in() {
            // in a workgroup of one row, a place in the row: it says nothing of the other axes
            Some(B::LocalInvocationIndex) if height == one && depth == one => {
                self.terms.intern(Term::Id(Id::Local(0)))
            }
            Some(B::GlobalInvocationId) => vector(&Id::Global),
            Some(B::LocalInvocationId) => vector(&Id::Local),
            Some(B::WorkGroupId) => vector(&Id::Group),
            Some(B::NumWorkGroups) => vector(&Id::GroupCount),
            Some(B::LocalInvocationIndex) => self.terms.intern(Term::Id(Id::LocalIndex)),
            Some(B::WorkGroupSize) => self.terms.vector(scalar, group_size.to_vec()),
            Some(B::SubgroupId | B::SubgroupSize | B::SubgroupInvocationId | B::NumSubgroups) => {
                self.terms.opaque(Opacity::Subgroup, Vec::new())
            }
            _ => self.terms.opaque(Opacity::Unfollowed, Vec::new()),
        }
    }

    /// The ids of invocation `y * width + x` of a one-dimensional dispatch.
    fn linear_builtin(
        &mut self,
        binding: &naga::Binding,
        width: TermId,
        [size, ..]: [TermId; 3],
    ) -> Option<TermId> {
        use naga::BuiltIn as B;
        let number = self.terms.linear_index(width);
        let zero = self.terms.literal(naga::Literal::U32(0));
        let operands = Operands::Integers;
        let local = (self.terms).binary(BinaryOperator::Modulo, operands, number, size);
        let group = (self.terms).binary(BinaryOperator::Divide, operands, number, size);
        let first = match binding.to_built_in()? {
            B::GlobalInvocationId => number,
            B::LocalInvocationId => local,
            B::WorkGroupId => group,
            B::LocalInvocationIndex => return Some(local),
            _ => return None,
        };
        Some(
            self.terms
                .vector(naga::Scalar::U32, vec![first, zero, zero]),
        )
    }
}
