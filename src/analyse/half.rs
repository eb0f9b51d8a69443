//! Rates of passes that run at half the resolution (DOOM, "VRCS on Half Res?": an additional output of the same analysis).
//!
//! Does: makes, for each quad of the smaller picture, one rate of the four quads that it covers: the finest, axis by axis.
//! Needs: the rates of the picture, smoothed and with the application's own.
//! Guarantees: no axis is coarser than that of any quad that is covered; quads beyond the border say nothing.
//! Refuses: nothing.

use crate::{rate::Rate, sri::Sri};

/// What a rate of the smaller picture may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "cli",
    derive(serde::Deserialize),
    serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")
)]
pub enum HalfResolution {
    /// The picture's own code: twice the footprint on the screen. For what is blurred or upsampled afterwards, as ambient occlusion is.
    #[default]
    Code,
    /// The same footprint on the screen: what may be 4 pixels wide in the picture may be 2 here. Needs
    /// [`Settings::largest`](super::Settings::largest) above 2x2 to be of use.
    Footprint,
}

/// The size of the smaller picture: half, rounded up.
pub fn size_of(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(2))
}

/// The rates of the smaller picture, given those of a picture of `size` pixels.
pub fn half(rates: &Sri, size: [u32; 2], kind: HalfResolution) -> Sri {
    let [width, height] = size_of(size);
    let layout = rates.layout();
    Sri::from_fn(width, height, |x, y| {
        let covered = (0..4).map(|i| (x * 2 + i % 2, y * 2 + i / 2));
        let rate = covered
            .filter(|&(x, y)| x < layout.width && y < layout.height)
            .map(|(x, y)| Rate::from_code_or_full(rates.code(x, y)))
            .fold(Rate::R4X4, Rate::meet);
        match kind {
            HalfResolution::Code => rate.code(),
            HalfResolution::Footprint => {
                let logs = rate.log2().map(|log| log.saturating_sub(1));
                Rate::from_log2(logs).code()
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_quad_is_the_finest_of_the_four_that_it_covers_on_each_axis() {
        let rates = Sri::from_fn(10, 6, |x, y| match (x, y) {
            (0, 0) => Rate::R2X4.code(),
            (1, 1) => Rate::R4X2.code(),
            (2, 0) => 0xff,
            _ => Rate::R4X4.code(),
        });
        let found = half(&rates, [10, 6], HalfResolution::Code);
        assert_eq!((found.layout().width, found.layout().height), (3, 2));
        assert_eq!(found.code(0, 0), Rate::R2X2.code(), "2x4 and 4x2");
        assert_eq!(found.code(1, 0), Rate::R1X1.code(), "no code is full rate");
        assert_eq!(
            found.code(2, 1),
            Rate::R4X4.code(),
            "the border says nothing"
        );
        let found = half(&rates, [10, 6], HalfResolution::Footprint);
        assert_eq!(found.code(0, 0), Rate::R1X1.code());
        assert_eq!(found.code(2, 1), Rate::R2X2.code());
    }

    #[test]
    fn a_uniform_picture_stays_uniform_at_every_size() {
        for size in [[1, 1], [2, 3], [5, 4], [64, 31]] {
            for rate in Rate::ALL {
                let rates = Sri::uniform(size[0], size[1], rate);
                let [width, height] = size_of(size);
                let found = half(&rates, size, HalfResolution::Code);
                assert_eq!(found, Sri::uniform(width, height, rate));
            }
        }
    }
}
