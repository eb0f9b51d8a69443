//! Whether the edges of tiles show.

use super::Shown;

/// The mean step of luma across the edges of tiles over the mean step elsewhere, relative to the same ratio of the full-rate
/// picture: 1 if tile edges show no more than there, 2 if steps there are twice as large.
///
/// A picture without edges of tiles, or without any steps at all, has no seams: 1.
///
/// # Panics
/// If the pictures differ in size, or the tile has no pixels.
pub fn seam(reference: Shown, test: Shown, tile: [u32; 2]) -> f64 {
    reference.assert_same_size(&test);
    assert!(tile[0] > 0 && tile[1] > 0);
    match (contrast(&reference, tile), contrast(&test, tile)) {
        (Some(reference), Some(test)) if reference > 0.0 => test / reference,
        _ => 1.0,
    }
}

/// Mean step across tile edges over mean step elsewhere.
fn contrast(shown: &Shown, tile: [u32; 2]) -> Option<f64> {
    let grey = shown.grey();
    let (width, height) = (shown.width as usize, shown.height as usize);
    let [mut at_edges, mut elsewhere] = [(0.0, 0u64); 2];
    for y in 0..height {
        for x in 0..width {
            let here = grey[y * width + x];
            let mut note = |other: f64, is_edge: bool| {
                let of = if is_edge {
                    &mut at_edges
                } else {
                    &mut elsewhere
                };
                of.0 += (here - other).abs();
                of.1 += 1;
            };
            if x > 0 {
                note(grey[y * width + x - 1], x % tile[0] as usize == 0);
            }
            if y > 0 {
                note(grey[(y - 1) * width + x], y % tile[1] as usize == 0);
            }
        }
    }
    let mean = |(sum, count): (f64, u64)| (count > 0).then(|| sum / count as f64);
    let (at_edges, elsewhere) = (mean(at_edges)?, mean(elsewhere)?);
    (elsewhere > 0.0).then(|| at_edges / elsewhere)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: impl Fn(u32, u32) -> u8) -> Vec<u8> {
        (0..32 * 32)
            .flat_map(|i| {
                let v = value(i % 32, i / 32);
                [v, v, v, 255]
            })
            .collect()
    }

    #[test]
    fn the_full_rate_picture_has_no_seams_of_its_own() {
        let ramp = picture(|x, y| (x * 3 + y) as u8);
        let shown = Shown::new([32, 32], &ramp);
        assert_eq!(seam(shown, shown, [8, 8]), 1.0);
        let plain = picture(|_, _| 7);
        let shown = Shown::new([32, 32], &plain);
        assert_eq!(seam(shown, shown, [8, 8]), 1.0);
    }

    #[test]
    fn of_a_row_of_four_it_is_what_a_hand_computes() {
        let row = |values: [u8; 4]| values.map(|v| [v, v, v, 255]).concat();
        let (reference, test) = (row([10, 20, 40, 80]), row([10, 20, 60, 80]));
        // the edge is in the middle: 20 over the mean of 10 and 40; then 40 over the mean of 10 and 20
        let wanted = (40.0 / 15.0) / (20.0 / 25.0);
        let found = seam(
            Shown::new([4, 1], &reference),
            Shown::new([4, 1], &test),
            [2, 1],
        );
        assert!((found - wanted).abs() < 1e-12, "{found}");
    }

    #[test]
    fn steps_at_tile_edges_show() {
        let ramp = picture(|x, y| (x * 3 + y) as u8);
        let stepped = picture(|x, y| (x * 3 + y + (x / 8) % 2 * 20) as u8);
        let found = seam(
            Shown::new([32, 32], &ramp),
            Shown::new([32, 32], &stepped),
            [8, 8],
        );
        assert!(found > 3.0, "{found}");
        let elsewhere = picture(|x, y| (x * 3 + y + (x + 4) / 8 % 2 * 20) as u8);
        let found = seam(
            Shown::new([32, 32], &ramp),
            Shown::new([32, 32], &elsewhere),
            [8, 8],
        );
        assert!(found < 1.0, "{found}");
    }
}
