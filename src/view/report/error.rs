//! Errors of pages.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Error of the report of a run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The path is no folder.
    #[error("{} is not the folder of a run", .0.display())]
    NotFolder(PathBuf),
    /// The summary, which every finished run has, is missing or cannot be read.
    #[error("cannot read {}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The summary is damaged.
    #[error("{} is not the summary of a run", path.display())]
    Summary {
        /// The file.
        path: PathBuf,
        /// Where, and what was expected.
        source: serde_json::Error,
    },
    /// There is something under the name of the page.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// The page cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl ReportError {
    /// Cure: what the user can do.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::NotFolder(_) => "carom run SCENE writes the folder runs/NAME",
            Self::Unreadable { .. } => "summary.json is the last file that a run writes: a killed run has none",
            Self::Summary { .. } => "run the scene again, or restore the file",
            Self::Exists(_) => "replace it with --force, or choose another name with --out",
            Self::Write { .. } => "choose a file with --out in a folder that can be written to",
        }
    }
}
