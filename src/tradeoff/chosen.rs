//! A file of the presets that were chosen for scenes: TOML, a table for each scene and preset.
//!
//! ```toml
//! [foliage.Balanced]
//! threshold = 0.075
//! motion = false
//! full_rate = ["composite"]
//! ```
//!
//! *Guarantees*: what is written is read as the same settings. *Refuses*: scenes, presets, settings and values that do not exist.

use toml::{Table, Value};

use super::{
    setting::{Setting, presets},
    study::{Chosen, SceneStudy, Study},
    sweep::{self, SweepError},
};
use crate::scenes::{SceneName, UnknownScene};

/// Why there is no such preset in a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChosenError {
    /// The file is not TOML, or a setting or its value does not exist.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A scene does not exist.
    #[error(transparent)]
    Scene(#[from] UnknownScene),
    /// A preset does not exist.
    #[error("no preset is called `{0}`; there are Exact, Balanced and Fast")]
    Preset(String),
    /// A part has the wrong form.
    #[error("`{0}` has to be a table: [SCENE.PRESET], and settings below it")]
    Form(String),
    /// The file does not have what is asked for.
    #[error("it has no [{scene}.{preset}]: `vrcs tradeoff {scene}` writes one")]
    Missing {
        /// The scene.
        scene: SceneName,
        /// The preset.
        preset: String,
    },
}

/// The file of a study: every preset that was chosen, and why.
pub fn toml(study: &Study) -> String {
    let mut text = format!(
        "# Presets for each scene: of what `{}` measured on {}\n# at {}x{}, what takes the least time and gives up no more than the \
         general preset of that name.\n#\n# vrcs plan SCENE --presets FILE    what runs\n# vrcs demo SCENE --presets FILE    how it looks\n",
        study.command, study.adapter, study.size[0], study.size[1]
    );
    for scene in &study.scenes {
        for chosen in &scene.chosen {
            text += &table(scene, chosen);
        }
    }
    text
}

fn table(scene: &SceneStudy, chosen: &Chosen) -> String {
    let mut text = format!("\n[{}.{}]\n", scene.name, chosen.preset);
    for sentence in &chosen.because {
        text += &format!("# {sentence}\n");
    }
    let Some(point) = scene.points.get(chosen.point) else {
        return text;
    };
    for (key, value) in point.setting.said() {
        text += &format!("{key} = {value}\n");
    }
    text
}

/// A scene's preset in such a file.
///
/// # Errors
/// If the file is none, or has no such preset.
pub fn read(text: &str, scene: SceneName, preset: &str) -> Result<Setting, ChosenError> {
    let file = sweep::table_of(text)?;
    let mut found = None;
    for (scene_name, tables) in &file {
        let known: SceneName = scene_name.parse()?;
        let Value::Table(tables) = tables else {
            return Err(ChosenError::Form(scene_name.clone()));
        };
        for (name, settings) in tables {
            if !presets().iter().any(|known| known.name == name) {
                return Err(ChosenError::Preset(name.clone()));
            }
            let Value::Table(settings) = settings else {
                return Err(ChosenError::Form(format!("{scene_name}.{name}")));
            };
            let setting = setting(settings)?;
            if known == scene && name.eq_ignore_ascii_case(preset) {
                found = Some(setting);
            }
        }
    }
    found.ok_or_else(|| ChosenError::Missing {
        scene,
        preset: preset.to_owned(),
    })
}

fn setting(settings: &Table) -> Result<Setting, SweepError> {
    sweep::with(settings, &[])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scenes::PassName,
        tradeoff::study::{Point, Seen, Times},
    };

    fn study(settings: Vec<Setting>) -> Study {
        let chosen = settings.iter().enumerate().map(|(point, _)| Chosen {
            preset: presets()[point].name.to_owned(),
            point,
            because: vec!["It is.".to_owned()],
            plan: Vec::new(),
        });
        let scene = SceneStudy {
            name: "foliage".to_owned(),
            chosen: chosen.collect(),
            points: settings
                .into_iter()
                .map(|setting| Point {
                    name: String::new(),
                    preset: None,
                    peer: false,
                    settings: String::new(),
                    setting,
                    gives_up: None,
                    seen: Seen::default(),
                    time: Times::default(),
                    pictures: Default::default(),
                })
                .collect(),
            ..SceneStudy::default()
        };
        Study {
            adapter: "a card".to_owned(),
            size: [64, 32],
            frames: 1,
            compared: 1,
            rounds: 1,
            seed: 1,
            command: "vrcs tradeoff".to_owned(),
            note: String::new(),
            legends: Default::default(),
            summary: None,
            unfinished: None,
            scenes: vec![scene],
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let settings = vec![
            Setting::untouched(),
            Setting::default(),
            Setting {
                motion: false,
                threshold: 0.3,
                full_rate: vec![PassName::Composite, PassName::Material],
                ..Setting::default()
            },
        ];
        let text = toml(&study(settings.clone()));
        for (preset, setting) in presets().iter().zip(settings) {
            let found = read(&text, SceneName::Foliage, preset.name).expect("a preset");
            assert_eq!(found, setting, "{text}");
        }
        let missing = read(&text, SceneName::Text, "Fast").expect_err("not there");
        assert!(missing.to_string().contains("[text.Fast]"), "{missing}");
    }

    #[test]
    fn what_does_not_exist_is_named() {
        for (text, said) in [
            ("[forest.Fast]\n", "forest"),
            ("[foliage.Quick]\n", "Quick"),
            ("[foliage.Fast]\nthreshhold = 1\n", "threshhold"),
            ("[foliage.Fast]\nfull_rate = [\"shadow\"]\n", "full_rate"),
            ("[foliage.Fast]\nthreshold = -1.0\n", "0 or more"),
            ("foliage = 1\n", "foliage"),
            ("[foliage\n", "line 1"),
        ] {
            let error = read(text, SceneName::Foliage, "Fast").expect_err(text);
            assert!(error.to_string().contains(said), "{text}: {error}");
        }
    }
}
