//! The folder of an exchange: tables, trajectories, a checkpoint and a summary.

mod mark;
mod measured;
mod rows;
mod size;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::error::ExchangeFolderError;
use super::execute::ExchangeRecorder;
use super::replicas::{Exchange, ExchangeRow};
use super::summary::ExchangeSummary;
use super::tables;
use crate::base::checksum::checksum;
use crate::engine::Simulation;
use crate::io::atomic::{sync_folder, write_text};
use crate::io::checkpoints::Checkpoints;
use crate::io::inputs::refuse_changed;
use crate::io::measurements::FILE as MEASUREMENTS;
use crate::io::partial::PartialFile;
use crate::io::plain;
use crate::io::surfaces;
use crate::io::{Frames, OutputError, remove};
use crate::model::input_file::spelled;
use crate::model::{ExchangePlan, Scene};
use crate::run::checkpoint::{self, Checked, ManifestEntry};
use crate::scene::without_limit;

const SCENE: &str = "scene.toml";
const ROWS: &str = "exchange.csv";
const ENERGIES: &str = "energies.csv";
const CURVES: &str = "curves.csv";
const DENSITY: &str = "density_of_states.csv";
const MEAN_FORCE: &str = "potential_of_mean_force.csv";
const CHECKPOINT: &str = "exchange.checkpoint";
/// The HTML page. It is removed if the exchange continues to a later end.
const PAGE: &str = "exchange.html";
pub(super) const SUMMARY: &str = "summary.json";

/// All files except for trajectories, surfaces and tables of instruments.
const FILES: [&str; 10] = [SCENE, ROWS, ENERGIES, CURVES, DENSITY, MEAN_FORCE, MEASUREMENTS, CHECKPOINT, PAGE, SUMMARY];

type Content = (Exchange, Vec<ManifestEntry>);

/// Folder of an exchange. This recorder writes rows, frames, checkpoints and results.
///
/// Until the exchange is complete, tables and trajectories have temporary names, such as `exchange.csv.partial`.
/// `summary.json` is written last. The folder is locked while an exchange writes to it.
///
/// ```
/// use carom::exchange::{ExchangeFolder, Opened};
/// use std::ops::ControlFlow;
///
/// # use carom::model::Scene;
/// # let directory = tempfile::tempdir()?;
/// # let target = directory.path().join("pair");
/// # let record = "species = [{ name = 'A', mass = 1.3, diameter = 1.0 }]\n\
/// #     interaction = [{ species = ['A', 'A'], potential = 'square-well', lambda = 1.5, well_depth = 1.0 }]\n\
/// #     fill = [{ species = 'A', arrangement = 'sc', count = 8, number_density = 0.05 }]\n\
/// #     exchange = { temperatures = [0.5, 1.0], interval = 1.0, rate = 1.0 }\n\
/// #     run = { until_time = 20.0 }";
/// # let scene = Scene::from_toml(record, "pair.toml")?;
/// // `scene` is a scene with the table [exchange], `record` its text, `target` the path of the folder.
/// if let Opened::UnderWay(begun) = ExchangeFolder::open(&target, scene, record)? {
///     let (mut folder, exchange) = *begun;
///     let exchange = exchange.execute(2, &mut folder, &mut |_| ControlFlow::Continue(()))?;
///     folder.complete(&exchange)?;
/// }
/// # assert!(target.join("summary.json").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ExchangeFolder {
    path: PathBuf,
    /// The folder is locked until this file is closed.
    _mark: File,
    rows: PartialFile,
    trajectories: Vec<PartialFile>,
    frames: Frames,
    checkpoints: Checkpoints,
}

/// Result of opening the folder of an exchange.
#[derive(Debug)]
#[non_exhaustive]
pub enum Opened {
    /// A complete exchange.
    Complete,
    /// An exchange at its start or at its last checkpoint.
    UnderWay(Box<(ExchangeFolder, Exchange)>),
}

impl ExchangeFolder {
    /// Creates the folder for the exchange of a scene, or opens an existing folder. `record` is the text of the scene
    /// with all overrides, such as [`Scene::record`]. If the folder has an exchange of the same scene with a different
    /// end, this exchange continues to the new end.
    ///
    /// # Errors
    /// [`ExchangeFolderError::Occupied`] and [`ExchangeFolderError::Other`] if the folder holds something else.
    /// [`ExchangeFolderError::Passed`] if the end is before the last checkpoint. [`ExchangeFolderError::Start`] if the
    /// scene cannot be used for an exchange. [`ExchangeFolderError::Output`] if another process writes to the folder, a
    /// link or a folder has the name of a file, the checkpoint cannot be used, or a file cannot be written.
    pub fn open(path: impl AsRef<Path>, scene: Scene, record: &str) -> Result<Opened, ExchangeFolderError> {
        let path = path.as_ref();
        let mark = mark::locked(path)?;
        let places = scene.exchange().map_or(0, ExchangePlan::replicas);
        let names = FILES.map(str::to_owned).into_iter();
        let names = names.chain(surfaces::names(&scene)).chain(measured::folders(places));
        names.chain((0..places).map(trajectory_of)).try_for_each(|name| plain::refuse_others(path, &name))?;
        let kept = path.join(SCENE);
        let is_complete = path.join(SUMMARY).exists();
        let has_begun = is_complete || path.join(CHECKPOINT).exists();
        let mut has_other_end = false;
        match fs::read_to_string(&kept) {
            Ok(text) if text == record => {}
            Ok(text) if !has_begun || without_limit(&text) == without_limit(record) => has_other_end = true,
            Ok(_) => return Err(ExchangeFolderError::Other(path.to_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                write_text(&kept, record)?;
            }
            Err(source) => return Err(ExchangeFolderError::Read { path: kept, source }),
        }
        if is_complete && !has_other_end {
            return Ok(Opened::Complete);
        }
        surfaces::write(path, &scene, |file| !has_begun || !file.exists())?;
        if !has_begun {
            if has_other_end {
                write_text(&kept, record)?;
            }
            return Ok(Opened::UnderWay(Box::new(Self::begin(path, mark, scene)?)));
        }
        let (exchange, files) = Self::kept(path, &scene)?;
        if is_complete && exchange.is_over() {
            return Ok(Opened::Complete);
        }
        if has_other_end {
            // If the process is killed before the new scene is written, the exchange continues to the old end.
            [SUMMARY, ENERGIES, CURVES, DENSITY, MEAN_FORCE, MEASUREMENTS, PAGE]
                .iter()
                .try_for_each(|name| remove(&path.join(name)))?;
            write_text(&kept, record)?;
        }
        Ok(Opened::UnderWay(Box::new(Self::resume(path, mark, exchange, &files)?)))
    }

    fn begin(path: &Path, mark: File, scene: Scene) -> Result<(Self, Exchange), ExchangeFolderError> {
        let frames = Frames::of(&scene);
        let exchange = Exchange::new(scene)?;
        let count = exchange.temperatures().len();
        let rows = PartialFile::with_text(path.join(ROWS), &tables::header(count, &exchange.measured_names()))?;
        let create = |place| PartialFile::create(trajectory_in(path, place));
        let trajectories = (0..count).map(create).collect::<Result<_, _>>()?;
        let folder = Self {
            path: path.to_owned(),
            _mark: mark,
            rows,
            trajectories,
            frames,
            checkpoints: Checkpoints::begin(path.join(CHECKPOINT)),
        };
        Ok((folder, exchange))
    }

    /// Returns the exchange of the last checkpoint, with the end of `scene`.
    fn kept(path: &Path, scene: &Scene) -> Result<(Exchange, Vec<ManifestEntry>), ExchangeFolderError> {
        let (mut exchange, files): Content =
            checkpoint::read_content(&path.join(CHECKPOINT)).map_err(OutputError::Checkpoint)?;
        refuse_changed(exchange.scene()).map_err(OutputError::Checkpoint)?;
        for file in &files {
            PartialFile::check(&path.join(&file.name), file).map_err(OutputError::Checkpoint)?;
        }
        let asked = scene.run().limit.time.unwrap_or(0.0);
        if !exchange.end_after(asked) {
            return Err(ExchangeFolderError::Passed {
                path: path.to_owned(),
                measured: exchange.results().duration,
                asked,
            });
        }
        Ok((exchange, files))
    }

    fn resume(
        path: &Path,
        mark: File,
        exchange: Exchange,
        files: &[ManifestEntry],
    ) -> Result<(Self, Exchange), ExchangeFolderError> {
        let mut files = files.iter().map(|file| PartialFile::resume(path.join(&file.name), file));
        let missing = || ExchangeFolderError::Occupied(path.to_owned());
        let folder = Self {
            rows: files.next().ok_or_else(missing)??,
            trajectories: files.collect::<Result<_, _>>()?,
            frames: Frames::of_simulation(exchange.example()),
            path: path.to_owned(),
            _mark: mark,
            checkpoints: Checkpoints::go_on(path.join(CHECKPOINT)),
        };
        exchange.enlarge();
        Ok((folder, exchange))
    }

    /// Sets the interval between checkpoints. By default, it is five minutes.
    #[must_use]
    pub fn checkpoint_every(mut self, interval: Duration) -> Self {
        self.checkpoints.interval = interval;
        self
    }

    /// Returns true if the folder is the folder of an exchange.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        mark::is_there(path)
    }

    /// Path of the scene in the folder of an exchange.
    #[must_use]
    pub fn scene_of(path: &Path) -> PathBuf {
        path.join(SCENE)
    }

    /// Paths of the files that are needed to continue the exchange or to make the HTML page. Some files may not exist.
    #[must_use]
    pub fn files_of(path: &Path) -> Vec<PathBuf> {
        FILES.into_iter().filter(|name| *name != PAGE).map(|name| path.join(name)).collect()
    }

    /// Gives all files their final names and writes the results.
    ///
    /// # Errors
    /// [`ExchangeFolderError::Output`] if a file cannot be written. `summary.json` is then missing.
    pub fn complete(mut self, exchange: &Exchange) -> Result<ExchangeSummary, ExchangeFolderError> {
        self.rows.sync()?;
        let rows = PartialFile::present(&self.path.join(ROWS));
        let mut summary = ExchangeSummary::of(exchange);
        let texts = if exchange.plan().umbrella.is_some() {
            summary = summary.with_mean_force(rows::mean_force(&rows, exchange)?);
            vec![(MEAN_FORCE, tables::mean_force(&summary.potential_of_mean_force))]
        } else {
            summary = summary.with_curves(rows::curves(&rows, exchange)?);
            vec![
                (ENERGIES, tables::energies(&summary.results)),
                (CURVES, tables::curves(&summary.curves)),
                (DENSITY, tables::density_of_states(&summary.density_of_states)),
            ]
        };
        for (name, text) in &texts {
            write_text(&self.path.join(name), text)?;
        }
        let mut measured = measured::measurements(&summary.results).prepare(&self.path)?;
        let of_measured = measured.first_mut().map(|file| file.keep(&self.path)).transpose()?;
        let checksums = texts.iter().map(|(name, text)| (*name, checksum(text.as_bytes())));
        let checksums = checksums.chain([(ROWS, self.rows.keep(&self.path)?.checksum)]);
        let checksums = checksums.chain(of_measured.map(|file| (MEASUREMENTS, file.checksum)));
        summary.tables = checksums.map(|(name, checksum)| (name.to_owned(), spelled(checksum))).collect();
        self.trajectories.iter_mut().try_for_each(PartialFile::sync)?;
        for file in [self.rows].into_iter().chain(self.trajectories).chain(measured) {
            file.complete()?;
        }
        sync_folder(&self.path);
        write_text(&self.path.join(SUMMARY), &summary.text())?;
        sync_folder(&self.path);
        Ok(summary)
    }

    /// Reads the results of a complete exchange.
    ///
    /// # Errors
    /// [`ExchangeFolderError::Incomplete`] if the exchange has not reached its end. [`ExchangeFolderError::Read`] if a
    /// file is missing or damaged. [`ExchangeFolderError::Table`] if a table has been changed.
    pub fn read(path: &Path) -> Result<ExchangeSummary, ExchangeFolderError> {
        let text = |name: &str| {
            let path = path.join(name);
            fs::read_to_string(&path).map_err(|source| ExchangeFolderError::Read { path, source })
        };
        let damaged = |name: &str, why: String| ExchangeFolderError::Read {
            path: path.join(name),
            source: io::Error::new(io::ErrorKind::InvalidData, why),
        };
        if Self::is_one(path) && !path.join(SUMMARY).exists() {
            return Err(ExchangeFolderError::Incomplete(path.to_owned()));
        }
        let mut summary: ExchangeSummary =
            serde_json::from_str(&text(SUMMARY)?).map_err(|error| damaged(SUMMARY, error.to_string()))?;
        // Summaries of old versions list no tables. An exchange between windows does not write all tables.
        let table = |name: &str| {
            summary.tables.get(name).map_or(Ok(None), |_| {
                let text = text(name)?;
                refuse_other(path, name, &summary, || Ok(checksum(text.as_bytes())))?;
                Ok::<_, ExchangeFolderError>(Some(text))
            })
        };
        let [energies, curves, levels] = [table(ENERGIES)?, table(CURVES)?, table(DENSITY)?];
        let [mean_force, measured] = [table(MEAN_FORCE)?, table(MEASUREMENTS)?];
        if let Some(text) = energies {
            tables::read_energies(&text, &mut summary.results).map_err(|why| damaged(ENERGIES, why))?;
        }
        if let Some(text) = curves {
            summary.curves = tables::read_curves(&text).map_err(|why| damaged(CURVES, why))?;
        }
        if let Some(text) = levels {
            summary.density_of_states = tables::read_density_of_states(&text).map_err(|why| damaged(DENSITY, why))?;
        }
        if let Some(text) = measured {
            measured::read(&text, &mut summary.results).map_err(|why| damaged(MEASUREMENTS, why))?;
        }
        if let Some(text) = mean_force {
            summary.potential_of_mean_force = tables::read_mean_force(&text).map_err(|why| damaged(MEAN_FORCE, why))?;
        }
        refuse_other(path, ROWS, &summary, || {
            let mut rows = Checked::new(io::sink());
            let copied = File::open(path.join(ROWS)).and_then(|mut file| io::copy(&mut file, &mut rows));
            copied.map_err(|source| ExchangeFolderError::Read { path: path.join(ROWS), source })?;
            Ok(rows.checksum())
        })?;
        Ok(summary)
    }

    /// Reads every `every`-th of the first `rows` rows of `exchange.csv`. Returns the simulated time of each row, and
    /// the replica at each temperature as an index.
    ///
    /// # Errors
    /// [`ExchangeFolderError::Read`] if the table is missing or damaged.
    pub fn read_places(path: &Path, every: usize, rows: usize) -> Result<Vec<(f64, Vec<usize>)>, ExchangeFolderError> {
        rows::places(&path.join(ROWS), every, rows)
    }
}

impl ExchangeRecorder for ExchangeFolder {
    type Error = OutputError;

    fn row(&mut self, row: &ExchangeRow<'_>) -> Result<(), OutputError> {
        self.rows.write(&tables::line(row))
    }

    fn frame(&mut self, place: usize, simulation: &Simulation) -> Result<(), OutputError> {
        let Some(file) = self.trajectories.get_mut(place) else { return Ok(()) };
        let path = file.path().to_owned();
        let written = self.frames.write_now(file.writer(), simulation);
        written.map_err(|source| OutputError::Frame { path, source })
    }

    fn is_checkpoint_due(&self) -> bool {
        self.checkpoints.is_due()
    }

    fn checkpoint(&mut self, exchange: &Exchange) -> Result<(), OutputError> {
        let files = std::iter::once(&mut self.rows).chain(&mut self.trajectories);
        let files: Vec<ManifestEntry> = files.map(|file| file.keep(&self.path)).collect::<Result<_, _>>()?;
        self.checkpoints.write(&(exchange, files))
    }
}

fn refuse_other(
    folder: &Path,
    name: &str,
    summary: &ExchangeSummary,
    found: impl FnOnce() -> Result<u32, ExchangeFolderError>,
) -> Result<(), ExchangeFolderError> {
    let Some(expected) = summary.tables.get(name).cloned() else { return Ok(()) };
    let found = spelled(found()?);
    if found == expected {
        Ok(())
    } else {
        Err(ExchangeFolderError::Table { path: folder.join(name), found, expected })
    }
}

fn trajectory_in(path: &Path, place: usize) -> PathBuf {
    path.join(trajectory_of(place))
}

fn trajectory_of(place: usize) -> String {
    format!("trajectory-{}.xyz", place + 1)
}
