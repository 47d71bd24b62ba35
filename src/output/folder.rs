//! The folder of a run.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::contacts;
use super::error::OutputError;
use super::extended_xyz::write_frame;
use super::frame::Frame;
use super::partial::{PartialFile, SUFFIX};
use super::summary::Summary;
use super::thermo::Columns;
use crate::event::Event;
use crate::observe::Row;
use crate::run::Recorder;
use crate::scene::Scene;
use crate::simulation::Snapshot;

/// The last file of a run: where it is, the others are complete and belong to it.
const SUMMARY: &str = "summary.json";
/// The scene as it was run.
const SCENE: &str = "scene.toml";
/// The files of a run besides the summary.
const FILES: [&str; 5] = [SCENE, "thermo.csv", "trajectory.xyz", "contacts.csv", "report.txt"];

/// How often a table that is being written can be looked at.
const FLUSH_INTERVAL: Duration = Duration::from_secs(2);

/// Writes a run to its folder.
///
/// Files are written beside their final names, as `thermo.csv.partial`; when all are complete they replace those of an
/// earlier run, `summary.json` last.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    scene: Option<PartialFile>,
    columns: Columns,
    thermo: PartialFile,
    trajectory: PartialFile,
    contacts: Option<PartialFile>,
    frame: Frame,
    flushed: Instant,
}

impl Folder {
    /// Makes the folder, unless it is there and empty or holds an earlier run.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if the folder holds something else, [`OutputError::NotFolder`] or
    /// [`OutputError::Folder`] if there can be none, [`OutputError::Write`] if its files cannot be made.
    pub fn create(path: &Path, scene: &Scene) -> Result<Self, OutputError> {
        refuse_occupied(path)?;
        fs::create_dir_all(path).map_err(|source| OutputError::Folder { path: path.to_owned(), source })?;
        let columns = Columns::of(scene);
        let mut thermo = PartialFile::create(path.join("thermo.csv"))?;
        thermo.write(&columns.header())?;
        let mut contacts =
            scene.output.has_contacts.then(|| PartialFile::create(path.join("contacts.csv"))).transpose()?;
        if let Some(file) = &mut contacts {
            file.write(contacts::HEADER)?;
        }
        Ok(Self {
            scene: None,
            columns,
            thermo,
            trajectory: PartialFile::create(path.join("trajectory.xyz"))?,
            contacts,
            frame: Frame::start_of(scene),
            flushed: Instant::now(),
            path: path.to_owned(),
        })
    }

    /// Keeps the text of the scene, from which the run can be made again: [`Scene::record`].
    ///
    /// # Errors
    /// [`OutputError::Write`] if it cannot be written.
    pub fn keep_scene(&mut self, text: &str) -> Result<(), OutputError> {
        let mut file = PartialFile::create(self.path.join(SCENE))?;
        file.write(text)?;
        file.flush()?;
        self.scene = Some(file);
        Ok(())
    }

    /// Where the scene of a run is kept, in the folder of the run.
    #[must_use]
    pub fn scene_of(run: &Path) -> PathBuf {
        run.join(SCENE)
    }

    /// Gives the files their names, and adds the summary and a report for people.
    ///
    /// # Errors
    /// [`OutputError::Write`] if a file cannot be written; there is no `summary.json` then.
    pub fn complete(self, summary: &Summary, report: &str) -> Result<Vec<PathBuf>, OutputError> {
        let mut report_file = PartialFile::create(self.path.join("report.txt"))?;
        report_file.write(report)?;
        let mut summary_file = PartialFile::create(self.path.join(SUMMARY))?;
        let text = serde_json::to_string_pretty(summary)
            .map_err(|error| OutputError::write(summary_file.path())(io::Error::other(error)))?;
        summary_file.write(&(text + "\n"))?;
        // From here on the folder belongs to this run.
        for old in [SUMMARY].iter().chain(&FILES) {
            let path = self.path.join(old);
            match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    return Err(OutputError::Write { path, source });
                }
                _ => {}
            }
        }
        let tables = [Some(self.thermo), Some(self.trajectory), self.contacts];
        let files = [self.scene].into_iter().chain(tables).chain([Some(report_file), Some(summary_file)]);
        files.flatten().map(PartialFile::complete).collect()
    }
}

impl Recorder for Folder {
    type Error = OutputError;

    fn row(&mut self, row: &Row) -> Result<(), OutputError> {
        self.thermo.write(&self.columns.line(row))?;
        if self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flushed = Instant::now();
            self.thermo.flush()?;
        }
        Ok(())
    }

    fn frame(&mut self, snapshot: &Snapshot) -> Result<(), OutputError> {
        self.frame.time = snapshot.time;
        let states = snapshot.positions.iter().zip(&snapshot.velocities);
        for (particle, (position, velocity)) in self.frame.particles.iter_mut().zip(states) {
            (particle.position, particle.velocity) = (*position, *velocity);
        }
        let path = self.trajectory.path().to_owned();
        write_frame(self.trajectory.writer(), &self.frame).map_err(|source| OutputError::Frame { path, source })?;
        self.trajectory.flush()
    }

    fn has_events(&self) -> bool {
        self.contacts.is_some()
    }

    fn event(&mut self, event: &Event) -> Result<(), OutputError> {
        self.contacts.as_mut().map_or(Ok(()), |file| file.write(&contacts::line(event)))
    }
}

/// Refuses a folder with contents that are not those of a run: one with a summary, or one that was not completed.
fn refuse_occupied(path: &Path) -> Result<(), OutputError> {
    let folder_error = |source| OutputError::Folder { path: path.to_owned(), source };
    match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
            return Err(OutputError::NotFolder(path.parent().unwrap_or(path).to_owned()));
        }
        Err(error) => return Err(folder_error(error)),
        Ok(metadata) if !metadata.is_dir() => return Err(OutputError::NotFolder(path.to_owned())),
        Ok(_) => {}
    }
    let mut is_empty = true;
    for entry in fs::read_dir(path).map_err(folder_error)? {
        let name = entry.map_err(folder_error)?.file_name().to_string_lossy().into_owned();
        let is_partial = FILES.iter().any(|file| name.strip_suffix(SUFFIX) == Some(file));
        if name == SUMMARY || is_partial {
            return Ok(());
        }
        is_empty = false;
    }
    if is_empty { Ok(()) } else { Err(OutputError::Occupied(path.to_owned())) }
}
