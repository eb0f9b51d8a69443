//! Holds what a rewritten shader wrote against what it should have written.

use std::collections::{HashMap, HashSet};

use vrcs_passes::{
    instrument::{OUTSIDE, Site},
    options::Policy,
};

use super::{
    atomics::{Done, Tallies, word},
    reference::{AddressBook, Log, Stored, position, units},
    run::Outputs,
};
use crate::build::cpu::Coordinates;

/// A group of pixels, as the effective map has it before the shader's domain is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The nominal primary.
    pub primary: [u32; 2],
    /// All members, in the order in which a new primary is sought.
    pub members: Vec<[u32; 2]>,
}

impl Group {
    /// A pixel for itself.
    pub fn lone(pixel: [u32; 2]) -> Group {
        Group {
            primary: pixel,
            members: vec![pixel],
        }
    }

    /// Each member for itself.
    pub fn apart(&self) -> impl Iterator<Item = Group> {
        self.members.iter().copied().map(Group::lone)
    }
}

/// The groups of a coordinate buffer, those of a single pixel included, confined to an extent: a group whose primary lies
/// outside is re-homed to its first member inside. Sky is left out if the shader skips it.
pub fn groups(coordinates: &Coordinates, extent: [u32; 2], skips_sky: bool) -> Vec<Group> {
    let width = coordinates.extent[0];
    let map = coordinates.map();
    let sky = coordinates.sky();
    let mut of_primary: HashMap<u32, Vec<[u32; 2]>> = HashMap::new();
    for y in 0..extent[1] {
        for x in 0..extent[0] {
            let at = (y * width + x) as usize;
            if skips_sky && sky[at] {
                continue;
            }
            of_primary.entry(map[at]).or_default().push([x, y]);
        }
    }
    let mut groups: Vec<Group> = of_primary
        .into_iter()
        .map(|(primary, members)| {
            let nominal = [primary % width, primary / width];
            let inside = nominal[0] < extent[0] && nominal[1] < extent[1];
            Group {
                primary: if inside { nominal } else { members[0] },
                members,
            }
        })
        .collect();
    groups.sort_by_key(|group| (group.primary[1], group.primary[0]));
    groups
}

/// What the original was seen to do.
#[derive(Clone, Debug)]
pub struct Original {
    /// The size of the picture.
    pub size: [u32; 2],
    /// What it stored, in the run whose outputs these are.
    pub log: Log,
    /// The stores in its text.
    pub sites: Vec<Site>,
    /// For each site, the number of the output that it stores to.
    pub output_of_site: Vec<usize>,
    /// Where each store goes.
    pub book: AddressBook,
    /// For each invocation, whether it ever stored, in any run, to a target that is not [`Policy::Full`].
    pub stores_ever: Vec<bool>,
    /// For each output, the invocation that was seen to store to each unit, in any run.
    pub owners: Vec<HashMap<u32, usize>>,
    /// Whether which invocations store depends on data.
    pub depends_on_data: bool,
    /// What it wrote.
    pub outputs: Outputs,
    /// What was there before.
    pub initial: Outputs,
    /// For each output, the units whose value is chance: a store outside of the resource may have gone there.
    pub chance: Vec<HashSet<u32>>,
    /// Bytes of a texel of each output; `None` for a buffer.
    pub texel_bytes: Vec<Option<usize>>,
    /// What is to become of the stores to each output.
    pub policies: Vec<Policy>,
}

/// What an invocation is to write at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Write {
    /// Where the value comes from, in the original's output, in bytes; `None` if it cannot be seen there, because the primary
    /// has written over it, stored it outside the resource, or stored it where what is found is chance.
    from: Option<usize>,
    /// Whether the value itself may be chance: the primary's own place may have been written by others.
    is_chance: bool,
    /// The pixel that is written, and the pixel that is shaded for it.
    pixel: [u32; 3],
    primary: [u32; 3],
    /// How often the place is written.
    times: u32,
    /// How many of these times go back to stores that the pixel was never seen to make itself, at a place that it
    /// stores to by others. Where some do and some do not, those that do may be left out: the pixel's own bounds check may keep
    /// it from them.
    unlike: u32,
    /// Whether it may also be left out: data kept the pixel from ever storing, so it is not known to be in the domain.
    optional: bool,
}

/// All writes that are due at a place: one, but for places that a pixel outside the domain would have in common with another.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Due {
    first: Write,
    others: Vec<Write>,
}

impl Due {
    fn writes(&self) -> impl Iterator<Item = &Write> {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// How often each write surely happens, and how often it may happen besides.
    fn counts(&self) -> impl Iterator<Item = (u32, u32)> {
        self.writes().map(|write| match write.optional {
            true => (0, write.times),
            false if write.unlike < write.times => (write.times - write.unlike, write.unlike),
            false => (write.times, 0),
        })
    }

    /// The write of a pixel, which is added if it is not there yet.
    fn of(&mut self, write: Write) -> &mut Write {
        if self.first.pixel == write.pixel {
            return &mut self.first;
        }
        let known = self.others.iter().position(|w| w.pixel == write.pixel);
        let at = known.unwrap_or_else(|| {
            self.others.push(write);
            self.others.len() - 1
        });
        &mut self.others[at]
    }

    /// Whether nothing at all may be written.
    fn is_optional(&self) -> bool {
        self.writes().all(|write| write.optional)
    }

    /// How far `got` writes are from what is due: 0 if they are some of the optional writes and all the others.
    fn excess(&self, got: u32) -> Option<u32> {
        let sure = self.counts().map(|(sure, _)| sure).sum();
        let mut nearest = got.checked_sub(sure)?;
        let mut sums = vec![sure];
        // an optional write is left out as a whole, but where bounds checks of single stores have a part in it
        let is_whole = |write: &Write| write.optional && write.unlike == 0;
        for write in self.writes().filter(|write| is_whole(write)) {
            for known in 0..sums.len() {
                sums.push(sums[known] + write.times);
            }
        }
        let in_part = self.counts().zip(self.writes());
        let besides: u32 = in_part
            .filter(|(_, write)| !is_whole(write))
            .map(|((_, besides), _)| besides)
            .sum();
        for sum in sums {
            for sum in sum..=sum + besides {
                nearest = got
                    .checked_sub(sum)
                    .map_or(nearest, |left| nearest.min(left));
            }
        }
        Some(nearest)
    }

    /// How often the place is written if nothing is left out.
    fn times(&self) -> u32 {
        self.writes().map(|write| write.times).sum()
    }
}

/// All that is due in one output: for each unit of places, what is written there.
#[derive(Clone, Debug, Default)]
pub struct Expected {
    due: HashMap<u32, Due>,
    /// What atomics make of it.
    tallies: Tallies,
    /// Values that may appear at places that are not known.
    anywhere: Vec<usize>,
    /// Units that are written at places that are not known, with values that cannot be seen in the original's output.
    unseen: u32,
    /// Units that are written at places that are not known, those that are written over included.
    unknown: u32,
}

/// A difference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The number of the output.
    pub output: usize,
    /// The byte at which it starts.
    pub byte: usize,
    /// What was to be there.
    pub expected: Vec<u8>,
    /// What is there.
    pub got: Vec<u8>,
    /// The pixel whose place it is; `None` where nothing was to be written.
    pub pixel: Option<[u32; 3]>,
    /// The pixel that is shaded for it.
    pub primary: Option<[u32; 3]>,
}

impl Original {
    /// What is due in each output, for a map and an extent.
    pub fn expected(&self, groups: &[Group], extent: [u32; 2]) -> Vec<Expected> {
        let mut expected = vec![Expected::default(); self.outputs.len()];
        let grid = self.log.grid();
        for z in 0..grid[2] {
            for group in groups {
                self.expect_group(group, z, &mut expected);
            }
        }
        if self.policies.contains(&Policy::Full) {
            self.expect_full(extent, &mut expected);
        }
        expected
    }

    /// What every pixel stores for itself, whatever the map.
    fn expect_full(&self, extent: [u32; 2], expected: &mut [Expected]) {
        let is_full = |output: usize| self.policies[output] == Policy::Full;
        let [width, height, depth] = self.log.grid();
        for z in 0..depth {
            for y in 0..extent[1].min(height) {
                for x in 0..extent[0].min(width) {
                    let pixel = self.invocation([x, y], z);
                    self.expect_pixel(pixel, pixel, false, &is_full, expected);
                    self.expect_atomics(pixel, pixel, false, &is_full, expected);
                }
            }
        }
    }

    fn invocation(&self, [x, y]: [u32; 2], z: u32) -> usize {
        let grid = self.log.grid();
        ((z * grid[1] + y) * grid[0] + x) as usize
    }

    fn expect_group(&self, group: &Group, z: u32, expected: &mut [Expected]) {
        let ever = |pixel: [u32; 2]| self.stores_ever[self.invocation(pixel, z)];
        // a group is re-homed to its first member that stores, if its primary never does
        let home = match ever(group.primary) {
            true => Some(group.primary),
            false => group.members.iter().copied().find(|&member| ever(member)),
        };
        let Some(home) = home else { return };
        let rehomed = home != group.primary;
        let primary = self.invocation(home, z);
        for &member in &group.members {
            let stores = ever(member);
            // a pixel that never stores lies outside the domain, or data keeps it from storing
            if !stores && !self.depends_on_data {
                continue;
            }
            let optional = self.depends_on_data && (!stores || rehomed);
            let pixel = self.invocation(member, z);
            let is_copied = |output: usize| self.policies[output] != Policy::Full;
            self.expect_pixel(primary, pixel, optional, &is_copied, expected);
            self.expect_atomics(primary, pixel, optional, &is_copied, expected);
        }
    }

    /// What the primary's atomics do for a pixel, in some outputs.
    fn expect_atomics(
        &self,
        primary: usize,
        pixel: usize,
        optional: bool,
        is_meant: &dyn Fn(usize) -> bool,
        expected: &mut [Expected],
    ) {
        for &stored in self.log.of(primary) {
            let site = &self.sites[stored.site as usize];
            let output = self.output_of_site[stored.site as usize];
            let Some(atomic) = site.atomic else { continue };
            if !is_meant(output) {
                continue;
            }
            if pixel != primary && self.policies[output] == Policy::Leader {
                continue;
            }
            // a place that data chooses is the primary's
            let place = match pixel == primary || self.book.moves(stored) {
                true => Some(stored.place),
                false => self.book.place(self.log.of(pixel), stored, pixel),
            };
            let at = |place: u32| {
                let byte = place as usize * self.texel_bytes[output].unwrap_or(1);
                let initial = self.initial[output].get(byte..byte + 4).map(word);
                Some((byte, initial?))
            };
            let done = Done {
                atomic,
                value: stored.value,
                optional,
            };
            let of_primary = at(stored.place);
            let tallies = &mut expected[output].tallies;
            match place {
                None => tallies.add(done, None, of_primary),
                Some(place) => match at(place) {
                    Some(own) => tallies.add(done, Some(own), of_primary),
                    None => tallies.add_outside(done, of_primary),
                },
            }
        }
    }

    /// Whether two invocations do an atomic at one place of an output.
    fn shares_atomics(&self, output: usize) -> bool {
        let mut owners = HashMap::new();
        (0..self.log.invocations()).any(|invocation| {
            self.log.of(invocation).iter().any(|stored| {
                let site = stored.site as usize;
                self.sites[site].atomic.is_some()
                    && self.output_of_site[site] == output
                    && stored.place != OUTSIDE
                    && *owners.entry(stored.place).or_insert(invocation) != invocation
            })
        })
    }

    /// What the primary's stores are for a pixel, in some outputs.
    fn expect_pixel(
        &self,
        primary: usize,
        pixel: usize,
        optional: bool,
        is_meant: &dyn Fn(usize) -> bool,
        expected: &mut [Expected],
    ) {
        let stores = self.log.of(primary);
        let own = self.log.of(pixel);
        for (index, &stored) in stores.iter().enumerate() {
            let site = &self.sites[stored.site as usize];
            let output = self.output_of_site[stored.site as usize];
            let is_leaders = self.policies[output] == Policy::Leader;
            if !is_meant(output) || site.atomic.is_some() || is_leaders && pixel != primary {
                continue;
            }
            // what the primary itself overwrites later cannot be seen, and is overwritten for the pixel, too
            // and what it stores outside the resource cannot be seen either
            let is_outside = stored.place == OUTSIDE;
            let is_last = !is_outside
                && !stores[index + 1..]
                    .iter()
                    .any(|later| self.overlap(*later, stored));
            let place = match pixel == primary {
                true => Some(stored.place),
                false => self.book.place(own, stored, pixel),
            };
            match place {
                Some(OUTSIDE) => {}
                Some(place) => {
                    // a place that the pixel was never seen to write may lie behind its own bounds check
                    let is_unlike = pixel != primary && !self.book.is_seen(stored, pixel);
                    let is_own = own
                        .iter()
                        .any(|own| self.overlap(*own, Stored { place, ..stored }));
                    // beyond the picture it is the rewriter's choice whether a copy asks a bounds check of its store alone
                    let [x, y, _] = position(pixel, self.log.grid());
                    let is_beyond = x >= self.size[0] || y >= self.size[1];
                    let optional = optional || is_unlike && (!is_own || is_beyond);
                    // what is another's place, the pixel's own bounds keep it from
                    if is_unlike && self.is_anothers(output, site, place, pixel) {
                        continue;
                    }
                    let source = if is_outside { place } else { stored.place };
                    let pairs = units(site, place).zip(units(site, source));
                    for ((unit, from), is_padding) in pairs.zip(&site.padding) {
                        let is_chance = self.chance[output].contains(&from);
                        let from = from as usize * self.unit(output);
                        let grid = self.log.grid();
                        let write = Write {
                            from: None,
                            is_chance: false,
                            pixel: position(pixel, grid),
                            primary: position(primary, grid),
                            times: 0,
                            unlike: 0,
                            optional,
                        };
                        let due = expected[output].due.entry(unit).or_insert_with(|| Due {
                            first: write,
                            others: Vec::new(),
                        });
                        let write = due.of(write);
                        // what is there then is one of two values, the first of which the primary has written over
                        let has_sure = write.unlike < write.times;
                        let may_be_left_out =
                            is_unlike && (has_sure || is_beyond && write.times > 0);
                        write.times += 1;
                        write.unlike += u32::from(is_unlike);
                        write.is_chance |= is_chance;
                        // what lies between the members of a struct is nobody's
                        let is_seen = is_last && !is_padding && !is_chance && !may_be_left_out;
                        write.from = is_seen.then_some(from);
                    }
                }
                None => {
                    let from = match is_outside {
                        true => units(site, 0),
                        false => units(site, stored.place),
                    };
                    expected[output].unknown += from.len() as u32;
                    for from in from {
                        if is_outside || self.chance[output].contains(&from) {
                            expected[output].unseen += 1;
                        } else if is_last {
                            expected[output]
                                .anywhere
                                .push(from as usize * self.unit(output));
                        }
                    }
                }
            }
        }
    }

    /// Whether another invocation was seen to store to a place.
    fn is_anothers(&self, output: usize, site: &Site, place: u32, pixel: usize) -> bool {
        let owners = &self.owners[output];
        units(site, place).any(|unit| owners.get(&unit).is_some_and(|&owner| owner != pixel))
    }

    fn overlap(&self, a: Stored, b: Stored) -> bool {
        let (site_a, site_b) = (&self.sites[a.site as usize], &self.sites[b.site as usize]);
        if a.place == OUTSIDE || b.place == OUTSIDE || site_a.global != site_b.global {
            return false;
        }
        let (a_units, b_units) = (units(site_a, a.place), units(site_b, b.place));
        a_units.start < b_units.end && b_units.start < a_units.end
    }

    /// Bytes of a unit of an output.
    pub fn unit(&self, output: usize) -> usize {
        self.texel_bytes[output].unwrap_or(2)
    }

    /// The first difference between what is due and what was written.
    pub fn compare(&self, expected: &[Expected], got: &Outputs) -> Option<Difference> {
        for (output, expected) in expected.iter().enumerate() {
            let unit = self.unit(output);
            let mut anywhere: Vec<&[u8]> = expected
                .anywhere
                .iter()
                .filter_map(|&from| self.outputs[output].get(from..from + unit))
                .collect();
            let mut unseen = expected.unseen;
            let (before, after) = (&self.initial[output], &got[output]);
            let counted = match expected.tallies.is_empty() {
                true => HashSet::new(),
                false => match expected.tallies.compare(
                    before,
                    after,
                    &|byte| self.chance[output].contains(&((byte / unit) as u32)),
                    || self.shares_atomics(output),
                ) {
                    Ok(counted) => counted,
                    Err(wrong) => {
                        return Some(Difference {
                            output,
                            byte: wrong.byte,
                            expected: wrong.expected.to_le_bytes().to_vec(),
                            got: wrong.got.to_le_bytes().to_vec(),
                            pixel: None,
                            primary: None,
                        });
                    }
                },
            };
            for (number, (initial, got)) in before.chunks(unit).zip(after.chunks(unit)).enumerate()
            {
                if self.chance[output].contains(&(number as u32)) {
                    continue;
                }
                let due = expected.due.get(&(number as u32));
                if counted.contains(&((number * unit) & !3)) {
                    continue;
                }
                let from = |write: &Write| {
                    let from = write.from?;
                    self.outputs[output].get(from..from + unit)
                };
                let wanted = match due {
                    // what the primary has written over has no reference
                    Some(due) if due.writes().any(|write| write.from.is_none()) => continue,
                    Some(due) if due.writes().any(|write| from(write) == Some(got)) => continue,
                    Some(due) if due.is_optional() && got == initial => continue,
                    Some(due) => from(&due.first).unwrap_or(initial),
                    None if got == initial => continue,
                    None => initial,
                };
                // a store whose place is not known may also go where another is due
                if let Some(found) = anywhere.iter().position(|value| *value == got) {
                    anywhere.swap_remove(found);
                    continue;
                }
                if unseen > 0 {
                    unseen -= 1;
                    continue;
                }
                return Some(Difference {
                    output,
                    byte: number * unit,
                    expected: wanted.to_vec(),
                    got: got.to_vec(),
                    pixel: due.map(|due| due.first.pixel),
                    primary: due.map(|due| due.first.primary),
                });
            }
        }
        None
    }

    /// The first place that was not written as often as is due. `counts` holds the counts of each output, one for each
    /// unit.
    pub fn compare_counts(&self, expected: &[Expected], counts: &[&[u32]]) -> Option<Difference> {
        for (output, expected) in expected.iter().enumerate() {
            let unit = self.unit(output);
            let mut spare = expected.unknown;
            for (number, &got) in counts[output].iter().enumerate() {
                let due = expected.due.get(&(number as u32));
                let excess = match due {
                    Some(due) => due.excess(got),
                    None => Some(got),
                };
                if let Some(excess) = excess.filter(|&excess| excess <= spare) {
                    spare -= excess;
                    continue;
                }
                let times = due.map_or(0, Due::times);
                return Some(Difference {
                    output,
                    byte: number * unit,
                    expected: times.to_le_bytes().to_vec(),
                    got: got.to_le_bytes().to_vec(),
                    pixel: due.map(|due| due.first.pixel),
                    primary: due.map(|due| due.first.primary),
                });
            }
        }
        None
    }

    /// The first place that two runs wrote differently, among those whose pixel and primary `of` accepts.
    pub fn compare_where(
        &self,
        expected: &[Expected],
        got: &Outputs,
        other: &Outputs,
        of: &dyn Fn([u32; 3], [u32; 3]) -> bool,
    ) -> Option<Difference> {
        for (output, expected) in expected.iter().enumerate() {
            let unit = self.unit(output);
            for (&number, due) in &expected.due {
                if self.chance[output].contains(&number) {
                    continue;
                }
                let at = number as usize * unit;
                // a place beyond the resource cannot be looked at
                let (Some(a), Some(b)) = (
                    got[output].get(at..at + unit),
                    other[output].get(at..at + unit),
                ) else {
                    continue;
                };
                // a place that several pixels may write is not compared, nor a value that is chance; nor is one of a pixel that
                // was never seen to store there, which may lie outside the domain, or behind a bound of the store's own: then the
                // place is another's, who may be due in one run and sky in the other
                let Write {
                    pixel,
                    primary,
                    optional,
                    is_chance,
                    unlike,
                    ..
                } = due.first;
                let [x, y, z] = pixel;
                let is_seen = unlike == 0 && self.stores_ever[self.invocation([x, y], z)];
                let is_known = !is_chance && (!optional || is_seen);
                if a != b && due.others.is_empty() && is_known && of(pixel, primary) {
                    return Some(Difference {
                        output,
                        byte: at,
                        expected: b.to_vec(),
                        got: a.to_vec(),
                        pixel: Some(pixel),
                        primary: Some(primary),
                    });
                }
            }
        }
        None
    }

    /// Calls `visit` with the pixel of each place that is due, and whether it holds what it should.
    pub fn each_due(
        &self,
        expected: &[Expected],
        got: &Outputs,
        visit: &mut dyn FnMut([u32; 3], bool),
    ) {
        for (output, expected) in expected.iter().enumerate() {
            let unit = self.unit(output);
            for (&number, due) in &expected.due {
                let at = number as usize * unit;
                let got = got[output].get(at..at + unit);
                let right = due.writes().any(|write| {
                    let from = write
                        .from
                        .map(|from| self.outputs[output].get(from..from + unit));
                    from.is_none_or(|from| got == from)
                });
                visit(due.first.pixel, right);
            }
        }
    }

    /// How many places are due, and how many of them are only allowed.
    pub fn strictness(&self, expected: &[Expected]) -> (usize, usize) {
        let all = expected
            .iter()
            .map(|e| e.due.len() + e.anywhere.len() + e.unseen as usize)
            .sum();
        let strict = expected
            .iter()
            .map(|e| e.due.values().filter(|due| !due.is_optional()).count())
            .sum();
        (all, strict)
    }
}
