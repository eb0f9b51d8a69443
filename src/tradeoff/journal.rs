//! What is finished, on disk, so that an interrupted study keeps what it had and goes on from there.
//!
//! *Does*: appends what was found to `points.jsonl`, a line each: how a setting looks; the times of settings that were timed together;
//! the truth of a scene. *Guarantees*: there is no file before there is a line; a line that was cut off by an interruption is passed
//! over; findings of another device, size, length or seed are never mixed in, for each line carries what it was measured with.

use std::{
    fs::{File, OpenOptions},
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    setting::Setting,
    study::{Effect, Seen, Times, Truth},
};

/// What a point was measured with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct With {
    /// The driver.
    pub adapter: String,
    /// The build of this program.
    pub build: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Frames of each point.
    pub frames: u32,
    /// Of these so many are compared.
    pub compared: u32,
    /// Timed frames of each point.
    pub rounds: u32,
    /// Where all chance comes from.
    pub seed: u64,
}

/// Something that was found of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Found {
    /// How a setting looks.
    Look {
        /// The setting.
        setting: Setting,
        /// What was seen.
        seen: Seen,
    },
    /// What settings that were timed together take, and the effects among them.
    Times {
        /// Each setting and its times.
        times: Vec<(Setting, Times)>,
        /// The effects.
        effects: Vec<Effect>,
    },
    /// How far the analyses are from the truth.
    Truth(Truth),
}

#[derive(Serialize, Deserialize)]
struct Line {
    with: With,
    scene: String,
    found: Found,
}

/// A journal of what was found.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: Option<File>,
    with: With,
    is_cut: bool,
    known: Vec<(String, Found)>,
}

impl Journal {
    /// Reads the journal in a folder, if there is one.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn open(folder: &Path, with: With) -> std::io::Result<Journal> {
        let path = folder.join("points.jsonl");
        let mut known = Vec::new();
        let mut is_cut = false;
        if path.exists() {
            for line in BufReader::new(File::open(&path)?).split(b'\n') {
                let line = line?;
                match serde_json::from_slice::<Line>(&line) {
                    Ok(line) if line.with == with => known.push((line.scene, line.found)),
                    Ok(_) => {}
                    Err(_) => is_cut |= !line.is_empty(),
                }
            }
        }
        Ok(Journal {
            path,
            file: None,
            with,
            is_cut,
            known,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is known of a scene.
    fn of(&self, scene: &str) -> impl Iterator<Item = &Found> {
        let known = self.known.iter().filter(move |(of, _)| of == scene);
        known.map(|(_, found)| found)
    }

    /// How a setting looked.
    pub fn look(&self, scene: &str, wanted: &Setting) -> Option<&Seen> {
        self.of(scene).find_map(|found| match found {
            Found::Look { setting, seen } if setting == wanted => Some(seen),
            _ => None,
        })
    }

    /// What a setting took.
    pub fn times(&self, scene: &str, wanted: &Setting) -> Option<&Times> {
        self.of(scene).find_map(|found| match found {
            Found::Times { times, .. } => times
                .iter()
                .find(|(setting, _)| setting == wanted)
                .map(|(_, times)| times),
            _ => None,
        })
    }

    /// What the effects of a scene add, if they were found.
    pub fn effects(&self, scene: &str) -> Vec<Effect> {
        let effects = self.of(scene).find_map(|found| match found {
            Found::Times { effects, .. } if !effects.is_empty() => Some(effects.clone()),
            _ => None,
        });
        effects.unwrap_or_default()
    }

    /// The truth of a scene.
    pub fn truth(&self, scene: &str) -> Option<&Truth> {
        self.of(scene).find_map(|found| match found {
            Found::Truth(truth) => Some(truth),
            _ => None,
        })
    }

    /// Notes what was found, and has it on disk before it returns.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn note(&mut self, scene: &str, found: Found) -> std::io::Result<()> {
        let line = Line {
            with: self.with.clone(),
            scene: scene.to_owned(),
            found,
        };
        let mut bytes = serde_json::to_vec(&line)?;
        bytes.push(b'\n');
        let is_cut = std::mem::take(&mut self.is_cut);
        let file = self.file()?;
        if is_cut {
            // what follows must not be glued to a line that was cut off
            file.write_all(b"\n")?;
        }
        file.write_all(&bytes)?;
        file.sync_data()?;
        self.known.push((line.scene, line.found));
        Ok(())
    }

    fn file(&mut self) -> std::io::Result<&mut File> {
        let file = match self.file.take() {
            Some(file) => file,
            None => {
                if let Some(folder) = self.path.parent() {
                    std::fs::create_dir_all(folder)?;
                }
                OpenOptions::new()
                    .create(true)
                    .append(true)
                    .open(&self.path)?
            }
        };
        Ok(self.file.insert(file))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with() -> With {
        With {
            adapter: "a driver".to_owned(),
            build: "1".to_owned(),
            size: [64, 32],
            frames: 4,
            compared: 4,
            rounds: 3,
            seed: 9,
        }
    }

    fn setting(threshold: f64) -> Setting {
        Setting {
            threshold,
            ..Setting::default()
        }
    }

    fn look(threshold: f64) -> Found {
        Found::Look {
            setting: setting(threshold),
            seen: Seen {
                primary_share: threshold,
                ..Seen::default()
            },
        }
    }

    #[test]
    fn before_anything_is_found_there_is_no_file_and_no_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let inner = folder.path().join("out");
        let journal = Journal::open(&inner, with()).expect("a journal");
        assert!(journal.look("text", &setting(0.1)).is_none() && !inner.exists());
    }

    #[test]
    fn what_was_finished_is_found_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(&folder.path().join("out"), with()).expect("a journal");
        journal.note("text", look(0.1)).expect("written");
        let times = Found::Times {
            times: vec![
                (setting(0.1), Times::default()),
                (setting(0.3), Times::default()),
            ],
            effects: vec![Effect::default()],
        };
        journal.note("text", times).expect("written");
        drop(journal);
        let journal = Journal::open(&folder.path().join("out"), with()).expect("a journal");
        let seen = journal.look("text", &setting(0.1)).expect("a look");
        assert_eq!(seen.primary_share, 0.1);
        assert!(journal.look("text", &setting(0.2)).is_none());
        assert!(journal.look("ramps", &setting(0.1)).is_none());
        assert!(journal.times("text", &setting(0.3)).is_some());
        assert!(journal.times("text", &setting(0.2)).is_none());
        assert_eq!(journal.effects("text").len(), 1);
        assert!(journal.effects("ramps").is_empty() && journal.truth("text").is_none());
    }

    #[test]
    fn a_line_that_was_cut_off_is_passed_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        journal.note("text", look(0.1)).expect("written");
        journal.note("text", look(0.2)).expect("written");
        let path = journal.path().to_owned();
        drop(journal);
        let bytes = std::fs::read(&path).expect("a file");
        std::fs::write(&path, &bytes[..bytes.len() - 20]).expect("cut");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        assert!(journal.look("text", &setting(0.1)).is_some());
        assert!(journal.look("text", &setting(0.2)).is_none());
        journal.note("text", look(0.3)).expect("written");
        drop(journal);
        let journal = Journal::open(folder.path(), with()).expect("a journal");
        let again = journal.look("text", &setting(0.3));
        assert!(again.is_some(), "not glued to the cut line");
    }

    #[test]
    fn findings_of_another_size_are_not_mixed_in() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        journal.note("text", look(0.1)).expect("written");
        drop(journal);
        let other = With {
            size: [32, 32],
            ..with()
        };
        let journal = Journal::open(folder.path(), other).expect("a journal");
        assert!(journal.look("text", &setting(0.1)).is_none());
    }
}
