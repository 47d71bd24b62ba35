//! Protection of input files. No output replaces an input, and a run is not continued if its inputs have changed.

use std::fs;
use std::path::{Path, PathBuf};

use super::checkpoints;
use super::error::OutputError;
use super::plain;
use crate::model::{InputFile, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::scene::NamedInput;

/// Rejects a `target` that is an input, or a folder with an input.
///
/// # Errors
/// [`OutputError::Input`] with the first such input.
pub fn refuse_input<P: AsRef<Path>>(target: &Path, inputs: impl IntoIterator<Item = P>) -> Result<(), OutputError> {
    // If the output file does not exist, no input is replaced.
    let Ok(place) = fs::canonicalize(target) else { return Ok(()) };
    for input in inputs {
        let input: PathBuf = input.as_ref().to_owned();
        if fs::canonicalize(&input).is_ok_and(|input| input.starts_with(&place)) {
            return Err(OutputError::Input { target: target.to_owned(), input });
        }
    }
    Ok(())
}

/// Rejects a path at which Carom must not write a file: a link, a folder or a device.
///
/// # Errors
/// [`OutputError::NotPlain`]. A missing file is accepted.
pub fn refuse_link(path: &Path) -> Result<(), OutputError> {
    plain::refuse(path, false)
}

/// Returns an input of a scene with the checksum of its current content. `None` if the file cannot be read.
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

/// Rejects the continuation of a run whose inputs have changed. Missing inputs and the checkpoint of a preceding run
/// are ignored, because a continued run does not read these files.
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
