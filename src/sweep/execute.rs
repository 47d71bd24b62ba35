//! Runs the points of a sweep, several at a time.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::error::SweepError;
use super::folder::SweepFolder;
use super::inputs::replaced;
use super::plan::{Point, Sweep};
use super::results::trouble_of;
use crate::base::text::with_causes;
use crate::io::{Existing, Folder, FolderState, OutputError, Summary};
use crate::run::{Ending, Finished, Progress, Run, RunError};

/// Outcome of a point.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fate {
    /// It was there already.
    Kept,
    /// It has been run to its end.
    Done,
    /// It cannot be run, or has not come to a good end: why.
    Failed(String),
    /// Another process is at it.
    Elsewhere,
    /// It was interrupted, and goes on from there the next time.
    Interrupted,
}

/// A part of the points: every N-th, for the tasks of a job array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Which one, from 1.
    pub number: usize,
    /// Of so many.
    pub of: usize,
}

impl Share {
    /// All points.
    pub const ALL: Self = Self { number: 1, of: 1 };

    /// Whether the point in this place, from 0, is in it.
    #[must_use]
    pub fn has(&self, place: usize) -> bool {
        place % self.of.max(1) + 1 == self.number
    }
}

/// How a sweep is run; nothing of it changes a result.
#[derive(Clone, Copy)]
pub struct Orders<'o> {
    /// Runs at the same time.
    pub jobs: usize,
    /// Which of the points.
    pub share: Share,
    /// Wall time between two checkpoints of a run.
    pub checkpoint_every: Duration,
    /// Largest size of the files of a run `[bytes]`.
    pub most_bytes: f64,
    /// The text of `report.txt` in the folder of a run.
    pub report: &'o (dyn Fn(&Finished) -> String + Sync),
}

/// Progress or outcome of a point.
#[derive(Debug)]
#[non_exhaustive]
pub enum News<'n> {
    /// Its run has come so far.
    Progress(&'n Progress),
    /// This has become of it.
    Over(&'n Fate),
}

impl SweepFolder {
    /// Runs the points of a share that are not there yet, and says what became of each, by its place in [`Sweep::points`]. A run that was
    /// interrupted goes on from its last checkpoint, to the same bits.
    ///
    /// `watch` is called from all threads, with the place of a point; where it breaks, that run is interrupted, and no other is begun.
    ///
    /// # Errors
    /// [`SweepError::Output`] if it cannot be kept why a run has failed. A run that fails is no error.
    pub fn execute(
        &self,
        sweep: &Sweep,
        orders: &Orders<'_>,
        watch: &(dyn Fn(usize, News<'_>) -> ControlFlow<()> + Sync),
    ) -> Result<Vec<(usize, Fate)>, SweepError> {
        let places: Vec<usize> = (0..sweep.points().len()).filter(|place| orders.share.has(*place)).collect();
        let (next, is_over) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let fates = Mutex::new(Vec::with_capacity(places.len()));
        let work = || -> Result<(), SweepError> {
            while is_over.load(Ordering::Relaxed) == 0 {
                let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed)) else { return Ok(()) };
                let point = &sweep.points()[place];
                let progress = &mut |progress: &Progress| watch(place, News::Progress(progress));
                let fate = self.execute_point(sweep, point, orders, progress)?;
                let flow = watch(place, News::Over(&fate));
                if flow.is_break() || fate == Fate::Interrupted {
                    is_over.store(1, Ordering::Relaxed);
                }
                // No thread panics while it holds the lock.
                fates.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((place, fate));
            }
            Ok(())
        };
        let jobs = orders.jobs.clamp(1, places.len().max(1));
        let results: Vec<Result<(), SweepError>> = thread::scope(|scope| {
            let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
            threads
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect()
        });
        results.into_iter().collect::<Result<Vec<()>, _>>()?;
        let mut fates = fates.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        fates.sort_unstable_by_key(|(place, _)| *place);
        Ok(fates)
    }

    /// Runs a point if it is not there yet, and says what became of it, as [`Self::execute`] does for all. `jobs` and `share` mean nothing here: the caller, a
    /// scheduler of its own, decides what runs when and where. Several processes may ask for the same point: one runs it.
    ///
    /// # Errors
    /// [`SweepError::Output`] if it cannot be kept why the run has failed. A run that fails is no error.
    pub fn execute_point(
        &self,
        sweep: &Sweep,
        point: &Point,
        orders: &Orders<'_>,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Fate, SweepError> {
        let fate = self.run(sweep, point, orders, watch);
        self.keep_fate(point, &fate)?;
        Ok(fate)
    }

    fn keep_fate(&self, point: &Point, fate: &Fate) -> Result<(), SweepError> {
        match fate {
            Fate::Failed(message) => self.keep_failure(point, Some(message)),
            Fate::Done => self.keep_failure(point, None),
            Fate::Kept | Fate::Elsewhere | Fate::Interrupted => Ok(()),
        }
    }

    fn run(
        &self,
        sweep: &Sweep,
        point: &Point,
        orders: &Orders<'_>,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Fate {
        let path = self.of(point);
        let begun = match self.state_of(point) {
            Ok(FolderState::Finished) => return self.over(point, &path),
            Ok(FolderState::Unfinished) => None,
            Ok(FolderState::Nothing) => match self.begin(sweep, point) {
                Ok(begun) => Some(begun),
                Err(Obstacle::Scene(message)) => return Fate::Failed(message),
                Err(Obstacle::Folder(OutputError::Finished(_))) => return Fate::Kept,
                Err(Obstacle::Folder(OutputError::Unfinished(_))) => None,
                Err(Obstacle::Folder(error)) => return fate_of(error),
            },
            Err(error) => return fate_of(error),
        };
        let resumed = || Folder::resume(&path, None).map(|(folder, checkpoint)| (folder, Run::resume(checkpoint)));
        match begun.map_or_else(resumed, Ok) {
            Ok((folder, run)) => finish(folder, run, orders, watch),
            Err(error) => fate_of(error),
        }
    }

    /// Outcome of a run that has ended. A conversion that is not there, as where the disk was full, is made now.
    fn over(&self, point: &Point, path: &Path) -> Fate {
        // One that was killed, and went on by itself, has failed without a word of it here.
        let trouble = || Summary::read(path).ok().and_then(|summary| trouble_of(&summary));
        let made = match Folder::convert_missing(path) {
            Ok(made) => made,
            Err(error) => return fate_of(error),
        };
        match made.failures.first() {
            Some(failure) => Fate::Failed(trouble().unwrap_or_else(|| one_line(failure))),
            None if made.files.is_empty() => self.failure(point).or_else(trouble).map_or(Fate::Kept, Fate::Failed),
            None => trouble().map_or(Fate::Done, Fate::Failed),
        }
    }

    fn begin(&self, sweep: &Sweep, point: &Point) -> Result<(Folder, Run), Obstacle> {
        let scene = sweep.scene_at(point).map_err(|error| Obstacle::Scene(one_line(&error)))?;
        if let Some((path, found, expected)) = replaced(&scene, self.inputs()) {
            let folder = self.path().to_owned();
            return Err(Obstacle::Scene(one_line(&SweepError::Input { path, found, expected, folder })));
        }
        let record = sweep.record_at(point, &scene).map_err(|error| Obstacle::Scene(one_line(&error)))?;
        let mut folder = Folder::create(&self.of(point), &scene, Existing::Keep).map_err(Obstacle::Folder)?;
        folder.keep_scene(&record).map_err(Obstacle::Folder)?;
        Ok((folder, Run::without_start(scene)))
    }
}

/// Why a point cannot be begun.
enum Obstacle {
    Scene(String),
    Folder(OutputError),
}

fn finish(folder: Folder, run: Run, orders: &Orders<'_>, watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> Fate {
    let mut folder = folder.checkpoint_every(orders.checkpoint_every).at_most(orders.most_bytes);
    let finished = match run.execute(&mut folder, watch) {
        Ok(finished) => finished,
        Err(RunError::Recorder(error)) => return fate_of(error),
        Err(error) => return Fate::Failed(one_line(&error)),
    };
    if let Some(excess) = folder.excess() {
        return fate_of(excess);
    }
    if finished.ending == Ending::Interrupted {
        // Its last checkpoint is all that it needs to go on.
        return Fate::Interrupted;
    }
    match folder.complete(&finished, &(orders.report)(&finished)) {
        Err(error) => fate_of(error),
        Ok(done) => match finished.trouble().or_else(|| done.failures.first().map(|failure| one_line(failure))) {
            Some(trouble) => Fate::Failed(trouble),
            None => Fate::Done,
        },
    }
}

fn fate_of(error: OutputError) -> Fate {
    match error {
        OutputError::Busy(_) => Fate::Elsewhere,
        error => Fate::Failed(one_line(&error)),
    }
}

/// The message of an error and those of what caused it, in one line.
fn one_line(error: &dyn std::error::Error) -> String {
    with_causes(error).replace('\n', " ")
}

#[cfg(test)]
mod tests;
