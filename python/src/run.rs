//! Runs in a folder, as with `carom run`.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use carom::analysis::instruments::CHAIN_SIZES;
use carom::analysis::observables::OBSERVABLES;
use carom::base::durability::without_sync;
use carom::base::text::with_causes;
use carom::exchange::DISTANCE;
use carom::io::estimate::{SizeEstimate, allowance, allowed, free_disk};
use carom::io::{Existing, Folder, refuse_input};
use carom::model::{Threads, Units, Until};
use carom::run::{Ending, Progress, Run, Stage, foreseen_rate};
use carom::scene::KeptParticles;
use carom::view::{final_table, report};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::error;
use crate::observe::{self, Observation};
use crate::scene::{Scene, borrowed};
use crate::signals::Signals;

pub struct Watch {
    signals: Signals,
    callback: Option<Py<PyAny>>,
    pub raised: Option<PyErr>,
}

impl Watch {
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { signals: Signals::new(), callback, raised: None }
    }

    pub fn see(&mut self, progress: &Progress) -> ControlFlow<()> {
        let stage = match progress.stage {
            Stage::Preparation(_) => "preparing",
            Stage::EquilibrationOf(_) | Stage::Equilibration => "equilibrating",
            _ => "measuring",
        };
        self.tell(stage, progress.fraction(), progress.time, progress.events)
    }

    pub fn steps(&self) -> u64 {
        self.signals.steps()
    }

    /// Calls the callback and checks for signals, if enough time has passed.
    pub fn tell(&mut self, stage: &str, fraction: f64, time: f64, events: u64) -> ControlFlow<()> {
        if self.raised.is_some() || observe::has_failed() {
            return ControlFlow::Break(());
        }
        if !self.signals.is_due() {
            return ControlFlow::Continue(());
        }
        let seen = Python::attach(|py| {
            py.check_signals()?;
            if let Some(callback) = &self.callback {
                callback.bind(py).call1((stage, fraction, time, events))?;
            }
            Ok(())
        });
        match seen {
            Ok(()) => ControlFlow::Continue(()),
            Err(raised) => {
                self.raised = Some(raised);
                ControlFlow::Break(())
            }
        }
    }
}

/// Returns the allowed size of an output, which is infinite with `force`. Raises an error if the predicted size `bytes`
/// is larger. `what` names the output in the message.
pub fn most_bytes(what: &str, bytes: f64, folder: &Path, force: bool) -> PyResult<f64> {
    if force {
        return Ok(f64::INFINITY);
    }
    allowed(bytes, folder).map_err(|too_large| {
        let cure = "choose longer intervals in [output], another out, or force=True";
        error::cured("FolderError", &format!("{what} {too_large}"), Some(cure))
    })
}

pub fn limit_of(time: Option<f64>, events: Option<u64>) -> PyResult<Option<Until>> {
    if let Some(time) = time.filter(|time| !(1e-50..=1e50).contains(time)) {
        return Err(PyValueError::new_err(format!("until_time: expected a time from 1e-50 to 1e50, found {time}")));
    }
    if events == Some(0) {
        return Err(PyValueError::new_err("until_events: expected a number of at least 1, found 0"));
    }
    Ok((time.is_some() || events.is_some()).then_some(Until { time, events }))
}

pub fn interval_of(seconds: f64) -> PyResult<Duration> {
    if !(1e-3..=1e9).contains(&seconds) {
        let message = format!("checkpoint_every: expected a time from 0.001 to 1e9 seconds, found {seconds}");
        return Err(PyValueError::new_err(message));
    }
    Ok(Duration::from_secs_f64(seconds))
}

pub fn threads_of(threads: Option<&str>) -> PyResult<Option<Threads>> {
    let parsed = threads.map(str::parse).transpose();
    parsed.map_err(|error: String| PyValueError::new_err(format!("threads: {error}")))
}

/// Executes a run. Returns the reason if the run has failed.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "all are keywords of one function of Python")]
pub fn run(
    py: Python<'_>,
    scene: &Scene,
    out: PathBuf,
    force: bool,
    checkpoint_every: f64,
    until_time: Option<f64>,
    until_events: Option<u64>,
    threads: Option<&str>,
    observe: Vec<(String, Py<PyAny>)>,
    every: f64,
    callback: Option<Py<PyAny>>,
    is_temporary: bool,
) -> PyResult<Option<String>> {
    let limit = limit_of(until_time, until_events)?;
    let interval = interval_of(checkpoint_every)?;
    let threads = threads_of(threads)?;
    let observation = Observation::new(observe, every)?;
    if scene.model.exchange().is_some() {
        let message = "the scene has [exchange], which describes several replicas";
        return Err(error::cured("SceneError", message, Some("use carom.exchange, or leave [exchange] out")));
    }
    let mut watch = Watch::new(callback);
    let work = || {
        let mut model = scene.model.clone();
        if let Some(limit) = limit {
            model = model.with_limit(limit).map_err(|error| error::scene(&error))?;
        }
        let particles = scene.given.as_ref().map(|given| given.0.file_for(&model)).transpose();
        let particles = particles.map_err(|error| PyRuntimeError::new_err(with_causes(&error)))?;
        let kept = particles.as_deref().map(|content| KeptParticles::InFile(Folder::PARTICLES, content));
        let record = model.record_with(scene.text.clone(), &scene.name, &borrowed(&scene.set), kept);
        let record = record.map_err(|error| error::scene(&error))?;
        refuse_input(&out, scene.inputs()).map_err(|error| error::output(&error))?;
        let bytes = SizeEstimate::of(&model, foreseen_rate(&model).ok()).bytes;
        let most = most_bytes("the run", bytes, &out, force)?;
        let existing = if force { Existing::Replace } else { Existing::Keep };
        let folder = Folder::create(&out, &model, existing).map_err(|error| error::output(&error))?;
        let mut folder = folder.checkpoint_every(interval).at_most(most);
        if let Some(content) = &particles {
            folder.keep_particles(content).map_err(|error| error::output(&error))?;
        }
        drop(particles);
        folder.keep_scene(&record).map_err(|error| error::output(&error))?;
        execute(Run::without_start(model), threads, observation, folder, &mut watch)
    };
    py.detach(|| if is_temporary { without_sync(work) } else { work() })
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "all are keywords of one function of Python")]
pub fn resume(
    py: Python<'_>,
    path: PathBuf,
    force: bool,
    checkpoint_every: f64,
    until_time: Option<f64>,
    until_events: Option<u64>,
    threads: Option<&str>,
    observe: Vec<(String, Py<PyAny>)>,
    every: f64,
    callback: Option<Py<PyAny>>,
    is_temporary: bool,
) -> PyResult<Option<String>> {
    let limit = limit_of(until_time, until_events)?;
    let interval = interval_of(checkpoint_every)?;
    let threads = threads_of(threads)?;
    let observation = Observation::new(observe, every)?;
    let mut watch = Watch::new(callback);
    let work = || {
        let (folder, checkpoint) =
            Folder::resume_with(&path, limit, &observation.names()).map_err(|error| error::output(&error))?;
        let most = if force { f64::INFINITY } else { allowance(free_disk(&path)) };
        let folder = folder.checkpoint_every(interval).at_most(most);
        execute(Run::resume(checkpoint), threads, observation, folder, &mut watch)
    };
    py.detach(|| if is_temporary { without_sync(work) } else { work() })
}

fn execute(
    run: Run,
    threads: Option<Threads>,
    observation: Observation,
    mut folder: Folder,
    watch: &mut Watch,
) -> PyResult<Option<String>> {
    let run = if let Some(threads) = threads { run.threads(threads) } else { run };
    let run = observation.of(run);
    let (finished, raised) = observation.during(|| run.execute(&mut folder, &mut |progress| watch.see(progress)));
    let finished = finished.map_err(|error| error::run(&error))?;
    let excess = folder.excess().filter(|_| finished.ending == Ending::Interrupted);
    let done = folder.complete(&finished, &final_table::text(&finished)).map_err(|error| error::output(&error))?;
    if let Some(raised) = raised.or_else(|| watch.raised.take()) {
        return Err(raised);
    }
    if let Some(excess) = excess {
        return Err(error::output(&excess));
    }
    let unconverted = done.failures.first();
    Ok(finished
        .trouble()
        .or_else(|| unconverted.map(|it| format!("the trajectory was not converted: {}", with_causes(it)))))
}

#[pyfunction]
#[pyo3(signature = (dimensions, names = None))]
pub fn observable_units(dimensions: usize, names: Option<[String; 3]>) -> BTreeMap<&'static str, String> {
    let units = names.map_or_else(Units::default, |[length, mass, time]| Units::new(&length, &mass, &time));
    OBSERVABLES
        .iter()
        .chain(&CHAIN_SIZES)
        .chain([&DISTANCE])
        .map(|(name, unit)| (*name, units.of(unit, dimensions)))
        .collect()
}

#[pyfunction]
pub fn page(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let page = py.detach(|| report::page(&path)).map_err(|error| error::report(&error))?;
    Ok(page.html)
}
