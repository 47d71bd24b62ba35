//! The folder of a run.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::checkpoints::{self, Checkpoints};
use super::contacts;
use super::convert::{Options, convert};
use super::error::OutputError;
use super::event_log::{self, EventLog};
use super::inputs;
use super::kept_scene::KeptScene;
use super::measurements;
use super::occupied::{active, spot};
use super::owned::{Owned, is_run};
use super::partial::PartialFile;
use super::place::{Existing, sync_folder};
use super::replacement;
use super::summary::Summary;
use super::thermo::Columns;
use crate::analysis::instruments::{Measured, Scalar};
use crate::analysis::observables::Row;
use crate::engine::event::Event;
use crate::engine::{Simulation, Snapshot};
use crate::model::Format;
use crate::model::{Limit, Scene};
use crate::run::checkpoint::{Checkpoint, CheckpointError, Kept, KeptFile};
use crate::run::{Course, Recorder, Stage};
use crate::trajectory::extended_xyz::write_frame;
use crate::trajectory::frame::Frame;

/// The last file of a run: where it is, the others are complete and belong to it.
pub(super) const SUMMARY: &str = "summary.json";
/// The summary of a run that goes on, until it has a new one.
const BEFORE: &str = "summary.json.before";
/// The scene as it was run.
pub(super) const SCENE: &str = "scene.toml";
pub(super) const THERMO: &str = "thermo.csv";
pub(super) const TRAJECTORY: &str = "trajectory.xyz";
pub(super) const CONTACTS: &str = "contacts.csv";
pub(super) const REPORT: &str = "report.txt";
/// The page about a run, which is no longer true when the run has gone on.
pub(super) const PAGE: &str = "report.html";
pub(super) const PICTURE: &str = "picture.png";

/// Events that are kept between two looks at how much the files take.
const COUNTED: u64 = 1024;

/// How often a table that is being written can be looked at.
const FLUSH_INTERVAL: Duration = Duration::from_secs(2);

/// Writes a run to its folder.
///
/// Files are written beside their final names, as `thermo.csv.partial`, and take those when all are complete, `summary.json` last. A run that
/// replaces another one does so in the folder `replacement` within the other's, which stays as it is until then. Checkpoints are
/// written now and then; from the last one, [`Folder::resume`] goes on. The file `.carom` lists what Carom wrote: nothing else is ever
/// replaced or removed. It is locked while a run writes.
#[derive(Debug)]
pub struct Folder {
    /// The folder that was asked for.
    target: PathBuf,
    /// Where the files are until they are complete: the same, or within it.
    path: PathBuf,
    /// The lists of both; one where they are the same.
    owned: Vec<Owned>,
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
    /// What the files may take together `[bytes]`.
    most_bytes: f64,
    events_kept: u64,
}

impl Folder {
    /// Makes the folder for a new run, if there is none, it is empty, or [`Existing::Replace`] says that the run in it may be replaced.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if the folder holds something else than a run, [`OutputError::Finished`] or [`OutputError::Unfinished`] if it
    /// holds a run that is to be kept, [`OutputError::Busy`] if another run writes to it, [`OutputError::NotFolder`] or
    /// [`OutputError::Folder`] if there can be none, [`OutputError::Foreign`] if a file that is not Carom's has the name of one of its
    /// files, [`OutputError::Write`] if its files cannot be made.
    pub fn create(target: &Path, scene: &Scene, existing: Existing) -> Result<Self, OutputError> {
        // Before anything is made there; a run that writes there is found out by its lock.
        if let Err(error @ (OutputError::Occupied(_) | OutputError::NotFolder(_))) = spot(target, existing) {
            return Err(error);
        }
        let make = |path: &Path| {
            fs::create_dir_all(path).map_err(|source| OutputError::Folder { path: path.to_owned(), source })
        };
        make(target)?;
        let mut owned = vec![Owned::lock(target)?];
        replacement::recover(target, &mut owned[0])?;
        let path = spot(target, existing)?;
        if path != target {
            make(&path)?;
            owned.push(Owned::lock(&path)?);
        }
        let names = names_of(scene, &path);
        // What would be in the way at the end is told now.
        owned[0].allow(&names)?;
        if let Some(owned) = owned.last_mut() {
            owned.claim(&names)?;
        }
        let columns = Columns::of(scene);
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
            events: scene.output.has_event_log.then(|| EventLog::create(&path)).transpose()?,
            radii: frame.particles.iter().map(|particle| particle.radius).collect(),
            frame,
            formats: scene.output.formats.clone(),
            flushed: Instant::now(),
            most_bytes: f64::INFINITY,
            events_kept: 0,
            checkpoints: Checkpoints::begin(&path),
            target: target.to_owned(),
            path,
            owned,
        })
    }

    /// Goes on with a run from its last checkpoint: what its files gained later is cut off.
    ///
    /// # Errors
    /// [`OutputError::Busy`] if another run writes there; [`OutputError::Checkpoint`] if there is none, or if a file is missing, too short, or not
    /// that of the checkpoint: nothing is changed then. [`OutputError::Write`] if one cannot be changed.
    pub fn resume(target: &Path) -> Result<(Self, Checkpoint), OutputError> {
        // Nothing is made where there is no run.
        if !is_run(target) {
            let last = checkpoints::last(target);
            return Err(Checkpoint::read(&last).err().unwrap_or(CheckpointError::Missing(target.to_owned())).into());
        }
        if !checkpoints::has_any(&active(target)) {
            return Err(CheckpointError::Missing(target.to_owned()).into());
        }
        let mut owned = vec![Owned::lock(target)?];
        replacement::recover(target, &mut owned[0])?;
        let path = &active(target);
        if path != target {
            owned.push(Owned::lock(path)?);
        }
        let checkpoint = Checkpoint::read(&checkpoints::last(path))?;
        let scene = checkpoint.simulation.scene();
        inputs::refuse_changed(&scene.inputs)?;
        let kept = &checkpoint.kept;
        if let Some(checksum) = kept.scene {
            KeptScene::check(&path.join(SCENE), checksum)?;
        }
        for file in &kept.files {
            PartialFile::check(&path.join(&file.name), file)?;
        }
        // Without a summary the folder is that of a run under way.
        let summary = path.join(SUMMARY);
        if summary.exists() {
            if let Some(owned) = owned.last_mut() {
                owned.claim(&[BEFORE.to_owned()])?;
            }
            fs::rename(&summary, path.join(BEFORE)).map_err(OutputError::write(&summary))?;
        }
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
        let folder = Self {
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
            most_bytes: f64::INFINITY,
            events_kept: 0,
            checkpoints: Checkpoints::go_on(path),
            target: target.to_owned(),
            path: path.to_owned(),
            owned,
        };
        Ok((folder, checkpoint))
    }

    /// Writes a checkpoint so often, instead of every five minutes.
    #[must_use]
    pub fn checkpoint_every(mut self, interval: Duration) -> Self {
        self.checkpoints.interval = interval;
        self
    }

    /// Ends the run with [`OutputError::TooMuch`] where its files would take more `[bytes]`.
    #[must_use]
    pub fn at_most(mut self, bytes: f64) -> Self {
        self.most_bytes = bytes;
        self
    }

    /// Whether the files still are within what they may take.
    fn count(&self) -> Result<(), OutputError> {
        let tables = [Some(&self.thermo), Some(&self.trajectory), self.contacts.as_ref()];
        let length = tables.into_iter().flatten().map(PartialFile::length).sum::<u64>();
        let bytes = (length + self.events.as_ref().map_or(0, EventLog::length)) as f64;
        if bytes <= self.most_bytes {
            return Ok(());
        }
        Err(OutputError::TooMuch { path: self.path.clone(), bytes, most: self.most_bytes })
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

    /// The files of a run that other files are made from, whether they are there or not.
    #[must_use]
    pub fn files_of(run: &Path) -> Vec<PathBuf> {
        let names = [SUMMARY, SCENE, THERMO, TRAJECTORY, CONTACTS, REPORT, measurements::FILE];
        names.iter().map(|name| run.join(name)).chain([checkpoints::last(run)]).collect()
    }

    /// Gives the files their names, and adds the measurements, the summary and a report for people; then takes the place of the run that is to be
    /// replaced, if there is one.
    ///
    /// # Errors
    /// [`OutputError::Write`] if a file cannot be written; there is no `summary.json` then, or that of the run that was to be replaced.
    pub fn complete(
        mut self,
        summary: &Summary,
        measured: &Measured,
        report: &str,
    ) -> Result<Vec<PathBuf>, OutputError> {
        let mut owned = self.owned.pop();
        if let Some(owned) = &mut owned {
            owned.claim(&measurements::names(measured))?;
        }
        let mut report_file = PartialFile::create(self.path.join(REPORT))?;
        report_file.write(report)?;
        let mut summary_file = PartialFile::create(self.path.join(SUMMARY))?;
        let text = serde_json::to_string_pretty(summary)
            .map_err(|error| OutputError::write(summary_file.path())(io::Error::other(error)))?;
        summary_file.write(&(text + "\n"))?;
        summary_file.sync()?;
        let measurements = measurements::prepare(&self.path, measured)?;
        let events = self.events.map(EventLog::finish).transpose()?.unwrap_or_default();
        let trajectory = self.path.join(TRAJECTORY);
        let tables = [Some(self.thermo), Some(self.trajectory), self.contacts];
        let files = [self.scene.map(KeptScene::into_file)]
            .into_iter()
            .chain(tables)
            .flatten()
            .chain(measurements)
            .chain(events);
        let mut files: Vec<PartialFile> = files.chain([report_file]).collect();
        // All are safe before the first of them gets its name.
        files.iter_mut().try_for_each(PartialFile::sync)?;
        let mut complete: Vec<_> = files.into_iter().map(PartialFile::complete).collect::<Result<_, _>>()?;
        for format in self.formats {
            let target = format.target_beside(&trajectory);
            convert(&trajectory, format, &target, &Options { replace: true, ..Options::default() })?;
            complete.push(target);
        }
        sync_folder(&self.path);
        complete.push(summary_file.complete()?);
        sync_folder(&self.path);
        if let Some(owned) = &mut owned {
            let new = measurements::names(measured);
            let is_stale = |name: &&String| {
                [PAGE, BEFORE].contains(&name.as_str()) || measurements::is_table(name) && !new.contains(name)
            };
            let stale: Vec<String> = owned.names().iter().filter(is_stale).cloned().collect();
            owned.remove(&stale)?;
        }
        if let (Some(mut inner), Some(mut outer)) = (owned, self.owned.pop()) {
            // Runs that were to replace a run that was to be replaced are one within the other.
            let mut path = self.path.as_path();
            while let Some(parent) = path.parent().filter(|parent| *parent != self.target) {
                let mut next = Owned::lock(parent)?;
                replacement::take_place(path, inner, parent, &mut next)?;
                (path, inner) = (parent, next);
            }
            replacement::take_place(path, inner, &self.target, &mut outer)?;
            let place = |file: PathBuf| {
                file.strip_prefix(&self.path).map(|name| self.target.join(name)).unwrap_or(file.clone())
            };
            complete = complete.into_iter().map(place).collect();
        }
        Ok(complete)
    }
}

/// The files that a run of a scene will write, besides its measurements.
fn names_of(scene: &Scene, path: &Path) -> Vec<String> {
    let [last, previous] = checkpoints::NAMES;
    let mut names: Vec<String> =
        [SCENE, THERMO, TRAJECTORY, REPORT, SUMMARY, last, previous].map(str::to_owned).to_vec();
    names.extend(scene.output.has_contacts.then(|| CONTACTS.to_owned()));
    if scene.output.has_event_log {
        names.extend(event_log::names());
    }
    for format in &scene.output.formats {
        let target = format.target_beside(&path.join(TRAJECTORY));
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        names.push(format!("{name}{}", if format.is_folder() { "/" } else { "" }));
    }
    names
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

    fn row(&mut self, stage: Stage, row: &Row) -> Result<(), OutputError> {
        self.thermo.write(&self.columns.line(stage, row))?;
        if self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flushed = Instant::now();
            self.thermo.flush()?;
        }
        self.count()
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
        self.frame.images.clone_from(&snapshot.images);
        let path = self.trajectory.path().to_owned();
        write_frame(self.trajectory.writer(), &self.frame).map_err(|source| OutputError::Frame { path, source })?;
        self.trajectory.flush()?;
        self.count()
    }

    fn has_events(&self) -> bool {
        self.contacts.is_some() || self.events.is_some()
    }

    fn event(&mut self, event: &Event) -> Result<(), OutputError> {
        if let Some(file) = &mut self.contacts {
            file.write(&contacts::line(event))?;
        }
        self.events.as_mut().map_or(Ok(()), |log| log.add(event))?;
        self.events_kept += 1;
        if self.events_kept.is_multiple_of(COUNTED) { self.count() } else { Ok(()) }
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
