//! Whether a read can meet what another invocation stores.
//!
//! A target may be read where nobody else stores: at the pixel's own place, be it another plane, layer or member of it; and where
//! nothing is stored at all. *Does*: holds the two addresses against each other, step by step, and looks for one of these:
//!
//! - **the same step**, which is one-to-one with the invocation: `cells[i].history[k]` against `cells[i].history[j]`;
//! - **strides**: both move by multiples of n and start less than n apart: `cells[i * 4 + 1]` against `cells[i * 4 + k]`, k < 4;
//! - **planes**: both are a place in a picture, which the shader's own bounds keep inside `width × height`, and whole pictures
//!   on: `cells[y * w + x]` against `cells[y * w + x + k * w * h]`;
//! - **ranges** that do not overlap: `cells[0]` against `cells[1 + i]`;
//! - **classes**: the domain leaves every place out that is read besides the pixel's own, as a checkerboard does.
//!
//! *Guarantees*: where the answer is not "perhaps", no invocation, original or rewritten, stores where another reads, if indices
//! do not wrap around 2³² and do not leave what they index (where they do, the original races already).

use naga::Literal;
use rustc_hash::FxHashSet;

use super::{Planner, addresses::is_one_to_one, classes::Classes, domain::Domain, iterations};
use crate::analysis::{
    Address,
    depends::Depends,
    guard::{Formula, flatten},
    interval::{Interval, less},
    polynomial::{Polynomial, Product, is_integer, without},
    tangent::Tangent,
    term::{Id, LoopId, Step, Term, TermId, integer},
};

/// How many pairs of iterations of the loops around a read are followed.
const MOST_ITERATIONS: i64 = 64;

/// Where a read and a store meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meet {
    /// Nowhere.
    Never,
    /// At most where one invocation does both.
    Own,
    /// Maybe where two invocations do.
    Perhaps,
}

/// An index, taken apart.
struct Index {
    /// What moves with the ids, by uniform factors.
    moves: Polynomial,
    /// What is the same for all invocations.
    shared: Polynomial,
    /// What is neither: loop counters, data.
    varies: Polynomial,
}

impl Planner<'_> {
    /// Where a read and a store of one target meet.
    pub(super) fn meet(&mut self, read: usize, store: usize, domain: &Domain) -> Meet {
        let (of_read, of_store) = (self.access(read), self.access(store));
        if of_read.target.element != of_store.target.element {
            return Meet::Perhaps;
        }
        let facts = [of_read.guards.clone(), of_store.guards.clone()];
        let pairs: Vec<(Step, Step)> = match (&of_read.address, &of_store.address) {
            (Address::Part(a), Address::Part(b)) => {
                a.iter().copied().zip(b.iter().copied()).collect()
            }
            (a @ Address::Texel { .. }, b @ Address::Texel { .. }) => {
                let steps = |address: &Address| address.terms().into_iter().map(Step::Dynamic);
                steps(a).zip(steps(b)).collect()
            }
            _ => return Meet::Perhaps,
        };
        let is_texel = matches!(of_store.address, Address::Texel { .. });
        // where the layers of the dispatch store apart, a pixel's own place is its own layer's
        let layered = self.axes(store).contains(Depends::Z);
        let same: Vec<TermId> = pairs
            .iter()
            .filter_map(|pair| match *pair {
                (Step::Dynamic(a), Step::Dynamic(b)) if a == b => Some(a),
                _ => None,
            })
            .collect();
        let mut found = Meet::Perhaps;
        if self.tells_invocations_apart(&same, layered) {
            found = Meet::Own;
        }
        let [of_read, of_store] = facts.map(|facts| {
            let mut conjuncts = Vec::new();
            flatten(&facts, &mut self.found.terms, &mut conjuncts);
            conjuncts
        });
        for &(a, b) in &pairs {
            let meet = match (a, b) {
                (Step::Index(a), Step::Index(b)) if a != b => Meet::Never,
                (Step::Index(_), Step::Index(_)) => Meet::Perhaps,
                (a, b) => {
                    let [a, b] = [a, b].map(|step| self.index_of(step));
                    self.meet_at(a, b, (&of_read, &of_store), domain)
                }
            };
            match meet {
                Meet::Never => return Meet::Never,
                Meet::Own if !layered => found = Meet::Own,
                Meet::Own | Meet::Perhaps => {}
            }
        }
        if found == Meet::Perhaps && is_texel {
            found = match self.meet_beside(&pairs, &of_read, domain) {
                Meet::Own if layered => Meet::Perhaps,
                meet => meet,
            };
        }
        found
    }

    /// An index as a term.
    fn index_of(&mut self, step: Step) -> TermId {
        match step {
            Step::Dynamic(term) => term,
            Step::Index(number) => self.found.terms.literal(Literal::U32(number)),
        }
    }

    /// Whether two invocations never agree in all of these values.
    fn tells_invocations_apart(&mut self, values: &[TermId], layered: bool) -> bool {
        let tangents: Option<Vec<Tangent>> = values
            .iter()
            .map(|&value| self.tangents.of(&mut self.found.terms, &mut self.on, value))
            .map(|tangent| tangent.filter(Tangent::is_pixel_only))
            .collect();
        let Some(tangents) = tangents else {
            return false;
        };
        let has_layer = tangents.iter().any(|tangent| {
            let [x, y, z] = tangent.pixel;
            x.is_zero() && y.is_zero() && !z.is_zero()
        });
        is_one_to_one(&tangents) && (has_layer || !layered)
    }

    /// Where two indices agree.
    fn meet_at(
        &mut self,
        read: TermId,
        store: TermId,
        (of_read, of_store): (&[Formula], &[Formula]),
        domain: &Domain,
    ) -> Meet {
        let (Some(a), Some(b)) = (self.taken_apart(read), self.taken_apart(store)) else {
            return Meet::Perhaps;
        };
        if a.moves == b.moves
            && !a.moves.factors.is_empty()
            && let Some(between) = a.shared.plus(&b.shared, -1)
        {
            let strides = self.meet_by_strides((&a, of_read), (&b, of_store), &between);
            let meet = match strides {
                Meet::Own => self.is_a_pixels_own(&a.moves).then_some(Meet::Own),
                Meet::Never => Some(Meet::Never),
                Meet::Perhaps => self
                    .lie_in_planes(&a, &b, &between, domain)
                    .then_some(Meet::Own),
            };
            if let Some(meet) = meet {
                return meet;
            }
        }
        match (self.range(&a, of_read), self.range(&b, of_store)) {
            (Some(a), Some(b)) if a.is_apart(b) => Meet::Never,
            _ => Meet::Perhaps,
        }
    }

    /// Whether what moves with the ids is another number for each pixel: it moves by different strides along x and y (that the longer
    /// one spans a row is the author's business: without that, the original races).
    fn is_a_pixels_own(&mut self, moves: &Polynomial) -> bool {
        let [x, y] = [0, 1].map(|axis| self.found.terms.intern(Term::Id(Id::Global(axis))));
        let mut products = moves.factors.iter();
        let (Some(a), Some(b), None) = (products.next(), products.next(), products.next()) else {
            return false;
        };
        let is_free = |stride: &Product| !stride.contains(&x) && !stride.contains(&y);
        let strides = match (without(a.0, &[x]), without(b.0, &[y])) {
            (Some(along), Some(down)) => Some((along, down)),
            _ => without(a.0, &[y]).zip(without(b.0, &[x])),
        };
        strides.is_some_and(|(along, down)| {
            is_free(&along) && is_free(&down) && (along != down || a.1.abs() != b.1.abs())
        })
    }

    /// An index as a polynomial; `None` if it is too long.
    pub(super) fn polynomial(&mut self, index: TermId) -> Option<Polynomial> {
        Polynomial::of(&mut self.found.terms, self.found.group_size, index)
    }

    /// Whether two pixels never have both these coordinates in common, as their strides tell: one moves along one axis alone, the
    /// other by more along the other axis than all the rest of it can make up for, as `(x * 2 + (y & 1), y)` does.
    pub(super) fn strides_tell_apart(&mut self, coordinates: &[TermId]) -> bool {
        let [a, b, ..] = *coordinates else {
            return false;
        };
        let [x, y] = [0, 1].map(|axis| vec![self.found.terms.intern(Term::Id(Id::Global(axis)))]);
        [
            (a, b, &y, &x),
            (b, a, &x, &y),
            (b, a, &y, &x),
            (a, b, &x, &y),
        ]
        .into_iter()
        .any(|(strided, plain, along, down)| {
            let (Some(strided), Some(plain)) = (self.taken_apart(strided), self.taken_apart(plain))
            else {
                return false;
            };
            let is_plain = plain.varies.factors.is_empty() && plain.moves.factors.keys().eq([down]);
            let (stride, rest) = strided.moves.split(|product| product == along.as_slice());
            let rest = self.sum(&rest, &[]).plus(self.sum(&strided.varies, &[]));
            is_plain && rest.is_bounded() && rest.most - rest.least < stride.divisor()
        })
    }

    /// An index, taken apart; `None` if it is too long.
    fn taken_apart(&mut self, index: TermId) -> Option<Index> {
        let whole = self.polynomial(index)?;
        let (varies, rest) = whole.split(|product| {
            product.iter().any(|&symbol| {
                self.iterates(symbol)
                    || !Depends::IDS.contains(self.on.of(&mut self.found.terms, symbol))
            })
        });
        let (moves, shared) = rest.split(|product| {
            product
                .iter()
                .any(|&symbol| !self.on.of(&mut self.found.terms, symbol).is_empty())
        });
        Some(Index {
            moves,
            shared,
            varies,
        })
    }

    /// Whether a value may be another in another iteration.
    fn iterates(&self, value: TermId) -> bool {
        let mut left = vec![value];
        let mut seen = FxHashSet::default();
        while let Some(term) = left.pop() {
            if !seen.insert(term) {
                continue;
            }
            if let Term::LoopVar { .. } | Term::LoopExit { .. } = self.found.terms.get(term) {
                return true;
            }
            self.found
                .terms
                .operands(term, &mut |operand| left.push(operand));
        }
        false
    }

    /// Two indices that move by multiples of a number, or of a uniform, and start less than that apart.
    fn meet_by_strides(
        &mut self,
        (read, of_read): (&Index, &[Formula]),
        (store, of_store): (&Index, &[Formula]),
        between: &Polynomial,
    ) -> Meet {
        if let Some(number) = between.as_number() {
            let stride = read.moves.divisor();
            let (a, b) = (
                self.sum(&read.varies, of_read),
                self.sum(&store.varies, of_store),
            );
            let apart = Interval::number(number).plus(a).plus(b.negative());
            if apart.least > -stride && apart.most < stride {
                return match apart.is_apart(Interval::number(0)) {
                    true => Meet::Never,
                    false => Meet::Own,
                };
            }
        }
        let symbols: Vec<TermId> = match read.moves.factors.first_key_value() {
            Some((product, _)) => product.clone(),
            None => return Meet::Perhaps,
        };
        let is_stride = |planner: &mut Self, symbol: TermId| {
            let is_uniform = planner.on.of(&mut planner.found.terms, symbol).is_empty();
            is_uniform
                && read.moves.is_multiple_of((&[symbol], 1))
                && planner.counts_to(&read.varies, symbol, of_read)
                && planner.counts_to(&store.varies, symbol, of_store)
        };
        let is_spanned =
            between.factors.is_empty() && symbols.into_iter().any(|symbol| is_stride(self, symbol));
        match is_spanned {
            true => Meet::Own,
            false => Meet::Perhaps,
        }
    }

    /// Whether a value is 0 or a counter that stays between 0 and a uniform.
    fn counts_to(&mut self, value: &Polynomial, uniform: TermId, facts: &[Formula]) -> bool {
        if value.factors.is_empty() {
            return true;
        }
        let mut products = value.factors.iter();
        let (Some((product, 1)), None) = (products.next(), products.next()) else {
            return false;
        };
        let [counter] = *product.as_slice() else {
            return false;
        };
        let bound = Polynomial::monomial(vec![uniform], 1);
        Interval::of(&self.found.terms, facts, counter).least >= 0
            && self.is_below(counter, facts, &bound)
    }

    /// Whether conditions that hold say that a value lies below another.
    fn is_below(&mut self, value: TermId, facts: &[Formula], bound: &Polynomial) -> bool {
        self.bounds(value, facts).contains(bound)
    }

    /// What a value lies below, as conditions that hold say.
    fn bounds(&mut self, value: TermId, facts: &[Formula]) -> Vec<Polynomial> {
        let value = Polynomial::monomial(vec![value], 1);
        let (terms, size) = (&mut self.found.terms, self.found.group_size);
        facts
            .iter()
            .filter_map(|fact| {
                let (lesser, greater, strictly) = less(terms, fact)?;
                if !is_integer(terms, lesser) && !is_integer(terms, greater) {
                    return None;
                }
                let lesser = Polynomial::of(terms, size, lesser)?;
                let greater = Polynomial::of(terms, size, greater)?;
                let beyond = Polynomial::number(i64::from(!strictly));
                (lesser == value).then(|| greater.plus(&beyond, 1))?
            })
            .collect()
    }

    /// Whether both indices are a place in a picture, and a multiple of the picture's size on.
    fn lie_in_planes(
        &mut self,
        read: &Index,
        store: &Index,
        between: &Polynomial,
        domain: &Domain,
    ) -> bool {
        let mut facts = Vec::new();
        flatten(&domain.shared, &mut self.found.terms, &mut facts);
        let [x, y] = [0, 1].map(|axis| self.found.terms.intern(Term::Id(Id::Global(axis))));
        let is_whole = |picture: &(Product, i64)| {
            [between, &read.varies, &store.varies]
                .into_iter()
                .all(|part| part.is_multiple_of((&picture.0, picture.1)))
        };
        [(x, y), (y, x)].into_iter().any(|axes| {
            self.pictures(&read.moves, axes, &facts)
                .iter()
                .any(is_whole)
        })
    }

    /// The size of the picture, times the number of indices a pixel has, that an index stays inside of: `column + row * width` with bounds
    /// for both.
    fn pictures(
        &mut self,
        moves: &Polynomial,
        (column, row): (TermId, TermId),
        facts: &[Formula],
    ) -> Vec<(Product, i64)> {
        let is_of = |product: &Product, axis| product.contains(&axis);
        let mut products = moves.factors.iter();
        let (Some(a), Some(b), None) = (products.next(), products.next(), products.next()) else {
            return Vec::new();
        };
        let ((along, &step), (down, &pitch)) = match is_of(a.0, row) {
            true => (b, a),
            false => (a, b),
        };
        let Some(width) = without(down, &[row]) else {
            return Vec::new();
        };
        let is_column = *along == [column] && !is_of(&width, column) && !is_of(&width, row);
        if !is_column || step <= 0 || pitch <= 0 || pitch % step != 0 {
            return Vec::new();
        }
        if !self.is_below(
            column,
            facts,
            &Polynomial::monomial(width.clone(), pitch / step),
        ) {
            return Vec::new();
        }
        self.bounds(row, facts)
            .into_iter()
            .filter_map(|height| {
                let mut monomials = height.factors.into_iter();
                let (Some((height, times)), None) = (monomials.next(), monomials.next()) else {
                    return None;
                };
                let mut size: Product = width.iter().copied().chain(height).collect();
                size.sort_unstable();
                Some((size, pitch.checked_mul(times).filter(|&size| size > 0)?))
            })
            .collect()
    }

    /// Where a sum of products lies.
    fn sum(&self, sum: &Polynomial, facts: &[Formula]) -> Interval {
        let of = |symbol| Interval::of(&self.found.terms, facts, symbol);
        sum.factors
            .iter()
            .map(|(product, &factor)| {
                let symbols = product.iter().map(|&symbol| of(symbol));
                symbols.fold(Interval::number(factor), Interval::times)
            })
            .fold(Interval::number(0), Interval::plus)
    }

    /// Where an index lies; `None` if what it is made of besides ids and uniforms has no bounds, and might wrap.
    fn range(&self, index: &Index, facts: &[Formula]) -> Option<Interval> {
        let varies = self.sum(&index.varies, facts);
        varies.is_bounded().then(|| {
            varies
                .plus(self.sum(&index.moves, facts))
                .plus(self.sum(&index.shared, facts))
        })
    }

    /// A texel beside the pixel's own, which the domain leaves out.
    fn meet_beside(
        &mut self,
        pairs: &[(Step, Step)],
        of_read: &[Formula],
        domain: &Domain,
    ) -> Meet {
        let [
            (Step::Dynamic(column), own_column),
            (Step::Dynamic(row), own_row),
            ..,
        ] = *pairs
        else {
            return Meet::Perhaps;
        };
        let [x, y] = [0, 1].map(|axis| {
            Polynomial::monomial(vec![self.found.terms.intern(Term::Id(Id::Global(axis)))], 1)
        });
        let mut is_at = |step: Step, place: &Polynomial| {
            let term = self.index_of(step);
            Polynomial::of(&mut self.found.terms, self.found.group_size, term).as_ref()
                == Some(place)
        };
        if !is_at(own_column, &x) || !is_at(own_row, &y) {
            return Meet::Perhaps;
        }
        let mut beside = [(column, &x), (row, &y)].map(|(term, own)| {
            Polynomial::of(&mut self.found.terms, self.found.group_size, term)?.plus(own, -1)
        });
        let [Some(column), Some(row)] = beside.each_mut().map(Option::take) else {
            return Meet::Perhaps;
        };
        let Some(places) = self.over_counters(&[column, row], of_read) else {
            return Meet::Perhaps;
        };
        let mut facts = Vec::new();
        flatten(&domain.shared, &mut self.found.terms, &mut facts);
        let classes = Classes::of(&mut self.found.terms, self.found.group_size, &facts);
        let is_own = |place: &Vec<i64>| place.iter().all(|&step| step == 0);
        let is_left_out = |place: &Vec<i64>| classes.leave_out([place[0], place[1]]);
        if !places
            .iter()
            .all(|place| is_own(place) || is_left_out(place))
        {
            return Meet::Perhaps;
        }
        match places.iter().any(is_own) {
            true => Meet::Own,
            false => Meet::Never,
        }
    }

    /// What sums come to in every iteration of the loops that have a part in them, if that is numbers.
    fn over_counters(&mut self, sums: &[Polynomial], facts: &[Formula]) -> Option<Vec<Vec<i64>>> {
        let mut counters: Vec<(LoopId, u32, TermId)> = Vec::new();
        let symbols = sums.iter().flat_map(|sum| sum.factors.keys().flatten());
        let mut left: Vec<TermId> = symbols.copied().collect();
        while let Some(term) = left.pop() {
            if let Term::LoopVar { of, var, ref part } = *self.found.terms.get(term) {
                if !part.is_empty() {
                    return None;
                }
                if !counters.iter().any(|&(_, _, known)| known == term) {
                    counters.push((of, var, term));
                }
            }
            self.found
                .terms
                .operands(term, &mut |operand| left.push(operand));
        }
        let mut iterations: Vec<Vec<(LoopId, u32, TermId)>> = vec![Vec::new()];
        for (of, var, counter) in counters {
            let range = Interval::of(&self.found.terms, facts, counter);
            let before = self.found.terms.loops[of.index()].variables[var as usize].before;
            let first = self.found.terms.as_literal(before)?;
            let count = range.most.checked_sub(range.least)?.checked_add(1)?;
            if !range.is_bounded() || count * iterations.len() as i64 > MOST_ITERATIONS {
                return None;
            }
            let mut longer = Vec::new();
            for number in range.least..=range.most {
                let number = match first {
                    Literal::U32(_) => Literal::U32(number as u32),
                    Literal::I32(_) => Literal::I32(number as i32),
                    _ => return None,
                };
                let number = self.found.terms.literal(number);
                longer.extend(iterations.iter().map(|known| {
                    let mut known = known.clone();
                    known.push((of, var, number));
                    known
                }));
            }
            iterations = longer;
        }
        iterations
            .iter()
            .map(|iteration| {
                sums.iter()
                    .map(|sum| self.in_iteration(sum, iteration))
                    .collect()
            })
            .collect()
    }

    fn in_iteration(
        &mut self,
        sum: &Polynomial,
        iteration: &[(LoopId, u32, TermId)],
    ) -> Option<i64> {
        let mut total = 0_i64;
        for (product, factor) in &sum.factors {
            let mut value = *factor;
            for &symbol in product {
                let number = iterations::at(&mut self.found.terms, symbol, iteration)?;
                value = value.checked_mul(integer(self.found.terms.as_literal(number))?)?;
            }
            total = total.checked_add(value)?;
        }
        Some(total)
    }
}
