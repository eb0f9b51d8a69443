//! Statement numbers, and the rebuild of a body around some of them.
//!
//! A statement is named by its place in a walk of its function's body, outer before inner, in program order. The
//! number means the same to the analysis, which reads the untouched body, and to the transforms, which rebuild it,
//! so decisions can be taken first and carried out later (collect, then mutate).
//!
//! *Guarantees*: [`rebuild`] keeps every span that it is given; the numbers are those of the body before the rebuild.

use naga::{Block, Span, Statement};

/// A statement's number inside its function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StatementId(pub u32);

/// Hands out statement numbers during a walk.
#[derive(Debug, Default)]
pub struct Numbering {
    next: u32,
}

impl Numbering {
    /// The number of the statement that the walk enters now.
    pub fn enter(&mut self) -> StatementId {
        let id = StatementId(self.next);
        self.next += 1;
        id
    }

    /// Passes over a block that the walk does not enter.
    pub fn skip(&mut self, block: &Block) {
        super::visit::statements(block, &mut |_| self.next += 1);
    }
}

/// Rebuilds a body. Each statement, its own sub-blocks already rebuilt, is given to `edit`, which pushes what is to
/// stand in its place.
pub fn rebuild(
    body: &Block,
    edit: &mut dyn FnMut(StatementId, Statement, Span, &mut Block),
) -> Block {
    rebuild_block(body, &mut Numbering::default(), edit)
}

fn rebuild_block(
    block: &Block,
    numbering: &mut Numbering,
    edit: &mut dyn FnMut(StatementId, Statement, Span, &mut Block),
) -> Block {
    let mut rebuilt = Block::with_capacity(block.len());
    for (statement, &span) in block.span_iter() {
        let id = numbering.enter();
        let mut inner = |block: &Block| rebuild_block(block, numbering, edit);
        let statement = super::visit::map_sub_blocks(statement, &mut inner);
        edit(id, statement, span, &mut rebuilt);
    }
    rebuilt
}
