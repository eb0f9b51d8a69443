//! The effects that a scene declares: for each, the preset that they are measured on without it.

use super::setting::{DeblockName, HysteresisName, Setting, SharingName, presets};
use crate::scenes::SceneName;

/// The preset that effects are measured on.
pub const BASE: &str = "Balanced";

/// That preset's setting.
pub fn base() -> Setting {
    match presets().into_iter().find(|preset| preset.name == BASE) {
        Some(preset) => preset.setting,
        None => unreachable!("there is such a preset"),
    }
}

/// The names of all effects.
pub const NAMES: [&str; 8] = [
    "motion",
    "materials",
    "ids and depth",
    "grain",
    "transparents",
    "sky",
    "hysteresis",
    "deblocking",
];

/// A setting without an effect.
pub fn without(effect: &str, setting: &Setting) -> Setting {
    let mut setting = setting.clone();
    match effect {
        "motion" => setting.motion = false,
        "materials" => setting.materials = false,
        "ids and depth" => setting.sharing = SharingName::Rate,
        "grain" => setting.grain = false,
        "transparents" => setting.transparents = false,
        "sky" => setting.sky = false,
        "hysteresis" => setting.hysteresis = HysteresisName::Off,
        "deblocking" => setting.deblock = DeblockName::Off,
        _ => {}
    }
    setting
}

/// Each effect that runs for a scene at that preset, by name, and the preset without it.
pub fn effects(scene: SceneName) -> Vec<(&'static str, Setting)> {
    let base = base();
    let declared = scene.declared();
    let is_there = |effect: &str| match effect {
        "motion" => declared.motion_vectors || declared.camera_motion,
        "materials" => declared.materials,
        "ids and depth" => declared.surface_ids || declared.triangle_ids || declared.depth,
        "grain" => declared.grain,
        "transparents" => declared.transparents,
        "sky" => declared.sky,
        _ => true,
    };
    let there = NAMES.into_iter().filter(|name| is_there(name));
    there
        .map(|name| (name, without(name, &base)))
        .filter(|(_, setting)| *setting != base)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_can_be_left_out() {
        for name in NAMES {
            assert_ne!(
                without(name, &Setting::default()),
                Setting::default(),
                "{name}"
            );
        }
    }

    #[test]
    fn a_scene_has_the_effects_that_it_declares() {
        let names = |scene| -> Vec<&str> {
            let all = effects(scene);
            all.into_iter().map(|(name, _)| name).collect()
        };
        assert!(!names(SceneName::Ramps).contains(&"ids and depth"));
        assert!(!names(SceneName::Text).contains(&"motion"));
        assert!(names(SceneName::Interior).contains(&"materials"));
        assert!(names(SceneName::Landscape).contains(&"grain"));
    }
}
