//! Limits between neighbours: a coarse quad beside a fine one is seen (Yang et al., §5.4; GDC, pass 3).
//!
//! *Guarantees*: never coarser than before, on either axis; quads outside the picture say nothing.

use super::settings::{Granularity, Smoothing};
use crate::sri::Sri;

/// Smooths an image of rates for a picture of `size` pixels, whose rates are each of a quad or of a tile: then neighbours are tiles.
pub fn smooth(sri: &Sri, size: [u32; 2], smoothing: Smoothing, granularity: Granularity) -> Sri {
    let step = granularity.side() / 2;
    match smoothing {
        Smoothing::None => sri.clone(),
        _ => Sri::from_fn(size[0], size[1], |x, y| {
            let logs = [0, 1].map(|axis| smoothed(sri, [x, y], axis, smoothing, step));
            super::pipeline::code(logs)
        }),
    }
}

fn log(sri: &Sri, x: u32, y: u32, axis: usize) -> u8 {
    let code = sri.code(x, y);
    if axis == 0 { code >> 2 & 3 } else { code & 3 }
}

fn smoothed(sri: &Sri, [x, y]: [u32; 2], axis: usize, smoothing: Smoothing, step: u32) -> u8 {
    let own = log(sri, x, y, axis);
    let layout = sri.layout();
    let around = (0..9).filter_map(|i| {
        let (nx, ny) = (
            (x / step + i % 3).checked_sub(1)? * step,
            (y / step + i / 3).checked_sub(1)? * step,
        );
        (nx < layout.width && ny < layout.height).then(|| log(sri, nx, ny, axis))
    });
    match smoothing {
        Smoothing::None => own,
        Smoothing::Limit => match around.min() {
            Some(0) => own.min(1),
            _ => own,
        },
        Smoothing::Conservative => {
            let (sum, count) =
                around.fold((0, 0), |(sum, count), log| (sum + log.min(own), count + 1));
            // the mean, rounded to fine
            sum / count
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rate;

    #[test]
    fn e26_a_fine_neighbour_limits_its_own_axis_only() {
        // one quad that is fine down, among 4x4
        let sri = Sri::from_fn(10, 10, |x, y| {
            if (x, y) == (2, 2) {
                Rate::R2X1.code()
            } else {
                Rate::R4X4.code()
            }
        });
        let out = smooth(&sri, [10, 10], Smoothing::Limit, Granularity::Quad);
        assert_eq!(
            out.code(1, 1),
            Rate::R4X2.code(),
            "2 across does not limit 4, 1 down does"
        );
        assert_eq!(out.code(0, 4), Rate::R4X4.code());
        assert_eq!(
            out.code(4, 4),
            Rate::R4X4.code(),
            "the border may be coarse"
        );
    }

    #[test]
    fn only_fine_spreads_and_nothing_becomes_coarser() {
        let sri = Sri::from_fn(12, 12, |x, y| {
            [0, 5, 10, 4, 1, 6, 9][((x * 5 + y * 3) % 7) as usize]
        });
        for smoothing in [Smoothing::Limit, Smoothing::Conservative] {
            let out = smooth(&sri, [12, 12], smoothing, Granularity::Quad);
            for i in 0..36 {
                let (x, y) = (i % 6, i / 6);
                let now = Rate::from_code(out.code(x, y)).expect("a rate");
                assert!(now.is_within(Rate::from_code_or_full(sri.code(x, y))));
            }
        }
        let plain = Sri::uniform(12, 12, Rate::R2X2);
        assert_eq!(
            smooth(&plain, [12, 12], Smoothing::Conservative, Granularity::Quad),
            plain
        );
    }

    #[test]
    fn tiles_are_limited_by_the_tiles_around_them() {
        // three tiles of 16 pixels side by side, the last cut off: fine, coarse, coarse
        let sri = Sri::from_fn(36, 16, |x, _| match x / 8 {
            0 => Rate::R1X1.code(),
            _ => Rate::R4X4.code(),
        });
        let tile = Granularity::Tile16;
        let out = smooth(&sri, [36, 16], Smoothing::Limit, tile);
        for (x, wanted) in [(0, 0), (8, 5), (15, 5), (16, 10), (17, 10)] {
            for y in 0..8 {
                assert_eq!(out.code(x, y), wanted, "{x},{y}");
            }
        }
        // of tiles in a row the means are 0, (0 + 2 + 2) / 3 and 2
        let out = smooth(&sri, [36, 16], Smoothing::Conservative, tile);
        assert_eq!([0, 8, 15, 16].map(|x| out.code(x, 7)), [0, 5, 5, 10]);
    }
}
