//! What was: motion, reprojection, the rates before, a change of resolution.

use super::*;

#[test]
fn e33_e34_e36_what_was_not_seen_is_full_rate() {
    let size = [32, 16];
    let picture = vec![[120u8; 4]; 512];
    let depth = vec![0.25f32; 512];
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        ..Settings::default()
    };
    let run = |vector: [f32; 2], before: f32, has_history: bool| {
        let motion = vec![vector; 512];
        let previous = vec![before; 512];
        let inputs = Inputs {
            has_history,
            motion: Some(&motion),
            depth: Some(&depth),
            previous_depth: Some(&previous),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        let [a, b] = twins(&inputs, &settings);
        assert_eq!(a.sri, b.sri);
        a
    };
    assert_eq!(
        run([0.0; 2], 0.25, true).sri,
        Sri::uniform(32, 16, Rate::R2X2)
    );
    assert_eq!(
        run([0.0; 2], 0.25, false).sri,
        Sri::uniform(32, 16, Rate::R1X1),
        "E36"
    );
    for hidden in [0.3, 0.2, f32::NAN, -1.0, 2.0] {
        let found = run([0.0; 2], hidden, true);
        assert_eq!(found.sri, Sri::uniform(32, 16, Rate::R1X1), "E34: {hidden}");
        assert_eq!(found.reasons[0], Reason::Disoccluded as u8);
    }
    assert_eq!(
        run([0.0; 2], 0.26, true).sri,
        Sri::uniform(32, 16, Rate::R2X2)
    );
    for far in [1e30, f32::NAN, f32::INFINITY, -1e9] {
        assert_eq!(
            run([far, 0.0], 0.25, true).sri,
            Sri::uniform(32, 16, Rate::R1X1),
            "E33: {far}"
        );
    }
    // what came from the left border has no past
    let found = run([4.0, 0.0], 0.25, true);
    assert_eq!(found.sri.code(0, 0), 0);
    assert_eq!(found.reasons[0], Reason::OffScreen as u8);
    assert_eq!(found.sri.code(3, 0), Rate::R2X2.code());
}

#[test]
fn motion_makes_coarse_and_a_single_still_pixel_keeps_fine() {
    // E32: the least speed of a window counts
    let size = [32, 32];
    let picture = random(size, 90, &mut rng());
    let still = vec![[0.0f32; 2]; 1024];
    let mut fast = vec![[6.0f32, 0.0]; 1024];
    let settings = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let run = |motion: &[[f32; 2]]| {
        let inputs = Inputs {
            motion: Some(motion),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        compare(&inputs, &settings);
        integer::analyse(&inputs, &settings).expect("inputs").sri
    };
    let plain = integer::analyse(
        &Inputs::of_colour(size, Colour::Codes(&picture)),
        &Settings::default(),
    )
    .expect("inputs")
    .sri;
    assert_eq!(run(&still), plain, "neutral");
    let moving = run(&fast);
    let coarser = |sri: &Sri| {
        (0..256)
            .filter(|q| sri.code(q % 16, q / 16) >> 2 > 0)
            .count()
    };
    assert!(coarser(&moving) > coarser(&plain));
    for vector in fast.iter_mut().step_by(2) {
        *vector = [f32::NAN, 0.0];
    }
    assert_eq!(run(&fast), plain, "what is no speed is none");
}

#[test]
fn e15_e16_hysteresis_settles_where_the_bare_loop_swings() {
    // a ramp near its threshold, shaded at the rates that it gets, by copies of each group's first pixel
    for norm in [Norm::L1, Norm::L2, Norm::LInf] {
        let mut flips = [0, 0, 0];
        for step in 0..24 {
            let slope = 0.5 + f64::from(step) / 16.0;
            for (index, stability) in [
                Stability::None,
                Stability::Hysteresis,
                Stability::Compensate,
            ]
            .into_iter()
            .enumerate()
            {
                flips[index] += closed_loop(norm, stability, slope);
            }
        }
        println!(
            "{norm:?}: flips in frames 32 to 64 without, with hysteresis, compensated: {flips:?}"
        );
        assert_eq!(flips[1], 0, "{norm:?}: {flips:?}");
        if norm == Norm::LInf {
            assert!(
                flips[0] > 0,
                "{norm:?}: the bare loop should swing: {flips:?}"
            );
        }
    }
}

/// Flips of the last 32 of 64 frames of a horizontal ramp at E / τ = `slope` in the middle.
fn closed_loop(norm: Norm, stability: Stability, slope: f64) -> usize {
    let size = [32u32, 4];
    let step = 2.0 * 0.15 * (0.5 + 0.05) * slope / 8.0;
    let truth: Vec<f32> = (0..128u32)
        .map(|i| (0.5 + step * (f64::from(i % 32) - 16.0) / 4.0) as f32)
        .collect();
    let content = Content {
        norm,
        threshold: 0.15 / 32.0,
        ..Content::default()
    };
    let settings = Settings {
        content,
        stability,
        ..Settings::default()
    };
    let mut rates = Sri::uniform(32, 4, Rate::R1X1);
    let mut flips = 0;
    for frame in 0..64 {
        let shaded: Vec<[f32; 4]> = (0..128u32)
            .map(|i| {
                let (x, y) = (i % 32, i / 32);
                let rate = rates.rate(x / 2, y / 2, Rate::R2X2);
                let from = (y & !(rate.height() - 1)) * 32 + (x & !(rate.width() - 1));
                [truth[from as usize]; 4]
            })
            .collect();
        let inputs = Inputs {
            previous_rates: Some(&rates),
            ..Inputs::of_colour(size, Colour::Linear(&shaded))
        };
        let next = integer::analyse(&inputs, &settings).expect("inputs").sri;
        if frame >= 32 {
            flips += (0..32)
                .filter(|q| next.code(q % 16, q / 16) != rates.code(q % 16, q / 16))
                .count();
        }
        rates = next;
    }
    flips
}

#[test]
fn e36_a_change_of_resolution_rescales_history() {
    // the left half plain, the right half striped, at two resolutions
    let picture = |width: u32, height: u32| -> Vec<[u8; 4]> {
        (0..width * height)
            .map(|i| match i % width < width / 2 {
                true => [120; 4],
                false => [(i / width % 2 * 255) as u8; 4],
            })
            .collect()
    };
    let before = picture(32, 16);
    let inputs = Inputs {
        size: [64, 32],
        previous_size: [32, 16],
        ..Inputs::of_colour([32, 16], Colour::Codes(&before))
    };
    let found = integer::analyse(&inputs, &Settings::default()).expect("inputs");
    for y in 0..16 {
        assert_eq!(found.sri.code(3, y), Rate::R2X2.code());
        assert_eq!(found.sri.code(28, y), Rate::R2X1.code(), "row {y}");
    }
}

#[test]
fn a_later_blur_counts_as_motion_of_its_width() {
    let size = [32, 32];
    let picture = random(size, 90, &mut rng());
    let (still, moving) = (vec![[0.0f32; 2]; 1024], vec![[6.0f32; 2]; 1024]);
    let run = |motion: &[[f32; 2]], blur: f32| {
        let blur = vec![blur; 1024];
        let inputs = Inputs {
            motion: Some(motion),
            blur: Some(&blur),
            ..Inputs::of_colour(size, Colour::Codes(&picture))
        };
        let settings = Settings {
            motion: Some(Motion::default()),
            later_blur: true,
            ..Settings::default()
        };
        integer::analyse(&inputs, &settings).expect("inputs").sri
    };
    assert_eq!(run(&still, 6.0), run(&moving, 0.0));
    assert_ne!(run(&still, 6.0), run(&still, 0.0));
    assert_eq!(
        run(&still, f32::NAN),
        run(&still, 0.0),
        "no number hides nothing"
    );
}
