//! Tile classification on the CPU: the oracle in tests.

use super::{Options, Rule};

/// The class of each tile, row by row, from the measured value of each pixel. `holds` evaluates [`Rule::Wgsl`]: it is told
/// the class's index, the least and the greatest value.
///
/// # Panics
/// If there is not one value for each pixel.
pub fn classify(
    values: &[f32],
    extent: [u32; 2],
    options: &Options,
    holds: impl Fn(usize, f32, f32) -> bool,
) -> Vec<usize> {
    assert_eq!(values.len(), extent[0] as usize * extent[1] as usize);
    let tiles = options.tiles(extent);
    let ranges: Vec<Option<[f32; 2]>> = (0..tiles[0] * tiles[1])
        .map(|i| range(values, extent, options.tile, [i % tiles[0], i / tiles[0]]))
        .collect();
    (0..tiles[0] * tiles[1])
        .map(|i| {
            let [x, y] = [i % tiles[0], i / tiles[0]];
            let around = match options.neighbourhood {
                true => neighbourhood(&ranges, tiles, [x, y]),
                false => ranges[i as usize],
            };
            let last = options.classes.len() - 1;
            let Some([lo, hi]) = around else {
                return last;
            };
            let is_of = |(index, rule): (usize, &Rule)| match rule {
                Rule::MaxBelow(limit) => hi < *limit,
                Rule::MinAbove(limit) => lo > *limit,
                Rule::RangeBelow(limit) => hi - lo < *limit,
                Rule::Wgsl(_) => holds(index, lo, hi),
                Rule::Rest => true,
            };
            let mut rules = options.classes.iter().map(|class| &class.rule).enumerate();
            rules.position(is_of).unwrap_or(last)
        })
        .collect()
}

/// The least and the greatest value of a tile; `None` if one is no number.
fn range(values: &[f32], extent: [u32; 2], side: u32, tile: [u32; 2]) -> Option<[f32; 2]> {
    let mut range = [f32::INFINITY, f32::NEG_INFINITY];
    for y in tile[1] * side..((tile[1] + 1) * side).min(extent[1]) {
        for x in tile[0] * side..((tile[0] + 1) * side).min(extent[0]) {
            let value = values[(y * extent[0] + x) as usize];
            if value.is_nan() {
                return None;
            }
            range = [range[0].min(value), range[1].max(value)];
        }
    }
    Some(range)
}

/// The range of the 3×3 tiles around one.
fn neighbourhood(
    ranges: &[Option<[f32; 2]>],
    tiles: [u32; 2],
    [x, y]: [u32; 2],
) -> Option<[f32; 2]> {
    let mut all = [f32::INFINITY, f32::NEG_INFINITY];
    for y in y.saturating_sub(1)..=(y + 1).min(tiles[1] - 1) {
        for x in x.saturating_sub(1)..=(x + 1).min(tiles[0] - 1) {
            let [lo, hi] = ranges[(y * tiles[0] + x) as usize]?;
            all = [all[0].min(lo), all[1].max(hi)];
        }
    }
    Some(all)
}
