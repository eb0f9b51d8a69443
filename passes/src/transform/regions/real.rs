//! The cooperative part: the author's own statements, less what it does not need.

use naga::{Block, Expression, Function, Handle, Module, Range, Span, Statement};

use super::{Split, count};
use crate::ir::{build::Code, visit};

impl Split<'_> {
    /// Writes what the cooperative part needs of a statement.
    pub(super) fn real_statement(
        &self,
        module: &mut Module,
        function: &mut Function,
        number: u32,
        statement: &Statement,
        span: Span,
        out: &mut Block,
    ) {
        if let Statement::Emit(range) = statement {
            for range in self.needed(range) {
                out.push(Statement::Emit(range), span);
            }
            return;
        }
        if !self.real().statements.contains(&number) {
            return;
        }
        let mut next = number + 1;
        let mut inner = |block: &Block| {
            let mut rebuilt = Block::new();
            for (statement, &span) in block.span_iter() {
                self.real_statement(module, function, next, statement, span, &mut rebuilt);
                next += count(statement);
            }
            rebuilt
        };
        let rebuilt = visit::map_sub_blocks(statement, &mut inner);
        if !self.is_masked(number) {
            out.push(rebuilt, span);
            return;
        }
        let mut code = Code::new(&mut module.types, function, span);
        let is_primary = code.global(self.prelude.masks().is_primary);
        code.when(is_primary, |code| code.push(rebuilt));
        out.append(&mut code.finish());
    }

    /// Whether a statement is a store of a masked region.
    fn is_masked(&self, number: u32) -> bool {
        let region = self.regions.skeleton.nodes[number as usize].region;
        region
            .and_then(|region| self.regions.masked.get(&region))
            .is_some_and(|stores| stores.contains(&number))
    }

    /// The parts of a range that are needed.
    fn needed(&self, range: &Range<Expression>) -> Vec<Range<Expression>> {
        let needed = |handle: &Handle<Expression>| self.real().expressions.contains(handle);
        let mut ranges = Vec::new();
        let mut run: Option<(Handle<Expression>, Handle<Expression>)> = None;
        for handle in range.clone() {
            run = match (needed(&handle), run) {
                (true, None) => Some((handle, handle)),
                (true, Some((first, _))) => Some((first, handle)),
                (false, Some((first, last))) => {
                    ranges.push(Range::new_from_bounds(first, last));
                    None
                }
                (false, None) => None,
            };
        }
        if let Some((first, last)) = run {
            ranges.push(Range::new_from_bounds(first, last));
        }
        ranges
    }
}
