mod completion;
mod conversions;
mod frames;
mod parts;
mod resumption;
mod trajectory;

pub use completion::Completed;
pub use conversions::Conversions;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub(crate) use self::frames::Frames;
use self::trajectory::Trajectory;
use super::atomic::Existing;
use super::checkpoints::{self, Checkpoints};
use super::contacts;
use super::draft::remove_abandoned;
use super::error::OutputError;
use super::event_log::{self, EventLog};
use super::measurements;
use super::occupied::{FolderState, run_around, spot, state_of};
use super::owned::{Owned, Replacement};
use super::partial::PartialFile;
use super::replacement;
use super::scene_copy;
use super::surfaces;
use super::thermo::Columns;
use crate::analysis::instruments::Scalar;
use crate::analysis::observables::Row;
use crate::engine::event::Event;
use crate::engine::{Simulation, Snapshot};
use crate::model::Format;
use crate::model::Scene;
use crate::run::checkpoint::{Content, Manifest};
use crate::run::{Recorder, RunState, Stage};

/// Last file that a run writes. If it exists, the run has ended and all files are complete.
pub(super) const SUMMARY: &str = "summary.json";
pub(super) const SUMMARY_BEFORE: &str = "summary.json.before";
pub(super) const SCENE: &str = "scene.toml";
/// File with particles from the calling program. The copy of the scene refers to it.
pub(super) const PARTICLES: &str = "particles.xyz";
pub(super) const THERMO: &str = "thermo.csv";
pub(super) const TRAJECTORY: &str = "trajectory.xyz";
pub(super) const CONTACTS: &str = "contacts.csv";
pub(super) const REPORT: &str = "report.txt";
/// Page with the results. It is outdated when the run is continued.
pub(super) const PAGE: &str = "report.html";
pub(crate) const SMALL_PAGE: &str = "run.html";
pub(super) const PICTURE: &str = "picture.png";

const FLUSH_INTERVAL: Duration = Duration::from_secs(2);

/// The folder of a run. This recorder writes rows, frames, checkpoints and results.
///
/// Until all files are complete, they have temporary names, such as `thermo.csv.partial`. `summary.json` is written
/// last. A run that replaces another run is written to the inner folder `replacement` until it ends complete and sound.
/// [`Folder::resume`] continues from the last checkpoint. The file `.carom` lists the files that Carom wrote, and is
/// locked during a run. Other files are never replaced or removed.
///
/// ```
/// use carom::io::{Existing, Folder};
/// use carom::run::Run;
/// use std::ops::ControlFlow;
///
/// # let directory = tempfile::tempdir()?;
/// # let target = directory.path().join("fluid");
/// # let scene = carom::model::Scene::from_file_with("configs/hard_sphere_fluid.toml", &[("run.until_events", "2000"), ("run.equilibration_events", "1000")])?;
/// // `scene` is a scene, `target` the path of the folder.
/// let mut folder = Folder::create(&target, &scene, Existing::Keep)?;
/// let finished = Run::new(scene).execute(&mut folder, &mut |_| ControlFlow::Continue(()))?;
/// folder.complete(&finished, "what is written into report.txt")?;
/// # assert!(target.join("summary.json").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// With the feature `view`, `carom::view::report::write` writes the page of the run. To continue a run, use
/// [`Folder::resume`] and [`Run::resume`](crate::run::Run::resume).
#[derive(Debug)]
pub struct Folder {
    /// The first field, so its thread ends before the locks are released.
    trajectory: Trajectory,
    target: PathBuf,
    /// Folder of the files: `target`, or an inner folder if this run replaces an old run.
    path: PathBuf,
    owned: Owned,
    /// Files of the old run that this run replaces.
    outer: Option<Owned>,
    /// Checksum of the scene; `None` if the text of the scene is not stored.
    scene: Option<u32>,
    columns: Columns,
    thermo: PartialFile,
    contacts: Option<PartialFile>,
    events: Option<EventLog>,
    formats: Vec<Format>,
    flushed: Instant,
    checkpoints: Checkpoints,
    /// Largest permitted total size of all files `[bytes]`.
    most_bytes: f64,
}

impl Folder {
    /// Creates the folder for a new run. The folder must be missing or empty. With [`Existing::Replace`], a run in the
    /// folder is replaced.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if the folder holds something other than a run. [`OutputError::Finished`],
    /// [`OutputError::Unfinished`] or [`OutputError::Replacing`] if it holds a run that must be kept.
    /// [`OutputError::WithinRun`] if it is inside the folder of another run. [`OutputError::NotReplacement`] if
    /// something else exists at the path of the inner folder. [`OutputError::Busy`] if another run writes to the
    /// folder. [`OutputError::NotFolder`] or [`OutputError::Folder`] if the folder cannot be created.
    /// [`OutputError::Foreign`] if a file with the name of an output file was not written by Carom.
    /// [`OutputError::NotPlain`] if an output file is a link or a folder. [`OutputError::Write`] if a file cannot be
    /// created.
    pub fn create(target: &Path, scene: &Scene, existing: Existing) -> Result<Self, OutputError> {
        if let Some(run) = run_around(target) {
            return Err(OutputError::WithinRun { target: target.to_owned(), run });
        }
        remove_abandoned(target);
        // The folder is checked before files are created. If another run writes to the folder, the lock fails later.
        if let Err(error @ (OutputError::Occupied(_) | OutputError::NotFolder(_))) = spot(target, existing) {
            return Err(error);
        }
        let make = |path: &Path| {
            fs::create_dir_all(path).map_err(|source| OutputError::Folder { path: path.to_owned(), source })
        };
        make(target)?;
        let mut owned = Owned::lock(target)?;
        replacement::recover(target, &mut owned)?;
        let path = spot(target, existing)?;
        let names = names_of(scene);
        owned.allow(&names)?;
        let mut outer = None;
        if path != target {
            owned.set_replacement(Replacement::Begun)?;
            make(&path)?;
            let mut inner = Owned::lock(&path)?;
            inner.remove_all()?;
            outer = Some(std::mem::replace(&mut owned, inner));
        }
        owned.claim(&names)?;
        surfaces::write(&path, scene, |_| true)?;
        let columns = Columns::of(scene);
        let contacts = || PartialFile::with_text(path.join(CONTACTS), contacts::HEADER);
        Ok(Self {
            scene: None,
            thermo: PartialFile::with_text(path.join(THERMO), &columns.header())?,
            columns,
            trajectory: Trajectory::new(PartialFile::create(path.join(TRAJECTORY))?, Frames::of(scene)),
            contacts: scene.output.has_contacts.then(contacts).transpose()?,
            events: scene.output.has_event_log.then(|| EventLog::create(&path)).transpose()?,
            formats: scene.output.formats.clone(),
            flushed: Instant::now(),
            most_bytes: f64::INFINITY,
            checkpoints: Checkpoints::begin(checkpoints::last(&path)).keeping(checkpoints::previous(&path)),
            target: target.to_owned(),
            path,
            owned,
            outer,
        })
    }

    /// Sets the interval between checkpoints. By default, it is five minutes.
    #[must_use]
    pub fn checkpoint_every(mut self, interval: Duration) -> Self {
        self.checkpoints.interval = interval;
        self
    }

    /// Interrupts the run when its files exceed this size `[bytes]`. The run first writes a checkpoint.
    /// [`Folder::excess`] then returns an error.
    #[must_use]
    pub fn at_most(mut self, bytes: f64) -> Self {
        self.most_bytes = bytes;
        self
    }

    /// Returns an error if the files of the run exceed the size set by [`Self::at_most`].
    #[must_use]
    pub fn excess(&self) -> Option<OutputError> {
        let tables = [&self.thermo].into_iter().chain(&self.contacts);
        let length = tables.map(PartialFile::length).sum::<u64>() + self.trajectory.length();
        let bytes = (length + self.events.as_ref().map_or(0, EventLog::length)) as f64;
        let is_too_much = bytes > self.most_bytes;
        is_too_much.then(|| OutputError::TooMuch { path: self.path.clone(), bytes, most: self.most_bytes })
    }

    /// Writes the text of the scene to `scene.toml`, so that the run can be repeated. [`Scene::record`] returns the
    /// text of a scene that was read from a file.
    ///
    /// # Errors
    /// [`OutputError::Write`] if the file cannot be written.
    pub fn keep_scene(&mut self, text: &str) -> Result<(), OutputError> {
        self.scene = Some(scene_copy::create(self.path.join(SCENE), text)?);
        Ok(())
    }

    /// Name of the file that [`Self::keep_particles`] writes.
    pub const PARTICLES: &str = PARTICLES;

    /// Writes particles that the calling program has passed to the scene to `particles.xyz`. The scene in the folder
    /// refers to this file ([`KeptParticles::InFile`](crate::scene::KeptParticles)).
    ///
    /// # Errors
    /// [`OutputError::Foreign`] if an existing file was not written by Carom. [`OutputError::Write`] if the file cannot
    /// be written.
    pub fn keep_particles(&mut self, content: &[u8]) -> Result<(), OutputError> {
        let names = [PARTICLES.to_owned()];
        if let Some(outer) = &self.outer {
            outer.allow(&names)?;
        }
        self.owned.claim(&names)?;
        let mut file = PartialFile::create(self.path.join(PARTICLES))?;
        file.write_bytes(content)?;
        file.sync()?;
        file.complete().map(drop)
    }

    /// Returns the state of the run in a folder.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if the folder holds something other than a run. [`OutputError::NotFolder`] or
    /// [`OutputError::Folder`] if the folder cannot be read.
    pub fn state_of(run: &Path) -> Result<FolderState, OutputError> {
        state_of(run)
    }

    /// Returns the path of the scene in the folder of a run.
    #[must_use]
    pub fn scene_of(run: &Path) -> PathBuf {
        run.join(SCENE)
    }

    /// Returns the path of the summary in the folder of a run. A run writes this file last.
    #[must_use]
    pub fn summary_of(run: &Path) -> PathBuf {
        run.join(SUMMARY)
    }

    /// Paths of the files of a run from which other files are made. Some files may not exist.
    #[must_use]
    pub fn files_of(run: &Path) -> Vec<PathBuf> {
        let names = [SUMMARY, SCENE, PARTICLES, THERMO, TRAJECTORY, CONTACTS, REPORT, measurements::FILE];
        let known = names.iter().map(|name| run.join(name)).chain([checkpoints::last(run)]);
        known.chain(surfaces::surface_files(run)).collect()
    }
}

/// Names of the files that a run of this scene will write, except measurements.
fn names_of(scene: &Scene) -> Vec<String> {
    let [last, previous] = checkpoints::NAMES;
    let mut names: Vec<String> =
        [SCENE, THERMO, TRAJECTORY, REPORT, SUMMARY, last, previous].map(str::to_owned).to_vec();
    names.extend(scene.output.has_contacts.then(|| CONTACTS.to_owned()));
    if scene.output.has_event_log {
        names.extend(event_log::names());
    }
    names.extend(surfaces::names(scene));
    names.extend(scene.output.formats.iter().map(|format| format.listed()));
    names
}

pub(crate) fn remove(path: &Path) -> Result<(), OutputError> {
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
        Ok(())
    }

    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), OutputError> {
        self.trajectory.add(snapshot, scalars)
    }

    fn frame_of(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        self.trajectory.add_now(simulation)
    }

    fn has_events(&self) -> bool {
        self.contacts.is_some() || self.events.is_some()
    }

    fn event(&mut self, event: &Event) -> Result<(), OutputError> {
        if let Some(contacts) = &mut self.contacts {
            contacts.write_bytes(&contacts::line(event))?;
        }
        self.events.as_mut().map_or(Ok(()), |log| log.add(event))
    }

    fn is_full(&self) -> bool {
        self.excess().is_some() || self.trajectory.has_failed()
    }

    fn is_checkpoint_due(&self) -> bool {
        self.checkpoints.is_due()
    }

    fn checkpoint(&mut self, simulation: &Simulation, state: &RunState) -> Result<(), OutputError> {
        let mut files = vec![self.thermo.keep(&self.path)?, self.trajectory.keep(&self.path)?];
        if let Some(contacts) = &mut self.contacts {
            files.push(contacts.keep(&self.path)?);
        }
        if let Some(log) = &mut self.events {
            files.extend(log.keep(&self.path)?);
        }
        let manifest = Manifest { scene: self.scene, files };
        let content: Content = (simulation, state, &manifest);
        self.checkpoints.write(&content)
    }
}
