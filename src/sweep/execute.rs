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
use crate::model::Scene;
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
    /// Number of shares.
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

/// Options of the execution of a sweep. None changes a result.
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
    /// Registers user-defined instruments with a run, on its thread: [`Run::instrument`]. A resumed run needs the same instruments.
    pub instruments: &'o (dyn Fn(Run) -> Run + Sync),
    /// Their names, by which a run that began with others is refused before anything in its folder changes.
    pub instrument_names: &'o [String],
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
                    // Another process was at it meanwhile.
                    Err(OutputError::Finished(_)) => return Ok(Fate::Kept),
                    Err(OutputError::Unfinished(_)) => {}
                    Err(error) => return Err(error),
                }
            }
        }
        let (folder, checkpoint) = Folder::resume_with(&path, None, orders.instrument_names)?;
        finish(folder, Run::resume(checkpoint), orders, watch)
    }

    /// Outcome of a run that has ended. A conversion that is not there, as where the disk was full, is made now.
    fn over(&self, point: &Point, path: &Path) -> Result<Fate, OutputError> {
        // One that was killed, and went on by itself, has failed without a word of it here.
        let trouble = || Summary::read(path).ok().and_then(|summary| trouble_of(&summary));
        let made = Folder::convert_missing(path)?;
        Ok(match made.failures.first() {
            Some(failure) => trouble().map_or_else(|| failed(failure), Fate::Failed),
            None if made.files.is_empty() => self.failure(point).or_else(trouble).map_or(Fate::Kept, Fate::Failed),
            None => trouble().map_or(Fate::Done, Fate::Failed),
        })
    }

    /// The scene of a point, and the text from which it can be made again.
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
        // Its last checkpoint is all that it needs to go on.
        return Ok(Fate::Interrupted);
    }
    let done = folder.complete(&finished, &(orders.report)(&finished))?;
    let failure = || done.failures.first().map(|failure| failed(failure));
    Ok(finished.trouble().map(Fate::Failed).or_else(failure).unwrap_or(Fate::Done))
}

/// The message of an error and those of what caused it, in one line.
fn failed(error: &dyn std::error::Error) -> Fate {
    Fate::Failed(with_causes(error).replace('\n', " "))
}

#[cfg(test)]
mod tests;
