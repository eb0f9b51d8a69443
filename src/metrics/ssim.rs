//! SSIM (Wang, Bovik, Sheikh, Simoncelli, *Image Quality Assessment: From Error Visibility to Structural Similarity*, 2004):
//! Gaussian windows of 11×11, σ = 1.5, K = 0.01 and 0.03, on the luma of the encoded picture, averaged over all windows that
//! lie inside.

use rayon::prelude::*;

use super::Shown;

const RADIUS: usize = 5;
const SIDE: usize = 2 * RADIUS + 1;
/// Rows of windows that are looked at together.
const BAND: usize = 64;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// The mean SSIM of two pictures: 1 if they are the same. Of a picture that is smaller than a window, the one window that
/// covers it all, with equal weights.
///
/// # Panics
/// If the pictures differ in size.
pub fn ssim(reference: Shown, test: Shown) -> f64 {
    reference.assert_same_size(&test);
    let (width, height) = (reference.width as usize, reference.height as usize);
    if width < SIDE || height < SIDE {
        return of_one_window(&reference.grey(), &test.grey());
    }
    let (inner, rows) = (width - SIDE + 1, height - SIDE + 1);
    let tops: Vec<usize> = (0..rows).step_by(BAND).collect();
    let sums: Vec<f64> = tops
        .into_par_iter()
        .map(|top| {
            let bottom = (top + BAND).min(rows);
            of_band(&reference, &test, top, bottom)
        })
        .collect();
    sums.into_iter().sum::<f64>() / (inner * rows) as f64
}

/// The moments of a pair of values: a, b, a², b² and ab.
type Moments = [f64; 5];

fn of_one_window(a: &[f64], b: &[f64]) -> f64 {
    let weight = 1.0 / a.len() as f64;
    let mut sums: Moments = [0.0; 5];
    for (a, b) in a.iter().zip(b) {
        add(&mut sums, weight, *a, *b);
    }
    of_window(sums)
}

/// The sum of SSIM over the windows whose first rows are `top` to `bottom`.
fn of_band(reference: &Shown, test: &Shown, top: usize, bottom: usize) -> f64 {
    let width = reference.width as usize;
    let inner = width - SIDE + 1;
    let weights = weights();
    let mut rows: Vec<Moments> = Vec::with_capacity(inner * (bottom - top + SIDE - 1));
    for y in top..bottom + SIDE - 1 {
        let (a, b) = (reference.grey_row(y), test.grey_row(y));
        for x in 0..inner {
            let mut sums: Moments = [0.0; 5];
            for (i, weight) in weights.iter().enumerate() {
                add(&mut sums, *weight, a[x + i], b[x + i]);
            }
            rows.push(sums);
        }
    }
    let mut sum = 0.0;
    for y in 0..bottom - top {
        for x in 0..inner {
            let mut sums: Moments = [0.0; 5];
            for (i, weight) in weights.iter().enumerate() {
                let row = &rows[(y + i) * inner + x];
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += weight * value;
                }
            }
            sum += of_window(sums);
        }
    }
    sum
}

fn add(sums: &mut Moments, weight: f64, a: f64, b: f64) {
    sums[0] += weight * a;
    sums[1] += weight * b;
    sums[2] += weight * a * a;
    sums[3] += weight * b * b;
    sums[4] += weight * a * b;
}

/// From the means of a, b, a², b² and ab over a window.
fn of_window([a, b, aa, bb, ab]: Moments) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    (2.0 * a * b + C1) * (2.0 * covariance + C2)
        / ((a * a + b * b + C1) * (variance_a + variance_b + C2))
}

fn weights() -> [f64; SIDE] {
    let raw: [f64; SIDE] = std::array::from_fn(|i| {
        let away = i as f64 - RADIUS as f64;
        (-away * away / (2.0 * 1.5 * 1.5)).exp()
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|w| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [48, 37];

    /// A grey picture.
    fn grey(values: impl Iterator<Item = u8>) -> Vec<u8> {
        values.flat_map(|v| [v, v, v, 255]).collect()
    }

    fn noise() -> Vec<u8> {
        let mut state = 1u32;
        (0..SIZE[0] * SIZE[1])
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            })
            .collect()
    }

    fn ramp() -> Vec<u8> {
        (0..SIZE[0] * SIZE[1])
            .map(|i| ((i % SIZE[0] * 5 + i / SIZE[0] * 3) % 256) as u8)
            .collect()
    }

    #[test]
    fn a_picture_is_like_itself() {
        let a = grey(noise().into_iter());
        let shown = Shown::new(SIZE, &a);
        assert!((ssim(shown, shown) - 1.0).abs() < 1e-12);
    }

    /// The references are scikit-image 0.25's `structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
    /// use_sample_covariance=False, data_range=255)`, its map cut by five pixels on each side, on the same pictures.
    #[test]
    fn it_agrees_with_scikit_image() {
        let mixed = ramp()
            .into_iter()
            .zip(noise())
            .map(|(r, n)| (f64::from(r) * 0.7 + f64::from(n) * 0.3).floor() as u8);
        let (noise, ramp, mixed) = (
            grey(noise().into_iter()),
            grey(ramp().into_iter()),
            grey(mixed),
        );
        let of = |a: &[u8], b: &[u8]| ssim(Shown::new(SIZE, a), Shown::new(SIZE, b));
        let near =
            |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        near(of(&ramp, &mixed), 0.335_361_279_221_793_26);
        near(of(&noise, &ramp), 0.008_061_868_049_603_668);
    }

    #[test]
    fn a_picture_smaller_than_a_window_has_one_window() {
        let (a, b) = (
            grey([10, 20, 30, 40].into_iter()),
            grey([10, 20, 30, 90].into_iter()),
        );
        let found = ssim(Shown::new([2, 2], &a), Shown::new([2, 2], &b));
        assert!(found > 0.0 && found < 1.0, "{found}");
    }
}
