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
use crate::model::Scene;
use crate::run::{Ending, Finished, Progress, Run, RunError};

/// Outcome of a point of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fate {
    /// The run had ended before this sweep was executed.
    Kept,
    /// The run was executed to its end.
    Done,
    /// The run failed or could not start, for the given reason.
    Failed(String),
    /// Another process is running the point.
    Elsewhere,
    /// The run was interrupted, and can be continued.
    Interrupted,
}

/// The points for one task of a job array: every N-th point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Number of this share, from 1.
    pub number: usize,
    /// Number of shares.
    pub of: usize,
}

impl Share {
    /// All points.
    pub const ALL: Self = Self { number: 1, of: 1 };

    /// Returns true if the share contains the point with this index. Indices start at 0.
    #[must_use]
    pub fn has(&self, place: usize) -> bool {
        place % self.of.max(1) + 1 == self.number
    }
}

/// Options for running a sweep. They do not affect the results.
#[derive(Clone, Copy)]
pub struct Orders<'o> {
    /// Largest number of simultaneous runs.
    pub jobs: usize,
    /// Points to run.
    pub share: Share,
    /// Wall time between two checkpoints of a run.
    pub checkpoint_every: Duration,
    /// A run is interrupted when its files exceed this size `[bytes]`.
    pub most_bytes: f64,
    /// Creates the text of `report.txt` for a finished run.
    pub report: &'o (dyn Fn(&Finished) -> String + Sync),
    /// Adds custom instruments to a run by [`Run::instrument`]. This function is called in the thread of the run. A
    /// resumed run needs the same instruments.
    pub instruments: &'o (dyn Fn(Run) -> Run + Sync),
    /// Names of the custom instruments. A run with other instruments is rejected.
    pub instrument_names: &'o [String],
}

/// Progress or outcome of a run.
#[derive(Debug)]
#[non_exhaustive]
pub enum News<'n> {
    /// Progress of the run.
    Progress(&'n Progress),
    /// Outcome of the point.
    Over(&'n Fate),
}

impl SweepFolder {
    /// Runs the unfinished points of a share. Returns each outcome with the index of the point in [`Sweep::points`]. An
    /// interrupted run continues from its last checkpoint, and has the same results as an uninterrupted run.
    ///
    /// Calls `watch` from all threads, with the index of a point. If `watch` returns [`ControlFlow::Break`], the run is
    /// interrupted and no further runs start. Points that have not started have no outcome.
    ///
    /// # Errors
    /// [`SweepError::Output`] if the reason for a failure cannot be recorded. A failed run is not an error.
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

    /// Runs one point, if it is unfinished, and returns the outcome. Ignores `jobs` and `share`. If several processes
    /// request the same point, only one process runs it.
    ///
    /// # Errors
    /// [`SweepError::Output`] if the reason for a failure cannot be recorded. A failed run is not an error.
    pub fn execute_point(
        &self,
        sweep: &Sweep,
        point: &Point,
        orders: &Orders<'_>,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Fate, SweepError> {
        let fate = self.run(sweep, point, orders, watch).unwrap_or_else(|error| match error {
            OutputError::Busy(_) => Fate::Elsewhere,
            error => failed(&error),
        });
        match &fate {
            Fate::Failed(message) => self.keep_failure(point, Some(message))?,
            Fate::Done => self.keep_failure(point, None)?,
            Fate::Kept | Fate::Elsewhere | Fate::Interrupted => {}
        }
        Ok(fate)
    }

    fn run(
        &self,
        sweep: &Sweep,
        point: &Point,
        orders: &Orders<'_>,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Fate, OutputError> {
        let path = self.of(point);
        match self.state_of(point)? {
            FolderState::Finished => return self.over(point, &path),
            FolderState::Unfinished => {}
            FolderState::Nothing => {
                let (scene, record) = match self.scene(sweep, point) {
                    Ok(scene) => scene,
                    Err(error) => return Ok(failed(&error)),
                };
                match Folder::create(&path, &scene, Existing::Keep) {
                    Ok(mut folder) => {
                        folder.keep_scene(&record)?;
                        return finish(folder, Run::without_start(scene), orders, watch);
                    }
                    // Another process has finished this run in the meantime.
                    Err(OutputError::Finished(_)) => return Ok(Fate::Kept),
                    Err(OutputError::Unfinished(_)) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        let (folder, checkpoint) = Folder::resume_with(&path, None, orders.instrument_names)?;
        finish(folder, Run::resume(checkpoint), orders, watch)
    }

    /// Returns the outcome of a finished run, and completes missing conversions.
    fn over(&self, point: &Point, path: &Path) -> Result<Fate, OutputError> {
        // If a run was continued outside the sweep, the folder of the sweep has no record of its failure.
        let trouble = || Summary::read(path).ok().and_then(|summary| trouble_of(&summary));
        let made = Folder::convert_missing(path)?;
        Ok(match made.failures.first() {
            Some(failure) => trouble().map_or_else(|| failed(failure), Fate::Failed),
            None if made.files.is_empty() => self.failure(point).or_else(trouble).map_or(Fate::Kept, Fate::Failed),
            None => trouble().map_or(Fate::Done, Fate::Failed),
        })
    }

    fn scene(&self, sweep: &Sweep, point: &Point) -> Result<(Scene, String), SweepError> {
        let scene = sweep.scene_at(point)?;
        if let Some((path, found, expected)) = replaced(&scene, self.inputs()) {
            return Err(SweepError::Input { path, found, expected, folder: self.path().to_owned() });
        }
        let record = sweep.record_at(point, &scene)?;
        Ok((scene, record))
    }
}

fn finish(
    folder: Folder,
    run: Run,
    orders: &Orders<'_>,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Fate, OutputError> {
    let mut folder = folder.checkpoint_every(orders.checkpoint_every).at_most(orders.most_bytes);
    let finished = match (orders.instruments)(run).execute(&mut folder, watch) {
        Ok(finished) => finished,
        Err(RunError::Recorder(error)) => return Err(error),
        Err(error) => return Ok(failed(&error)),
    };
    if let Some(excess) = folder.excess() {
        return Err(excess);
    }
    if finished.ending == Ending::Interrupted {
        return Ok(Fate::Interrupted);
    }
    let done = folder.complete(&finished, &(orders.report)(&finished))?;
    let failure = || done.failures.first().map(|failure| failed(failure));
    Ok(finished.trouble().map(Fate::Failed).or_else(failure).unwrap_or(Fate::Done))
}

fn failed(error: &dyn std::error::Error) -> Fate {
    Fate::Failed(with_causes(error).replace('\n', " "))
}

#[cfg(test)]
mod tests;
