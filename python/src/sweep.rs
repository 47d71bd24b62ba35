//! Sweeps. Any process can run a point.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use carom::io::Existing;
use carom::io::estimate::{allowance, free_disk};
use carom::run::Run;
use carom::sweep::{Axis, Fate, News, Orders, Results, Share, Standing, Sweep as Model, SweepFolder};
use carom::view::{final_table, report};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::error;
use crate::observe::{self, Observation};
use crate::run::{Watch, interval_of, most_bytes};
use crate::scene::borrowed;

const PAUSE: Duration = Duration::from_millis(5);

/// A scene, and the axes along which a sweep varies it.
#[pyclass(frozen, module = "carom._carom")]
pub struct Sweep(Model);

/// Functions of a frame by name, and the time between two calls.
type Observed = (Vec<(String, Py<PyAny>)>, f64);

/// Whether files are replaced, the time between two checkpoints, and the functions that observe the runs.
type Observing = ((bool, f64), Observed);

/// Folder of a point, with keys and values.
type PointOf = (String, Vec<(String, String)>);

#[pymethods]
impl Sweep {
    /// A sweep of the scene `text` or, without `text`, of the scene in the file `name`.
    #[new]
    fn new(name: PathBuf, text: Option<String>, set: Vec<(String, String)>, vary: Vec<String>) -> PyResult<Self> {
        let axes = vary.iter().map(|axis| axis.parse::<Axis>()).collect::<Result<Vec<_>, _>>();
        let axes = axes.map_err(|error| error::sweep(&error.into()))?;
        let made = match text {
            Some(text) => Model::of_text(text, name, &borrowed(&set), axes),
            None => Model::new(name, &borrowed(&set), axes),
        };
        made.map(Self).map_err(|error| error::sweep(&error))
    }

    #[staticmethod]
    fn open(folder: PathBuf) -> PyResult<Self> {
        Model::from_file(SweepFolder::file_in(&folder)).map(Self).map_err(|error| error::sweep(&error))
    }

    fn points(&self) -> Vec<PointOf> {
        self.0.points().iter().map(|point| (point.folder().to_owned(), point.settings().to_vec())).collect()
    }

    fn names(&self) -> Vec<String> {
        self.0.short_names()
    }

    /// Checks the sweep before any folder is created.
    fn check(&self, py: Python<'_>, folder: PathBuf, force: bool) -> PyResult<()> {
        py.detach(|| {
            let scene = self.0.check().map_err(|error| error::sweep(&error))?;
            if scene.exchange().is_some() {
                let message = "a sweep cannot run a scene with [exchange]";
                let cure = "call carom.exchange in a loop, with another out for each call";
                return Err(error::cured("SweepError", message, Some(cure)));
            }
            most_bytes("the sweep", self.0.expected_bytes(&scene), &folder, force).map(|_| ())
        })
    }

    /// Creates or opens the folder of the sweep.
    fn begin(&self, folder: PathBuf) -> PyResult<()> {
        SweepFolder::open(folder, &self.0).map(|_| ()).map_err(|error| error::sweep(&error))
    }

    /// Runs the point in this folder, unless it has results. Returns the outcome and, if the point failed, the reason.
    fn run_point(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        name: &str,
        orders: Observing,
    ) -> PyResult<(&'static str, Option<String>)> {
        let ((force, checkpoint_every), observe) = orders;
        let interval = interval_of(checkpoint_every)?;
        let Some(point) = self.0.points().iter().find(|point| point.folder() == name) else {
            return Err(PyKeyError::new_err(format!("the sweep in {} has no point {name}", folder.display())));
        };
        let observation = Observation::new(observe.0, observe.1)?;
        let mut watch = Watch::new(None);
        let (fate, raised) = py.detach(|| {
            let opened = SweepFolder::existing(&folder).map_err(|error| error::sweep(&error))?;
            let instruments = |run: Run| observation.of(run);
            let names = observation.names();
            let orders = orders_for(1, interval, (&folder, force), (&instruments, &names));
            let execute = || opened.execute_point(&self.0, point, &orders, &mut |progress| watch.see(progress));
            let (fate, raised) = observation.during(execute);
            Ok::<_, PyErr>((fate.map_err(|error| error::sweep(&error))?, raised))
        })?;
        match raised.or_else(|| watch.raised.take()) {
            Some(raised) => Err(raised),
            None => Ok(words(fate)),
        }
    }

    /// Runs all points without results, in threads.
    fn run_all(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        jobs: usize,
        orders: Observing,
        callback: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(String, &'static str, Option<String>)>> {
        let ((force, checkpoint_every), observe) = orders;
        let interval = interval_of(checkpoint_every)?;
        let observation = Observation::new(observe.0, observe.1)?;
        let instruments = |run: Run| observation.begin(run);
        let failure: Mutex<Option<PyErr>> = Mutex::new(None);
        let (parts, is_over) = (Mutex::new(vec![0.0; self.0.points().len()]), AtomicBool::new(false));
        let mut watch = Watch::new(callback);
        // No thread panics while it holds the lock.
        let parts = || parts.lock().unwrap_or_else(PoisonError::into_inner);
        let see = |place: usize, news: News<'_>| {
            match news {
                News::Progress(progress) => parts()[place] = progress.fraction(),
                News::Over(_) => {
                    parts()[place] = 1.0;
                    if let Some(raised) = observe::end() {
                        is_over.store(true, Ordering::Relaxed);
                        failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(raised);
                    }
                }
                _ => {}
            }
            if observe::has_failed() || is_over.load(Ordering::Relaxed) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let fates = py.detach(|| {
            let opened = SweepFolder::existing(&folder).map_err(|error| error::sweep(&error))?;
            let names = observation.names();
            let orders = orders_for(jobs, interval, (&folder, force), (&instruments, &names));
            // Signals reach only this thread, so the other threads run the simulations.
            let ran = thread::scope(|scope| {
                let runs = scope.spawn(|| opened.execute(&self.0, &orders, &see));
                while !runs.is_finished() {
                    thread::sleep(PAUSE);
                    let (done, all) = so_far(&parts());
                    if watch.tell("sweeping", all, 0.0, done).is_break() {
                        is_over.store(true, Ordering::Relaxed);
                    }
                }
                runs.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            });
            ran.map_err(|error| error::sweep(&error))
        })?;
        let failure = failure.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(raised) = failure.or_else(|| watch.raised.take()) {
            return Err(raised);
        }
        let named = |(place, fate): (usize, Fate)| {
            let (word, why) = words(fate);
            (self.0.points()[place].folder().to_owned(), word, why)
        };
        Ok(fates.into_iter().map(named).collect())
    }

    /// Writes the tables and the page with the results so far.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| {
            let opened = SweepFolder::existing(&folder).map_err(|error| error::sweep(&error))?;
            let results = Results::read(&opened, &self.0);
            opened.write_tables(&self.0, &results).map_err(|error| error::sweep(&error))?;
            // Ignores failures to write the pages of runs, because runs are complete without them.
            let _ = report::write_run_pages(&opened, &self.0, &results);
            let page = report::sweep_page(&opened, &self.0, &results);
            let written = report::write(&page, &report::sweep_page_in(&folder), Existing::Replace);
            written.map_err(|error| error::report(&error))
        })
    }

    /// State of each point: `done`, `failed` with the reason, `begun` or `missing`.
    fn standing(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<(String, &'static str, Option<String>)>> {
        py.detach(|| {
            let opened = SweepFolder::existing(&folder).map_err(|error| error::sweep(&error))?;
            let standing = self.0.points().iter().zip(Results::read(&opened, &self.0).points).map(|(point, result)| {
                let (word, why) = match result.standing {
                    Standing::Done => ("done", None),
                    Standing::Failed(why) => ("failed", Some(why)),
                    Standing::Begun => ("begun", None),
                    _ => ("missing", None),
                };
                (point.folder().to_owned(), word, why)
            });
            Ok(standing.collect())
        })
    }
}

fn so_far(parts: &[f64]) -> (u64, f64) {
    let done = parts.iter().filter(|part| **part >= 1.0).count();
    (done as u64, parts.iter().sum::<f64>() / parts.len().max(1) as f64)
}

type Instruments<'o> = &'o (dyn Fn(Run) -> Run + Sync);

fn orders_for<'o>(
    jobs: usize,
    checkpoint_every: Duration,
    (folder, force): (&Path, bool),
    (instruments, instrument_names): (Instruments<'o>, &'o [String]),
) -> Orders<'o> {
    Orders {
        jobs,
        share: Share::ALL,
        checkpoint_every,
        most_bytes: if force { f64::INFINITY } else { allowance(free_disk(folder)) },
        report: &final_table::text,
        instruments,
        instrument_names,
    }
}

fn words(fate: Fate) -> (&'static str, Option<String>) {
    match fate {
        Fate::Done => ("done", None),
        Fate::Kept => ("kept", None),
        Fate::Failed(why) => ("failed", Some(why)),
        Fate::Elsewhere => ("elsewhere", None),
        _ => ("interrupted", None),
    }
}
