//! The folder of a run.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::checkpoints::Checkpoints;
use super::contacts;
use super::convert::{Format, Options, convert};
use super::error::OutputError;
use super::event_log::{self, EventLog};
use super::extended_xyz::write_frame;
use super::frame::Frame;
use super::kept_scene::KeptScene;
use super::measurements;
use super::partial::{PartialFile, SUFFIX};
use super::summary::Summary;
use super::thermo::Columns;
use crate::checkpoint::{Checkpoint, CheckpointError, Kept, KeptFile};
use crate::event::Event;
use crate::measure::{Measured, Scalar};
use crate::observe::Row;
use crate::run::{Course, Recorder};
use crate::scene::{Limit, Scene};
use crate::simulation::{Simulation, Snapshot};

/// The last file of a run: where it is, the others are complete and belong to it.
const SUMMARY: &str = "summary.json";
/// The scene as it was run.
const SCENE: &str = "scene.toml";
const THERMO: &str = "thermo.csv";
const TRAJECTORY: &str = "trajectory.xyz";
const CONTACTS: &str = "contacts.csv";
const REPORT: &str = "report.txt";
/// The page about an earlier run, which a new run makes untrue.
const PAGE: &str = "report.html";
/// The files of a run besides the summary.
const FILES: [&str; 6] = [SCENE, THERMO, TRAJECTORY, CONTACTS, REPORT, measurements::FILE];

/// How often a table that is being written can be looked at.
const FLUSH_INTERVAL: Duration = Duration::from_secs(2);

/// Writes a run to its folder.
///
/// Files are written beside their final names, as `thermo.csv.partial`; when all are complete they replace those of an
/// earlier run, `summary.json` last. Checkpoints are written now and then; from the last one, [`Folder::resume`] goes on.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    scene: Option<KeptScene>,
    columns: Columns,
    thermo: PartialFile,
    trajectory: PartialFile,
    contacts: Option<PartialFile>,
    events: Option<EventLog>,
    frame: Frame,
    /// Radii of the particles at the start of the scene.
    radii: Vec<f64>,
    formats: Vec<Format>,
    flushed: Instant,
    checkpoints: Checkpoints,
}

impl Folder {
    /// Makes the folder, unless it is there and empty or holds an earlier run that has ended.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if the folder holds something else, [`OutputError::Unfinished`] if it holds a run that can be
    /// resumed, [`OutputError::NotFolder`] or [`OutputError::Folder`] if there can be none, [`OutputError::Write`] if its files
    /// cannot be made.
    pub fn create(path: &Path, scene: &Scene) -> Result<Self, OutputError> {
        refuse_occupied(path)?;
        fs::create_dir_all(path).map_err(|source| OutputError::Folder { path: path.to_owned(), source })?;
        let columns = Columns::of(scene);
        // Those of the run before do not belong to the files of this one.
        let checkpoints = Checkpoints::begin(path)?;
        let mut thermo = PartialFile::create(path.join(THERMO))?;
        thermo.write(&columns.header())?;
        let mut contacts = scene.output.has_contacts.then(|| PartialFile::create(path.join(CONTACTS))).transpose()?;
        if let Some(file) = &mut contacts {
            file.write(contacts::HEADER)?;
        }
        let frame = Frame::start_of(scene);
        Ok(Self {
            scene: None,
            columns,
            thermo,
            trajectory: PartialFile::create(path.join(TRAJECTORY))?,
            contacts,
            events: scene.output.has_event_log.then(|| EventLog::create(path)).transpose()?,
            radii: frame.particles.iter().map(|particle| particle.radius).collect(),
            frame,
            formats: scene.output.formats.clone(),
            flushed: Instant::now(),
            checkpoints,
            path: path.to_owned(),
        })
    }

    /// Goes on with a run from a checkpoint: what its files gained later is cut off.
    ///
    /// # Errors
    /// [`OutputError::Checkpoint`] if a file is missing, too short, or not that of the checkpoint; nothing is changed then.
    /// [`OutputError::Write`] if one cannot be changed.
    pub fn resume(path: &Path, checkpoint: &Checkpoint) -> Result<Self, OutputError> {
        let scene = checkpoint.simulation.scene();
        let kept = &checkpoint.kept;
        if let Some(checksum) = kept.scene {
            KeptScene::check(&path.join(SCENE), checksum)?;
        }
        for file in &kept.files {
            PartialFile::check(&path.join(&file.name), file)?;
        }
        // Without a summary the folder is that of a run under way.
        remove(&path.join(SUMMARY))?;
        let file = |name: &str| {
            let kept = kept.files.iter().find(|kept| kept.name == name);
            kept.map(|kept| PartialFile::resume(path.join(name), kept)).transpose()
        };
        let need = |name: &str| {
            let missing = || CheckpointError::File { path: path.join(name), found: 0, expected: 0 };
            file(name)?.ok_or_else(|| OutputError::from(missing()))
        };
        let frame = Frame::start_of(scene);
        let radii = frame.particles.iter().map(|particle| particle.radius / checkpoint.simulation.grown()).collect();
        Ok(Self {
            // A program of the library need not have kept it.
            scene: kept.scene.map(|checksum| KeptScene::resume(&path.join(SCENE), checksum)).transpose()?,
            columns: Columns::of(scene),
            thermo: need(THERMO)?,
            trajectory: need(TRAJECTORY)?,
            contacts: file(CONTACTS)?,
            events: scene.output.has_event_log.then(|| EventLog::resume(path, kept)).transpose()?,
            radii,
            frame,
            formats: scene.output.formats.clone(),
            flushed: Instant::now(),
            checkpoints: Checkpoints::go_on(path),
            path: path.to_owned(),
        })
    }

    /// Writes a checkpoint so often, instead of every five minutes.
    #[must_use]
    pub fn checkpoint_every(mut self, interval: Duration) -> Self {
        self.checkpoints.interval = interval;
        self
    }

    /// Keeps the text of the scene, from which the run can be made again: [`Scene::record`].
    ///
    /// # Errors
    /// [`OutputError::Write`] if it cannot be written.
    pub fn keep_scene(&mut self, text: &str) -> Result<(), OutputError> {
        self.scene = Some(KeptScene::create(&self.path.join(SCENE), text)?);
        Ok(())
    }

    /// Changes the limit in the scene that is kept, for a run that is to go on to another end.
    ///
    /// # Errors
    /// [`OutputError::Write`] if it cannot be written.
    pub fn keep_limit(&mut self, limit: Limit) -> Result<(), OutputError> {
        self.scene.as_mut().map_or(Ok(()), |scene| scene.set_limit(limit))
    }

    /// Where the scene of a run is kept, in the folder of the run.
    #[must_use]
    pub fn scene_of(run: &Path) -> PathBuf {
        run.join(SCENE)
    }

    /// Where the last checkpoint of a run is kept, in the folder of the run.
    #[must_use]
    pub fn checkpoint_of(run: &Path) -> PathBuf {
        Checkpoints::last(run)
    }

    /// Gives the files their names, and adds the measurements, the summary and a report for people.
    ///
    /// # Errors
    /// [`OutputError::Write`] if a file cannot be written; there is no `summary.json` then.
    pub fn complete(self, summary: &Summary, measured: &Measured, report: &str) -> Result<Vec<PathBuf>, OutputError> {
        let mut report_file = PartialFile::create(self.path.join(REPORT))?;
        report_file.write(report)?;
        let mut summary_file = PartialFile::create(self.path.join(SUMMARY))?;
        let text = serde_json::to_string_pretty(summary)
            .map_err(|error| OutputError::write(summary_file.path())(io::Error::other(error)))?;
        summary_file.write(&(text + "\n"))?;
        let measurements = measurements::prepare(&self.path, measured)?;
        // From here on the folder belongs to this run.
        for old in [SUMMARY, PAGE].iter().chain(&FILES) {
            remove(&self.path.join(old))?;
        }
        measurements::remove_tables(&self.path)?;
        event_log::remove(&self.path)?;
        let events = self.events.map(EventLog::finish).transpose()?.unwrap_or_default();
        let trajectory = self.path.join(TRAJECTORY);
        let tables = [Some(self.thermo), Some(self.trajectory), self.contacts];
        let files = [self.scene.map(KeptScene::into_file)]
            .into_iter()
            .chain(tables)
            .flatten()
            .chain(measurements)
            .chain(events);
        let mut complete: Vec<_> = files.chain([report_file]).map(PartialFile::complete).collect::<Result<_, _>>()?;
        for format in self.formats {
            let target = format.target_beside(&trajectory);
            convert(&trajectory, format, &target, &Options { replace: true, ..Options::default() })?;
            complete.push(target);
        }
        complete.push(summary_file.complete()?);
        Ok(complete)
    }
}

/// Removes a file that may not be there.
pub(super) fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(OutputError::write(path)(error)),
        _ => Ok(()),
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

    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), OutputError> {
        (self.frame.time, self.frame.displacement, self.frame.scalars) =
            (snapshot.time, snapshot.displacement, scalars);
        let states = snapshot.positions.iter().zip(&snapshot.velocities);
        let all = self.frame.particles.iter_mut().zip(&self.radii);
        for ((particle, radius), (position, velocity)) in all.zip(states) {
            (particle.position, particle.velocity) = (*position, *velocity);
            particle.radius = radius * snapshot.scale;
        }
        let path = self.trajectory.path().to_owned();
        write_frame(self.trajectory.writer(), &self.frame).map_err(|source| OutputError::Frame { path, source })?;
        self.trajectory.flush()
    }

    fn has_events(&self) -> bool {
        self.contacts.is_some() || self.events.is_some()
    }

    fn event(&mut self, event: &Event) -> Result<(), OutputError> {
        if let Some(file) = &mut self.contacts {
            file.write(&contacts::line(event))?;
        }
        self.events.as_mut().map_or(Ok(()), |log| log.add(event))
    }

    fn is_checkpoint_due(&self) -> bool {
        self.checkpoints.is_due()
    }

    fn checkpoint(&mut self, simulation: &Simulation, course: &Course) -> Result<(), OutputError> {
        let files = [Some(&mut self.thermo), Some(&mut self.trajectory), self.contacts.as_mut()];
        let files = files.into_iter().flatten().map(|file| file.keep(&self.path));
        let mut files: Vec<KeptFile> = files.collect::<Result<_, _>>()?;
        if let Some(log) = &mut self.events {
            files.extend(log.keep(&self.path)?);
        }
        let kept = Kept { scene: self.scene.as_ref().map(|scene| scene.checksum), files };
        self.checkpoints.write(simulation, course, &kept)
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
    let is_under_way = path.join(format!("{THERMO}{SUFFIX}")).exists();
    if Checkpoints::last(path).exists() && is_under_way {
        return Err(OutputError::Unfinished(path.to_owned()));
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
