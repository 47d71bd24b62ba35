//! Protects input files. No output replaces an input, and no run continues if its inputs have changed.

use std::fs;
use std::path::{Path, PathBuf};

use super::checkpoints;
use super::error::OutputError;
use super::plain;
use crate::model::{InputFile, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::scene::NamedInput;

/// Rejects an output path that is an input, or a folder that contains an input.
///
/// # Errors
/// [`OutputError::Input`] with the first such input.
pub fn refuse_input<P: AsRef<Path>>(target: &Path, inputs: impl IntoIterator<Item = P>) -> Result<(), OutputError> {
    // A missing file cannot be an input.
    let Ok(place) = fs::canonicalize(target) else { return Ok(()) };
    for input in inputs {
        let input: PathBuf = input.as_ref().to_owned();
        if fs::canonicalize(&input).is_ok_and(|input| input.starts_with(&place)) {
            return Err(OutputError::Input { target: target.to_owned(), input });
        }
    }
    Ok(())
}

/// Rejects links, folders and devices, which Carom must not replace by a file.
///
/// # Errors
/// [`OutputError::NotPlain`]. A missing file is accepted.
pub fn refuse_link(path: &Path) -> Result<(), OutputError> {
    plain::refuse(path, false)
}

/// Returns an input of a scene with its current checksum. `None` if the file cannot be read.
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

/// Rejects the continuation of a run if its inputs have changed. Missing inputs and the checkpoint of an earlier run
/// are ignored, because a continued run does not read them.
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
