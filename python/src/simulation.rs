//! A simulation, event by event.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};

use carom::Vector;
use carom::analysis::observables::ApplicableObservables;
use carom::engine::event::{Event, EventCounts};
use carom::engine::{NeedsRun, PairStates, ParticleNow, Reason, Simulation as Engine, Until};
use carom::io::{Existing, load_simulation, save_simulation, simulation_from_bytes, simulation_to_bytes};
use carom::model::Thermostat;
use carom::model::space::Boundary;
use carom::run::{Run, RunError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyDict};

use crate::array::{Number, array};
use crate::error;
use crate::event;
use crate::run::{Watch, threads_of};
use crate::saved::{Beside, engine_of};
use crate::scene::{Scene, dictionary};
use crate::signals::Signals;

pub struct State {
    pub engine: Engine,
    /// Events that an interrupted call did not return.
    pub pending: Vec<u8>,
    /// Number of heat baths set so far. Each bath has its own random numbers.
    pub baths: usize,
}

impl State {
    fn of(engine: Engine) -> Self {
        Self { engine, pending: Vec::new(), baths: 0 }
    }
}

/// Temperature, rate and axes of a heat bath.
type Bath = (f64, f64, [bool; 3]);

/// A simulation for one thread at a time. While a call is in progress, calls from other threads raise an error.
#[pyclass(frozen, module = "carom._carom")]
pub struct Simulation(Mutex<State>);

impl Simulation {
    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        self.0.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => error::busy("the simulation"),
            TryLockError::Poisoned(_) => error::cured("SimulationError", "the simulation failed earlier", None),
        })
    }

    /// Returns an array with `K` numbers for each particle, in the order of the ids.
    fn numbers<'py, T: Number, const K: usize>(
        &self,
        py: Python<'py>,
        of: impl Fn(&ParticleNow) -> [T; K] + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let state = self.state()?;
        let numbers = py.detach(|| {
            let mut numbers = Vec::with_capacity(K * state.engine.population().iter().sum::<usize>());
            let Ok(()) = state.engine.for_each_now(|particle| {
                numbers.extend(of(&particle));
                Ok::<(), std::convert::Infallible>(())
            });
            numbers
        });
        array(py, numbers, (K > 1).then_some(K))
    }
}

fn word(reason: Reason) -> &'static str {
    match reason {
        Reason::Time => "time",
        Reason::Events => "events",
        Reason::Observer => "stop",
        _ => "idle",
    }
}

/// Completed fraction of a call, by time or by events. The larger fraction is returned.
fn part(of_time: f64, done: u64, events: u64) -> f64 {
    of_time.max(done as f64 / events.max(1) as f64).clamp(0.0, 1.0)
}

fn until(time: f64, events: u64) -> PyResult<Until> {
    if time.is_nan() {
        return Err(PyValueError::new_err("expected a time that is a number, found nan"));
    }
    Ok(Until::time(time).or_events(events))
}

#[pymethods]
impl Simulation {
    /// Creates a simulation at the start of a scene. If `plan` is true, rejects scenes with a plan that requires a run.
    #[new]
    fn new(py: Python<'_>, scene: &Scene, plan: bool, threads: Option<&str>) -> PyResult<Self> {
        let model = scene.model.clone();
        let threads = threads_of(threads)?;
        let made = py.detach(|| if plan { Engine::new(model) } else { Ok(Engine::without_plan(model)) });
        let mut engine = made.map_err(|error| error::needs_run(&error))?;
        if let Some(threads) = threads {
            engine.set_threads(threads);
        }
        Ok(Self(Mutex::new(State::of(engine))))
    }

    /// Runs a scene up to the start of the last measurement, and returns the simulation at this point.
    #[staticmethod]
    fn prepared(py: Python<'_>, scene: &Scene, threads: Option<&str>, callback: Option<Py<PyAny>>) -> PyResult<Self> {
        let (model, threads) = (scene.model.clone(), threads_of(threads)?);
        if model.exchange().is_some() {
            return Err(error::needs_run(&NeedsRun::Exchange));
        }
        if matches!(model.run().thermostat, Some(Thermostat::Rescaling { .. })) {
            return Err(error::needs_run(&NeedsRun::Rescaling));
        }
        if model.run().barostat.is_some() {
            return Err(error::needs_run(&NeedsRun::Barostat));
        }
        if model.run().swap.is_some() {
            return Err(error::needs_run(&NeedsRun::Swap));
        }
        let mut watch = Watch::new(callback);
        let (run, ending) = py.detach(|| {
            let run = Run::new(model);
            let run = if let Some(threads) = threads { run.threads(threads) } else { run };
            run.prepare(&mut |progress| watch.see(progress)).map_err(|error| error::run(&RunError::Instrument(error)))
        })?;
        if let Some(raised) = watch.raised.take() {
            return Err(raised);
        }
        match ending {
            None => Ok(Self(Mutex::new(State::of(run.into_simulation())))),
            Some(ending) => Err(error::unprepared(&ending)),
        }
    }

    fn save(&self, py: Python<'_>, scene: &Scene, path: PathBuf, force: bool) -> PyResult<()> {
        let state = self.state()?;
        let existing = if force { Existing::Replace } else { Existing::Keep };
        let saved = py.detach(|| save_simulation(&path, &state.engine, &Beside::of(scene, &state), existing));
        saved.map_err(|error| error::saved(&error))
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, threads: Option<&str>) -> PyResult<(Self, Scene)> {
        let threads = threads_of(threads)?;
        let loaded = py.detach(|| load_simulation::<Beside>(&path).map(|loaded| engine_of(loaded, threads)));
        let (state, scene) = loaded.map_err(|error| error::saved(&error))?;
        Ok((Self(Mutex::new(state)), scene))
    }

    fn to_bytes<'py>(&self, py: Python<'py>, scene: &Scene) -> PyResult<Bound<'py, PyBytes>> {
        let state = self.state()?;
        let bytes = py.detach(|| simulation_to_bytes(&state.engine, &Beside::of(scene, &state)));
        Ok(PyBytes::new(py, &bytes?))
    }

    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<(Self, Scene)> {
        let loaded = py.detach(|| simulation_from_bytes::<Beside>(bytes).map(|loaded| engine_of(loaded, None)));
        let (state, scene) = loaded.map_err(|error| error::saved(&error))?;
        Ok((Self(Mutex::new(state)), scene))
    }

    fn thermalize(&self, py: Python<'_>, temperature: f64, seed: u64) -> PyResult<()> {
        let mut state = self.state()?;
        let engine = &mut state.engine;
        py.detach(|| engine.thermalize(temperature, seed)).map_err(|error| error::thermostat(&error))
    }

    fn rescale(&self, py: Python<'_>, temperature: f64) -> PyResult<()> {
        let mut state = self.state()?;
        let engine = &mut state.engine;
        py.detach(|| engine.rescale(temperature)).map_err(|error| error::thermostat(&error))
    }

    fn set_thermostat(&self, bath: Option<Bath>) -> PyResult<()> {
        let mut state = self.state()?;
        let thermostat = bath.map(|(temperature, rate, axes)| Thermostat::Andersen { temperature, rate, axes });
        let stream = state.engine.scene().next_stream() + state.baths;
        let set = state.engine.set_thermostat(thermostat.as_ref(), stream);
        set.map_err(|error| error::thermostat(&error))?;
        state.baths += usize::from(thermostat.is_some());
        Ok(())
    }

    fn thermostat(&self) -> PyResult<Option<Bath>> {
        Ok(match self.state()?.engine.thermostat() {
            Some(Thermostat::Andersen { temperature, rate, axes }) => Some((temperature, rate, axes)),
            _ => None,
        })
    }

    /// Current radius of each particle, in the order of ids.
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.state()?;
        let species = state.engine.scene().species();
        let mut radii = Vec::new();
        let Ok(()) = state.engine.for_each_now(|now| {
            radii.push(0.5 * now.diameter.unwrap_or(species[now.species.0 as usize].diameter));
            Ok::<(), Infallible>(())
        });
        array::<f64>(py, radii, None)
    }

    /// Lower corner, edges and periodic axes of the current box.
    fn space(&self) -> PyResult<([f64; 3], [f64; 3], [bool; 3])> {
        let state = self.state()?;
        let space = state.engine.scene().space();
        let periodic = space.boundary.map(|boundary| boundary == Boundary::Periodic);
        Ok((space.lower.into(), space.size.into(), periodic))
    }

    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let state = self.state()?;
        let copied = py.detach(|| State { engine: state.engine.clone(), pending: state.pending.clone(), ..*state });
        Ok(Self(Mutex::new(copied)))
    }

    /// Advances to a time or to a total number of events, whichever comes first. Returns the reason of the stop.
    fn advance(&self, py: Python<'_>, time: f64, events: u64, callback: Option<Py<PyAny>>) -> PyResult<&'static str> {
        let (until, end) = (until(time, events)?, (time, events));
        let mut state = self.state()?;
        if !state.pending.is_empty() {
            let message = "a signal interrupted events() before it returned all events: call events() again first";
            return Err(PyValueError::new_err(message));
        }
        let engine = &mut state.engine;
        let begun = (engine.time(), engine.event_counts().physical());
        let mut watch = Watch::new(callback);
        py.detach(|| {
            loop {
                let reason = engine.advance_for(watch.steps(), until);
                if let Some(reason) = reason.map_err(|error| error::engine(&error))? {
                    return Ok(word(reason));
                }
                let (time, events) = (engine.time(), engine.event_counts().physical());
                let done = part((time - begun.0) / (end.0 - begun.0), events - begun.1, end.1 - begun.1);
                if watch.tell("advancing", done, time, events - begun.1).is_break()
                    && let Some(raised) = watch.raised.take()
                {
                    return Err(raised);
                }
            }
        })
    }

    /// Advances until `count` events of the kinds in the bit mask have happened. Returns these events as bytes. If the
    /// simulation stops earlier, also returns the reason.
    fn events<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        time: f64,
        events: u64,
        kinds: u16,
    ) -> PyResult<(Bound<'py, PyByteArray>, Option<&'static str>)> {
        let until = until(time, events)?;
        let mut state = self.state()?;
        let State { engine, pending, .. } = &mut *state;
        let reason = py.detach(|| -> PyResult<_> {
            let bytes = count.saturating_mul(event::SIZE);
            pending.reserve(bytes.saturating_sub(pending.len()).min(1 << 28));
            let mut signals = Signals::new();
            while pending.len() < bytes {
                let mut keep = |event: &Event| {
                    if kinds >> event.code() & 1 == 1 {
                        event::write(event, pending);
                    }
                    if pending.len() < bytes { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                };
                let reason = engine.advance_for_with(signals.steps(), until, &mut keep);
                match reason.map_err(|error| error::engine(&error))? {
                    Some(Reason::Observer) | None => signals.look()?,
                    Some(reason) => return Ok(Some(word(reason))),
                }
            }
            Ok(None)
        })?;
        let found = std::mem::take(&mut state.pending);
        Ok((PyByteArray::new(py, &found), reason))
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.state()?.engine.time())
    }

    #[getter]
    fn displacement(&self) -> PyResult<f64> {
        Ok(self.state()?.engine.displacement())
    }

    #[getter]
    fn engine(&self) -> PyResult<String> {
        Ok(self.state()?.engine.engine().to_string())
    }

    fn physical_events(&self) -> PyResult<u64> {
        Ok(self.state()?.engine.event_counts().physical())
    }

    fn event_counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.state()?;
        let EventCounts { core, capture, release, bounce, wall, thermostat, exit, entry, transition, .. } =
            *state.engine.event_counts();
        let counts = [
            ("core", core),
            ("capture", capture),
            ("release", release),
            ("bounce", bounce),
            ("wall", wall),
            ("thermostat", thermostat),
            ("exit", exit),
            ("entry", entry),
            ("transition", transition),
        ];
        dictionary(py, counts)
    }

    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.state()?;
        let energy = py.detach(|| state.engine.energy());
        let counts = state.engine.event_counts();
        let energies = [
            ("kinetic", energy.kinetic),
            ("rotational", energy.rotational),
            ("thermal", energy.thermal),
            ("potential", energy.potential),
            ("pair", energy.pair),
            ("dissipated", counts.dissipated.total()),
            ("supplied", counts.supplied.total()),
        ];
        dictionary(py, energies)
    }

    /// Kinetic temperature; `None` if it is undefined.
    #[getter]
    fn temperature(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let state = self.state()?;
        Ok(py.detach(|| {
            let energy = state.engine.energy();
            let applicable = ApplicableObservables::of_simulation(&state.engine);
            applicable.temperature(energy.thermal, &energy.peculiar_momentum)
        }))
    }

    fn momentum(&self) -> PyResult<[f64; 3]> {
        Ok(self.state()?.engine.energy().momentum.into())
    }

    /// The deepest current overlap, relative to the required distance; 0 if nothing overlaps.
    fn deepest_overlap(&self, py: Python<'_>) -> PyResult<f64> {
        let state = self.state()?;
        Ok(py.detach(|| state.engine.deepest_overlap()).map_or(0.0, |overlap| overlap.depth))
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| <[f64; 3]>::from(particle.position))
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| <[f64; 3]>::from(particle.velocity))
    }

    fn spins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| <[f64; 3]>::from(particle.spin))
    }

    fn images<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| particle.image)
    }

    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| [i64::from(particle.id.0)])
    }

    /// Current number of particles.
    fn count(&self) -> PyResult<usize> {
        Ok(self.state()?.engine.population().iter().sum())
    }

    fn species<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| [i64::from(particle.species.0)])
    }

    /// Captured pairs: lower id, higher id, state.
    fn captured_pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.state()?;
        let pairs = py.detach(|| state.engine.captured_pairs());
        let flat: Vec<i64> =
            pairs.iter().flat_map(|([a, b], state)| [a.0.into(), b.0.into(), i64::from(*state)]).collect();
        array(py, flat, Some(3))
    }

    /// `velocities` has three numbers of the type `f8` for each particle.
    fn set_velocities(&self, py: Python<'_>, velocities: &[u8]) -> PyResult<()> {
        let mut state = self.state()?;
        let engine = &mut state.engine;
        let set = py.detach(|| engine.set_velocities(&vectors_of(velocities)));
        set.map_err(|error| PyValueError::new_err(format!("velocities: {error}")))
    }

    /// `positions` has three numbers of the type `f8` for each particle.
    fn set_positions(&self, py: Python<'_>, positions: &[u8], keep_states: bool) -> PyResult<()> {
        let states = if keep_states { PairStates::Keep } else { PairStates::FromDistances };
        let mut state = self.state()?;
        let engine = &mut state.engine;
        let set = py.detach(|| engine.set_positions(&vectors_of(positions), states));
        set.map_err(|error| PyValueError::new_err(format!("positions: {error}")))
    }
}

fn vectors_of(bytes: &[u8]) -> Vec<Vector> {
    let number = |bytes: &[u8; 8]| f64::from_ne_bytes(*bytes);
    let numbers = bytes.as_chunks::<8>().0;
    numbers.as_chunks::<3>().0.iter().map(|of| Vector::from(of.each_ref().map(number))).collect()
}
