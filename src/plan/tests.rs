//! Plans are what scenes and settings call for.

use super::*;
use crate::analyse::settings::{
    Blur, Foveation, HalfRate, Ladder, Motion, Reprojection, SafeArea, Stability,
};

#[test]
fn nothing_that_is_not_called_for_is_there() {
    let everything = Scene {
        motion: true,
        depth: true,
        materials: true,
        noise: true,
        previous_rates: true,
        after_transparents: true,
        ..Scene::default()
    };
    for scene in [Scene::default(), everything] {
        let plan = Plan::new(&scene, &Settings::default()).expect("a plan");
        assert_eq!((plan.passes.len(), plan.bindings.len()), (1, 4), "{plan}");
        assert_eq!(plan.passes[0].effects, ["CODES"]);
    }
}

#[test]
fn an_effect_adds_its_own_bindings_and_no_others() {
    let scene = Scene {
        motion: true,
        depth: true,
        flags: true,
        ..Scene::default()
    };
    let settings = Settings {
        motion: Some(Motion::default()),
        reprojection: Some(Reprojection::default()),
        smoothing: Smoothing::Limit,
        ..Settings::default()
    };
    let plan = Plan::new(&scene, &settings).expect("a plan");
    let names: Vec<&str> = plan.bindings[4..].iter().map(|b| b.name()).collect();
    assert_eq!(
        names,
        ["motion vectors", "depth", "previous depth", "flags"]
    );
    assert_eq!(plan.passes.len(), 2);
    assert_eq!(plan.to_json()["passes"][1]["kernel"], "smooth.wgsl");
}

#[test]
fn more_storage_buffers_than_a_device_binds_are_refused_by_name() {
    let everything = Scene {
        colour: ColourForm::SqrtLuma,
        after_transparents: true,
        previous_rates: true,
        attachment: true,
        reasons: true,
        ..Scene::default()
    };
    let settings = Settings {
        transparents: true,
        stability: Stability::Hysteresis,
        ..Settings::default()
    };
    let plan = Plan::new(&everything, &settings).expect("the most there is fits");
    let error = plan.within(6).expect_err("seven").to_string();
    assert!(
        error.starts_with("the plan binds 7 storage buffers (tables, rates, colour"),
        "{error}"
    );
    let least = Plan::new(&Scene::default(), &Settings::default()).expect("a plan");
    assert_eq!(least.within(2), Ok(()), "tables and rates");
    assert!(least.within(1).is_err());
}

#[test]
fn settings_that_the_scene_cannot_serve_are_refused_by_name() {
    let settings = Settings {
        transparents: true,
        ..Settings::default()
    };
    let error = Plan::new(&Scene::default(), &settings).expect_err("no picture after transparents");
    assert_eq!(
        error.to_string(),
        "transparents needs the colour after transparents, which the scene does not declare"
    );
}

#[test]
fn what_content_tolerates_is_refused_where_motion_alone_decides() {
    let scene = Scene {
        motion: true,
        after_transparents: true,
        previous_rates: true,
        noise: true,
        ..Scene::default()
    };
    type Effect = (&'static str, fn(&mut Settings));
    let effects: [Effect; 6] = [
        ("stability", |s| s.stability = Stability::Hysteresis),
        ("the extra half rate", |s| {
            s.half_rate = Some(HalfRate::default())
        }),
        ("transparents", |s| s.transparents = true),
        ("foveation", |s| s.foveation = Some(Foveation::default())),
        ("quality overshoot", |s| s.overshoot = vec![[1.0, 0.5]]),
        ("a safe area", |s| s.safe_area = Some(SafeArea::default())),
    ];
    for blur in [
        Blur::Standalone { error: 0.1 },
        Blur::Ladder(Ladder::default()),
    ] {
        for (name, set) in effects {
            let mut settings = Settings {
                motion: Some(Motion {
                    blur,
                    ..Motion::default()
                }),
                ..Settings::default()
            };
            assert!(Plan::new(&scene, &settings).is_ok());
            set(&mut settings);
            assert_eq!(
                Plan::new(&scene, &settings),
                Err(PlanError::MotionAlone(name))
            );
            settings.motion = Some(Motion::default());
            assert!(Plan::new(&scene, &settings).is_ok(), "{name} by content");
        }
    }
}
