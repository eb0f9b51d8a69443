//! Finished points on disk, so that an interrupted study keeps what it had and goes on from there.
//!
//! *Does*: appends each finished point to `points.jsonl`, a line each. *Guarantees*: a line that was cut off by an
//! interruption is passed over; points of another device, size, length or seed are never mixed in, for each line carries
//! what it was measured with.

use std::{
    fs::{File, OpenOptions},
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{setting::Setting, study::Point};

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
    /// Timed frames of each point.
    pub rounds: u32,
    /// Where all chance comes from.
    pub seed: u64,
}

#[derive(Serialize, Deserialize)]
struct Line {
    with: With,
    scene: String,
    point: Point,
}

/// A journal of finished points.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    with: With,
    known: Vec<(String, Point)>,
}

impl Journal {
    /// Opens the journal in a folder, or starts one.
    ///
    /// # Errors
    /// If the file can be neither read nor written.
    pub fn open(folder: &Path, with: With) -> std::io::Result<Journal> {
        let path = folder.join("points.jsonl");
        let mut known = Vec::new();
        let mut is_cut = false;
        if path.exists() {
            for line in BufReader::new(File::open(&path)?).split(b'\n') {
                let line = line?;
                match serde_json::from_slice::<Line>(&line) {
                    Ok(line) if line.with == with => known.push((line.scene, line.point)),
                    Ok(_) => {}
                    Err(_) => is_cut |= !line.is_empty(),
                }
            }
        }
        let mut file = OpenOptions::new().create(true).append(true).open(&path)?;
        if is_cut {
            // what follows must not be glued to a line that was cut off
            file.write_all(b"\n")?;
        }
        Ok(Journal {
            path,
            file,
            with,
            known,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A point that was finished before.
    pub fn find(&self, scene: &str, setting: &Setting) -> Option<&Point> {
        self.known
            .iter()
            .find(|(of, point)| of == scene && point.setting == *setting)
            .map(|(_, point)| point)
    }

    /// Notes a finished point, and has it on disk before it returns.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn note(&mut self, scene: &str, point: &Point) -> std::io::Result<()> {
        let line = Line {
            with: self.with.clone(),
            scene: scene.to_owned(),
            point: point.clone(),
        };
        let mut bytes = serde_json::to_vec(&line)?;
        bytes.push(b'\n');
        self.file.write_all(&bytes)?;
        self.file.sync_data()?;
        self.known.push((line.scene, line.point));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::study::{Errors, Times},
        *,
    };

    fn with() -> With {
        With {
            adapter: "a driver".to_owned(),
            build: "1".to_owned(),
            size: [64, 32],
            frames: 4,
            rounds: 3,
            seed: 9,
        }
    }

    fn point(threshold: f64) -> Point {
        Point {
            name: "one".to_owned(),
            preset: None,
            peer: false,
            settings: String::new(),
            setting: Setting {
                threshold,
                ..Setting::default()
            },
            gives_up: None,
            identical: false,
            primary_share: 0.5,
            retired_share: 0.25,
            average_rate: 0.5,
            error: Errors::default(),
            time: Times::default(),
            pictures: std::collections::BTreeMap::new(),
        }
    }

    #[test]
    fn what_was_finished_is_found_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        assert_eq!(journal.find("text", &point(0.1).setting), None);
        journal.note("text", &point(0.1)).expect("written");
        drop(journal);
        let journal = Journal::open(folder.path(), with()).expect("a journal");
        assert_eq!(journal.find("text", &point(0.1).setting), Some(&point(0.1)));
        assert_eq!(journal.find("text", &point(0.2).setting), None);
        assert_eq!(journal.find("ramps", &point(0.1).setting), None);
    }

    #[test]
    fn a_line_that_was_cut_off_is_passed_over() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        journal.note("text", &point(0.1)).expect("written");
        journal.note("text", &point(0.2)).expect("written");
        let path = journal.path().to_owned();
        drop(journal);
        let bytes = std::fs::read(&path).expect("a file");
        std::fs::write(&path, &bytes[..bytes.len() - 20]).expect("cut");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        assert!(journal.find("text", &point(0.1).setting).is_some());
        assert!(journal.find("text", &point(0.2).setting).is_none());
        journal.note("text", &point(0.3)).expect("written");
        drop(journal);
        let journal = Journal::open(folder.path(), with()).expect("a journal");
        assert!(
            journal.find("text", &point(0.3).setting).is_some(),
            "not glued to the cut line"
        );
    }

    #[test]
    fn points_of_another_size_are_not_mixed_in() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::open(folder.path(), with()).expect("a journal");
        journal.note("text", &point(0.1)).expect("written");
        drop(journal);
        let other = With {
            size: [32, 32],
            ..with()
        };
        let journal = Journal::open(folder.path(), other).expect("a journal");
        assert_eq!(journal.find("text", &point(0.1).setting), None);
    }
}
