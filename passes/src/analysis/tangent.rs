//! The tangent of a value: d(value)/d(id), as a small matrix of integers and uniform strides.
//!
//! Where an address is `M·id + c` and `c` is the same for a primary and its duplicates, a duplicate's address is the
//! primary's plus `M·delta`, exact in the wrapping arithmetic of WGSL; no code has to be cloned. This is forward-mode
//! differentiation of addresses: every id has a unit tangent, sums add tangents, products with a uniform scale them,
//! and whatever is not linear has none.
//!
//! *Guarantees*: a tangent is claimed only if no condition that depends on ids, data or state chose the value.

use naga::{BinaryOperator, ScalarKind, UnaryOperator};
use rustc_hash::FxHashMap;

use super::{
    depends::Dependence,
    term::{Axis, Id, LoopVariable, Term, TermId, Terms, integer},
};

/// One entry of a tangent: `constant + symbol × scale`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Slope {
    /// The constant part.
    pub constant: i64,
    /// A uniform value and its factor.
    pub symbol: Option<(TermId, i64)>,
}

impl Slope {
    fn constant(constant: i64) -> Slope {
        Slope {
            constant,
            symbol: None,
        }
    }

    /// Whether the value does not move along this axis.
    pub fn is_zero(self) -> bool {
        self == Slope::default()
    }

    fn add(self, other: Slope) -> Option<Slope> {
        let symbol = match (self.symbol, other.symbol) {
            (None, symbol) | (symbol, None) => symbol,
            (Some((a, m)), Some((b, n))) if a == b => Some((a, m.checked_add(n)?)),
            _ => return None,
        };
        Some(Slope {
            constant: self.constant.checked_add(other.constant)?,
            symbol: symbol.filter(|&(_, scale)| scale != 0),
        })
    }

    fn scale(self, by: i64) -> Option<Slope> {
        let symbol = match self.symbol {
            Some((symbol, scale)) => Some((symbol, scale.checked_mul(by)?)),
            None => None,
        };
        Some(Slope {
            constant: self.constant.checked_mul(by)?,
            symbol: symbol.filter(|&(_, scale)| scale != 0),
        })
    }

    fn times(self, by: TermId) -> Option<Slope> {
        match self.symbol {
            None if self.constant == 0 => Some(self),
            None => Some(Slope {
                constant: 0,
                symbol: Some((by, self.constant)),
            }),
            Some(_) => None,
        }
    }
}

/// How a scalar moves with the invocation grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Tangent {
    /// Along the axes of the pixel's position.
    pub pixel: [Slope; 3],
    /// Along the axes of the workgroup's position, for values that mix both until they cancel.
    pub group: [Slope; 3],
}

impl Tangent {
    /// One along an axis.
    pub fn along(axis: Axis) -> Tangent {
        let mut tangent = Tangent::default();
        tangent.pixel[axis as usize] = Slope::constant(1);
        tangent
    }

    fn zip(self, other: Tangent) -> Option<Tangent> {
        let mut sum = Tangent::default();
        for axis in 0..3 {
            sum.pixel[axis] = self.pixel[axis].add(other.pixel[axis])?;
            sum.group[axis] = self.group[axis].add(other.group[axis])?;
        }
        Some(sum)
    }

    fn map(self, f: impl Fn(Slope) -> Option<Slope>) -> Option<Tangent> {
        let mut mapped = Tangent::default();
        for axis in 0..3 {
            mapped.pixel[axis] = f(self.pixel[axis])?;
            mapped.group[axis] = f(self.group[axis])?;
        }
        Some(mapped)
    }

    /// Whether nothing is left that moves with the workgroup alone. A duplicate lies in its primary's layer, so both have
    /// the same z, and what moves with the workgroup's z is the same for both.
    pub fn is_pixel_only(&self) -> bool {
        let [x, y, _] = self.group;
        x.is_zero() && y.is_zero()
    }
}

/// Answers how terms move.
pub struct Tangents {
    /// The original workgroup size, as terms.
    group_size: [TermId; 3],
    known: FxHashMap<TermId, Option<Tangent>>,
    found: Vec<TermId>,
}

impl Tangents {
    /// Nothing is known yet.
    pub fn new(group_size: [TermId; 3]) -> Tangents {
        Tangents {
            group_size,
            known: FxHashMap::default(),
            found: Vec::new(),
        }
    }

    /// The tangent of an integer scalar, if it has one.
    pub fn of(&mut self, terms: &mut Terms, on: &mut Dependence, id: TermId) -> Option<Tangent> {
        if let Some(&known) = self.known.get(&id) {
            return known;
        }
        if let Term::LoopVar { of, var, part } = terms.get(id).clone() {
            return self.of_loop_variable(terms, on, id, (of.0, var), &part);
        }
        let tangent = self.compute(terms, on, id);
        self.learn(id, tangent);
        tangent
    }

    fn learn(&mut self, id: TermId, tangent: Option<Tangent>) {
        if self.known.insert(id, tangent).is_none() {
            self.found.push(id);
        }
    }

    /// Assumes that the variable moves as it did before the loop, and gives up if an iteration disagrees.
    fn of_loop_variable(
        &mut self,
        terms: &mut Terms,
        on: &mut Dependence,
        id: TermId,
        (of, var): (u32, u32),
        part: &[u32],
    ) -> Option<Tangent> {
        let LoopVariable { before, next, .. } =
            terms.loops[of as usize].variables[var as usize].clone();
        let before = terms.project(before, part);
        let assumed = self.of(terms, on, before);
        self.learn(id, assumed);
        assumed?;
        let next = next.map(|next| terms.project(next, part));
        let mark = self.found.len();
        if next.is_none_or(|next| self.of(terms, on, next) == assumed) {
            return assumed;
        }
        for taken_back in self.found.split_off(mark) {
            self.known.remove(&taken_back);
        }
        self.known.insert(id, None);
        None
    }

    fn compute(&mut self, terms: &mut Terms, on: &mut Dependence, id: TermId) -> Option<Tangent> {
        use BinaryOperator as B;
        if on.of(terms, id).is_empty() {
            return Some(Tangent::default());
        }
        match *terms.get(id) {
            Term::Id(Id::Global(axis)) => Some(Tangent::along(axis)),
            Term::Id(Id::Group(axis)) => {
                let mut tangent = Tangent::default();
                tangent.group[axis as usize] = Slope::constant(1);
                Some(tangent)
            }
            // a local id is the global id less the group's place, so `group * size + local` cancels to the global id
            Term::Id(Id::Local(axis)) => {
                let mut tangent = Tangent::along(axis);
                let size = self.group_size[axis as usize];
                tangent.group[axis as usize] = match integer(terms.as_literal(size)) {
                    Some(size) => Slope::constant(-size),
                    None => Slope {
                        constant: 0,
                        symbol: Some((size, -1)),
                    },
                };
                Some(tangent)
            }
            Term::Binary(op, left, right) => {
                let (a, b) = (self.of(terms, on, left)?, self.of(terms, on, right)?);
                match op {
                    B::Add => a.zip(b),
                    B::Subtract => a.zip(b.map(|slope| slope.scale(-1))?),
                    B::Multiply if b == Tangent::default() => scale(terms, a, right),
                    B::Multiply if a == Tangent::default() => scale(terms, b, left),
                    B::ShiftLeft => match integer(terms.as_literal(right)) {
                        Some(by @ 0..=31) => a.map(|slope| slope.scale(1 << by)),
                        _ => None,
                    },
                    _ => None,
                }
            }
            Term::Unary(UnaryOperator::Negate, value) => {
                self.of(terms, on, value)?.map(|slope| slope.scale(-1))
            }
            // 32-bit conversions between the signs keep all bits
            Term::As(ScalarKind::Sint | ScalarKind::Uint, None | Some(4), value) => {
                self.of(terms, on, value)
            }
            Term::Select(condition, accept, reject) => {
                let (a, b) = (self.of(terms, on, accept)?, self.of(terms, on, reject)?);
                (a == b && on.of(terms, condition).is_empty()).then_some(a)
            }
            Term::Merge {
                ref values,
                ref conditions,
                ..
            } => {
                let (values, conditions) = (values.clone(), conditions.clone());
                self.common(terms, on, &values, &conditions)
            }
            Term::LoopExit { of, var, ref part } => {
                let part = part.clone();
                let of = &terms.loops[of.0 as usize];
                let conditions = of.conditions.clone();
                let after = of.variables[var as usize].after.clone();
                let after: Vec<_> = after.iter().map(|&v| terms.project(v, &part)).collect();
                self.common(terms, on, &after, &conditions)
            }
            Term::Call(..) => {
                let expansion = *terms.expansions.get(&id)?;
                self.of(terms, on, expansion)
            }
            Term::Extract(base, index) => {
                let expansion = *terms.expansions.get(&base)?;
                let part = terms.extract(expansion, index);
                self.of(terms, on, part)
            }
            _ => None,
        }
    }

    /// The tangent that all values share, if nothing that differs between invocations chooses among them.
    fn common(
        &mut self,
        terms: &mut Terms,
        on: &mut Dependence,
        values: &[TermId],
        conditions: &[TermId],
    ) -> Option<Tangent> {
        if conditions.iter().any(|&c| !on.of(terms, c).is_empty()) {
            return None;
        }
        let (&first, rest) = values.split_first()?;
        let tangent = self.of(terms, on, first)?;
        rest.iter()
            .all(|&value| self.of(terms, on, value) == Some(tangent))
            .then_some(tangent)
    }
}

fn scale(terms: &Terms, tangent: Tangent, by: TermId) -> Option<Tangent> {
    match integer(terms.as_literal(by)) {
        Some(by) => tangent.map(|slope| slope.scale(by)),
        None => tangent.map(|slope| slope.times(by)),
    }
}
