//! ꟻLIP (Andersson et al., *ꟻLIP: A Difference Evaluator for Alternating Images*, HPG 2020), by its authors' own code.

use super::Shown;

/// The viewing distance that the authors assume: a 0.7 m wide monitor of 3840 pixels seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// What ꟻLIP says of a pair of pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// The mean over all pixels, 0 to 1.
    pub mean: f64,
    /// The value that 99 % of the pixels stay below, 0 to 1.
    pub p99: f64,
    /// The error of each pixel, row by row.
    pub errors: Vec<f32>,
}

/// Compares two pictures, at the authors' viewing distance.
///
/// # Panics
/// If the pictures differ in size.
pub fn flip(reference: Shown, test: Shown) -> Flip {
    reference.assert_same_size(&test);
    let rgb = |shown: &Shown| {
        let bytes: Vec<u8> = shown
            .rgba
            .chunks_exact(4)
            .flat_map(|pixel| &pixel[..3])
            .copied()
            .collect();
        nv_flip::FlipImageRgb8::with_data(shown.width, shown.height, &bytes)
    };
    let errors = nv_flip::flip(rgb(&reference), rgb(&test), PIXELS_PER_DEGREE);
    let errors = errors.to_vec();
    let mean = errors.iter().map(|&v| f64::from(v)).sum::<f64>() / errors.len() as f64;
    let at = ((errors.len() as f64 * 0.99).ceil() as usize).clamp(1, errors.len()) - 1;
    let mut order = errors.clone();
    let (_, p99, _) = order.select_nth_unstable_by(at, f32::total_cmp);
    Flip {
        mean,
        p99: f64::from(*p99),
        errors,
    }
}

/// Errors in the magma colours, as the authors show them: RGB for each.
pub fn magma(errors: &[f32]) -> Vec<u8> {
    let colours = nv_flip::magma_lut().to_vec();
    let last = (colours.len() / 3).saturating_sub(1);
    let colour = |&error: &f32| {
        let at = (error.clamp(0.0, 1.0) * last as f32 + 0.5) as usize;
        <[u8; 3]>::try_from(&colours[at * 3..at * 3 + 3]).unwrap_or_default()
    };
    errors.iter().flat_map(colour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(value: [u8; 4]) -> Vec<u8> {
        value.repeat(32 * 32)
    }

    #[test]
    fn equal_pictures_do_not_differ() {
        let a = plain([90, 120, 30, 255]);
        let found = flip(Shown::new([32, 32], &a), Shown::new([32, 32], &a));
        assert_eq!((found.mean, found.p99), (0.0, 0.0));
    }

    #[test]
    fn black_and_white_differ_by_nearly_all() {
        // the authors' normalisation sends the largest colour difference, blue to green, to 1
        let (a, b) = (plain([0, 0, 0, 255]), plain([255, 255, 255, 255]));
        let found = flip(Shown::new([32, 32], &a), Shown::new([32, 32], &b));
        assert!(found.mean > 0.9 && found.mean <= 1.0, "{}", found.mean);
        let (a, b) = (plain([0, 0, 255, 255]), plain([0, 255, 0, 255]));
        let most = flip(Shown::new([32, 32], &a), Shown::new([32, 32], &b));
        assert!(most.mean >= found.mean && most.mean > 0.99, "{}", most.mean);
    }

    /// The references are the authors' `flip-evaluator` 1.7 (PyPI), `evaluate(a, b, "LDR", applyMagma=False)` on the bytes
    /// divided by 255: the mean of its map, and the value at rank ⌈0.99 n⌉. The pictures are those below, 48×37.
    #[test]
    fn it_agrees_with_the_authors_own_program() {
        use crate::metrics::reference::{SIZE, mixed, noise, ramp};
        let near = |found: Flip, mean: f64, p99: f64| {
            assert!((found.mean - mean).abs() < 2e-5, "{} {mean}", found.mean);
            assert!((found.p99 - p99).abs() < 2e-4, "{} {p99}", found.p99);
        };
        let of = |a: &[u8], b: &[u8]| flip(Shown::new(SIZE, a), Shown::new(SIZE, b));
        near(of(&ramp(), &mixed()), 0.417_538_055, 0.763_023_6);
        near(of(&noise(), &ramp()), 0.785_295_930, 0.981_694_16);
    }

    #[test]
    fn one_pixel_moves_the_map_and_hardly_the_mean() {
        let a = plain([90, 90, 90, 255]);
        let mut b = a.clone();
        b[4 * (16 * 32 + 16)] = 255;
        let found = flip(Shown::new([32, 32], &a), Shown::new([32, 32], &b));
        assert!(found.mean > 0.0 && found.mean < 0.05, "{}", found.mean);
        let map = magma(&found.errors);
        assert_eq!(map.len(), 32 * 32 * 3);
        assert_ne!(map[3 * (16 * 32 + 16)..][..3], map[..3]);
    }
}
