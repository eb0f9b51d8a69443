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

/// Each effect that runs for a scene at that preset, by name, and the preset without it.
pub fn effects(scene: SceneName) -> Vec<(&'static str, Setting)> {
    let base = base();
    let declared = scene.declared();
    let has_motion = declared.motion_vectors || declared.camera_motion;
    let tells_surfaces = declared.surface_ids || declared.triangle_ids || declared.depth;
    let all = [
        (
            "motion",
            has_motion,
            Setting {
                motion: false,
                ..base.clone()
            },
        ),
        (
            "materials",
            declared.materials,
            Setting {
                materials: false,
                ..base.clone()
            },
        ),
        (
            "ids and depth",
            tells_surfaces,
            Setting {
                sharing: SharingName::Rate,
                ..base.clone()
            },
        ),
        (
            "grain",
            declared.grain,
            Setting {
                grain: false,
                ..base.clone()
            },
        ),
        (
            "sky",
            declared.sky,
            Setting {
                sky: false,
                ..base.clone()
            },
        ),
        (
            "hysteresis",
            true,
            Setting {
                hysteresis: HysteresisName::Off,
                ..base.clone()
            },
        ),
        (
            "deblocking",
            true,
            Setting {
                deblock: DeblockName::Off,
                ..base.clone()
            },
        ),
    ];
    all.into_iter()
        .filter(|(_, is_there, setting)| *is_there && *setting != base)
        .map(|(name, _, setting)| (name, setting))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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
