//! How far a variable-rate picture is from the full-rate one.
//!
//! | metric | measures | range |
//! |---|---|---|
//! | [`flip`] | what a viewer notices who flips between the two (Andersson et al., HPG 2020) | 0 the same, 1 |
//! | [`ssim`] | structure (Wang et al., 2004), which the NAS paper reports | 1 the same |
//! | [`psnr`] | energy of the difference | decibels, infinite for the same |
//! | [`seam`] | whether tile edges show | 1 as much as in the full-rate picture |
//!
//! All take pictures as they are shown: 8-bit sRGB, RGBA, row by row.

mod flip;
mod seam;
mod ssim;

pub use flip::{Flip, PIXELS_PER_DEGREE, flip, magma};
pub use seam::seam;
pub use ssim::ssim;

use crate::sri::Sri;

/// A picture as it is shown.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'p> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, row by row: four bytes for each pixel.
    pub rgba: &'p [u8],
}

impl<'p> Shown<'p> {
    /// A picture.
    ///
    /// # Panics
    /// If there are not four bytes for each pixel.
    pub fn new([width, height]: [u32; 2], rgba: &'p [u8]) -> Shown<'p> {
        assert_eq!(rgba.len(), width as usize * height as usize * 4);
        Shown {
            width,
            height,
            rgba,
        }
    }

    fn assert_same_size(&self, other: &Shown) {
        assert_eq!(
            (self.width, self.height),
            (other.width, other.height),
            "pictures of two sizes cannot be compared"
        );
    }

    /// Luma of the encoded values, 0 to 255 (Rec. 601, as SSIM's authors use).
    fn grey(&self) -> Vec<f64> {
        self.rgba.chunks_exact(4).map(grey).collect()
    }

    /// The same of a row.
    fn grey_row(&self, y: usize) -> Vec<f64> {
        let pitch = self.width as usize * 4;
        let row = &self.rgba[y * pitch..(y + 1) * pitch];
        row.chunks_exact(4).map(grey).collect()
    }
}

fn grey(p: &[u8]) -> f64 {
    0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2])
}

/// Peak signal-to-noise ratio over red, green and blue, in decibels; infinite if the pictures are equal.
///
/// # Panics
/// If the pictures differ in size.
pub fn psnr(reference: Shown, test: Shown) -> f64 {
    reference.assert_same_size(&test);
    let mut sum = 0u64;
    let pixels = reference.rgba.chunks_exact(4);
    for (a, b) in pixels.zip(test.rgba.chunks_exact(4)) {
        for channel in 0..3 {
            let step = u64::from(a[channel].abs_diff(b[channel]));
            sum += step * step;
        }
    }
    let count = f64::from(reference.width) * f64::from(reference.height) * 3.0;
    10.0 * (255.0f64.powi(2) / (sum as f64 / count)).log10()
}

/// The share of quads whose byte differs between two frames' shading-rate images, 0 to 1.
///
/// # Panics
/// If the images differ in size.
pub fn flips(before: &Sri, after: &Sri) -> f64 {
    assert_eq!(before.layout(), after.layout());
    let layout = after.layout();
    let changed = (0..layout.height)
        .flat_map(|y| (0..layout.width).map(move |x| (x, y)))
        .filter(|&(x, y)| before.code(x, y) != after.code(x, y))
        .count();
    changed as f64 / (f64::from(layout.width) * f64::from(layout.height))
}

/// Pictures that the references of other programs were computed on: RGBA, alpha 255.
#[cfg(test)]
mod reference {
    pub(super) const SIZE: [u32; 2] = [48, 37];

    fn rgba(mut of: impl FnMut(u32, u32, u32) -> u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                bytes.extend([0, 1, 2].map(|channel| of(x, y, channel)));
                bytes.push(255);
            }
        }
        bytes
    }

    /// The high bytes of Numerical Recipes' generator, from 1.
    pub(super) fn noise() -> Vec<u8> {
        let mut state = 1u32;
        rgba(|_, _, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
    }

    pub(super) fn ramp() -> Vec<u8> {
        rgba(|x, y, channel| (x * 5 + y * 3 + channel * 40) as u8)
    }

    /// 70 % of the ramp and 30 % of the noise, rounded down.
    pub(super) fn mixed() -> Vec<u8> {
        let both = ramp().into_iter().zip(noise());
        both.map(|(r, n)| (f64::from(r) * 0.7 + f64::from(n) * 0.3).floor() as u8)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rate;

    /// The references are scikit-image 0.26's `peak_signal_noise_ratio(a, b, data_range=255)` on red, green and blue.
    #[test]
    fn psnr_agrees_with_scikit_image() {
        use reference::{SIZE, mixed, noise, ramp};
        let of = |a: &[u8], b: &[u8]| psnr(Shown::new(SIZE, a), Shown::new(SIZE, b));
        assert!((of(&ramp(), &mixed()) - 18.064_766_137_412_448).abs() < 1e-9);
        assert!((of(&noise(), &ramp()) - 7.614_137_277_629_933).abs() < 1e-9);
    }

    #[test]
    fn equal_pictures_have_no_noise() {
        let picture = [7; 16];
        let shown = Shown::new([2, 2], &picture);
        assert_eq!(psnr(shown, shown), f64::INFINITY);
    }

    #[test]
    fn psnr_of_a_difference_of_one_is_the_known_number() {
        let (a, b) = ([10; 16], [11; 16]);
        let found = psnr(Shown::new([2, 2], &a), Shown::new([2, 2], &b));
        // 20 log10 255
        assert!((found - 48.130_803_608_679_1).abs() < 1e-10, "{found}");
    }

    #[test]
    fn alpha_is_not_seen() {
        let a = [1, 2, 3, 0];
        let b = [1, 2, 3, 255];
        assert_eq!(
            psnr(Shown::new([1, 1], &a), Shown::new([1, 1], &b)),
            f64::INFINITY
        );
    }

    #[test]
    fn flips_are_counted_by_quad() {
        let before = Sri::uniform(8, 4, Rate::R1X1);
        let after = Sri::from_fn(8, 4, |x, _| if x == 0 { 5 } else { 0 });
        assert_eq!(flips(&before, &before), 0.0);
        assert_eq!(flips(&before, &after), 0.25);
    }
}
