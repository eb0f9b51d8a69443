//! Holds what a rewritten shader wrote against what it should have written.

use std::collections::HashMap;

use vrcs_passes::instrument::{OUTSIDE, Site};

use super::{
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

/// The groups of a coordinate buffer, those of a single pixel included, confined to an extent: a group whose primary lies
/// outside is re-homed to its first member inside.
pub fn groups(coordinates: &Coordinates, extent: [u32; 2]) -> Vec<Group> {
    let width = coordinates.extent[0];
    let map = coordinates.map();
    let mut of_primary: HashMap<u32, Vec<[u32; 2]>> = HashMap::new();
    for y in 0..extent[1] {
        for x in 0..extent[0] {
            of_primary
                .entry(map[(y * width + x) as usize])
                .or_default()
                .push([x, y]);
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
    /// What it stored, in the run whose outputs these are.
    pub log: Log,
    /// The stores in its text.
    pub sites: Vec<Site>,
    /// For each site, the number of the output that it stores to.
    pub output_of_site: Vec<usize>,
    /// Where each store goes.
    pub book: AddressBook,
    /// For each invocation, whether it ever stored, in any run.
    pub stores_ever: Vec<bool>,
    /// Whether which invocations store depends on data.
    pub depends_on_data: bool,
    /// What it wrote.
    pub outputs: Outputs,
    /// What was there before.
    pub initial: Outputs,
    /// Bytes of a texel of each output; `None` for a buffer.
    pub texel_bytes: Vec<Option<usize>>,
}

/// A write that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Due {
    /// Where the value comes from, in the original's output, in bytes; `None` if the primary has overwritten it there.
    from: Option<usize>,
    /// The pixel that is written, and the pixel that is shaded for it.
    pixel: [u32; 3],
    primary: [u32; 3],
    /// How often the place is written.
    times: u32,
    /// Whether it may also be left out: data kept the pixel from ever storing, so it is not known to be in the domain.
    optional: bool,
}

/// All that is due in one output: for each unit of places, what is written there.
#[derive(Clone, Debug, Default)]
pub struct Expected {
    due: HashMap<u32, Due>,
    /// Values that may appear at places that are not known.
    anywhere: Vec<usize>,
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
    /// What is due in each output, for a map.
    pub fn expected(&self, groups: &[Group]) -> Vec<Expected> {
        let mut expected = vec![Expected::default(); self.outputs.len()];
        let grid = self.log.grid();
        for z in 0..grid[2] {
            for group in groups {
                self.expect_group(group, z, &mut expected);
            }
        }
        expected
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
            self.expect_pixel(primary, self.invocation(member, z), optional, expected);
        }
    }

    fn expect_pixel(
        &self,
        primary: usize,
        pixel: usize,
        optional: bool,
        expected: &mut [Expected],
    ) {
        let stores = self.log.of(primary);
        let own = self.log.of(pixel);
        for (index, &stored) in stores.iter().enumerate() {
            if stored.place == OUTSIDE {
                continue;
            }
            let site = &self.sites[stored.site as usize];
            let output = self.output_of_site[stored.site as usize];
            // what the primary itself overwrites later cannot be seen, and is overwritten for the pixel, too
            let is_last = !stores[index + 1..]
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
                    let beyond = pixel != primary
                        && !self.book.is_seen(stored, pixel)
                        && !own
                            .iter()
                            .any(|own| self.overlap(*own, Stored { place, ..stored }));
                    let optional = optional || beyond;
                    for (unit, from) in units(site, place).zip(units(site, stored.place)) {
                        let from = from as usize * self.unit(output);
                        let grid = self.log.grid();
                        let due = expected[output].due.entry(unit).or_insert(Due {
                            from: None,
                            pixel: position(pixel, grid),
                            primary: position(primary, grid),
                            times: 0,
                            optional,
                        });
                        due.times += 1;
                        due.from = is_last.then_some(from);
                    }
                }
                None if is_last => {
                    let from =
                        units(site, stored.place).map(|from| from as usize * self.unit(output));
                    expected[output].anywhere.extend(from);
                }
                None => {}
            }
        }
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
            let (before, after) = (&self.initial[output], &got[output]);
            for (number, (initial, got)) in before.chunks(unit).zip(after.chunks(unit)).enumerate()
            {
                let due = expected.due.get(&(number as u32));
                let wanted = match due {
                    Some(Due { from: None, .. }) => continue,
                    Some(Due {
                        from: Some(from), ..
                    }) => &self.outputs[output][*from..from + unit],
                    None => initial,
                };
                if wanted == got {
                    continue;
                }
                if due.is_some_and(|due| due.optional) && got == initial {
                    continue;
                }
                if due.is_none()
                    && let Some(found) = anywhere.iter().position(|value| *value == got)
                {
                    anywhere.swap_remove(found);
                    continue;
                }
                return Some(Difference {
                    output,
                    byte: number * unit,
                    expected: wanted.to_vec(),
                    got: got.to_vec(),
                    pixel: due.map(|due| due.pixel),
                    primary: due.map(|due| due.primary),
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
            let mut spare = expected.anywhere.len() as u32;
            for (number, &got) in counts[output].iter().enumerate() {
                let due = expected.due.get(&(number as u32));
                let times = due.map_or(0, |due| due.times);
                if got == times || due.is_some_and(|due| due.optional) && got == 0 {
                    continue;
                }
                if due.is_none() && got <= spare {
                    spare -= got;
                    continue;
                }
                return Some(Difference {
                    output,
                    byte: number * unit,
                    expected: times.to_le_bytes().to_vec(),
                    got: got.to_le_bytes().to_vec(),
                    pixel: due.map(|due| due.pixel),
                    primary: due.map(|due| due.primary),
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
                let at = number as usize * unit;
                let (a, b) = (&got[output][at..at + unit], &other[output][at..at + unit]);
                if a != b && of(due.pixel, due.primary) {
                    return Some(Difference {
                        output,
                        byte: at,
                        expected: b.to_vec(),
                        got: a.to_vec(),
                        pixel: Some(due.pixel),
                        primary: Some(due.primary),
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
                let right = due
                    .from
                    .is_none_or(|from| got == self.outputs[output].get(from..from + unit));
                visit(due.pixel, right);
            }
        }
    }

    /// How many places are due, and how many of them are only allowed.
    pub fn strictness(&self, expected: &[Expected]) -> (usize, usize) {
        let all = expected
            .iter()
            .map(|e| e.due.len() + e.anywhere.len())
            .sum();
        let strict = expected
            .iter()
            .map(|e| e.due.values().filter(|due| !due.optional).count())
            .sum();
        (all, strict)
    }
}
