//! Errors of checkpoints.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Error of a checkpoint: why a run cannot be resumed from it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// There is no checkpoint.
    #[error("{} holds no checkpoint to go on from", .0.display())]
    Missing(PathBuf),
    /// It cannot be read.
    #[error("cannot read the checkpoint {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The bytes have changed since they were written.
    #[error("the checkpoint {} is damaged: {why}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// How that is known.
        why: String,
    },
    /// Another version of carom wrote it, or one that was built from other sources.
    #[error("carom {found} wrote the checkpoint {}, and this is carom {} ({here}), which may go on otherwise",
        path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Which one, with the fingerprint of its sources.
        found: String,
        /// The fingerprint of the sources of this one.
        here: &'static str,
    },
    /// An output file is not what it was.
    #[error("{} has {found} bytes, but had {expected} when the checkpoint was written", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Present length; 0 if it is missing.
        found: u64,
        /// How long it was.
        expected: u64,
    },
    /// An output file cannot be read.
    #[error("cannot read {}, which belongs to the checkpoint", path.display())]
    FileUnreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An output file holds something else than it did: it is that of another run, or damaged.
    #[error("the first {length} bytes of {} are not those of the checkpoint: their checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// How long it was.
        length: u64,
        /// CRC-32 of what it holds.
        found: u32,
        /// CRC-32 of what it held.
        expected: u32,
    },
    /// A file that the scene read is not what it was.
    #[error(
        "{path}, which the run started from, is not the file that it was: its checksum is {found}, expected {expected}"
    )]
    Input {
        /// The file.
        path: String,
        /// The checksum of what it holds.
        found: String,
        /// The checksum that was found.
        expected: String,
    },
    /// The run is asked for an end that it is beyond.
    #[error("the run is at t = {time} already and has measured {measured}, expected a later end than {asked}")]
    Passed {
        /// Simulated time `[time]`.
        time: f64,
        /// Progress of the measurement.
        measured: String,
        /// The end that was asked for.
        asked: String,
    },
    /// The text of the scene is not that of the run.
    #[error("{} is not the scene of the checkpoint: without its limit its checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// CRC-32 of the text that is there.
        found: u32,
        /// CRC-32 of the text that was there.
        expected: u32,
    },
}

impl CheckpointError {
    pub(super) fn unreadable(path: &Path, source: io::Error) -> Self {
        if source.kind() == io::ErrorKind::NotFound {
            return Self::Missing(path.parent().unwrap_or(path).to_owned());
        }
        Self::Unreadable { path: path.to_owned(), source }
    }

    /// Cure: what the user can do.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::Missing(_) => "a run writes its first one after a second; start it again",
            Self::Unreadable { .. } => "make the file readable",
            Self::Damaged { .. } => {
                "if there is a checkpoint.previous, rename it to checkpoint and resume from there; else start the run again"
            }
            Self::OtherVersion { .. } => "resume with the version that wrote it, or start the run again",
            Self::File { .. } | Self::FileUnreadable { .. } => "bring the file back, or start the run again",
            Self::Passed { .. } => {
                "give --until-time or --until-events at least what is measured; a shorter run is a new one, with --out"
            }
            Self::Input { .. } => "bring the file back, or remove it: the checkpoint does not need it",
            Self::Content { .. } | Self::Scene { .. } => {
                "is it the file, or the checkpoint, of another run? bring back what belongs together, or start the run again"
            }
        }
    }
}
