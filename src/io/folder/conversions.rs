use std::path::{Path, PathBuf};

use super::{Folder, TRAJECTORY};
use crate::io::convert::{ConvertError, Options, convert, foreign_in};
use crate::io::error::OutputError;
use crate::io::owned::{Owned, listed_formats};
use crate::model::Format;

/// Files and errors of the conversions of a trajectory.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Conversions {
    /// Paths of the written files.
    pub files: Vec<PathBuf>,
    /// Errors of the conversions that failed.
    pub failures: Vec<ConvertError>,
}

impl Conversions {
    pub(super) fn make(trajectory: &Path, formats: &[Format]) -> Self {
        let mut made = Self::default();
        for &format in formats {
            let target = format.target_beside(trajectory);
            match convert(trajectory, format, &target, &Options { replace: true, ..Options::default() }) {
                Ok(_) => made.files.push(target),
                Err(error) => made.failures.push(error),
            }
        }
        made
    }
}

impl Folder {
    /// Makes conversions that a finished run lacks, for example because the disk was full. Does nothing without a
    /// trajectory. Files that Carom did not write are not replaced.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another program writes to the folder, and errors of reading the list of files.
    /// Failed conversions are in [`Conversions::failures`].
    pub fn convert_missing(run: &Path) -> Result<Conversions, OutputError> {
        let trajectory = run.join(TRAJECTORY);
        let is_missing = |format: &Format| {
            let target = format.target_beside(&trajectory);
            !target.exists() || !matches!(foreign_in(&target, *format), Ok(None))
        };
        let missing: Vec<Format> = listed_formats(run).into_iter().filter(is_missing).collect();
        if missing.is_empty() || !trajectory.exists() {
            return Ok(Conversions::default());
        }
        let _lock = Owned::lock(run)?;
        Ok(Conversions::make(&trajectory, &missing))
    }
}
