//! Recursion as deep as a shader nests, without an overflow.
//!
//! naga's front ends, its validator and its writers recurse, and so do this crate's walks: a sum of ten thousand terms is ten
//! thousand calls deep. What is deeper than a thread's usual stack can take runs on a thread with a large one; what is
//! deeper than that is refused.

use naga::{Block, Expression, Function, Module, Statement};

use crate::ir::visit;

/// The stack of a thread that recurses, in bytes. It is only reserved; what is not used costs nothing.
const STACK: usize = 1 << 30;

/// How deep the thread at hand can certainly go.
const USUAL: usize = 48;

/// How deep [`run`] can certainly go.
pub const MOST: usize = 20_000;

/// Runs on a thread with a large stack.
///
/// # Errors
/// The message of a panic: naga's SPIR-V and GLSL front ends panic on some malformed input.
pub fn run<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, String> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new()
            .name("vrcs-deep".to_owned())
            .stack_size(STACK)
            .spawn_scoped(scope, work)
            .map_err(|error| format!("no thread: {error}"))?;
        thread.join().map_err(|panic| {
            let text = panic.downcast_ref::<&str>().map(ToString::to_string);
            text.or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_else(|| "it panicked".to_owned())
        })
    })
}

/// Runs in place if `depth` is usual, else on a thread with a large stack. A panic goes on.
pub fn run_if_deep<T: Send>(depth: usize, work: impl FnOnce() -> T + Send) -> T {
    if depth <= USUAL {
        return work();
    }
    let mut outcome = None;
    let ran = std::thread::scope(|scope| {
        let outcome = &mut outcome;
        let thread = std::thread::Builder::new()
            .name("vrcs-deep".to_owned())
            .stack_size(STACK)
            .spawn_scoped(scope, move || *outcome = Some(work()));
        match thread {
            Ok(thread) => thread.join(),
            Err(error) => Err(Box::new(format!("no thread: {error}")) as Box<_>),
        }
    });
    match (ran, outcome) {
        (Ok(()), Some(outcome)) => outcome,
        (Err(panic), _) => std::panic::resume_unwind(panic),
        (Ok(()), None) => unreachable!("the thread ended without an outcome"),
    }
}

/// How deep a text may nest, at most: brackets that are open, and operators and `else`s of one statement.
pub fn of_text(text: &str) -> usize {
    let mut most = 0;
    let mut open = 0usize;
    // operators since the last `;`, and `else`s since the last statement that is none
    let (mut operators, mut elses) = (0usize, 0usize);
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        at += 1;
        match byte {
            b'/' if bytes.get(at) == Some(&b'/') => {
                at += bytes[at..]
                    .iter()
                    .position(|&b| b == b'\n')
                    .unwrap_or(bytes.len() - at);
            }
            b'[' => (open, operators) = (open + 1, operators + 1),
            b'(' | b'{' => open += 1,
            b')' | b']' | b'}' => open = open.saturating_sub(1),
            b';' => operators = 0,
            b'+' | b'-' | b'*' | b'/' | b'%' | b'&' | b'|' | b'^' | b'!' | b'~' | b'<' | b'>'
            | b'=' | b'.' | b',' => operators += 1,
            b'e' if bytes[at..].starts_with(b"lse") => elses += 1,
            b'f' if bytes[at..].starts_with(b"n ") => elses = 0,
            _ => {}
        }
        most = most.max(open + operators + elses);
    }
    most
}

/// How deep a module nests: its expressions and its blocks.
pub fn of_module(module: &Module) -> usize {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let globals = of_expressions(module.global_expressions.iter().map(|(_, e)| e));
    functions
        .chain(entries)
        .map(of_function)
        .max()
        .unwrap_or(0)
        .max(globals)
        .max(module.functions.len().min(chain_of_calls(module)))
}

fn of_function(function: &Function) -> usize {
    of_expressions(function.expressions.iter().map(|(_, e)| e)) + of_block(&function.body)
}

fn of_expressions<'e>(expressions: impl Iterator<Item = &'e Expression>) -> usize {
    let mut depths: Vec<usize> = Vec::new();
    for expression in expressions {
        let mut depth = 0;
        visit::operands(expression, &mut |operand| {
            depth = depth.max(depths.get(operand.index()).map_or(0, |inner| inner + 1));
        });
        depths.push(depth);
    }
    depths.into_iter().max().unwrap_or(0)
}

/// Blocks, without recursion: this has to hold however deep they are.
fn of_block(body: &Block) -> usize {
    let mut most = 0;
    let mut open: Vec<(&Block, usize)> = vec![(body, 1)];
    while let Some((block, depth)) = open.pop() {
        most = most.max(depth);
        for statement in block {
            visit::sub_blocks(statement, &mut |inner| open.push((inner, depth + 1)));
        }
    }
    most
}

/// The longest chain of calls. A function stands before its callers.
fn chain_of_calls(module: &Module) -> usize {
    let mut depths: Vec<usize> = Vec::new();
    for (_, function) in module.functions.iter() {
        let mut depth = 0;
        let mut open = vec![&function.body];
        while let Some(block) = open.pop() {
            for statement in block {
                if let Statement::Call { function, .. } = statement {
                    let inner = depths.get(function.index()).copied().unwrap_or(0);
                    depth = depth.max(inner + 1);
                }
                visit::sub_blocks(statement, &mut |inner| open.push(inner));
            }
        }
        depths.push(depth);
    }
    depths.into_iter().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_text_is_not_deep() {
        assert_eq!(of_text(""), 0);
        assert!(of_text("fn f(a: u32) -> u32 { return (a + 1u) * 2u; } // (((((((") < 8);
        assert!(of_text(&"let a = b + c;\n".repeat(1000)) < 8);
    }

    #[test]
    fn deep_text_is() {
        assert!(of_text(&"(".repeat(100)) >= 100);
        assert!(of_text(&format!("let a = 1{};", "+1".repeat(100))) >= 100);
        assert!(of_text(&"if a { b(); } else ".repeat(100)) >= 100);
    }

    #[test]
    fn a_panic_is_a_message() {
        assert_eq!(run(|| 3), Ok(3));
        assert_eq!(run_if_deep(1000, || 3), 3);
    }
}
