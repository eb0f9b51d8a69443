//! What a rewritten shader should have written, from what the original was seen to do.
//!
//! The original's [log](vrcs_passes::instrument) tells, for each invocation, the sites that it stored at and the places, in
//! order, and in which iterations of loops. From the logs of several runs with other data comes an [`AddressBook`]: for each store of an
//! invocation at a site, the place that it goes to. Where an invocation was never seen to make a store that its primary makes, its
//! place is taken from the book's pattern, if all that were seen lie in one: place = a + b·x + c·y + d·z, exactly; or the same
//! with a factor for each bit of x, y and z, which is how tiled and Morton orders, and swizzles by exclusive or, look.
//!
//! Nothing here comes from the rewriter: not its slices, not its tangents, not its idea of the domain.

use std::collections::{HashMap, HashSet};

use naga::{GlobalVariable, Handle};
use vrcs_passes::instrument::{LogSize, OUTSIDE, STORE_WORDS, Site};

/// A store in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The site's number.
    pub site: u32,
    /// The iterations of loops and the calls on the way to it, as a number.
    pub path: u32,
    /// How many stores at that site, on that path, the invocation had made before.
    pub occurrence: u32,
    /// The place, or [`OUTSIDE`].
    pub place: u32,
    /// The place in a buffer with each index confined to its array.
    pub confined: u32,
    /// The value of an atomic.
    pub value: u32,
}

impl Stored {
    /// What tells it from an invocation's other stores.
    fn key(self) -> (u32, u32, u32) {
        (self.site, self.path, self.occurrence)
    }
}

/// What one run of the original stored.
#[derive(Clone, Debug)]
pub struct Log {
    size: LogSize,
    stores: Vec<Vec<Stored>>,
    /// The most stores of one invocation, logged or not.
    pub most: u32,
}

impl Log {
    /// Reads the words of a log.
    pub fn new(words: &[u32], size: LogSize) -> Log {
        let stride = size.words_each() as usize;
        let mut most = 0;
        let stores = words
            .chunks_exact(stride)
            .map(|words| {
                most = most.max(words[0]);
                let logged = words[0].min(size.slots) as usize;
                let mut stores: Vec<Stored> = Vec::with_capacity(logged);
                const EACH: usize = STORE_WORDS as usize;
                for words in words[1..1 + EACH * logged].chunks_exact(EACH) {
                    let &[site, place, path, confined, value] = words else {
                        unreachable!("as many words as a store has");
                    };
                    let same = |stored: &&Stored| (stored.site, stored.path) == (site, path);
                    stores.push(Stored {
                        site,
                        path,
                        occurrence: stores.iter().filter(same).count() as u32,
                        place,
                        confined,
                        value,
                    });
                }
                stores
            })
            .collect();
        Log { size, stores, most }
    }

    /// The stores of an invocation, in order.
    pub fn of(&self, invocation: usize) -> &[Stored] {
        &self.stores[invocation]
    }

    /// Puts other stores in the place of an invocation's.
    pub fn replace(&mut self, invocation: usize, stores: Vec<Stored>) {
        self.stores[invocation] = stores;
    }

    /// The number of invocations.
    pub fn invocations(&self) -> usize {
        self.stores.len()
    }

    /// The grid.
    pub fn grid(&self) -> [u32; 3] {
        self.size.grid
    }

    /// Whether any invocation stores at a site.
    pub fn reaches(&self, site: u32) -> bool {
        let mut stores = self.stores.iter().flatten();
        stores.any(|stored| stored.site == site)
    }

    /// Stores outside their resources.
    pub fn outside(&self) -> usize {
        self.stores
            .iter()
            .flatten()
            .filter(|stored| stored.place == OUTSIDE)
            .count()
    }

    /// The units of a resource that stores and atomics outside of it may hit: WGSL lets a driver drop such a store, or confine its
    /// index to the array, which is some other invocation's place. What is there is chance.
    pub fn chance(&self, sites: &[Site], global: Handle<GlobalVariable>) -> HashSet<u32> {
        let outside = |stored: &&Stored| {
            let site = &sites[stored.site as usize];
            // a texel is dropped
            stored.place == OUTSIDE && site.global == global && site.size > 1
        };
        self.stores
            .iter()
            .flatten()
            .filter(outside)
            .flat_map(|stored| units(&sites[stored.site as usize], stored.confined))
            .collect()
    }

    /// A site that exchanges something outside its resource. A driver may drop that, or confine it to a place where others exchange,
    /// too: who gets what is chance, and goes on from there into every output.
    pub fn exchanged_outside<'s>(&self, sites: &'s [Site]) -> Option<&'s Site> {
        let outside = self.stores.iter().flatten().filter(|s| s.place == OUTSIDE);
        outside
            .map(|stored| &sites[stored.site as usize])
            .find(|site| is_exchange(site))
    }

    /// The first place that two invocations store to, if there is one.
    pub fn race(&self, sites: &[Site]) -> Option<Race> {
        let mut owners: HashMap<(usize, u32), usize> = HashMap::new();
        for (invocation, stores) in self.stores.iter().enumerate() {
            for stored in stores.iter().filter(|stored| stored.place != OUTSIDE) {
                let site = &sites[stored.site as usize];
                if site.atomic.is_some() && !is_exchange(site) {
                    continue;
                }
                for unit in units(site, stored.place) {
                    let owner = *owners
                        .entry((site.global.index(), unit))
                        .or_insert(invocation);
                    if owner != invocation {
                        return Some(Race {
                            site: stored.site,
                            invocations: [owner, invocation],
                        });
                    }
                }
            }
        }
        None
    }
}

/// Two invocations that store to one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Race {
    /// The second one's site.
    pub site: u32,
    /// The invocations.
    pub invocations: [usize; 2],
}

/// The units of a place: one for a texel, one for each two bytes of a buffer.
pub fn units(site: &Site, place: u32) -> std::ops::Range<u32> {
    match site.size {
        1 => place..place + 1,
        size => place / 2..(place + size) / 2,
    }
}

/// Where each invocation's n-th store at each site, on each path of iterations and calls, goes.
#[derive(Clone, Debug, Default)]
pub struct AddressBook {
    pages: HashMap<(u32, u32, u32), Page>,
    grid: [u32; 3],
}

#[derive(Clone, Debug)]
struct Page {
    /// For each invocation, the place if it was seen.
    seen: Vec<Option<u32>>,
    pattern: Option<PlacePattern>,
    /// Whether an invocation stored at different places in different runs: its address depends on data.
    moves: bool,
}

impl AddressBook {
    /// Compiles the book from the logs of several runs. `textures` gives the size of the texture that a site stores to;
    /// `None` for a buffer.
    pub fn new(logs: &[Log], textures: &[Option<[u32; 3]>]) -> AddressBook {
        let mut book = AddressBook {
            pages: HashMap::new(),
            grid: logs.first().map_or([0; 3], Log::grid),
        };
        let invocations = logs.first().map_or(0, Log::invocations);
        for log in logs {
            for (invocation, stores) in log.stores.iter().enumerate() {
                for stored in stores {
                    let page = book.pages.entry(stored.key()).or_insert_with(|| Page {
                        seen: vec![None; invocations],
                        pattern: None,
                        moves: false,
                    });
                    let slot = &mut page.seen[invocation];
                    page.moves |= slot.is_some_and(|place| place != stored.place);
                    *slot = Some(stored.place);
                }
            }
        }
        let grid = book.grid;
        for (&(site, ..), page) in &mut book.pages {
            page.pattern = PlacePattern::fit(&page.seen, grid, textures[site as usize]);
        }
        book
    }

    /// Whether an invocation was ever seen to make a store.
    pub fn is_seen(&self, store: Stored, invocation: usize) -> bool {
        let page = self.pages.get(&store.key());
        page.is_some_and(|page| page.seen[invocation].is_some())
    }

    /// Whether the place of a store depends on data.
    pub fn moves(&self, store: Stored) -> bool {
        let page = self.pages.get(&store.key());
        page.is_some_and(|page| page.moves)
    }

    /// The place of an invocation's store; `None` if it is not known.
    ///
    /// `own` are the invocation's own stores in the run at hand, which say it best.
    pub fn place(&self, own: &[Stored], store: Stored, invocation: usize) -> Option<u32> {
        let same = |s: &&Stored| s.key() == store.key();
        if let Some(seen) = own.iter().find(same) {
            return Some(seen.place);
        }
        let page = self.pages.get(&store.key())?;
        if page.moves {
            return None;
        }
        let pattern = page.pattern.as_ref();
        page.seen[invocation].or_else(|| pattern?.at(position(invocation, self.grid)))
    }
}

/// The position of an invocation in a grid.
pub fn position(invocation: usize, grid: [u32; 3]) -> [u32; 3] {
    let invocation = invocation as u32;
    [
        invocation % grid[0],
        invocation / grid[0] % grid[1],
        invocation / grid[0] / grid[1],
    ]
}

/// The pattern of a place: of each coordinate of a texel, or of a byte offset.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PlacePattern {
    Texel(Box<[Pattern; 3]>, [u32; 3]),
    Offset(Box<Pattern>),
}

impl PlacePattern {
    fn fit(
        seen: &[Option<u32>],
        grid: [u32; 3],
        texture: Option<[u32; 3]>,
    ) -> Option<PlacePattern> {
        let inside = |place: &u32| *place != OUTSIDE;
        match texture {
            None => {
                let seen: Vec<_> = seen.iter().map(|place| place.filter(inside)).collect();
                Some(PlacePattern::Offset(Box::new(Pattern::fit(&seen, grid)?)))
            }
            Some(size) => {
                let axis = |axis: usize| {
                    let seen: Vec<_> = seen
                        .iter()
                        .map(|place| {
                            place
                                .filter(inside)
                                .map(|p| position(p as usize, size)[axis])
                        })
                        .collect();
                    Pattern::fit(&seen, grid)
                };
                Some(PlacePattern::Texel(
                    Box::new([axis(0)?, axis(1)?, axis(2)?]),
                    size,
                ))
            }
        }
    }

    fn at(&self, at: [u32; 3]) -> Option<u32> {
        match self {
            // what lies before the buffer comes out as a number beyond all buffers
            PlacePattern::Offset(pattern) => match pattern.at(at)? {
                before if before > u32::MAX / 2 => Some(OUTSIDE),
                offset => Some(offset),
            },
            PlacePattern::Texel(patterns, size) => {
                let [x, y, z] = [
                    patterns[0].at(at)?,
                    patterns[1].at(at)?,
                    patterns[2].at(at)?,
                ];
                let inside = x < size[0] && y < size[1] && z < size[2];
                Some(match inside {
                    true => (z * size[1] + y) * size[0] + x,
                    false => OUTSIDE,
                })
            }
        }
    }
}

/// Bits of a coordinate that a pattern tells apart.
const BITS: usize = 12;

/// The slope of each bit of x, y and z, where it is known.
type Slopes = [[Option<u32>; BITS]; 3];

/// value = that of an invocation that was seen, and the slopes of all bits of x, y and z that differ from it, wrapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pattern {
    anchor: [u32; 3],
    value: u32,
    slopes: Slopes,
}

impl Pattern {
    /// The value at a position; `None` if that takes a slope that nothing seen tells.
    fn at(&self, position: [u32; 3]) -> Option<u32> {
        let mut value = self.value;
        for (axis, there) in position.into_iter().enumerate() {
            let here = self.anchor[axis];
            for bit in (0..BITS).filter(|bit| (here ^ there) >> bit & 1 == 1) {
                let slope = self.slopes[axis][bit]?;
                value = match there >> bit & 1 {
                    1 => value.wrapping_add(slope),
                    _ => value.wrapping_sub(slope),
                };
            }
        }
        Some(value)
    }

    /// The pattern that all known values lie in; `None` if they do not.
    fn fit(seen: &[Option<u32>], grid: [u32; 3]) -> Option<Pattern> {
        let known = |position: [u32; 3]| {
            let index = (position[2] * grid[1] + position[1]) * grid[0] + position[0];
            seen.get(index as usize).copied().flatten()
        };
        let with = |slopes| Pattern::with(slopes, seen, grid);
        with(Pattern::linear(seen, grid, &known))
            .or_else(|| with(Pattern::by_bits(seen, grid, &known)))
    }

    /// The pattern with certain slopes, if all known values lie in it.
    fn with(slopes: Slopes, seen: &[Option<u32>], grid: [u32; 3]) -> Option<Pattern> {
        let first = seen.iter().position(Option::is_some)?;
        let pattern = Pattern {
            anchor: position(first, grid),
            value: seen[first]?,
            slopes,
        };
        let fits = seen.iter().enumerate().all(|(index, value)| {
            value.is_none_or(|value| pattern.at(position(index, grid)) == Some(value))
        });
        fits.then_some(pattern)
    }

    /// The slopes of a linear pattern, from one pair of neighbours along each axis.
    fn linear(
        seen: &[Option<u32>],
        grid: [u32; 3],
        known: &dyn Fn([u32; 3]) -> Option<u32>,
    ) -> Slopes {
        [0, 1, 2].map(|axis| {
            let slope = (0..seen.len()).find_map(|index| {
                let here = position(index, grid);
                let mut next = here;
                next[axis] += 1;
                (next[axis] < grid[axis])
                    .then(|| Some(known(next)?.wrapping_sub(known(here)?)))
                    .flatten()
            });
            std::array::from_fn(|bit| Some(slope? << bit))
        })
    }

    /// The slopes of each bit, from one pair of places that differ in nothing else.
    fn by_bits(
        seen: &[Option<u32>],
        grid: [u32; 3],
        known: &dyn Fn([u32; 3]) -> Option<u32>,
    ) -> Slopes {
        [0, 1, 2].map(|axis| {
            std::array::from_fn(|bit| {
                (0..seen.len()).find_map(|index| {
                    let here = position(index, grid);
                    let mut next = here;
                    next[axis] |= 1 << bit;
                    (next != here && next[axis] < grid[axis])
                        .then(|| Some(known(next)?.wrapping_sub(known(here)?)))
                        .flatten()
                })
            })
        })
    }
}

/// Whether a site takes what is there and leaves another value.
fn is_exchange(site: &Site) -> bool {
    matches!(
        site.atomic.map(|atomic| atomic.function),
        Some(naga::AtomicFunction::Exchange { .. })
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_found_from_what_was_seen_and_holds_for_the_rest() {
        let grid = [4, 3, 1];
        let seen: Vec<Option<u32>> = (0..12)
            .map(|i| {
                let [x, y, _] = position(i, grid);
                (x != 3).then_some(7 + 2 * x + 100 * y)
            })
            .collect();
        let pattern = Pattern::fit(&seen, grid).expect("a pattern");
        assert_eq!(pattern.at([3, 2, 0]), Some(7 + 6 + 200));
    }

    #[test]
    fn a_pattern_says_nothing_of_an_axis_that_was_not_seen() {
        let grid = [8, 3, 1];
        let mut seen = vec![None; 24];
        seen[8] = Some(20);
        seen[9] = Some(23);
        let pattern = Pattern::fit(&seen, grid).expect("a pattern");
        assert_eq!(pattern.at([6, 1, 0]), Some(38));
        assert_eq!(pattern.at([0, 0, 0]), None);
    }

    #[test]
    fn tiled_and_swizzled_places_lie_in_a_pattern_of_bits() {
        let grid = [12, 6, 1];
        let place = |x: u32, y: u32| (y / 4 * 3 + x / 4) * 16 + (y % 4) * 4 + ((x % 4) ^ 1);
        let seen: Vec<Option<u32>> = (0..72)
            .map(|i| {
                let [x, y, _] = position(i, grid);
                (i % 5 != 2).then_some(place(x, y))
            })
            .collect();
        let pattern = Pattern::fit(&seen, grid).expect("a pattern");
        assert_eq!(pattern.at([2, 0, 0]), Some(place(2, 0)));
        assert_eq!(pattern.at([9, 5, 0]), Some(place(9, 5)));
    }

    #[test]
    fn places_that_lie_in_no_pattern_give_none() {
        let grid = [4, 2, 1];
        let seen: Vec<Option<u32>> = [0, 1, 2, 9, 4, 5, 6, 7].map(Some).to_vec();
        assert_eq!(Pattern::fit(&seen, grid), None);
    }

    #[test]
    fn two_invocations_at_one_place_are_a_race() {
        let size = LogSize {
            grid: [2, 1, 1],
            slots: 1,
        };
        let module = naga::front::wgsl::parse_str(
            "@group(0) @binding(0) var<storage, read_write> b: array<u32>;",
        )
        .expect("WGSL");
        let (global, _) = module.global_variables.iter().next().expect("a variable");
        let sites = [Site {
            global,
            size: 4,
            padding: vec![false; 2],
            atomic: None,
            span: naga::Span::UNDEFINED,
        }];
        let apart = Log::new(&[1, 0, 0, 0, 0, 0, 1, 0, 4, 0, 0, 0], size);
        assert_eq!(apart.race(&sites), None);
        let together = Log::new(&[1, 0, 4, 0, 0, 0, 1, 0, 4, 0, 0, 0], size);
        assert_eq!(
            together.race(&sites).map(|race| race.invocations),
            Some([0, 1])
        );
    }
}
