//! The state of a run folder.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::atomic::Existing;
use super::error::OutputError;
use super::folder::{SUMMARY, THERMO};
use super::owned::{self, Replacement, is_run};
use super::partial::partial_of;
use super::{checkpoints, replacement};

/// State of the run in a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FolderState {
    /// No run, or a run that was killed before its first checkpoint.
    Nothing,
    /// A run that can be resumed.
    Unfinished,
    /// A run that has ended.
    Finished,
}

/// Returns the folder for a new run: `path`, or a folder inside `path` if the new run replaces an old run.
pub(super) fn spot(path: &Path, existing: Existing) -> Result<PathBuf, OutputError> {
    match (state_of(path)?, existing) {
        (FolderState::Nothing, _) => Ok(path.to_owned()),
        (_, Existing::Keep) if active(path) != path => Err(OutputError::Replacing(path.to_owned())),
        (FolderState::Finished, Existing::Keep) => Err(OutputError::Finished(path.to_owned())),
        (FolderState::Unfinished, Existing::Keep) => Err(OutputError::Unfinished(path.to_owned())),
        (_, Existing::Replace) => {
            let inner = replacement::within(path);
            // The inner folder is foreign if the list of files records no replacement.
            let is_known = owned::replacement_of(path) != Replacement::None;
            if !is_known && (inner.is_symlink() || !matches!(state_of(&inner), Ok(FolderState::Nothing))) {
                return Err(OutputError::NotReplacement(inner));
            }
            Ok(inner)
        }
    }
}

/// Returns the folder of the replacement if the replacement has a checkpoint, otherwise `path`.
pub(super) fn active(path: &Path) -> PathBuf {
    let inner = replacement::within(path);
    let is_known = owned::replacement_of(path) != Replacement::None;
    if is_known && is_run(&inner) && checkpoints::has_any(&inner) { inner } else { path.to_owned() }
}

/// Returns the run folder that contains `path`, if any. The path need not exist.
pub(crate) fn run_around(path: &Path) -> Option<PathBuf> {
    let path = std::path::absolute(path).ok()?;
    // Symbolic links can only be resolved in the part of the path that exists.
    let (depth, real) =
        path.ancestors().enumerate().find_map(|(depth, it)| Some((depth, fs::canonicalize(it).ok()?)))?;
    real.ancestors().skip(usize::from(depth == 0)).find(|folder| is_run(folder)).map(Path::to_owned)
}

/// Returns the state of the run in a folder. Returns `Finished` if a replacement of the run can be resumed.
pub(super) fn state_of(path: &Path) -> Result<FolderState, OutputError> {
    let folder_error = |source| OutputError::Folder { path: path.to_owned(), source };
    match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(FolderState::Nothing),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            return Err(OutputError::NotFolder(path.parent().unwrap_or(path).to_owned()));
        }
        Err(error) => return Err(folder_error(error)),
        Ok(metadata) if !metadata.is_dir() => return Err(OutputError::NotFolder(path.to_owned())),
        Ok(_) => {}
    }
    if !is_run(path) {
        for entry in fs::read_dir(path).map_err(folder_error)? {
            let entry = entry.map_err(folder_error)?;
            let is_begun = entry.file_name() == owned::FILE && owned::is_begun(&entry.path());
            if !is_begun {
                return Err(OutputError::Occupied(path.to_owned()));
            }
        }
        return Ok(FolderState::Nothing);
    }
    let is_under_way = partial_of(&path.join(THERMO)).exists();
    Ok(if active(path) != path || path.join(SUMMARY).exists() && !is_under_way {
        FolderState::Finished
    } else if checkpoints::has_any(path) {
        FolderState::Unfinished
    } else {
        FolderState::Nothing
    })
}
