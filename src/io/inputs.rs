//! Protection of inputs: they are neither replaced by outputs, nor changed between two parts of a run.

use std::fs;
use std::path::{Path, PathBuf};

use super::checkpoints;
use super::error::OutputError;
use super::plain;
use crate::model::{InputFile, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::scene::NamedInput;

/// Rejects writing a file or a folder if this would destroy an input at that path or in that folder.
///
/// # Errors
/// [`OutputError::Input`] with the first such input.
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

/// Rejects writing one of Carom's own files through a link, or where a folder exists.
///
/// # Errors
/// [`OutputError::NotPlain`]. A missing file is fine.
pub fn refuse_link(path: &Path) -> Result<(), OutputError> {
    plain::refuse(path, false)
}

/// An input of a scene with its present checksum; `None` if it cannot be read.
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

/// Rejects changed inputs of a run. Inputs that are missing and the predecessor of the run are ignored: they
/// are not needed to continue.
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
