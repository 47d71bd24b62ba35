//! Conversions of a run's trajectory to the formats that its scene requests.

use std::path::{Path, PathBuf};

use super::{Folder, TRAJECTORY};
use crate::io::convert::{ConvertError, Options, convert, foreign_in};
use crate::io::error::OutputError;
use crate::io::owned::{Owned, listed_formats};
use crate::model::Format;

/// Results of the conversions of a trajectory.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Conversions {
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Why the other files could not be written.
    pub failures: Vec<ConvertError>,
}

impl Conversions {
    /// Converts a trajectory to several formats, beside it.
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
    /// Repeats missing conversions of a finished run, for example if the disk was full at its end. The run's
    /// list names them. They need the trajectory. A foreign file with the name of a conversion counts as a
    /// failure.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another program writes to the folder, and the errors of reading its list. A
    /// failed conversion is not an error here.
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
