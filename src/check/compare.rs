//! Compares the files of a run with the files of a replay.
//!
//! A run depends only on the scene and the seed. A file that differs was changed, or written by another version.

mod content;

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use content::Difference;

use crate::base::durability::without_sync;
use crate::io::estimate::free_disk;
use crate::io::{Existing, Folder, OutputError, Summary, read_scene};
use crate::model::{Scene, Until};
use crate::run::checkpoint::CheckpointError;
use crate::run::{Finished, Progress, Run, RunError};
use crate::scene::SceneError;

/// Result of comparing the files of a run with the files of its replay.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Comparison {
    /// Files that are identical.
    pub equal: Vec<String>,
    /// Files that differ or are missing, each with its first difference.
    pub differences: Vec<(String, Difference)>,
    /// Files that were not compared or only partly compared, with the reason.
    pub not_compared: Vec<(String, &'static str)>,
    /// Whether the caller stopped the comparison before it was complete.
    pub is_interrupted: bool,
}

/// Reason why the files of a run cannot be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error from the operating system.
        source: io::Error,
    },
    /// There is not enough disk space for the files of the replay.
    #[error("the replay writes {} into {}, where {} are free", crate::base::text::size(*bytes), folder.display(), crate::base::text::size(*free))]
    NoRoom {
        /// Temporary folder.
        folder: PathBuf,
        /// Size of the files of the run `[bytes]`.
        bytes: f64,
        /// Free space on the disk `[bytes]`.
        free: f64,
    },
    /// The scene of the run cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The files of the replay cannot be written.
    #[error("cannot write the files of the replay: {0}")]
    Output(#[from] OutputError),
    /// The replay cannot be started.
    #[error("cannot replay the run: {0}")]
    Run(String),
}

impl CompareError {
    /// Advice to the user, shown with the error.
    pub const CURE: &'static str =
        "set the environment variable TMPDIR to a folder with more space, or leave the files out with --no-files";
}

const CHECKSUM: &str = "only its checksum";
const REPLAYED: &str = "the input of the replay";
const CHECKPOINT: &str = "only its checksum, because it contains wall times";
const NEWER: &str = "written by another build of Carom";
const OWN: &str = "the run had registered instruments, which a replay lacks";
const LIST: &str = "the list of the files";
const MADE: &str = "made from the other files";
const FOREIGN: &str = "not written by the replay";
const SUMMARY: &str = "everything except version, engine and speed";
const REPORT: &str = "everything except the lines about engine and speed";
const OTHER_SCENE: &str = "the scene differs from the scene of the run";
const FREE_TEXT: &str = "a text that Carom did not write";

#[derive(Debug, Default)]
struct Known {
    planned: Option<Until>,
    has_own_instruments: bool,
    is_scene_checked: bool,
}

/// Simulates the run in a folder again and compares the files of both simulations. `report` returns the text of
/// `report.txt`. If the run was interrupted or stopped by a user's instrument, the replay stops at the same time.
///
/// # Errors
/// [`CompareError`] if the files of the run cannot be read, or if the replay fails.
pub fn compare(
    run: &Path,
    report: &dyn Fn(&Finished) -> String,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Comparison, CompareError> {
    let names = files_in(run)?;
    let mut comparison = Comparison::default();
    let known = checkpoints(run, &names, &mut comparison);
    if comparison.is_different(Folder::SCENE) {
        // If the scene differs, the remaining files belong to another run.
        let others = names.into_iter().filter(|name| !comparison.is_listed(name)).map(|name| (name, OTHER_SCENE));
        let others: Vec<_> = others.collect();
        comparison.not_compared.extend(others);
        return Ok(comparison);
    }
    let summary = Folder::summary_of(run);
    let recorded = Summary::read(run).map_err(|source| CompareError::Read { path: summary, source })?;
    let (temporary, bytes) = room(run, &names)?;
    let target = temporary.path().join("replay");
    match without_sync(|| replay(run, &target, &recorded, (known.planned, bytes), report, watch))? {
        Replayed::Complete => {}
        Replayed::Stopped => return Ok(Comparison { is_interrupted: true, ..Comparison::default() }),
        Replayed::GoesOn => {
            let why = format!("the replay continues beyond t = {}, the end of the run", recorded.time);
            comparison.differences.push((Folder::SUMMARY.to_owned(), Difference::Damaged(why)));
            return Ok(comparison);
        }
    }
    let replayed = files_in(&target)?;
    for name in names.union(&replayed) {
        if comparison.is_listed(name) {
            continue;
        }
        if !names.contains(name) {
            if !Folder::is_checkpoint(name) {
                comparison.differences.push((name.clone(), Difference::Missing));
            }
            continue;
        }
        if let Some(why) = left_out(name, &known, replayed.contains(name)) {
            comparison.not_compared.push((name.clone(), why));
            continue;
        }
        let ends_itself = recorded.ending.as_deref() == Some(CONDITION);
        let found = content::compare(name, &run.join(name), &target.join(name), ends_itself)
            .map_err(|source| CompareError::Read { path: run.join(name), source })?;
        match found {
            content::Found::Equal => {
                comparison.equal.push(name.clone());
                let partly = [(Folder::SUMMARY, SUMMARY), (Folder::REPORT, REPORT)];
                let why = partly.into_iter().find(|(other, _)| other == name);
                comparison.not_compared.extend(why.map(|(name, why)| (name.to_owned(), why)));
            }
            content::Found::Different(difference) => comparison.differences.push((name.clone(), difference)),
            content::Found::OtherText => comparison.not_compared.push((name.clone(), FREE_TEXT)),
        }
    }
    Ok(comparison)
}

impl Comparison {
    fn is_different(&self, name: &str) -> bool {
        self.differences.iter().any(|(other, _)| other == name)
    }

    fn is_listed(&self, name: &str) -> bool {
        self.is_different(name) || self.not_compared.iter().any(|(other, _)| other == name)
    }
}

/// Endings that the scene does not determine: an interruption by the user, and the condition of a user's instrument.
const INTERRUPTED: &str = "interrupted";
const CONDITION: &str = "condition";

/// Reads the checkpoints of a run, and checks the scene file against them.
fn checkpoints(run: &Path, names: &BTreeSet<String>, comparison: &mut Comparison) -> Known {
    let mut known = Known::default();
    for name in names.iter().filter(|name| Folder::is_checkpoint(name)) {
        match Folder::read_checkpoint(run, name) {
            Ok(checkpoint) => {
                comparison.not_compared.push((name.clone(), CHECKPOINT));
                known.planned = known.planned.or(checkpoint.state.planned_before());
                known.has_own_instruments |= !checkpoint.state.registered().is_empty();
                match Folder::check_scene(run, &checkpoint.manifest) {
                    Ok(is_there) => known.is_scene_checked |= is_there,
                    Err(error) => {
                        let difference = Difference::Damaged(error.to_string());
                        comparison.differences.push((Folder::SCENE.to_owned(), difference));
                    }
                }
            }
            Err(CheckpointError::OtherVersion { .. }) => comparison.not_compared.push((name.clone(), NEWER)),
            Err(error) => comparison.differences.push((name.clone(), Difference::Damaged(error.to_string()))),
        }
    }
    comparison.differences.dedup_by(|one, other| one.0 == other.0);
    known
}

fn left_out(name: &str, known: &Known, is_replayed: bool) -> Option<&'static str> {
    let is_measured = name == Folder::REPORT || Folder::is_measurement(name);
    match name {
        Folder::LIST => Some(LIST),
        Folder::SCENE if known.is_scene_checked => Some(CHECKSUM),
        Folder::SCENE => Some(REPLAYED),
        Folder::PARTICLES => Some(CHECKSUM),
        _ if known.has_own_instruments && is_measured => Some(OWN),
        _ if Folder::is_view(name) => Some(MADE),
        _ if !is_replayed => Some(FOREIGN),
        _ => None,
    }
}

/// Creates a temporary folder if the disk has enough space for a run's files. Also returns their size `[bytes]`.
fn room(run: &Path, names: &BTreeSet<String>) -> Result<(tempfile::TempDir, f64), CompareError> {
    let folder = std::env::temp_dir();
    let bytes = names.iter().filter_map(|name| fs::metadata(run.join(name)).ok()).map(|it| it.len() as f64).sum();
    if let Some(free) = free_disk(&folder).filter(|free| *free < bytes) {
        return Err(CompareError::NoRoom { folder, bytes, free });
    }
    let made = tempfile::Builder::new().prefix("carom-verify-").tempdir_in(&folder);
    let made = made.map_err(|source| OutputError::Folder { path: folder, source })?;
    Ok((made, bytes))
}

fn replay(
    run: &Path,
    target: &Path,
    recorded: &Summary,
    (planned, bytes): (Option<Until>, f64),
    report: &dyn Fn(&Finished) -> String,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Replayed, CompareError> {
    let (scene, text) = scene_of(run)?;
    // A scene that does not belong to the run could write files of any size, so the size is limited.
    let mut folder = Folder::create(target, &scene, Existing::Keep)?.at_most(2.0 * bytes + SOME_BYTES);
    folder.keep_scene(&text)?;
    let again = Run::without_start(scene).planned_for(planned);
    let (mut is_stopped, mut goes_on) = (false, false);
    let latest = recorded.time + BEYOND * recorded.time.abs();
    let mut stoppable = |progress: &Progress| {
        goes_on |= progress.time > latest;
        is_stopped |= watch(progress).is_break();
        if goes_on || is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let finished = match recorded.ending.as_deref() {
        Some(INTERRUPTED | CONDITION) => {
            let events = recorded.events.before.unwrap_or_default().saturating_add(recorded.events.total);
            again.execute_up_to(events, recorded.time, &mut folder, &mut stoppable)
        }
        _ => again.execute(&mut folder, &mut stoppable),
    };
    let finished = finished.map_err(|error| match error {
        RunError::Recorder(error) => error.into(),
        RunError::Instrument(error) => CompareError::Run(error.to_string()),
    })?;
    if is_stopped {
        return Ok(Replayed::Stopped);
    }
    if goes_on {
        return Ok(Replayed::GoesOn);
    }
    folder.complete(&finished, &report(&finished))?;
    Ok(Replayed::Complete)
}

/// Number of bytes by which a replay may exceed twice the size of the run.
const SOME_BYTES: f64 = 1e6;

/// A replay is stopped if its simulated time exceeds the end of the run by this fraction.
const BEYOND: f64 = 0.01;

enum Replayed {
    Complete,
    Stopped,
    GoesOn,
}

/// Reads the scene of a run. Its trajectory formats are set to the formats found in the folder.
fn scene_of(run: &Path) -> Result<(Scene, String), CompareError> {
    let path = Folder::scene_of(run);
    let text = fs::read_to_string(&path).map_err(|source| CompareError::Read { path: path.clone(), source })?;
    let mut scene = read_scene(&path, &[])?;
    scene.output.formats = Folder::formats_of(run);
    Ok((scene, text))
}

fn files_in(folder: &Path) -> Result<BTreeSet<String>, CompareError> {
    let mut names = BTreeSet::new();
    collect(folder, "", &mut names).map_err(|source| CompareError::Read { path: folder.to_owned(), source })?;
    Ok(names)
}

fn collect(folder: &Path, prefix: &str, names: &mut BTreeSet<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        match entry.file_type()? {
            kind if kind.is_dir() && name == Folder::REPLACEMENT_FOLDER => {}
            kind if kind.is_dir() => collect(&entry.path(), &format!("{name}/"), names)?,
            _ => {
                names.insert(name);
            }
        }
    }
    Ok(())
}
