//! Copy of the scene in a run folder. The run can be repeated from this copy.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::partial::{PartialFile, partial_of};
use crate::base::checksum::checksum;
use crate::model::Until;
use crate::run::checkpoint::CheckpointError;
use crate::scene::{with_limit, without_limit};

/// Writes the file and returns a checksum of the scene. The checksum does not depend on the limit of the run.
pub(super) fn create(path: PathBuf, text: &str) -> Result<u32, OutputError> {
    PartialFile::with_text(path, text)?.flush()?;
    Ok(identity(text))
}

pub(super) fn check(path: &Path, expected: u32) -> Result<(), CheckpointError> {
    let path = PartialFile::present(path);
    let text =
        fs::read_to_string(&path).map_err(|source| CheckpointError::FileUnreadable { path: path.clone(), source })?;
    let found = identity(&text);
    if found == expected { Ok(()) } else { Err(CheckpointError::Scene { path, found, expected }) }
}

pub(super) fn set_limit(path: &Path, limit: Until) -> Result<(), OutputError> {
    let partial = partial_of(path);
    let text = fs::read_to_string(&partial).map_err(OutputError::write(&partial))?;
    let changed = with_limit(&text, limit).map_err(|error| OutputError::write(path)(io::Error::other(error)))?;
    if changed != text {
        PartialFile::with_text(partial, &changed)?.complete()?;
    }
    Ok(())
}

fn identity(text: &str) -> u32 {
    checksum(without_limit(text).as_bytes())
}
