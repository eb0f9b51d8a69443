//! The settings that nothing beats in both time and error.

/// The numbers of the points that no other point beats: no other is at least as good in both and better in one. In the
/// order of the first measure. Points that are no numbers are never among them.
pub fn front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&i| points[i].iter().all(|v| !v.is_nan()))
        .collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a], points[b]);
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let mut front: Vec<usize> = Vec::new();
    for i in order {
        let beaten = front
            .last()
            .is_some_and(|&last| points[last] != points[i] && points[last][1] <= points[i][1]);
        if !beaten {
            front.push(i);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_nothing_there_is_nothing() {
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn a_point_that_another_beats_is_left_out() {
        let points = [
            [1.0, 0.0],
            [0.5, 0.2],
            [0.6, 0.3],
            [0.4, 0.5],
            [0.4, 0.6],
            [1.0, 0.1],
        ];
        assert_eq!(front(&points), [3, 1, 0]);
    }

    #[test]
    fn equals_stand_together_and_what_is_no_number_never_stands() {
        let points = [[0.5, 0.2], [f64::NAN, 0.0], [0.5, 0.2], [0.2, f64::NAN]];
        assert_eq!(front(&points), [0, 2]);
    }

    #[test]
    fn it_is_what_comparing_all_with_all_gives() {
        let mut rng = fastrand::Rng::with_seed(3);
        for _ in 0..200 {
            let points: Vec<[f64; 2]> = (0..rng.usize(1..30))
                .map(|_| [f64::from(rng.u8(0..8)), f64::from(rng.u8(0..8))])
                .collect();
            let mut found = front(&points);
            found.sort_unstable();
            let beats = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
            let wanted: Vec<usize> = (0..points.len())
                .filter(|&i| !points.iter().any(|&other| beats(other, points[i])))
                .collect();
            assert_eq!(found, wanted);
        }
    }
}
