//! The files of a run, for the comparison with a replay.

use std::path::Path;

use super::{Folder, PAGE, PICTURE, REPORT, SCENE, SMALL_PAGE, SUMMARY, scene_copy};
use crate::io::checkpoints;
use crate::io::measurements;
use crate::io::owned::{self, listed_formats};
use crate::io::replacement;
use crate::model::Format;
use crate::run::checkpoint::{Checkpoint, CheckpointError, Manifest};

impl Folder {
    /// The numbers of the run.
    pub(crate) const SUMMARY: &'static str = SUMMARY;
    /// The final table.
    pub(crate) const REPORT: &'static str = REPORT;
    /// The scene.
    pub(crate) const SCENE: &'static str = SCENE;
    /// The list of files.
    pub(crate) const LIST: &'static str = owned::FILE;

    /// The folder of a run that is to replace this run.
    pub(crate) const REPLACEMENT_FOLDER: &'static str = replacement::FOLDER;

    /// Returns true for the names of checkpoints.
    pub(crate) fn is_checkpoint(name: &str) -> bool {
        checkpoints::NAMES.contains(&name)
    }

    /// Returns true for the names of files with measurements.
    pub(crate) fn is_measurement(name: &str) -> bool {
        name == measurements::FILE || measurements::is_table(name)
    }

    /// Returns true for the names of pages and pictures, which are derived from other files.
    pub(crate) fn is_view(name: &str) -> bool {
        [PAGE, SMALL_PAGE, PICTURE].contains(&name)
    }

    /// The formats, other than extended XYZ, in which a run's trajectory exists.
    pub(crate) fn formats_of(run: &Path) -> Vec<Format> {
        listed_formats(run)
    }

    /// A checkpoint of a run, by its name.
    ///
    /// # Errors
    /// The errors of [`Checkpoint::read`].
    pub(crate) fn read_checkpoint(run: &Path, name: &str) -> Result<Checkpoint, CheckpointError> {
        Checkpoint::read(&run.join(name))
    }

    /// Compares the scene in a run's folder with its checksum in a checkpoint. Returns whether the folder has
    /// a scene.
    ///
    /// # Errors
    /// [`CheckpointError::Scene`] if it differs.
    pub(crate) fn check_scene(run: &Path, manifest: &Manifest) -> Result<bool, CheckpointError> {
        let Some(checksum) = manifest.scene else { return Ok(false) };
        scene_copy::check(&run.join(SCENE), checksum)?;
        Ok(true)
    }
}
