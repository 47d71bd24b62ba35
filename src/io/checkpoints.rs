//! The checkpoints of a run in its folder, the last one and the one before; and when and how checkpoints are written.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::atomic::{folder_of, sync_folder};
use super::error::OutputError;
use super::folder::remove;
use super::partial::partial_of;
use super::plain;
use crate::run::checkpoint;

const LAST: &str = "checkpoint";
const PREVIOUS: &str = "checkpoint.previous";

/// Names of complete checkpoints.
pub(super) const NAMES: [&str; 2] = [LAST, PREVIOUS];

/// Interval between two checkpoints unless one is given.
const INTERVAL: Duration = Duration::from_secs(300);

/// A run that is over sooner needs none on the way.
const FIRST: Duration = Duration::from_secs(1);

/// Where the last one is.
pub(super) fn last(folder: &Path) -> PathBuf {
    folder.join(LAST)
}

/// Where the one before is.
pub(super) fn previous(folder: &Path) -> PathBuf {
    folder.join(PREVIOUS)
}

/// The one to go on from: the last one, or where that is gone the one before.
pub(super) fn newest(folder: &Path) -> PathBuf {
    let [last, previous] = NAMES.map(|name| folder.join(name));
    if !last.exists() && previous.exists() { previous } else { last }
}

/// Whether a folder has one to go on from.
pub(super) fn has_any(folder: &Path) -> bool {
    NAMES.iter().any(|name| folder.join(name).exists())
}

/// When and where checkpoints are written.
#[derive(Debug)]
pub(crate) struct Checkpoints {
    last: PathBuf,
    /// Where the one before is kept.
    previous: Option<PathBuf>,
    pub interval: Duration,
    since: Instant,
    is_first: bool,
}

impl Checkpoints {
    /// For what begins again.
    pub fn begin(last: PathBuf) -> Self {
        Self { is_first: true, ..Self::go_on(last) }
    }

    /// For what is resumed.
    pub fn go_on(last: PathBuf) -> Self {
        Self { last, previous: None, interval: INTERVAL, since: Instant::now(), is_first: false }
    }

    /// Keeps the checkpoint before the last one, too.
    pub fn keeping(self, previous: PathBuf) -> Self {
        Self { previous: Some(previous), ..self }
    }

    /// Whether it is time for the next one.
    pub fn is_due(&self) -> bool {
        let interval = if self.is_first { self.interval.min(FIRST) } else { self.interval };
        self.since.elapsed() >= interval
    }

    /// Writes one beside the last one, which becomes the one before when the new one is safe on the disk.
    pub fn write(&mut self, content: &impl Serialize) -> Result<(), OutputError> {
        let (last, partial) = (&self.last, partial_of(&self.last));
        let file = plain::create(&partial).map_err(OutputError::write(&partial))?;
        if let Err(error) = checkpoint::write(&file, content) {
            // Half of one is of no use; what it took on a full disk may be.
            drop(file);
            let _ = fs::remove_file(&partial);
            return Err(OutputError::write(&partial)(error));
        }
        // A hard link first, so that a checkpoint always has its name. On a disk without hard links there is a short gap.
        if let Some(previous) = self.previous.as_ref().filter(|_| last.exists()) {
            remove(previous)?;
            if fs::hard_link(last, previous).is_err() {
                fs::rename(last, previous).map_err(OutputError::write(previous))?;
            }
        }
        fs::rename(&partial, last).map_err(OutputError::write(last))?;
        // The new names, too, are to survive a power cut.
        sync_folder(folder_of(last));
        (self.since, self.is_first) = (Instant::now(), false);
        Ok(())
    }
}
