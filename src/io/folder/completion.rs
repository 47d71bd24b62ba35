use std::io;
use std::path::{Path, PathBuf};

use super::conversions::Conversions;
use super::{
    CONTACTS, Folder, PAGE, PARTICLES, REPORT, SCENE, SMALL_PAGE, SUMMARY, SUMMARY_BEFORE, THERMO, TRAJECTORY,
};
use crate::io::atomic::sync_folder;
use crate::io::contacts;
use crate::io::convert::ConvertError;
use crate::io::error::OutputError;
use crate::io::event_log::EventLog;
use crate::io::measurements::{self, Measurements};
use crate::io::owned::Owned;
use crate::io::partial::PartialFile;
use crate::io::replacement;
use crate::io::summary::Summary;
use crate::io::surfaces;
use crate::run::Finished;

/// The files of a completed run.
#[derive(Debug)]
#[non_exhaustive]
pub struct Completed {
    /// Paths of the files.
    pub files: Vec<PathBuf>,
    /// Folder of the files.
    pub folder: PathBuf,
    /// Folder of the old run. It is kept if the new run is not sound or lacks a conversion.
    pub kept: Option<PathBuf>,
    /// Errors of the conversions that failed.
    pub failures: Vec<ConvertError>,
}

impl Folder {
    /// Ends the run. Writes the measurements, the summary and `report.txt` with the text `report`, and gives all files
    /// their final names. An old run is replaced only if the new run is [sound](Finished::is_sound) and all conversions
    /// have succeeded.
    ///
    /// # Errors
    /// [`OutputError::Write`] if a file cannot be written. `summary.json` is then missing or from the old run. A failed
    /// conversion is not an error; see [`Completed::failures`].
    pub fn complete(mut self, finished: &Finished, report: &str) -> Result<Completed, OutputError> {
        let trajectory_file = self.trajectory.into_file()?;
        let measured = Measurements::of(finished);
        self.owned.claim(&measured.names())?;
        let report_file = PartialFile::with_text(self.path.join(REPORT), report)?;
        let contacts = self
            .contacts
            .as_ref()
            .map(|_| (CONTACTS.to_owned(), contacts::columns(finished.simulation.scene().units())));
        let columns = [(THERMO.to_owned(), self.columns.columns())].into_iter().chain(contacts).collect();
        let summary_file = summary(&self.path, &Summary { columns, ..Summary::of(finished) })?;
        let measurements = measured.prepare(&self.path)?;
        let events = self.events.map(EventLog::finish).transpose()?.unwrap_or_default();
        let trajectory = self.path.join(TRAJECTORY);
        let tables = [Some(self.thermo), Some(trajectory_file), self.contacts];
        let scene = self.scene.map(|_| PartialFile::reopen(self.path.join(SCENE))).transpose()?;
        let files = [scene].into_iter().chain(tables).flatten().chain(measurements).chain(events);
        let mut files: Vec<PartialFile> = files.chain([report_file]).collect();
        // All files must be on disk before the first rename.
        files.iter_mut().try_for_each(PartialFile::sync)?;
        let mut files: Vec<_> = files.into_iter().map(PartialFile::complete).collect::<Result<_, _>>()?;
        let Conversions { files: converted, failures } = Conversions::make(&trajectory, &self.formats);
        files.extend(converted);
        files.extend(self.owned.names().contains(PARTICLES).then(|| self.path.join(PARTICLES)));
        let surfaces = surfaces::names(finished.simulation.scene()).into_iter().map(|name| self.path.join(name));
        files.extend(surfaces.filter(|file| file.exists()));
        sync_folder(&self.path);
        files.push(summary_file.complete()?);
        sync_folder(&self.path);
        remove_stale(&mut self.owned, &measured.names())?;
        let is_whole = finished.is_sound() && failures.is_empty();
        let Some(mut outer) = self.outer.filter(|_| is_whole) else {
            let kept = (self.path != self.target).then_some(self.target);
            return Ok(Completed { files, folder: self.path, kept, failures });
        };
        replacement::take_place(&self.path, self.owned, &self.target, &mut outer)?;
        let place = |file: PathBuf| file.strip_prefix(&self.path).map_or(file.clone(), |name| self.target.join(name));
        let files = files.into_iter().map(place).collect();
        Ok(Completed { files, folder: self.target, kept: None, failures })
    }
}

fn summary(folder: &Path, summary: &Summary) -> Result<PartialFile, OutputError> {
    let path = folder.join(SUMMARY);
    let text =
        serde_json::to_string_pretty(summary).map_err(|error| OutputError::write(&path)(io::Error::other(error)))?;
    let mut file = PartialFile::with_text(path, &(text + "\n"))?;
    file.sync()?;
    Ok(file)
}

fn remove_stale(owned: &mut Owned, new: &[String]) -> Result<(), OutputError> {
    let is_stale = |name: &&String| {
        [PAGE, SMALL_PAGE, SUMMARY_BEFORE].contains(&name.as_str())
            || measurements::is_table(name) && !new.contains(name)
    };
    let stale: Vec<String> = owned.names().iter().filter(is_stale).cloned().collect();
    owned.remove(&stale)
}
