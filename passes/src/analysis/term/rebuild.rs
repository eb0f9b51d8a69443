//! Makes a term anew with others in the place of what it is made of: a loop's counter in one iteration, the ids of one pixel.

use naga::{BinaryOperator, Literal, MathFunction, ScalarKind};

use super::{Bits, Operands, Step, Term, TermId, Terms, integer};

impl Terms<'_> {
    /// A term with others for its operands, simplified; `None` if `put` gives none for one of them. What a loop makes of a variable, and
    /// what cannot be computed a second time, has no operands and stays as it is.
    pub fn rebuilt(
        &mut self,
        id: TermId,
        put: &mut dyn FnMut(&mut Self, TermId) -> Option<TermId>,
    ) -> Option<TermId> {
        Some(match self.get(id).clone() {
            Term::Literal(_)
            | Term::Constant(_)
            | Term::Override(_)
            | Term::Zero(_)
            | Term::Id(_)
            | Term::LoopVar { .. }
            | Term::LoopExit { .. }
            | Term::Opaque { .. } => id,
            Term::Resource(global, path) => {
                let path = self.rebuilt_path(&path, put)?;
                self.intern(Term::Resource(global, path))
            }
            Term::ArrayLength(global, path) => {
                let path = self.rebuilt_path(&path, put)?;
                self.intern(Term::ArrayLength(global, path))
            }
            Term::Load(global, path) => {
                let path = self.rebuilt_path(&path, put)?;
                self.intern(Term::Load(global, path))
            }
            Term::Compose { ty, parts } => {
                let parts = self.rebuilt_all(&parts, put)?;
                self.compose(ty, parts)
            }
            Term::Extract(base, index) => {
                let base = put(self, base)?;
                self.extract(base, index)
            }
            Term::Index(base, index) => {
                let (base, index) = (put(self, base)?, put(self, index)?);
                self.index(base, index)
            }
            Term::Insert(base, index, value) => {
                let (base, value) = (put(self, base)?, put(self, value)?);
                self.insert(base, index, value)
            }
            Term::Update(base, index, value) => {
                let (base, index) = (put(self, base)?, put(self, index)?);
                let value = put(self, value)?;
                self.intern(Term::Update(base, index, value))
            }
            Term::Splat(size, value) => {
                let value = put(self, value)?;
                self.intern(Term::Splat(size, value))
            }
            Term::Swizzle(size, vector, pattern) => {
                let vector = put(self, vector)?;
                self.intern(Term::Swizzle(size, vector, pattern))
            }
            Term::Unary(op, value) => {
                let value = put(self, value)?;
                self.intern(Term::Unary(op, value))
            }
            Term::Binary(op, left, right) => {
                let (left, right) = (put(self, left)?, put(self, right)?);
                match compare(op, self.as_literal(left), self.as_literal(right)) {
                    Some(result) => self.bool(result),
                    None => match exact(op, self.as_literal(left), self.as_literal(right)) {
                        Some(number) => self.literal(number),
                        // floats do not commute bit for bit where one is a NaN, and are left as they stand
                        None => self.binary(op, Operands::Other, left, right),
                    },
                }
            }
            Term::Select(condition, accept, reject) => {
                let condition = put(self, condition)?;
                let (accept, reject) = (put(self, accept)?, put(self, reject)?);
                self.select(condition, accept, reject)
            }
            Term::Relational(fun, argument) => {
                let argument = put(self, argument)?;
                self.intern(Term::Relational(fun, argument))
            }
            Term::Math(fun, arguments) => {
                let arguments = self.rebuilt_all(&arguments, put)?;
                match self.folded(fun, &arguments) {
                    Some(number) => self.literal(number),
                    None => self.intern(Term::Math(fun, arguments.into())),
                }
            }
            Term::As(kind, convert, value) => {
                let value = put(self, value)?;
                match self.converted(kind, convert, value) {
                    Some(number) => self.literal(number),
                    None => self.cast(kind, convert, value),
                }
            }
            Term::ImageQuery(query, image, level) => {
                let image = put(self, image)?;
                let level = match level {
                    Some(level) => Some(put(self, level)?),
                    None => None,
                };
                self.intern(Term::ImageQuery(query, image, level))
            }
            Term::Original {
                function,
                expression,
                operands,
            } => {
                let operands = self.rebuilt_all(&operands, put)?.into();
                self.intern(Term::Original {
                    function,
                    expression,
                    operands,
                })
            }
            Term::Call(function, arguments) => {
                let arguments = self.rebuilt_all(&arguments, put)?.into();
                self.intern(Term::Call(function, arguments))
            }
            Term::Merge {
                id,
                values,
                conditions,
            } => {
                let values = self.rebuilt_all(&values, put)?.into();
                let conditions = self.rebuilt_all(&conditions, put)?.into();
                self.intern(Term::Merge {
                    id,
                    values,
                    conditions,
                })
            }
        })
    }

    fn rebuilt_all(
        &mut self,
        all: &[TermId],
        put: &mut dyn FnMut(&mut Self, TermId) -> Option<TermId>,
    ) -> Option<Vec<TermId>> {
        all.iter().map(|&term| put(self, term)).collect()
    }

    fn rebuilt_path(
        &mut self,
        path: &[Step],
        put: &mut dyn FnMut(&mut Self, TermId) -> Option<TermId>,
    ) -> Option<Box<[Step]>> {
        path.iter()
            .map(|step| match *step {
                Step::Dynamic(index) => put(self, index).map(Step::Dynamic),
                Step::Index(index) => Some(Step::Index(index)),
            })
            .collect()
    }

    /// What a built-in function gives for integers.
    fn folded(&self, fun: MathFunction, arguments: &[TermId]) -> Option<Literal> {
        let numbers: Vec<Literal> = arguments
            .iter()
            .map(|&argument| self.as_literal(argument))
            .collect::<Option<_>>()?;
        match (fun, numbers.as_slice()) {
            (MathFunction::Min, &[Literal::U32(a), Literal::U32(b)]) => {
                Some(Literal::U32(a.min(b)))
            }
            (MathFunction::Max, &[Literal::U32(a), Literal::U32(b)]) => {
                Some(Literal::U32(a.max(b)))
            }
            (MathFunction::Min, &[Literal::I32(a), Literal::I32(b)]) => {
                Some(Literal::I32(a.min(b)))
            }
            (MathFunction::Max, &[Literal::I32(a), Literal::I32(b)]) => {
                Some(Literal::I32(a.max(b)))
            }
            (MathFunction::Floor, &[Literal::F32(a)]) => Some(Literal::F32(a.floor())),
            _ => None,
        }
    }

    /// A number, converted: between the signs, and between integers and floats that hold the very number.
    fn converted(&self, kind: ScalarKind, convert: Option<u8>, value: TermId) -> Option<Literal> {
        let Term::Literal(Bits(number)) = *self.get(value) else {
            return None;
        };
        match (kind, convert, number) {
            (ScalarKind::Sint, None | Some(4), Literal::U32(n)) => Some(Literal::I32(n as i32)),
            (ScalarKind::Uint, None | Some(4), Literal::I32(n)) => Some(Literal::U32(n as u32)),
            (ScalarKind::Sint, None | Some(4), Literal::I32(_))
            | (ScalarKind::Uint, None | Some(4), Literal::U32(_)) => Some(number),
            (ScalarKind::Float, Some(4), Literal::U32(n)) if n < 1 << 24 => {
                Some(Literal::F32(n as f32))
            }
            (ScalarKind::Float, Some(4), Literal::I32(n)) if n.unsigned_abs() < 1 << 24 => {
                Some(Literal::F32(n as f32))
            }
            // towards zero; what does not fit, and a NaN, is another matter
            (ScalarKind::Uint, Some(4), Literal::F32(x)) if (0.0..16_777_216.0).contains(&x) => {
                Some(Literal::U32(x as u32))
            }
            (ScalarKind::Sint, Some(4), Literal::F32(x)) if x.abs() < 16_777_216.0 => {
                Some(Literal::I32(x as i32))
            }
            _ => None,
        }
    }
}

/// What an operation on two floats comes to, where no driver has to round.
fn exact(op: BinaryOperator, left: Option<Literal>, right: Option<Literal>) -> Option<Literal> {
    let (Some(Literal::F32(left)), Some(Literal::F32(right))) = (left, right) else {
        return None;
    };
    let (left, right) = (f64::from(left), f64::from(right));
    let number = match op {
        BinaryOperator::Add => left + right,
        BinaryOperator::Subtract => left - right,
        BinaryOperator::Multiply => left * right,
        BinaryOperator::Divide if right.abs().log2().fract() == 0.0 => left / right,
        _ => return None,
    };
    let rounded = number as f32;
    (rounded.is_finite() && f64::from(rounded) == number).then_some(Literal::F32(rounded))
}

/// What a comparison of two integers comes to.
fn compare(op: BinaryOperator, left: Option<Literal>, right: Option<Literal>) -> Option<bool> {
    use BinaryOperator as B;
    let (left, right) = (integer(left)?, integer(right)?);
    match op {
        B::Less => Some(left < right),
        B::LessEqual => Some(left <= right),
        B::Greater => Some(left > right),
        B::GreaterEqual => Some(left >= right),
        B::Equal => Some(left == right),
        B::NotEqual => Some(left != right),
        _ => None,
    }
}
