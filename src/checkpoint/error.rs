//! What can be wrong with a checkpoint.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a run cannot be resumed.
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
    /// Its bytes are not those that were written.
    #[error("the checkpoint {} is damaged: {why}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// How that is known.
        why: String,
    },
    /// Another version of carom wrote it.
    #[error("carom {found} wrote the checkpoint {}, and this is carom {}", path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The file.
        path: PathBuf,
        /// Which one.
        found: String,
    },
    /// An output file is not what it was.
    #[error("{} has {found} bytes, but had {expected} when the checkpoint was written", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// How long it is; 0 if it is missing.
        found: u64,
        /// How long it was.
        expected: u64,
    },
}

impl CheckpointError {
    pub(super) fn unreadable(path: &Path, source: io::Error) -> Self {
        if source.kind() == io::ErrorKind::NotFound {
            return Self::Missing(path.parent().unwrap_or(path).to_owned());
        }
        Self::Unreadable { path: path.to_owned(), source }
    }

    /// What the user can do about it.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::Missing(_) => "a run writes its first one after a second; start it again",
            Self::Unreadable { .. } => "make the file readable",
            Self::Damaged { .. } => {
                "the one before it is kept as checkpoint.previous: rename it to checkpoint, and resume from there"
            }
            Self::OtherVersion { .. } => "resume with the version that wrote it, or start the run again",
            Self::File { .. } => "bring the file back, or start the run again",
        }
    }
}
