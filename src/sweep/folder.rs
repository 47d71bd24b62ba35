//! The folder of a sweep: `sweep.toml`, a folder for each point, and the tables.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::error::SweepError;
use super::inputs::Inputs;
use super::plan::{Point, Sweep};
use crate::io::atomic::{write_atomically, write_text};
use crate::io::draft::is_draft;
use crate::io::plain::{self, refuse, refuse_others};
use crate::io::{Existing, Folder, FolderState, OutputError, Summary, remove};
use crate::run::Ending;
use crate::scene::read_text;

const SWEEP: &str = "sweep.toml";

const SCENE: &str = "scene.toml";

/// Folder with one file per failed point, which contains the reason and has the name of the point's folder.
const FAILURES: &str = "failures";

const HEADER: &str = "\
# A sweep of Carom: the scene, the overrides for all points, and the axes. Each combination of values on the axes is a run with its own folder.
";

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SweepFile {
    /// Path of the scene, relative to the folder of this file.
    scene: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    checksum: Option<String>,
    /// Overrides for all points, written as `KEY=VALUE`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    set: Vec<String>,
    vary: Vec<String>,
    #[serde(default, skip_serializing_if = "Inputs::is_empty")]
    inputs: Inputs,
}

impl SweepFile {
    fn read(path: &Path) -> Result<Self, SweepError> {
        let text = fs::read_to_string(path).map_err(|source| SweepError::Read { path: path.to_owned(), source })?;
        toml::from_str(&text).map_err(|source| SweepError::File { path: path.to_owned(), source: Box::new(source) })
    }

    fn axes(&self) -> Result<Vec<Axis>, SweepError> {
        Ok(self.vary.iter().map(|axis| axis.parse()).collect::<Result<_, _>>()?)
    }
}

impl Sweep {
    /// Reads a sweep from a file with the keys `scene`, `vary` and `set`.
    ///
    /// # Errors
    /// [`SweepError::Read`] or [`SweepError::File`] if the file cannot be read, [`SweepError::Changed`] if the checksum
    /// of the scene differs, and the errors of [`Sweep::new`].
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, SweepError> {
        let path = path.as_ref();
        let file = SweepFile::read(path)?;
        let set: Vec<(&str, &str)> = file.set.iter().filter_map(|pair| pair.split_once('=')).collect();
        let scene = path.parent().unwrap_or(Path::new("")).join(&file.scene);
        // The scene is a copy in the folder of the sweep, and moves with this folder.
        let is_kept = file.checksum.is_some() && file.scene == SCENE && path.file_name() == Some(OsStr::new(SWEEP));
        let sweep = if is_kept {
            Self::of_text(read_text(&scene)?, scene, &set, file.axes()?)?
        } else {
            Self::new(scene, &set, file.axes()?)?
        };
        if file.checksum.is_some_and(|checksum| checksum != sweep.checksum()) {
            return Err(SweepError::Changed { scene: sweep.scene().to_owned(), folder: path.to_owned() });
        }
        Ok(sweep)
    }

    fn file(&self) -> SweepFile {
        let absolute = match self.text_alone() {
            Some(_) => PathBuf::from(SCENE),
            None => std::path::absolute(self.scene()).unwrap_or_else(|_| self.scene().to_owned()),
        };
        let pair = |(key, value): &(String, String)| format!("{key}={value}");
        SweepFile {
            scene: absolute.to_string_lossy().into_owned(),
            checksum: Some(self.checksum()),
            set: self.set().iter().map(pair).collect(),
            vary: self.axes().iter().map(Axis::to_string).collect(),
            inputs: self.inputs(),
        }
    }
}

/// Folder of a sweep.
#[derive(Debug, Clone)]
pub struct SweepFolder {
    path: PathBuf,
    inputs: Inputs,
}

impl SweepFolder {
    /// Creates the folder of a sweep, or opens an existing folder with the same scene text, overrides and keys. If the
    /// values of the keys differ, existing runs are kept, and the tables show only the points of `sweep`. If different
    /// sweeps open a new folder at the same time, only one call succeeds.
    ///
    /// # Errors
    /// [`SweepError::Occupied`] if the folder contains other files, [`SweepError::Changed`] or [`SweepError::Other`] if
    /// it contains another sweep, [`SweepError::Input`] if an input file of a scene has changed since the sweep began,
    /// [`SweepError::Output`] if the folder cannot be created or written, or if one of its files is a link.
    pub fn open(path: impl AsRef<Path>, sweep: &Sweep) -> Result<Self, SweepError> {
        let mut folder = Self { path: path.as_ref().to_owned(), inputs: Inputs::new() };
        plain::make_folder(&folder.path)?;
        refuse_others(&folder.path, SWEEP)?;
        refuse(&folder.path.join(FAILURES), true)?;
        folder.claim(sweep)?;
        if let Some(text) = sweep.text_alone() {
            refuse_others(&folder.path, SCENE)?;
            write_text(&folder.path.join(SCENE), text)?;
        }
        Ok(folder)
    }

    fn claim(&mut self, sweep: &Sweep) -> Result<(), SweepError> {
        let (record, mut now) = (self.record(), sweep.file());
        let write = |now: &SweepFile, existing| {
            let text = toml::to_string(now).map_err(io::Error::other)?;
            write_atomically(&record, existing, |file| write!(file, "{HEADER}{text}"))
        };
        let is_new = loop {
            if record.exists() {
                break false;
            }
            let mut entries = fs::read_dir(&self.path).map_err(OutputError::write(&self.path))?.flatten();
            // Another process may have created `sweep.toml` in the meantime.
            if entries.any(|entry| !is_draft(&entry.file_name())) && !record.exists() {
                return Err(SweepError::Occupied(self.path.clone()));
            }
            match write(&now, Existing::Keep) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                written => {
                    written.map_err(OutputError::write(&record))?;
                    break true;
                }
            }
        };
        if !is_new {
            let then = SweepFile::read(&record)?;
            self.refuse_other(sweep, &then, &now)?;
            // Keeps the checksums of inputs whose runs are no longer in the sweep.
            for (path, checksum) in then.inputs {
                now.inputs.entry(path).or_insert(checksum);
            }
            write(&now, Existing::Replace).map_err(OutputError::write(&record))?;
        }
        self.inputs = now.inputs;
        Ok(())
    }

    pub(super) fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Opens an existing folder of a sweep without changing it.
    ///
    /// # Errors
    /// [`SweepError::Read`] if the folder holds no sweep.
    pub fn existing(path: impl AsRef<Path>) -> Result<Self, SweepError> {
        let mut folder = Self { path: path.as_ref().to_owned(), inputs: Inputs::new() };
        folder.inputs = SweepFile::read(&folder.record())?.inputs;
        Ok(folder)
    }

    fn refuse_other(&self, sweep: &Sweep, then: &SweepFile, now: &SweepFile) -> Result<(), SweepError> {
        if then.checksum != now.checksum {
            return Err(SweepError::Changed { scene: sweep.scene().to_owned(), folder: self.path.clone() });
        }
        let other = |why: String| Err(SweepError::Other { folder: self.path.clone(), why });
        let words = |list: &[String]| if list.is_empty() { "nothing".to_owned() } else { list.join(", ") };
        if then.set != now.set {
            return other(format!("it sets {}, not {}", words(&then.set), words(&now.set)));
        }
        let keys: Vec<String> = then.axes()?.iter().flat_map(|axis| axis.keys().to_vec()).collect();
        if keys != sweep.keys() {
            return other(format!("it varies {}", words(&keys)));
        }
        for (path, expected) in &then.inputs {
            if let Some(found) = now.inputs.get(path).filter(|found| *found != expected) {
                let (path, found, expected) = (path.clone(), found.clone(), expected.clone());
                return Err(SweepError::Input { path, found, expected, folder: self.path.clone() });
            }
        }
        Ok(())
    }

    /// Path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn record(&self) -> PathBuf {
        self.path.join(SWEEP)
    }

    /// Path of `sweep.toml` in the folder of a sweep.
    #[must_use]
    pub fn file_in(folder: &Path) -> PathBuf {
        folder.join(SWEEP)
    }

    /// Path of the folder of a point.
    #[must_use]
    pub fn of(&self, point: &Point) -> PathBuf {
        self.path.join(point.folder())
    }

    /// An interrupted run is unfinished, even if it has a summary.
    pub(super) fn state_of(&self, point: &Point) -> Result<FolderState, OutputError> {
        let path = self.of(point);
        let state = Folder::state_of(&path)?;
        let is_interrupted = state == FolderState::Finished
            && Summary::read(&path).is_ok_and(|summary| summary.ending.as_deref() == Some(Ending::Interrupted.word()));
        Ok(if is_interrupted { FolderState::Unfinished } else { state })
    }

    pub(super) fn failure(&self, point: &Point) -> Option<String> {
        fs::read_to_string(self.failure_file(point)).ok().map(|text| text.trim_end().to_owned())
    }

    fn failure_file(&self, point: &Point) -> PathBuf {
        self.path.join(FAILURES).join(format!("{}.txt", point.folder()))
    }

    /// Records why a run has failed. Deletes the record if there is no message.
    pub(super) fn keep_failure(&self, point: &Point, message: Option<&str>) -> Result<(), SweepError> {
        let path = self.failure_file(point);
        refuse_others(&self.path, &format!("{FAILURES}/{}.txt", point.folder()))?;
        let Some(message) = message else {
            remove(&path)?;
            // The folder remains if other runs have failed.
            let _ = fs::remove_dir(self.path.join(FAILURES));
            return Ok(());
        };
        let folder = self.path.join(FAILURES);
        fs::create_dir_all(&folder).map_err(OutputError::write(&folder))?;
        Ok(write_text(&path, &format!("{message}\n"))?)
    }

    pub(super) fn write(&self, name: &str, text: &str) -> Result<PathBuf, SweepError> {
        let path = self.path.join(name);
        refuse_others(&self.path, name)?;
        write_text(&path, text)?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests;
