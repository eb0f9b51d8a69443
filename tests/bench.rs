//! `vrcs bench`: what it measures and how it says so; never how fast anything is.

mod common;

use vrcs::{
    bench::{Bench, BenchError},
    check::gpu::Gpu,
};

fn small(filter: &str) -> Bench {
    Bench {
        size: [96, 64],
        rounds: 3,
        filter: Some(filter.to_owned()),
        lights: 4,
        rotated: 1 << 16,
    }
}

#[test]
fn a_software_driver_meets_no_goal() {
    let gpu = Gpu::open(None).expect("a driver");
    for (filter, rows) in [
        ("heavy, 25", 1),
        ("stage", 4),
        ("all machinery", 2),
        ("barriers", 6),
        ("identity", 6),
        ("indirect", 1),
        ("resolution", 2),
    ] {
        let found = small(filter).run(&gpu, &mut |_| {}).expect("rows");
        assert_eq!(found.rows.len(), rows, "{filter}: {:?}", found.rows);
        for row in &found.rows {
            // a constant of resolution, and a difference, may be below zero
            let is_signed = ["resolution, a", "indirect", "barriers, the per-pixel"]
                .iter()
                .any(|name| row.name.starts_with(name));
            assert!(row.value.is_finite(), "{row:?}");
            assert!(is_signed || row.value > 0.0, "{row:?}");
            let drift = row.drift.expect("a control ran beside it");
            assert!(drift.control >= 1.0 && drift.counted >= 3, "{row:?}");
            assert!(
                row.parts.iter().all(|part| part.milliseconds > 0.0),
                "{row:?}"
            );
            assert!(row.met.is_none() || !found.is_software, "{row:?}");
        }
    }
}

#[test]
fn a_filter_that_fits_nothing_is_told() {
    let gpu = Gpu::open(None).expect("a driver");
    let error = small("no such row")
        .run(&gpu, &mut |_| {})
        .expect_err("no row");
    assert!(matches!(error, BenchError::NoRow(_)), "{error}");
}
