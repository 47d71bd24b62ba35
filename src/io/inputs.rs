//! Inputs stay as they are: neither replaced by outputs, nor changed between two parts of a run.

use std::fs;
use std::path::{Path, PathBuf};

use super::checkpoints;
use super::error::OutputError;
use super::plain;
use crate::model::{InputFile, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::scene::NamedInput;

/// Refuses to write a file, or a folder, where a file would be lost that is read: one in that place, or in that folder.
///
/// # Errors
/// [`OutputError::Input`] with the first of them.
pub fn refuse_input<P: AsRef<Path>>(target: &Path, inputs: impl IntoIterator<Item = P>) -> Result<(), OutputError> {
    // A missing file replaces nothing.
    let Ok(place) = fs::canonicalize(target) else { return Ok(()) };
    for input in inputs {
        let input: PathBuf = input.as_ref().to_owned();
        if fs::canonicalize(&input).is_ok_and(|input| input.starts_with(&place)) {
            return Err(OutputError::Input { target: target.to_owned(), input });
        }
    }
    Ok(())
}

/// Refuses to write a file of Carom's own through a link, or where a folder is.
///
/// # Errors
/// [`OutputError::NotPlain`]. What is not there is fine.
pub fn refuse_link(path: &Path) -> Result<(), OutputError> {
    plain::refuse(path, false)
}

/// Input of a scene with the checksum that it has now; `None` where it cannot be read.
pub(crate) fn present(path: &Path, kind: NamedInput) -> Option<InputFile> {
    match kind {
        NamedInput::File => Some(InputFile::new(path, &fs::read(path).ok()?)),
        NamedInput::Run => {
            let checkpoint = checkpoints::last(path);
            let checksum = Checkpoint::stated_checksum(&checkpoint).ok()?;
            Some(InputFile::of_checkpoint(&checkpoint, checksum))
        }
    }
}

/// Refuses inputs of a run that are not what they were. One that is gone is not needed to go on, nor is a run that it started from.
pub(crate) fn refuse_changed(scene: &Scene) -> Result<(), CheckpointError> {
    let is_run = |input: &&InputFile| scene.predecessor().is_some_and(|run| run.checkpoint == **input);
    for input in scene.inputs().iter().filter(|input| !is_run(input)) {
        if let Ok(Some(found)) = input.changed() {
            let InputFile { path, checksum: expected, .. } = input.clone();
            return Err(CheckpointError::Input { path, found, expected });
        }
    }
    Ok(())
}
