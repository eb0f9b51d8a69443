//! Whether several pixels store to one place: `textureStore(half, id.xy / 2u, ..)`, `buf[(id.y >> 1u) * width + (id.x >> 1u)]`.
//!
//! In the original one of them stores last, or all of them store the same. In a rewritten shader the pixels of such a place may have
//! different primaries, and so different values, where they had one before: what the place holds would then be chance. Where all
//! pixels store one value, whatever their ids and data (a flag that is raised), nothing is lost and nothing changes.
//!
//! *Does*: puts the ids of a few pixels that lie close together into the store's address and into the conditions on the way to it,
//! and looks for two that store to the same place. *Guarantees*: the two that are found do meet, if what data have a say in allows both.
//! Where nothing is found, addresses are taken to be one-to-one, as a Morton order's are.

use naga::{BinaryOperator, Literal};
use rustc_hash::FxHashMap;

use super::{CopyPlan, Planner};
use crate::{
    analysis::{
        Access, AccessKind,
        depends::Depends,
        guard::{Formula, flatten},
        term::{Id, Operands, Step, Term, TermId, Terms, integer},
    },
    finding::{Code, Finding},
};

/// Pixels along each axis that are tried at most, from the first on.
const TRIED: u32 = 8;
/// What is nested more deeply is not followed.
const DEEPEST: u32 = 100;

/// Two pixels.
pub(super) type Pair = [[u32; 2]; 2];

/// A pixel's ids as numbers, and what terms come to with them.
struct Pixel {
    ids: FxHashMap<Id, TermId>,
    found: FxHashMap<TermId, Option<TermId>>,
    depth: u32,
}

/// Whether a pixel comes to a store.
enum Comes {
    /// It does, if data allow it and a uniform bound is not too small.
    Yes,
    No,
    Unknown,
}

impl Planner<'_> {
    /// Refuses a store that several pixels make at one place, unless they all store the same. Whether it is refused.
    pub(super) fn refuse_together(&mut self, store: usize) -> bool {
        if !self.access(store).kind.replaces() || self.stores_one_value(store) {
            return false;
        }
        let Some([a, b]) = self.meet_together(store) else {
            return false;
        };
        let access = self.access(store);
        let stored = access.plain();
        let (span, name) = (access.span, self.name(access.target.global));
        let [a, b] = [a, b].map(|[x, y]| format!("({x}, {y})"));
        self.say(
            Finding::new(
                Code::AddressNotOneToOne,
                format!("several pixels store to one place of `{name}`, and they may have different primaries, so what it holds would be chance"),
            )
            .about(stored)
            .at(span, format!("pixels {a} and {b} store to the same place"))
            .help(match self.works_together() {
                true => format!("store to `{name}` in an entry point of its own, that runs once for each place"),
                false => format!("dispatch one invocation for each place, in an entry point of its own; or `--target {name}=full`: every pixel stores there what the original does"),
            }),
        );
        true
    }

    /// Says so where whole workgroups work on a pixel each.
    pub(super) fn warn_of_groups_for_pixels(&mut self, copies: &[CopyPlan]) {
        let size = self.found.group_size;
        let is_lone = size
            .iter()
            .all(|&side| integer(self.found.terms.as_literal(side)) == Some(1));
        let Some(first) = copies.first() else {
            return;
        };
        if is_lone
            || !self.works_together()
            || !copies.iter().all(|copy| self.moves_by_groups(copy.access))
        {
            return;
        }
        let access = self.access(first.access);
        let (span, name) = (access.span, self.name(access.target.global));
        self.say(
            Finding::new(
                Code::PixelIsAGroup,
                format!("a whole workgroup works on each pixel of `{name}`, so no shading rate saves anything"),
            )
            .at(span, "the place moves with the workgroup alone")
            .help("leave this entry point as it is, or have one invocation work on each pixel"),
        );
    }

    /// Whether an address is the same for all invocations of a workgroup, and another for each workgroup.
    fn moves_by_groups(&self, access: usize) -> bool {
        let terms = &self.found.terms;
        let address = self.access(access).address.terms();
        let is_group = |term: &Term| matches!(term, Term::Id(Id::Group(_)));
        // what a loop makes of a variable is not followed
        let is_other = |term: &Term| match term {
            Term::Id(Id::Group(_) | Id::GroupCount(_)) => false,
            Term::Id(_) | Term::LoopVar { .. } | Term::LoopExit { .. } => true,
            _ => false,
        };
        !terms.is_any_below(&address, is_other) && terms.is_any_below(&address, is_group)
    }

    /// Two pixels that store to the same place.
    pub(super) fn meet_together(&mut self, store: usize) -> Option<Pair> {
        let mut places: FxHashMap<Vec<Step>, [u32; 2]> = FxHashMap::default();
        for (pixel, place) in self.places(store) {
            if let Some(other) = places.insert(place?, pixel) {
                return Some([other, pixel]);
            }
        }
        None
    }

    /// Two pixels, of which the first reads where the second stores.
    pub(super) fn reads_what_another_stores(&mut self, read: usize, store: usize) -> Option<Pair> {
        if self.access(read).target != self.access(store).target {
            return None;
        }
        let mut stored: FxHashMap<Vec<Step>, [u32; 2]> = FxHashMap::default();
        for (pixel, place) in self.places(store) {
            stored.insert(place?, pixel);
        }
        let is_met = |(pixel, place): ([u32; 2], Option<Vec<Step>>)| {
            let by = *stored.get(&place?)?;
            (by != pixel).then_some([pixel, by])
        };
        self.places(read).into_iter().find_map(is_met)
    }

    /// The pixels that are tried and come to an access, each with the place; `None` where the ids do not tell it.
    fn places(&mut self, access: usize) -> Vec<([u32; 2], Option<Vec<Step>>)> {
        let guards = self.access(access).guards.clone();
        let mut conjuncts = Vec::new();
        flatten(&guards, &mut self.found.terms, &mut conjuncts);
        let steps = steps(self.access(access));
        let [across, down] = self.tried(&steps);
        let mut places = Vec::new();
        for [x, y] in (0..down).flat_map(|y| (0..across).map(move |x| [x, y])) {
            let mut pixel = Pixel::new(&mut self.found.terms, self.found.group_size, [x, y]);
            if !matches!(self.comes(&conjuncts, &mut pixel), Comes::Yes) {
                continue;
            }
            let place = steps
                .iter()
                .map(|&step| match step {
                    Step::Dynamic(term) => {
                        self.at(term, &mut pixel).map(|term| self.numbered(term))
                    }
                    Step::Index(_) => Some(step),
                })
                .collect();
            places.push(([x, y], place));
        }
        places
    }

    /// A step, a number whatever its type if it is one.
    fn numbered(&self, term: TermId) -> Step {
        match integer(self.found.terms.as_literal(term)).map(u32::try_from) {
            Some(Ok(number)) => Step::Index(number),
            _ => Step::Dynamic(term),
        }
    }

    /// The pixels along each axis that are tried. What is made of ids of the workgroup and the invocation is tried within one workgroup
    /// alone: pixels of two may lie anywhere, and further apart than a row is long.
    fn tried(&self, steps: &[Step]) -> [u32; 2] {
        let terms = &self.found.terms;
        let computed: Vec<TermId> = steps
            .iter()
            .filter_map(|step| match *step {
                Step::Dynamic(term) => Some(term),
                Step::Index(_) => None,
            })
            .collect();
        let by_group = terms.is_any_below(&computed, |term| {
            matches!(term, Term::Id(Id::Local(_) | Id::LocalIndex | Id::Group(_)))
        });
        [0, 1].map(|axis| {
            let side = integer(terms.as_literal(self.found.group_size[axis]));
            match side.and_then(|side| u32::try_from(side).ok()) {
                Some(side) if by_group => side.min(TRIED),
                _ => TRIED,
            }
        })
    }

    /// Whether all pixels store the same value.
    fn stores_one_value(&mut self, store: usize) -> bool {
        let access = self.access(store);
        let AccessKind::Store { value } = access.kind else {
            return false;
        };
        let instance = &self.found.instances[access.instance.0 as usize];
        let Some(value) = instance.values[value.index()] else {
            return false;
        };
        self.on.of(&mut self.found.terms, value).is_empty()
    }

    /// Whether a pixel comes to where these conditions hold.
    fn comes(&mut self, conjuncts: &[Formula], pixel: &mut Pixel) -> Comes {
        let mut comes = Comes::Yes;
        for formula in conjuncts {
            match self.holds(formula, pixel) {
                Comes::Yes => {}
                Comes::No => return Comes::No,
                Comes::Unknown => comes = Comes::Unknown,
            }
        }
        comes
    }

    fn holds(&mut self, formula: &Formula, pixel: &mut Pixel) -> Comes {
        match formula {
            // whether two pixels both have such data is not for their ids to say
            Formula::Is(condition, _) if !self.is_positional(*condition) => Comes::Yes,
            Formula::Is(condition, holds) => {
                if let Some(now) = self.at(*condition, pixel)
                    && let Some(Literal::Bool(now)) = self.found.terms.as_literal(now)
                {
                    return match now == *holds {
                        true => Comes::Yes,
                        false => Comes::No,
                    };
                }
                // whether two pixels both pass a bound is not for their ids to say; whether both have a uniform's parity is
                let is_bound = matches!(
                    self.found.terms.get(*condition),
                    Term::Binary(
                        BinaryOperator::Less
                            | BinaryOperator::LessEqual
                            | BinaryOperator::Greater
                            | BinaryOperator::GreaterEqual,
                        ..
                    )
                );
                match is_bound {
                    true => Comes::Yes,
                    false => Comes::Unknown,
                }
            }
            Formula::All(parts) => self.comes(parts, pixel),
            Formula::Any(parts) => {
                let mut any = Comes::No;
                for part in parts {
                    match self.holds(part, pixel) {
                        Comes::Yes => return Comes::Yes,
                        Comes::No => {}
                        Comes::Unknown => any = Comes::Unknown,
                    }
                }
                any
            }
        }
    }

    /// A term at a pixel; `None` if it may differ between pixels in a way that the ids do not tell.
    fn at(&mut self, id: TermId, pixel: &mut Pixel) -> Option<TermId> {
        if let Some(&found) = pixel.found.get(&id) {
            return found;
        }
        let depends = self.on.of(&mut self.found.terms, id);
        let found = if !depends.intersects(Depends::X | Depends::Y | Depends::STATE) {
            // in one iteration, too: both pixels may come to it
            Some(id)
        } else if pixel.depth == DEEPEST {
            None
        } else {
            pixel.depth += 1;
            let put = self.put(id, pixel);
            let found = put.or_else(|| self.multiplied_out(id, pixel));
            pixel.depth -= 1;
            found
        };
        pixel.found.insert(id, found);
        found
    }

    /// An index of which only the whole moves with the pixel: `group * SIZE + local`, where an override says the size.
    fn multiplied_out(&mut self, id: TermId, pixel: &mut Pixel) -> Option<TermId> {
        let index = self.polynomial(id)?;
        if index.factors.keys().flatten().any(|&symbol| symbol == id) {
            return None;
        }
        let mut sum = self.found.terms.literal(Literal::U32(0));
        for (product, factor) in index.factors {
            let mut value = self.found.terms.literal(Literal::U32(factor as u32));
            for symbol in product {
                let symbol = self.at(symbol, pixel)?;
                let terms = &mut self.found.terms;
                value = terms.binary(BinaryOperator::Multiply, Operands::Integers, value, symbol);
            }
            let terms = &mut self.found.terms;
            sum = terms.binary(BinaryOperator::Add, Operands::Integers, sum, value);
        }
        Some(sum)
    }

    fn put(&mut self, id: TermId, pixel: &mut Pixel) -> Option<TermId> {
        match *self.found.terms.get(id) {
            Term::Id(of) => return pixel.ids.get(&of).copied(),
            Term::LoopVar { .. } | Term::LoopExit { .. } | Term::Opaque { .. } => return None,
            Term::Call(..) => {
                if let Some(&expansion) = self.found.terms.expansions.get(&id) {
                    return self.at(expansion, pixel);
                }
            }
            Term::Extract(base, index) => {
                if let Some(part) = self.part(base, index) {
                    return self.at(part, pixel);
                }
            }
            _ => {}
        }
        // the graph and what asks it are fields of one struct: operands first, then the term
        let mut operands = Vec::new();
        self.found
            .terms
            .operands(id, &mut |operand| operands.push(operand));
        for operand in operands {
            self.at(operand, pixel)?;
        }
        let found = &pixel.found;
        self.found
            .terms
            .rebuilt(id, &mut |_, operand| found.get(&operand).copied()?)
    }

    /// A component of a vector of floats, which is kept whole, as a term of its own.
    fn part(&mut self, vector: TermId, index: u32) -> Option<TermId> {
        let terms = &mut self.found.terms;
        match terms.get(vector).clone() {
            Term::As(kind, convert, value) => {
                let value = self.part(value, index)?;
                Some(self.found.terms.cast(kind, convert, value))
            }
            Term::Binary(op, left, right) => {
                let (left, right) = (self.part(left, index)?, self.part(right, index)?);
                Some(self.found.terms.intern(Term::Binary(op, left, right)))
            }
            Term::Math(fun @ naga::MathFunction::Floor, ref arguments) => {
                let argument = self.part(arguments[0], index)?;
                let arguments = [argument].into();
                Some(self.found.terms.intern(Term::Math(fun, arguments)))
            }
            Term::Literal(_) => Some(vector),
            Term::Compose { .. } | Term::Splat(..) | Term::Swizzle(..) => {
                Some(terms.extract(vector, index))
            }
            _ => None,
        }
    }
}

impl Pixel {
    fn new(terms: &mut Terms, group_size: [TermId; 3], pixel: [u32; 2]) -> Pixel {
        let mut ids = FxHashMap::default();
        let mut local = [None; 2];
        for (axis, &number) in (0..).zip(&pixel) {
            let mut put = |terms: &mut Terms, id, number| {
                let number = terms.literal(Literal::U32(number));
                ids.insert(id, number);
            };
            put(terms, Id::Global(axis), number);
            let size = integer(terms.as_literal(group_size[usize::from(axis)]));
            let Some(size) = size.and_then(|size| u32::try_from(size).ok()) else {
                continue;
            };
            if size > 0 {
                put(terms, Id::Local(axis), number % size);
                put(terms, Id::Group(axis), number / size);
                local[usize::from(axis)] = Some((number % size, size));
            }
        }
        // of the first layer
        if let [Some((x, width)), Some((y, _))] = local {
            let index = terms.literal(Literal::U32(y * width + x));
            ids.insert(Id::LocalIndex, index);
        }
        Pixel {
            ids,
            found: FxHashMap::default(),
            depth: 0,
        }
    }
}

/// The steps of an access, those of the element of a binding array before the others.
fn steps(access: &Access) -> Vec<Step> {
    use crate::analysis::Address;
    let mut steps = access.target.element.clone();
    match &access.address {
        Address::Part(path) => steps.extend(path),
        address @ Address::Texel { .. } => {
            steps.extend(address.terms().into_iter().map(Step::Dynamic));
        }
    }
    steps
}
