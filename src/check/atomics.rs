//! What atomics are to leave behind.
//!
//! A primary's atomic counts for each of its pixels, at the pixel's own place where that is a function of the ids, and at the
//! primary's own place where data chooses it. What the original was seen to do does not always tell the two apart: a place that
//! several invocations share may be either, and all of an output's atomics are held to one of the two. Where an invocation was
//! never seen to come to an atomic, its place may be unknown: then any word may have been changed by it, but by no other
//! values, and sums are held to their total.

use std::collections::{HashMap, HashSet};

use naga::AtomicFunction;
use vrcs_passes::instrument::Atomic;

/// What atomics make of a word.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// With all that is sure.
    sure: u32,
    /// What may come to it, or not.
    besides: Vec<(Atomic, u32)>,
}

/// What atomics make of an output.
#[derive(Clone, Debug, Default)]
pub(super) struct Tallies {
    /// By byte, at each pixel's own place.
    own: HashMap<usize, Tally>,
    /// By byte, at the primary's place.
    primary: HashMap<usize, Tally>,
    /// Those whose place is not known, and whether they surely happen.
    lost: Vec<(Atomic, u32, bool)>,
}

/// A word that holds what it should not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    pub(super) byte: usize,
    pub(super) expected: u32,
    pub(super) got: u32,
}

/// An atomic that is done for a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Done {
    pub(super) atomic: Atomic,
    pub(super) value: u32,
    /// Whether it may also be left out.
    pub(super) optional: bool,
}

impl Tallies {
    /// Whether there are none at all.
    pub(super) fn is_empty(&self) -> bool {
        self.own.is_empty() && self.primary.is_empty() && self.lost.is_empty()
    }

    /// Adds an atomic that is done for a pixel: where it would do it itself (`None` if that is not known), and where its primary
    /// does it. A place is a byte, and the word that is there to begin with.
    pub(super) fn add(
        &mut self,
        done: Done,
        own: Option<(usize, u32)>,
        primary: Option<(usize, u32)>,
    ) {
        match own {
            Some(place) => note(&mut self.own, done, place),
            None => self.lost.push((done.atomic, done.value, !done.optional)),
        }
        if let Some(place) = primary {
            note(&mut self.primary, done, place);
        }
    }

    /// Adds an atomic that goes outside of the resource for the pixel, but not for its primary.
    pub(super) fn add_outside(&mut self, done: Done, primary: Option<(usize, u32)>) {
        if let Some(place) = primary {
            note(&mut self.primary, done, place);
        }
    }

    /// Compares what is there; the words that atomics account for. `is_chance` tells of a word, by its first byte, whether what it holds
    /// is chance; `is_shared`, whether invocations of the original share places, so that a place may be the primary's.
    pub(super) fn compare(
        &self,
        before: &[u8],
        after: &[u8],
        is_chance: &dyn Fn(usize) -> bool,
        is_shared: impl FnOnce() -> bool,
    ) -> Result<HashSet<usize>, Wrong> {
        match held(&self.own, &self.lost, before, after, is_chance) {
            Err(wrong) if is_shared() => {
                held(&self.primary, &[], before, after, is_chance).map_err(|_| wrong)
            }
            other => other,
        }
    }
}

fn note(tallies: &mut HashMap<usize, Tally>, done: Done, (byte, initial): (usize, u32)) {
    let tally = tallies.entry(byte).or_insert_with(|| Tally {
        sure: initial,
        besides: Vec::new(),
    });
    match done.optional {
        true => tally.besides.push((done.atomic, done.value)),
        false => tally.sure = apply(done.atomic, tally.sure, done.value),
    }
}

/// Holds all words against their tallies.
fn held(
    tallies: &HashMap<usize, Tally>,
    lost: &[(Atomic, u32, bool)],
    before: &[u8],
    after: &[u8],
    is_chance: &dyn Fn(usize) -> bool,
) -> Result<HashSet<usize>, Wrong> {
    let lost_values: Vec<(Atomic, u32)> = lost.iter().map(|&(a, value, _)| (a, value)).collect();
    let mut accounted = HashSet::new();
    let mut excess = 0u32;
    let mut any_chance = false;
    for (byte, (before, after)) in before
        .chunks_exact(4)
        .zip(after.chunks_exact(4))
        .enumerate()
    {
        let (byte, initial, got) = (byte * 4, word(before), word(after));
        if is_chance(byte) {
            any_chance = true;
            continue;
        }
        let untouched = Tally {
            sure: initial,
            besides: Vec::new(),
        };
        let tally = match tallies.get(&byte) {
            Some(tally) => tally,
            None if lost.is_empty() || initial == got => continue,
            None => &untouched,
        };
        let mut besides = tally.besides.clone();
        besides.extend(&lost_values);
        if !fits(tally.sure, &besides, got) {
            return Err(Wrong {
                byte,
                expected: tally.sure,
                got,
            });
        }
        excess = excess.wrapping_add(got.wrapping_sub(tally.sure));
        accounted.insert(byte);
    }
    let is_sum = |atomic: &Atomic| {
        matches!(
            atomic.function,
            AtomicFunction::Add | AtomicFunction::Subtract
        )
    };
    let is_sure = !any_chance
        && lost.iter().all(|(atomic, _, sure)| *sure && is_sum(atomic))
        && tallies.values().all(|tally| tally.besides.is_empty());
    let total = lost_values
        .iter()
        .fold(0, |sum, &(atomic, value)| apply(atomic, sum, value));
    match is_sure && total != excess {
        true => Err(Wrong {
            byte: 0,
            expected: total,
            got: excess,
        }),
        false => Ok(accounted),
    }
}

/// Whether a word can come about from another by some of the atomics of a list.
fn fits(sure: u32, besides: &[(Atomic, u32)], got: u32) -> bool {
    let Some(&(first, _)) = besides.first() else {
        return got == sure;
    };
    let values = || besides.iter().map(|(_, value)| *value);
    // where functions are mixed, their order tells, and that is chance
    if besides.iter().any(|(a, _)| a.function != first.function) {
        return true;
    }
    match first.function {
        AtomicFunction::Add | AtomicFunction::Subtract => {
            let sign = match first.function {
                AtomicFunction::Add => 1,
                _ => -1,
            };
            let changes = || values().map(|value| i64::from(value as i32) * sign);
            let least: i64 = changes().map(|change| change.min(0)).sum();
            let most: i64 = changes().map(|change| change.max(0)).sum();
            let change = i64::from(got.wrapping_sub(sure) as i32);
            (least..=most).contains(&change) || most - least > i64::from(u32::MAX / 2)
        }
        AtomicFunction::InclusiveOr => {
            let all = values().fold(sure, |all, value| all | value);
            got & sure == sure && got & !all == 0
        }
        AtomicFunction::And => {
            let all = values().fold(sure, |all, value| all & value);
            got | sure == sure && got & all == all
        }
        _ => got == sure || values().any(|value| value == got) && apply(first, sure, got) == got,
    }
}

/// The word of four bytes.
pub(super) fn word(bytes: &[u8]) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[..4]);
    u32::from_le_bytes(word)
}

/// What an atomic leaves behind.
fn apply(atomic: Atomic, before: u32, value: u32) -> u32 {
    let signed = |least: bool| {
        let (a, b) = (before as i32, value as i32);
        (if least { a.min(b) } else { a.max(b) }) as u32
    };
    match atomic.function {
        AtomicFunction::Add => before.wrapping_add(value),
        AtomicFunction::Subtract => before.wrapping_sub(value),
        AtomicFunction::And => before & value,
        AtomicFunction::InclusiveOr => before | value,
        AtomicFunction::ExclusiveOr => before ^ value,
        AtomicFunction::Min if atomic.is_signed => signed(true),
        AtomicFunction::Max if atomic.is_signed => signed(false),
        AtomicFunction::Min => before.min(value),
        AtomicFunction::Max => before.max(value),
        AtomicFunction::Exchange { .. } => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADD: Atomic = Atomic {
        function: AtomicFunction::Add,
        is_signed: true,
    };

    fn done(value: i32, optional: bool) -> Done {
        Done {
            atomic: ADD,
            value: value as u32,
            optional,
        }
    }

    fn bytes(words: [i32; 2]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    #[test]
    fn what_is_sure_is_held_exactly() {
        let mut tallies = Tallies::default();
        tallies.add(done(3, false), Some((0, 10)), Some((4, 20)));
        let before = bytes([10, 20]);
        let compare =
            |after, shared| tallies.compare(&before, &bytes(after), &|_| false, || shared);
        assert!(compare([13, 20], false).is_ok());
        assert!(compare([12, 20], false).is_err());
        // at the primary's place only if places are shared
        assert!(compare([10, 23], true).is_ok());
        assert!(compare([10, 23], false).is_err());
        // a word that no atomic goes to is left to the comparison of plain writes, which holds it to what it was
        let accounted = compare([13, 23], true).ok();
        assert_eq!(accounted, Some(HashSet::from([0])));
    }

    #[test]
    fn words_that_additions_beyond_the_end_may_hit_are_not_compared() {
        let mut tallies = Tallies::default();
        tallies.add(done(3, false), Some((0, 10)), None);
        // one that goes beyond the end: dropped, or sent to the last word
        tallies.add_outside(done(7, false), None);
        let last = |byte| byte == 4;
        let before = bytes([10, 20]);
        let fits = |after| {
            tallies
                .compare(&before, &bytes(after), &last, || false)
                .is_ok()
        };
        assert!(fits([13, 20]) && fits([13, 27]));
        assert!(!fits([20, 20]) && !fits([10, 27]));
    }

    #[test]
    fn optional_sums_of_either_sign_may_come_in_part() {
        let mut tallies = Tallies::default();
        for value in [5, -7] {
            tallies.add(done(value, true), Some((0, 10)), None);
        }
        let fits = |got| {
            let before = bytes([10, 20]);
            let compared = tallies.compare(&before, &bytes([got, 20]), &|_| false, || false);
            compared.is_ok()
        };
        assert!([10, 15, 3, 8].into_iter().all(fits));
        assert!(!fits(16) && !fits(2));
    }

    #[test]
    fn sums_at_unknown_places_are_held_to_their_total() {
        let mut tallies = Tallies::default();
        tallies.add(done(5, false), None, None);
        tallies.add(done(2, false), None, None);
        let fits = |after| {
            let before = bytes([10, 20]);
            tallies
                .compare(&before, &bytes(after), &|_| false, || false)
                .is_ok()
        };
        assert!(fits([15, 22]) && fits([17, 20]));
        assert!(!fits([15, 20]) && !fits([10, 20]) && !fits([20, 17]));
    }
}
