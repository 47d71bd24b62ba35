//! Lists and reads the files of a run, for comparison with a replay.

use std::path::Path;

use super::{Folder, PAGE, PICTURE, REPORT, SCENE, SMALL_PAGE, SUMMARY, scene_copy};
use crate::io::checkpoints;
use crate::io::measurements;
use crate::io::owned::{self, listed_formats};
use crate::io::replacement;
use crate::model::Format;
use crate::run::checkpoint::{Checkpoint, CheckpointError, Manifest};

impl Folder {
    pub(crate) const SUMMARY: &'static str = SUMMARY;
    pub(crate) const REPORT: &'static str = REPORT;
    pub(crate) const SCENE: &'static str = SCENE;
    pub(crate) const LIST: &'static str = owned::FILE;

    pub(crate) const REPLACEMENT_FOLDER: &'static str = replacement::FOLDER;

    pub(crate) fn is_checkpoint(name: &str) -> bool {
        checkpoints::NAMES.contains(&name)
    }

    pub(crate) fn is_measurement(name: &str) -> bool {
        name == measurements::FILE || measurements::is_table(name)
    }

    /// Whether a file is a page or a picture, which can be made again from other files.
    pub(crate) fn is_view(name: &str) -> bool {
        [PAGE, SMALL_PAGE, PICTURE].contains(&name)
    }

    pub(crate) fn formats_of(run: &Path) -> Vec<Format> {
        listed_formats(run)
    }

    pub(crate) fn read_checkpoint(run: &Path, name: &str) -> Result<Checkpoint, CheckpointError> {
        Checkpoint::read(&run.join(name))
    }

    /// Compares the stored scene with its checksum in a checkpoint. Returns false if the run did not store its scene.
    pub(crate) fn check_scene(run: &Path, manifest: &Manifest) -> Result<bool, CheckpointError> {
        let Some(checksum) = manifest.scene else { return Ok(false) };
        scene_copy::check(&run.join(SCENE), checksum)?;
        Ok(true)
    }
}
