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
        /// The evidence.
        why: String,
    },
    /// It was written by another version of carom, or by a build from other sources.
    #[error("carom {found} wrote the checkpoint {}, and this is carom {} ({here}), which may continue differently",
        path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// That version, with the fingerprint of its sources.
        found: String,
        /// The fingerprint of the sources of this program.
        here: &'static str,
    },
    /// The length of an output file has changed.
    #[error("{} has {found} bytes, but had {expected} when the checkpoint was written", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Present length; 0 if it is missing.
        found: u64,
        /// Length at the checkpoint.
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
    /// The content of an output file has changed: it belongs to another run, or is damaged.
    #[error("the first {length} bytes of {} are not those of the checkpoint: their checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Length at the checkpoint.
        length: u64,
        /// Present CRC-32.
        found: u32,
        /// CRC-32 at the checkpoint.
        expected: u32,
    },
    /// A file that the scene read has changed.
    #[error("{path}, from which the run started, has changed: its checksum is {found}, expected {expected}")]
    Input {
        /// The file.
        path: String,
        /// Present checksum.
        found: String,
        /// Former checksum.
        expected: String,
    },
    /// The requested end has already passed.
    #[error("the run is at t = {time} already and has measured {measured}, expected a later end than {asked}")]
    Passed {
        /// Simulated time `[time]`.
        time: f64,
        /// Progress of the measurement.
        measured: String,
        /// The requested end.
        asked: String,
    },
    /// The text of the scene does not belong to the run.
    #[error("{} is not the scene of the checkpoint: without its limit its checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// CRC-32 of the present text.
        found: u32,
        /// CRC-32 of the run's text.
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

    /// Returns a suggestion for the user.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::Missing(_) => "a run writes its first one after a second; start it again",
            Self::Unreadable { .. } => "make the file readable",
            Self::Damaged { .. } => {
                "if there is a checkpoint.previous, rename it to checkpoint and resume from there; else start the run again"
            }
            Self::OtherVersion { .. } => "resume with the version that wrote it, or start the run again",
            Self::File { .. } | Self::FileUnreadable { .. } => "restore the file, or start the run again",
            Self::Passed { .. } => {
                "set --until-time or --until-events beyond the measured part; a shorter run is a new one, with --out"
            }
            Self::Input { .. } => "restore the file, or remove it: the checkpoint does not need it",
            Self::Content { .. } | Self::Scene { .. } => {
                "is it the file, or the checkpoint, of another run? restore the files that belong together, or start the run again"
            }
        }
    }
}
