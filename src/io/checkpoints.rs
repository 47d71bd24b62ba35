//! Schedule and files of the checkpoints of a run or an exchange.

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

pub(super) const NAMES: [&str; 2] = [LAST, PREVIOUS];

const INTERVAL: Duration = Duration::from_secs(300);

/// Time from the start of a new run to the first checkpoint. Shorter runs write no intermediate checkpoint.
const FIRST: Duration = Duration::from_secs(1);

pub(super) fn last(folder: &Path) -> PathBuf {
    folder.join(LAST)
}

pub(super) fn previous(folder: &Path) -> PathBuf {
    folder.join(PREVIOUS)
}

pub(super) fn newest(folder: &Path) -> PathBuf {
    let [last, previous] = NAMES.map(|name| folder.join(name));
    if !last.exists() && previous.exists() { previous } else { last }
}

pub(super) fn has_any(folder: &Path) -> bool {
    NAMES.iter().any(|name| folder.join(name).exists())
}

#[derive(Debug)]
pub(crate) struct Checkpoints {
    last: PathBuf,
    /// Path of the previous checkpoint, if it is kept.
    previous: Option<PathBuf>,
    pub interval: Duration,
    since: Instant,
    is_first: bool,
}

impl Checkpoints {
    pub fn begin(last: PathBuf) -> Self {
        Self { is_first: true, ..Self::go_on(last) }
    }

    pub fn go_on(last: PathBuf) -> Self {
        Self { last, previous: None, interval: INTERVAL, since: Instant::now(), is_first: false }
    }

    pub fn keeping(self, previous: PathBuf) -> Self {
        Self { previous: Some(previous), ..self }
    }

    pub fn is_due(&self) -> bool {
        let interval = if self.is_first { self.interval.min(FIRST) } else { self.interval };
        self.since.elapsed() >= interval
    }

    /// Writes a checkpoint and renames it to `last`. The old checkpoint is kept as `previous`, if this path is set.
    pub fn write(&mut self, content: &impl Serialize) -> Result<(), OutputError> {
        let (last, partial) = (&self.last, partial_of(&self.last));
        let file = plain::create(&partial).map_err(OutputError::write(&partial))?;
        if let Err(error) = checkpoint::write(&file, content) {
            // The incomplete checkpoint is useless, and the disk may be full.
            drop(file);
            let _ = fs::remove_file(&partial);
            return Err(OutputError::write(&partial)(error));
        }
        // With a hard link, the file `last` exists at all times. Without hard links, it is missing for a moment.
        if let Some(previous) = self.previous.as_ref().filter(|_| last.exists()) {
            remove(previous)?;
            if fs::hard_link(last, previous).is_err() {
                fs::rename(last, previous).map_err(OutputError::write(previous))?;
            }
        }
        fs::rename(&partial, last).map_err(OutputError::write(last))?;
        // After the sync, the new names survive a power failure.
        sync_folder(folder_of(last));
        (self.since, self.is_first) = (Instant::now(), false);
        Ok(())
    }
}
