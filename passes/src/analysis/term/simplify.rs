//! Makes terms, simplified on the way: taking apart what was put together, folding numbers, ordering what commutes, so
//! that equal values get equal terms.

use naga::{BinaryOperator, Bytes, Literal, ScalarKind, UnaryOperator};

use super::{Bits, Id, Opacity, Operands, Step, Term, TermId, Terms, integer, longer};

impl Terms<'_> {
    /// Part `index` of a value.
    pub fn extract(&mut self, base: TermId, index: u32) -> TermId {
        match *self.get(base) {
            Term::Compose { ty, ref parts } if self.is_flat(ty, parts.len()) => {
                match parts.get(index as usize) {
                    Some(&part) => return part,
                    None => return self.opaque(Opacity::Beyond, vec![base]),
                }
            }
            Term::Splat(_, value) => return value,
            Term::Swizzle(size, vector, pattern) if index < size as u32 => {
                return self.extract(vector, u32::from(pattern[index as usize]));
            }
            Term::Insert(under, at, value) => {
                return if at == index {
                    value
                } else {
                    self.extract(under, index)
                };
            }
            Term::Select(condition, accept, reject) => {
                let accept = self.extract(accept, index);
                let reject = self.extract(reject, index);
                return self.select(condition, accept, reject);
            }
            Term::Zero(ty) => {
                if let Some(zero) = self.zero_part(ty, index) {
                    return zero;
                }
            }
            Term::LoopVar { of, var, ref part } => {
                let part = longer(part, index);
                return self.intern(Term::LoopVar { of, var, part });
            }
            Term::LoopExit { of, var, ref part } => {
                let part = longer(part, index);
                return self.intern(Term::LoopExit { of, var, part });
            }
            Term::Merge {
                id,
                ref values,
                ref conditions,
            } => {
                let values = values.clone();
                let conditions = conditions.clone();
                let values = values.iter().map(|&v| self.extract(v, index)).collect();
                return self.merge_as(id, values, conditions);
            }
            Term::Load(global, ref path) if self.loads_aggregate(global, path) => {
                let path = path
                    .iter()
                    .copied()
                    .chain([Step::Index(index)])
                    .collect::<Box<[Step]>>();
                return self.intern(Term::Load(global, path));
            }
            _ => {}
        }
        self.intern(Term::Extract(base, index))
    }

    /// The element of a value at a computed place.
    pub fn index(&mut self, base: TermId, index: TermId) -> TermId {
        match self.as_literal(index) {
            Some(Literal::U32(i)) => return self.extract(base, i),
            Some(Literal::I32(i)) if i >= 0 => return self.extract(base, i as u32),
            _ => {}
        }
        if let Term::Load(global, path) = self.get(base)
            && self.loads_aggregate(*global, path)
        {
            let global = *global;
            let path = path.iter().copied().chain([Step::Dynamic(index)]).collect();
            return self.intern(Term::Load(global, path));
        }
        self.intern(Term::Index(base, index))
    }

    /// A value with part `index` replaced.
    pub fn insert(&mut self, base: TermId, index: u32, value: TermId) -> TermId {
        if let Term::Compose { ty, parts } = self.get(base)
            && self.is_flat(*ty, parts.len())
            && (index as usize) < parts.len()
        {
            let ty = *ty;
            let mut parts = parts.to_vec();
            parts[index as usize] = value;
            return self.compose(ty, parts);
        }
        self.intern(Term::Insert(base, index, value))
    }

    /// `select(reject, accept, condition)`; one of the two where they agree or the condition is known.
    pub fn select(&mut self, condition: TermId, accept: TermId, reject: TermId) -> TermId {
        if accept == reject {
            return accept;
        }
        match self.as_literal(condition) {
            Some(Literal::Bool(true)) => return accept,
            Some(Literal::Bool(false)) => return reject,
            _ => {}
        }
        match (self.as_literal(accept), self.as_literal(reject)) {
            (Some(Literal::Bool(true)), Some(Literal::Bool(false))) => return condition,
            (Some(Literal::Bool(false)), Some(Literal::Bool(true))) => return self.not(condition),
            // `a && b` and `a || b`, which naga's front end lowers to a variable and an `if`
            (_, Some(Literal::Bool(false))) => return self.and(condition, accept),
            (Some(Literal::Bool(true)), _) => return self.or(condition, reject),
            (_, Some(Literal::Bool(true))) => {
                let otherwise = self.not(condition);
                return self.or(otherwise, accept);
            }
            (Some(Literal::Bool(false)), _) => {
                let otherwise = self.not(condition);
                return self.and(otherwise, reject);
            }
            _ => {}
        }
        // the same as glslang lowers them: the value of the branch that is not taken is the condition's own
        let otherwise = self.not(condition);
        if reject == condition {
            return self.and(condition, accept);
        } else if accept == condition {
            return self.or(condition, reject);
        } else if reject == otherwise {
            return self.or(otherwise, accept);
        } else if accept == otherwise {
            return self.and(otherwise, reject);
        }
        self.intern(Term::Select(condition, accept, reject))
    }

    /// One of several values; the value itself where they all agree.
    pub fn merge(&mut self, values: Vec<TermId>, conditions: Vec<TermId>) -> TermId {
        let id = self.fresh();
        self.merge_as(id, values, conditions.into())
    }

    fn merge_as(&mut self, id: u32, values: Vec<TermId>, conditions: Box<[TermId]>) -> TermId {
        if let [first, rest @ ..] = values.as_slice()
            && rest.iter().all(|value| value == first)
        {
            return *first;
        }
        self.intern(Term::Merge {
            id,
            values: values.into(),
            conditions,
        })
    }

    /// `!value`
    pub fn not(&mut self, value: TermId) -> TermId {
        match *self.get(value) {
            Term::Literal(Bits(Literal::Bool(value))) => self.bool(!value),
            Term::Unary(UnaryOperator::LogicalNot, inner) => inner,
            _ => self.intern(Term::Unary(UnaryOperator::LogicalNot, value)),
        }
    }

    /// `left && right`
    pub fn and(&mut self, left: TermId, right: TermId) -> TermId {
        match (self.as_literal(left), self.as_literal(right)) {
            (Some(Literal::Bool(true)), _) => right,
            (_, Some(Literal::Bool(true))) => left,
            (Some(Literal::Bool(false)), _) | (_, Some(Literal::Bool(false))) => self.bool(false),
            _ if left == right => left,
            _ => self.intern(Term::Binary(BinaryOperator::LogicalAnd, left, right)),
        }
    }

    /// `left || right`
    pub fn or(&mut self, left: TermId, right: TermId) -> TermId {
        match (self.as_literal(left), self.as_literal(right)) {
            (Some(Literal::Bool(false)), _) => right,
            (_, Some(Literal::Bool(false))) => left,
            (Some(Literal::Bool(true)), _) | (_, Some(Literal::Bool(true))) => self.bool(true),
            _ if left == right => left,
            _ => self.intern(Term::Binary(BinaryOperator::LogicalOr, left, right)),
        }
    }

    /// A conversion, or a bit cast.
    pub fn cast(&mut self, kind: ScalarKind, convert: Option<Bytes>, value: TermId) -> TermId {
        self.intern(Term::As(kind, convert, value))
    }

    /// The number of a pixel, row by row: `y * width + x`.
    pub fn linear_index(&mut self, width: TermId) -> TermId {
        let [x, y] = [0, 1].map(|axis| self.intern(Term::Id(Id::Global(axis))));
        let row = self.binary(BinaryOperator::Multiply, Operands::Integers, y, width);
        self.binary(BinaryOperator::Add, Operands::Integers, row, x)
    }

    /// Column or row of a pixel's number: `(y * width + x) % width` is x, since x lies inside the width, and
    /// `(y * width + x) / width` is y; as `i32`, too, since a picture has less than 2³¹ pixels.
    fn unlinear(&mut self, op: BinaryOperator, left: TermId, right: TermId) -> Option<TermId> {
        let width = self.width?;
        let axis = match op {
            BinaryOperator::Modulo => 0,
            BinaryOperator::Divide => 1,
            _ => return None,
        };
        let number = self.linear_index(width);
        let of = self.intern(Term::Id(Id::Global(axis)));
        if (left, right) == (number, width) {
            return Some(of);
        }
        let signed = |terms: &Terms, id| match *terms.get(id) {
            Term::As(ScalarKind::Sint, Some(4) | None, inner) => Some(inner),
            _ => None,
        };
        let as_signed = match self.get(width) {
            Term::As(ScalarKind::Uint, Some(4), inner) => Some(*inner),
            Term::Literal(Bits(Literal::U32(n))) => {
                let n = *n;
                Some(self.literal(Literal::I32(n as i32)))
            }
            _ => None,
        };
        let same_width = as_signed == Some(right) || signed(self, right) == Some(width);
        (signed(self, left) == Some(number) && same_width)
            .then(|| self.intern(Term::As(ScalarKind::Sint, Some(4), of)))
    }

    /// Column or row of a workgroup's invocation, from its number: `index % width`, `index & 7u`, `index / width`, `index >> 3u`, as
    /// `i32`, too.
    fn unflattened(&mut self, op: BinaryOperator, left: TermId, right: TermId) -> Option<TermId> {
        let [width, _, depth] = self.sides?;
        let number = u32::try_from(integer(self.as_literal(right))?).ok()?;
        let is_power = width.is_power_of_two();
        let axis = match op {
            BinaryOperator::Modulo if number == width => 0,
            BinaryOperator::And if is_power && number == width - 1 => 0,
            BinaryOperator::Divide if depth == 1 && number == width => 1,
            BinaryOperator::ShiftRight
                if depth == 1 && is_power && number == width.trailing_zeros() =>
            {
                1
            }
            _ => return None,
        };
        match *self.get(left) {
            Term::Id(Id::LocalIndex) => Some(self.intern(Term::Id(Id::Local(axis)))),
            // a workgroup has far fewer than 2³¹ invocations
            Term::As(ScalarKind::Sint, convert @ (Some(4) | None), inner)
                if *self.get(inner) == Term::Id(Id::LocalIndex) =>
            {
                let of = self.intern(Term::Id(Id::Local(axis)));
                Some(self.intern(Term::As(ScalarKind::Sint, convert, of)))
            }
            _ => None,
        }
    }

    /// A binary operation on two scalars, or on two whole values.
    pub fn binary(
        &mut self,
        op: BinaryOperator,
        operands: Operands,
        left: TermId,
        right: TermId,
    ) -> TermId {
        use BinaryOperator as B;
        if let (Some(left), Some(right)) = (self.as_literal(left), self.as_literal(right))
            && let Some(folded) = fold(op, left, right)
        {
            return self.literal(folded);
        }
        if let Some(of) = self.unlinear(op, left, right) {
            return of;
        }
        if let Some(of) = self.unflattened(op, left, right) {
            return of;
        }
        let is = |terms: &Terms, id, n: i64| integer(terms.as_literal(id)) == Some(n);
        match op {
            B::LogicalAnd => return self.and(left, right),
            B::LogicalOr => return self.or(left, right),
            B::Add if is(self, left, 0) => return right,
            B::Add | B::Subtract | B::InclusiveOr | B::ShiftLeft | B::ShiftRight
                if is(self, right, 0) =>
            {
                return left;
            }
            B::Multiply if is(self, left, 1) => return right,
            B::Multiply if is(self, left, 0) => return left,
            B::Multiply if is(self, right, 0) => return right,
            B::Multiply | B::Divide if is(self, right, 1) => return left,
            // what WGSL says of a division by zero at run time; naga accepts none by a literal
            B::Divide if is(self, right, 0) => return left,
            B::Modulo if is(self, right, 0) => return right,
            _ => {}
        }
        let commutes = matches!(
            op,
            B::Add
                | B::Multiply
                | B::And
                | B::InclusiveOr
                | B::ExclusiveOr
                | B::Equal
                | B::NotEqual
        );
        let (left, right) = if commutes && operands == Operands::Integers && right < left {
            (right, left)
        } else {
            (left, right)
        };
        self.intern(Term::Binary(op, left, right))
    }
}

/// Folds the operations that addresses are made of. Wraps, as WGSL does; what it leaves open (a division by zero, a shift by more
/// bits than there are) stays as it stands.
fn fold(op: BinaryOperator, left: Literal, right: Literal) -> Option<Literal> {
    use BinaryOperator as B;
    match (left, right) {
        (Literal::U32(a), Literal::U32(b)) => Some(match op {
            B::Equal => Literal::Bool(a == b),
            B::NotEqual => Literal::Bool(a != b),
            B::Add => Literal::U32(a.wrapping_add(b)),
            B::Subtract => Literal::U32(a.wrapping_sub(b)),
            B::Multiply => Literal::U32(a.wrapping_mul(b)),
            B::Divide => Literal::U32(a.checked_div(b)?),
            B::Modulo => Literal::U32(a.checked_rem(b)?),
            B::And => Literal::U32(a & b),
            B::InclusiveOr => Literal::U32(a | b),
            B::ExclusiveOr => Literal::U32(a ^ b),
            // bits that are shifted out are lost
            B::ShiftLeft if b < 32 => Literal::U32(a << b),
            B::ShiftRight if b < 32 => Literal::U32(a >> b),
            _ => return None,
        }),
        (Literal::I32(a), Literal::I32(b)) => Some(match op {
            B::Equal => Literal::Bool(a == b),
            B::NotEqual => Literal::Bool(a != b),
            B::Add => Literal::I32(a.wrapping_add(b)),
            B::Subtract => Literal::I32(a.wrapping_sub(b)),
            B::Multiply => Literal::I32(a.wrapping_mul(b)),
            B::Divide => Literal::I32(a.checked_div(b)?),
            B::Modulo => Literal::I32(a.checked_rem(b)?),
            B::And => Literal::I32(a & b),
            B::InclusiveOr => Literal::I32(a | b),
            B::ExclusiveOr => Literal::I32(a ^ b),
            _ => return None,
        }),
        (Literal::I32(a), Literal::U32(b)) => match op {
            B::ShiftLeft if b < 32 => Some(Literal::I32(a << b)),
            B::ShiftRight if b < 32 => Some(Literal::I32(a >> b)),
            _ => None,
        },
        _ => None,
    }
}
