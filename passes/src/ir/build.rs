//! Writes IR: expressions with their emission kept right, statements, nested blocks.
//!
//! naga wants every computed expression covered by exactly one `Emit`, before its first use, in a block that encloses
//! the use; literals, globals, locals, arguments and zero values must stay outside any `Emit`; its validator checks
//! little of this (see [`verify`](super::verify)). [`Code`] keeps the rule by construction: it opens an `Emit` with the first computed expression and
//! closes it before anything that is not one.
//!
//! *Guarantees*: appends only, so no handle of the function that it writes into ever changes its meaning.

use naga::{
    Arena, BinaryOperator, Block, Expression, Function, FunctionArgument, FunctionResult,
    GlobalVariable, Handle, Literal, LocalVariable, MathFunction, Range, Scalar, Span, Statement,
    SwizzleComponent, Type, TypeInner, UnaryOperator, UniqueArena, VectorSize,
};

/// Finds or adds an unnamed type.
pub fn intern(types: &mut UniqueArena<Type>, inner: TypeInner) -> Handle<Type> {
    types.insert(Type { name: None, inner }, Span::UNDEFINED)
}

/// The scalar type, or the vector type of `size` components.
pub fn numeric(
    types: &mut UniqueArena<Type>,
    size: Option<VectorSize>,
    scalar: Scalar,
) -> Handle<Type> {
    intern(
        types,
        match size {
            None => TypeInner::Scalar(scalar),
            Some(size) => TypeInner::Vector { size, scalar },
        },
    )
}

/// The vector size of `count` components; `None` for a scalar.
///
/// # Panics
/// If `count` is not 1 to 4.
pub fn vector_size(count: usize) -> Option<VectorSize> {
    match count {
        1 => None,
        2 => Some(VectorSize::Bi),
        3 => Some(VectorSize::Tri),
        4 => Some(VectorSize::Quad),
        _ => unreachable!("a vector of {count} components"),
    }
}

/// A place in a function where code is written.
pub struct Code<'a> {
    /// The module's types, for those that new expressions need.
    pub types: &'a mut UniqueArena<Type>,
    expressions: &'a mut Arena<Expression>,
    locals: &'a mut Arena<LocalVariable>,
    blocks: Vec<Block>,
    emitting: Option<usize>,
    span: Span,
}

impl<'a> Code<'a> {
    /// Starts a fresh block inside `function`. `span` is given to everything written: inserted code inherits the span
    /// of the statement that it serves.
    pub fn new(
        types: &'a mut UniqueArena<Type>,
        function: &'a mut Function,
        span: Span,
    ) -> Code<'a> {
        Code {
            types,
            expressions: &mut function.expressions,
            locals: &mut function.local_variables,
            blocks: vec![Block::new()],
            emitting: None,
            span,
        }
    }

    /// Ends the block and gives it back.
    pub fn finish(mut self) -> Block {
        self.flush();
        self.blocks.pop().unwrap_or_default()
    }

    /// What is written from now on serves another statement.
    pub fn set_span(&mut self, span: Span) {
        self.flush();
        self.span = span;
    }

    fn flush(&mut self) {
        let Some(start) = self.emitting.take() else {
            return;
        };
        let end = self.expressions.len();
        if start < end {
            let range = Range::from_index_range(start as u32..end as u32, self.expressions);
            let span = self.span;
            self.current().push(Statement::Emit(range), span);
        }
    }

    fn current(&mut self) -> &mut Block {
        let last = self.blocks.len() - 1;
        &mut self.blocks[last]
    }

    /// Appends an expression.
    pub fn add(&mut self, expression: Expression) -> Handle<Expression> {
        let span = self.span;
        self.add_at(expression, span)
    }

    /// Appends an expression that stands elsewhere in the source than its statement.
    pub fn add_at(&mut self, expression: Expression, span: Span) -> Handle<Expression> {
        let results = matches!(
            expression,
            Expression::CallResult(_)
                | Expression::AtomicResult { .. }
                | Expression::WorkGroupUniformLoadResult { .. }
                | Expression::RayQueryProceedResult
                | Expression::SubgroupBallotResult
                | Expression::SubgroupOperationResult { .. }
        );
        if expression.needs_pre_emit() || results {
            self.flush();
        } else if self.emitting.is_none() {
            self.emitting = Some(self.expressions.len());
        }
        self.expressions.append(expression, span)
    }

    /// Appends a statement.
    pub fn push(&mut self, statement: Statement) {
        self.flush();
        let span = self.span;
        self.current().push(statement, span);
    }

    /// Writes a nested block.
    pub fn nested(&mut self, write: impl FnOnce(&mut Self)) -> Block {
        self.flush();
        self.blocks.push(Block::new());
        write(self);
        self.flush();
        self.blocks.pop().unwrap_or_default()
    }

    /// `if condition { write }`
    pub fn when(&mut self, condition: Handle<Expression>, write: impl FnOnce(&mut Self)) {
        let accept = self.nested(write);
        self.push(Statement::If {
            condition,
            accept,
            reject: Block::new(),
        });
    }

    /// `loop { write }`
    pub fn repeat(&mut self, write: impl FnOnce(&mut Self)) {
        let body = self.nested(write);
        self.push(Statement::Loop {
            body,
            continuing: Block::new(),
            break_if: None,
        });
    }

    /// `if !condition { return; }`, in a function without a result.
    pub fn return_unless(&mut self, condition: Handle<Expression>) {
        let negated = self.add(Expression::Unary {
            op: UnaryOperator::LogicalNot,
            expr: condition,
        });
        self.when(negated, |code| code.push(Statement::Return { value: None }));
    }

    /// A call; the result's expression if the function has a result.
    pub fn call(
        &mut self,
        function: Handle<Function>,
        arguments: Vec<Handle<Expression>>,
        has_result: bool,
    ) -> Option<Handle<Expression>> {
        let result = has_result.then(|| self.add(Expression::CallResult(function)));
        self.push(Statement::Call {
            function,
            arguments,
            result,
        });
        result
    }

    /// A call of a function that has a result.
    pub fn value_of(
        &mut self,
        function: Handle<Function>,
        arguments: Vec<Handle<Expression>>,
    ) -> Handle<Expression> {
        let result = self.add(Expression::CallResult(function));
        self.push(Statement::Call {
            function,
            arguments,
            result: Some(result),
        });
        result
    }

    /// A `u32` literal.
    pub fn u32(&mut self, value: u32) -> Handle<Expression> {
        self.add(Expression::Literal(Literal::U32(value)))
    }

    /// A `bool` literal.
    pub fn bool(&mut self, value: bool) -> Handle<Expression> {
        self.add(Expression::Literal(Literal::Bool(value)))
    }

    /// `left op right`
    pub fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Handle<Expression> {
        self.add(Expression::Binary { op, left, right })
    }

    /// `base.index` or `base[index]`, a constant index.
    pub fn at(&mut self, base: Handle<Expression>, index: u32) -> Handle<Expression> {
        self.add(Expression::AccessIndex { base, index })
    }

    /// `vector.xy`
    pub fn xy(&mut self, vector: Handle<Expression>) -> Handle<Expression> {
        self.add(Expression::Swizzle {
            size: VectorSize::Bi,
            vector,
            pattern: SwizzleComponent::XYZW,
        })
    }

    /// The value of a global variable.
    pub fn global(&mut self, global: Handle<GlobalVariable>) -> Handle<Expression> {
        let pointer = self.add(Expression::GlobalVariable(global));
        self.add(Expression::Load { pointer })
    }

    /// The value of member `index` of a global variable.
    pub fn global_member(
        &mut self,
        global: Handle<GlobalVariable>,
        index: u32,
    ) -> Handle<Expression> {
        let pointer = self.add(Expression::GlobalVariable(global));
        let pointer = self.at(pointer, index);
        self.add(Expression::Load { pointer })
    }

    /// Stores a value in a private global variable.
    pub fn set_global(&mut self, global: Handle<GlobalVariable>, value: Handle<Expression>) {
        let pointer = self.add(Expression::GlobalVariable(global));
        self.push(Statement::Store { pointer, value });
    }

    /// A new local variable; its pointer expression.
    pub fn local(
        &mut self,
        name: &str,
        ty: Handle<Type>,
        init: Option<Handle<Expression>>,
    ) -> Handle<Expression> {
        let local = self.locals.append(
            LocalVariable {
                name: Some(name.to_owned()),
                ty,
                init: None,
            },
            self.span,
        );
        let pointer = self.add(Expression::LocalVariable(local));
        if let Some(value) = init {
            self.push(Statement::Store { pointer, value });
        }
        pointer
    }

    /// The value behind a pointer.
    pub fn load(&mut self, pointer: Handle<Expression>) -> Handle<Expression> {
        self.add(Expression::Load { pointer })
    }

    /// A vector of the given components, or the lone component itself.
    pub fn vector(
        &mut self,
        scalar: Scalar,
        components: Vec<Handle<Expression>>,
    ) -> Handle<Expression> {
        match vector_size(components.len()) {
            None => components[0],
            Some(size) => {
                let ty = numeric(self.types, Some(size), scalar);
                self.add(Expression::Compose { ty, components })
            }
        }
    }

    /// A built-in function of one argument.
    pub fn math1(&mut self, fun: MathFunction, arg: Handle<Expression>) -> Handle<Expression> {
        self.add(Expression::Math {
            fun,
            arg,
            arg1: None,
            arg2: None,
            arg3: None,
        })
    }

    /// A conversion of scalars or vectors to the scalar type `to`.
    pub fn convert(&mut self, expr: Handle<Expression>, to: Scalar) -> Handle<Expression> {
        self.add(Expression::As {
            expr,
            kind: to.kind,
            convert: Some(to.width),
        })
    }

    /// Where the expressions go.
    pub fn expressions(&self) -> &Arena<Expression> {
        self.expressions
    }
}

/// An empty function with these arguments. The body is written with [`Code`] and set by [`set_body`].
pub fn function(
    name: &str,
    arguments: &[(&str, Handle<Type>)],
    result: Option<Handle<Type>>,
) -> (Function, Vec<Handle<Expression>>) {
    let mut function = Function {
        name: Some(name.to_owned()),
        arguments: arguments
            .iter()
            .map(|&(name, ty)| FunctionArgument {
                name: Some(name.to_owned()),
                ty,
                binding: None,
            })
            .collect(),
        result: result.map(|ty| FunctionResult { ty, binding: None }),
        ..Function::default()
    };
    let arguments = (0..arguments.len() as u32)
        .map(|index| {
            function
                .expressions
                .append(Expression::FunctionArgument(index), Span::UNDEFINED)
        })
        .collect();
    (function, arguments)
}

/// Gives a function without a result its body.
pub fn set_body(function: &mut Function, mut body: Block) {
    body.push(Statement::Return { value: None }, Span::UNDEFINED);
    function.body = body;
}
