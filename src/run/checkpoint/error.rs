//! Errors of checkpoints.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a run cannot be resumed from a checkpoint.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The checkpoint does not exist.
    #[error("{} contains no checkpoint", .0.display())]
    Missing(PathBuf),
    /// The checkpoint cannot be read.
    #[error("cannot read the checkpoint {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The checkpoint is damaged.
    #[error("the checkpoint {} is damaged: {why}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with the content.
        why: String,
    },
    /// A different version or build of carom wrote the checkpoint.
    #[error("carom {found} wrote the checkpoint {}, and this is carom {} ({here}), which may continue differently",
        path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Version that wrote the checkpoint, with the fingerprint of its sources.
        found: String,
        /// Fingerprint of the sources of this program.
        here: &'static str,
    },
    /// An output file is shorter than at the time of the checkpoint.
    #[error("{} has {found} bytes, but had {expected} when the checkpoint was written", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Current length `[bytes]`; 0 if the file is missing.
        found: u64,
        /// Length at the time of the checkpoint `[bytes]`.
        expected: u64,
    },
    /// An output file of the run cannot be read.
    #[error("cannot read {}, which belongs to the checkpoint", path.display())]
    FileUnreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// An output file is damaged, or belongs to another run.
    #[error("the first {length} bytes of {} differ from the checkpoint: their checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Length at the time of the checkpoint `[bytes]`.
        length: u64,
        /// Current CRC-32.
        found: u32,
        /// CRC-32 at the time of the checkpoint.
        expected: u32,
    },
    /// A file that the scene reads has changed since the start of the run.
    #[error("{path}, from which the run started, has changed: its checksum is {found}, expected {expected}")]
    Input {
        /// The file.
        path: String,
        /// Current checksum.
        found: String,
        /// Former checksum.
        expected: String,
    },
    /// The requested end of the measurement has already passed.
    #[error("the run is at t = {time} already and has measured {measured}, expected a later end than {asked}")]
    Passed {
        /// Simulated time `[time]`.
        time: f64,
        /// What has been measured: a time or a number of events.
        measured: String,
        /// The requested end.
        asked: String,
    },
    /// The scene file is not the scene of the run.
    #[error("{} is not the scene of the checkpoint: without its limit its checksum is {found:08x}, expected {expected:08x}",
        path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// CRC-32 of the scene file.
        found: u32,
        /// CRC-32 of the scene of the run.
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

    /// Returns how the user can solve the problem.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::Missing(_) => "a run writes its first checkpoint after a second; start the run again",
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
                "the file and the checkpoint may belong to different runs: restore both from the same run, or start the run again"
            }
        }
    }
}
