use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::frames::Frames;
use super::trajectory::Trajectory;
use super::{CONTACTS, Folder, SCENE, SUMMARY, SUMMARY_BEFORE, THERMO, TRAJECTORY, names_of};
use crate::analysis::instruments::compare_instruments;
use crate::io::checkpoints::{self, Checkpoints};
use crate::io::draft::remove_abandoned;
use crate::io::error::OutputError;
use crate::io::event_log::EventLog;
use crate::io::occupied::active;
use crate::io::owned::{Owned, is_run};
use crate::io::partial::PartialFile;
use crate::io::thermo::Columns;
use crate::io::{inputs, replacement, scene_copy, surfaces};
use crate::model::{Scene, Until};
use crate::run::Recorder;
use crate::run::checkpoint::{Checkpoint, CheckpointError, Manifest};

impl Folder {
    /// Resumes a run from its last checkpoint, or from the previous checkpoint if the last checkpoint is missing.
    /// Output after the checkpoint is cut off. If the run was being replaced, the new run is resumed. `limit` replaces
    /// the end of the measurement, also on disk.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another run writes to the folder. [`OutputError::Checkpoint`] if there is no
    /// checkpoint, if a file is missing, too short or changed, or if the run is beyond the limit.
    /// [`OutputError::Foreign`] if an existing file was not written by Carom. [`OutputError::NotPlain`] if a file of
    /// the run is a link or a folder. These errors leave everything unchanged. [`OutputError::Write`] if a file cannot
    /// be changed.
    pub fn resume(target: &Path, limit: Option<Until>) -> Result<(Self, Checkpoint), OutputError> {
        Self::resume_if(target, limit, None)
    }

    /// Like [`Self::resume`], for a run with custom instruments of these names.
    ///
    /// # Errors
    /// The errors of [`Self::resume`]. [`OutputError::Instrument`] if the run began with other instruments. This error
    /// leaves everything unchanged.
    pub fn resume_with(
        target: &Path,
        limit: Option<Until>,
        instruments: &[String],
    ) -> Result<(Self, Checkpoint), OutputError> {
        Self::resume_if(target, limit, Some(instruments))
    }

    fn resume_if(
        target: &Path,
        limit: Option<Until>,
        instruments: Option<&[String]>,
    ) -> Result<(Self, Checkpoint), OutputError> {
        let (path, mut owned, outer) = locked(target)?;
        let path = &path;
        let mut checkpoint = Checkpoint::read(&checkpoints::newest(path))?;
        if let Some(instruments) = instruments {
            compare_instruments(instruments, checkpoint.state.registered())?;
        }
        if let Some(limit) = limit {
            checkpoint.refuse_passed(limit)?;
            checkpoint.extend(limit);
        }
        let scene = checkpoint.simulation.scene();
        inputs::refuse_changed(scene)?;
        let names = names_of(scene);
        outer.iter().try_for_each(|outer| outer.allow(&names))?;
        // If the list was lost, the new list may lack files of this run, so only listed files are checked here.
        owned.allow(&names.into_iter().filter(|name| owned.names().contains(name)).collect::<Vec<_>>())?;
        let manifest = &checkpoint.manifest;
        check_files(path, manifest)?;
        add_surfaces(path, &mut owned, scene)?;
        set_summary_aside(path, &mut owned)?;
        let file = |name: &str| {
            let entry = manifest.files.iter().find(|entry| entry.name == name);
            entry.map(|entry| PartialFile::resume(path.join(name), entry)).transpose()
        };
        let need = |name: &str| {
            let missing = || CheckpointError::File { path: path.join(name), found: 0, expected: 0 };
            file(name)?.ok_or_else(|| OutputError::from(missing()))
        };
        if manifest.scene.is_some() {
            PartialFile::reopen(path.join(SCENE))?;
        }
        let mut folder = Self {
            // A program that uses the library may not have stored the text of the scene.
            scene: manifest.scene,
            columns: Columns::with(scene, checkpoint.state.applicable().clone()),
            thermo: need(THERMO)?,
            trajectory: Trajectory::new(need(TRAJECTORY)?, Frames::of_simulation(&checkpoint.simulation)),
            contacts: file(CONTACTS)?,
            events: scene.output.has_event_log.then(|| EventLog::resume(path, manifest)).transpose()?,
            formats: scene.output.formats.clone(),
            flushed: Instant::now(),
            most_bytes: f64::INFINITY,
            checkpoints: Checkpoints::go_on(checkpoints::last(path)).keeping(checkpoints::previous(path)),
            target: target.to_owned(),
            path: path.to_owned(),
            owned,
            outer,
        };
        if limit.is_some() {
            folder.checkpoint(&checkpoint.simulation, &checkpoint.state)?;
        }
        // The limit in the file may be outdated. An earlier program may have been killed after its checkpoint with a
        // new limit.
        if folder.scene.is_some() {
            scene_copy::set_limit(&path.join(SCENE), checkpoint.simulation.scene().run().limit)?;
        }
        Ok((folder, checkpoint))
    }
}

fn check_files(path: &Path, manifest: &Manifest) -> Result<(), OutputError> {
    if let Some(checksum) = manifest.scene {
        scene_copy::check(&path.join(SCENE), checksum)?;
    }
    for file in &manifest.files {
        PartialFile::check(&path.join(&file.name), file)?;
    }
    Ok(())
}

/// Locks the folder of the run to resume. Returns the path and the list of files of the run. If the run will replace an
/// old run, returns the list of files of the old run, too.
fn locked(target: &Path) -> Result<(PathBuf, Owned, Option<Owned>), OutputError> {
    // No list of files must be created in a folder without a run.
    if !is_run(target) {
        let last = checkpoints::last(target);
        return Err(Checkpoint::read(&last).err().unwrap_or(CheckpointError::Missing(target.to_owned())).into());
    }
    if !checkpoints::has_any(&active(target)) {
        return Err(CheckpointError::Missing(target.to_owned()).into());
    }
    let mut owned = Owned::lock(target)?;
    remove_abandoned(target);
    replacement::recover(target, &mut owned)?;
    let path = active(target);
    let is_inner = path != target;
    Ok(if is_inner { (path.clone(), Owned::lock(&path)?, Some(owned)) } else { (path, owned, None) })
}

/// Writes missing surface files, and keeps existing files. At open sides of the box, surfaces extend to the initial
/// particles. The resumed simulation may have lost some of these particles.
fn add_surfaces(path: &Path, owned: &mut Owned, scene: &Scene) -> Result<(), OutputError> {
    let is_missing = |file: &Path| fs::symlink_metadata(file).is_err();
    let names = surfaces::names(scene);
    let missing: Vec<String> = names.into_iter().filter(|name| is_missing(&path.join(name))).collect();
    owned.claim(&missing)?;
    surfaces::write(path, scene, is_missing)
}

/// Renames the old summary until the new summary is written, because only a finished run has a summary.
fn set_summary_aside(path: &Path, owned: &mut Owned) -> Result<(), OutputError> {
    let summary = path.join(SUMMARY);
    if summary.exists() {
        owned.claim(&[SUMMARY_BEFORE.to_owned()])?;
        fs::rename(&summary, path.join(SUMMARY_BEFORE)).map_err(OutputError::write(&summary))?;
    }
    Ok(())
}
