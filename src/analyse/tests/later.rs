//! What comes to the content: the extra half rate, noise, materials, transparents.

use super::*;

#[test]
fn e38_the_extra_half_rate_is_never_full_and_never_coarser() {
    for code in Rate::ALL
        .into_iter()
        .filter(|rate| Rate::R2X2.is_within(*rate))
    {
        for second in 0..9u8 {
            for error in [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]] {
                let rate = [code.code() >> 2, code.code() & 3];
                let out = crate::analyse::decide::half_rate(rate, [second / 3, second % 3], || {
                    error[0] <= error[1]
                });
                let out = Rate::from_code(out[0] << 2 | out[1]).expect("a rate, so no 4x1");
                assert!(
                    out.is_within(code) && out != Rate::R1X1,
                    "{code} {second} {out}"
                );
            }
        }
    }
}

#[test]
fn the_extra_half_rate_leaves_the_attachment_alone_and_heeds_noise_and_materials() {
    let picture: Vec<[f32; 4]> = (0..256u32)
        .map(|i| [0.3 + 0.012 * (i % 16) as f32 + 0.009 * (i / 16) as f32; 4])
        .collect();
    let settings = Settings {
        half_rate: Some(HalfRate {
            tolerance: 0.02,
            ..HalfRate::default()
        }),
        ..Settings::default()
    };
    let run = |noise: Option<&[u8]>, flags: Option<&[u8]>| {
        let inputs = Inputs {
            noise,
            flags,
            ..Inputs::of_colour([16, 16], Colour::Linear(&picture))
        };
        let [a, b] = twins(&inputs, &settings);
        let is_masked = flags.is_some_and(|all| all[0] & flags::FULL != 0);
        let wanted = if is_masked { Rate::R1X1 } else { Rate::R2X2 };
        assert_eq!(
            a.attachment,
            Sri::uniform(16, 16, wanted),
            "no half rate in the attachment"
        );
        assert_eq!(a.sri, b.sri);
        a.sri
    };
    let boosted = run(None, None);
    assert!(
        (0..64).all(|q| [1, 4].contains(&boosted.code(q % 8, q / 8))),
        "{boosted:?}"
    );
    assert_eq!(run(Some(&[255; 256]), None), boosted);
    assert_eq!(
        run(Some(&[0; 256]), None),
        Sri::uniform(16, 16, Rate::R2X2),
        "no noise here"
    );
    assert_eq!(
        run(None, Some(&[flags::NO_HALF_RATE; 256])),
        Sri::uniform(16, 16, Rate::R2X2),
        "foliage"
    );
    assert_eq!(run(None, Some(&[flags::FULL; 256])).code(3, 3), 0, "masked");
}

#[test]
fn e39_transparents_make_solids_coarser_and_never_finer() {
    let mut rng = rng();
    let size = [32, 32];
    let (before, after) = (natural(size, 0.8, &mut rng), natural(size, 0.5, &mut rng));
    let alone = |picture: &[[u8; 4]]| {
        integer::analyse(
            &Inputs::of_colour(size, Colour::Codes(picture)),
            &Settings::default(),
        )
        .expect("inputs")
    };
    let inputs = Inputs {
        after: Some(Colour::Codes(&after)),
        ..Inputs::of_colour(size, Colour::Codes(&before))
    };
    let both = integer::analyse(
        &inputs,
        &Settings {
            transparents: true,
            ..Settings::default()
        },
    )
    .expect("inputs");
    let (solid, seen) = (alone(&before), alone(&after));
    assert_eq!(both.attachment, seen.attachment);
    for q in 0..256 {
        let rate = |sri: &Sri| Rate::from_code_or_full(sri.code(q % 16, q / 16));
        assert_eq!(rate(&both.sri), rate(&solid.sri).join(rate(&seen.sri)));
    }
}
