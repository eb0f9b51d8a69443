//! Kernels bind what their plan says.

use super::*;

/// The numbers of the resources that a module binds.
fn bound(module: &naga::Module) -> Vec<u32> {
    let mut numbers: Vec<u32> = module
        .global_variables
        .iter()
        .filter_map(|(_, global)| global.binding.as_ref().map(|binding| binding.binding))
        .collect();
    numbers.sort_unstable();
    numbers
}

// what is not declared is not even in the text that is compiled: counted in the composed modules, for each effect alone and for all
#[test]
fn kernels_bind_what_their_plan_says_and_nothing_else() {
    use crate::{
        kernel::{compose, shader},
        plan::{Binding, Plan, Scene},
    };
    let everything = Scene {
        after_transparents: true,
        motion: true,
        depth: true,
        previous_rates: true,
        materials: true,
        noise: true,
        ids: true,
        flags: true,
        blur: true,
        attachment: true,
        sqrt_luma: true,
        reasons: true,
        ..Scene::default()
    };
    let bare = Scene {
        flags: false,
        attachment: false,
        sqrt_luma: false,
        reasons: false,
        ..everything
    };
    let motion = Settings {
        motion: Some(Motion::default()),
        ..Settings::default()
    };
    let own = crate::analyse::OwnRates {
        ids: Some(crate::analyse::own::IdRates::default()),
        ..crate::analyse::OwnRates::default()
    };
    let plans = [
        (bare, Settings::default(), 4),
        (bare, motion.clone(), 5),
        (
            bare,
            Settings {
                later_blur: true,
                ..motion.clone()
            },
            6,
        ),
        (
            bare,
            Settings {
                reprojection: Some(Reprojection::default()),
                ..motion.clone()
            },
            7,
        ),
        (
            bare,
            Settings {
                materials: Some(Materials::default()),
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                half_rate: Some(HalfRate::default()),
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                transparents: true,
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                stability: Stability::Hysteresis,
                ..Settings::default()
            },
            5,
        ),
        (
            bare,
            Settings {
                foveation: Some(Foveation::default()),
                safe_area: Some(SafeArea::default()),
                ..Settings::default()
            },
            4,
        ),
        (
            bare,
            Settings {
                granularity: Granularity::Tile16,
                ..Settings::default()
            },
            4,
        ),
        (
            everything,
            Settings {
                attachment: Granularity::Quad,
                ..Settings::default()
            },
            8,
        ),
        (everything, Settings::default(), 8),
        (
            everything,
            Settings {
                own: Some(own),
                half_resolution: Some(crate::analyse::HalfResolution::Code),
                ..Settings::default()
            },
            8,
        ),
    ];
    for (scene, settings, count) in plans {
        let plan = Plan::new(&scene, &settings).expect("what it asks for is declared");
        let mut wanted: Vec<u32> = plan.bindings.iter().map(|b| b.index()).collect();
        wanted.sort_unstable();
        // the luma's kernel shares the group
        let first = match settings.granularity {
            Granularity::Quad => plan.kernel(),
            _ => shader!("tiles.wgsl"),
        };
        let mut found = bound(&compose(first, &plan.defs()));
        if plan.has_attachment_of_its_own() {
            // and so does that of the attachment's tiles, which has no other output
            let of_tiles = bound(&compose(shader!("tiles.wgsl"), &plan.defs_of_attachment()));
            for output in [Binding::Rates, Binding::Reasons, Binding::PlainRates] {
                assert!(!of_tiles.contains(&output.index()), "{plan}");
            }
            assert!(!found.contains(&Binding::Attachment.index()), "{plan}");
            found.extend(of_tiles);
        }
        if plan.pass("write_luma.wgsl").is_some() {
            found.extend(bound(&compose(shader!("write_luma.wgsl"), &plan.defs())));
        }
        found.sort_unstable();
        found.dedup();
        assert_eq!(found, wanted, "{plan}");
        assert_eq!(wanted.len(), count, "{plan}");
        for (name, source) in [
            ("own.wgsl", shader!("own.wgsl")),
            ("half.wgsl", shader!("half.wgsl")),
        ] {
            if let Some(pass) = plan.pass(name) {
                let defs: Vec<_> = pass.effects.iter().map(|&name| (name, 1)).collect();
                let found = bound(&compose(source, &defs));
                assert_eq!(found.len(), pass.bindings, "{name}: {plan}");
            }
        }
    }
}
