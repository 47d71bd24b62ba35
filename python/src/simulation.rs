//! A simulation from event to event.

use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard, TryLockError};

use carom::Vector;
use carom::analysis::observables::ApplicableObservables;
use carom::engine::event::{Event, EventCounts};
use carom::engine::{PairStates, ParticleNow, Reason, Simulation as Engine, Until};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};

use crate::array::{Number, array};
use crate::error;
use crate::run::threads_of;
use crate::scene::{Scene, dictionary};
use crate::signals::Signals;

/// Bytes of an event, in the order of `carom.EVENT`.
const EVENT: usize = 225;

/// A simulation, and events that were asked for and not handed out because a signal came.
struct State {
    engine: Engine,
    pending: Vec<u8>,
}

/// A simulation. The lock is never waited for with Python's own lock held: another thread that asks in the meantime gets an error.
#[pyclass(frozen, module = "carom._carom")]
pub struct Simulation(Mutex<State>);

impl Simulation {
    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        self.0.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => error::busy("the simulation"),
            TryLockError::Poisoned(_) => error::cured("SimulationError", "the simulation has failed before", None),
        })
    }

    /// Numbers of all particles, in the order of their ids: `K` of each, written once.
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

fn until(time: f64, events: u64) -> PyResult<Until> {
    if time.is_nan() {
        return Err(PyValueError::new_err("expected a time that is a number, found nan"));
    }
    Ok(Until { time, events })
}

#[pymethods]
impl Simulation {
    /// The dynamics of a scene from its start. With a plan, what only a run does is refused; without, it is left out.
    #[new]
    fn new(py: Python<'_>, scene: &Scene, plan: bool, threads: Option<&str>) -> PyResult<Self> {
        let model = scene.model.clone();
        let threads = threads_of(threads)?;
        let made = py.detach(|| if plan { Engine::new(model) } else { Ok(Engine::without_plan(model)) });
        let mut engine = made.map_err(|error| error::needs_run(&error))?;
        if let Some(threads) = threads {
            engine.set_threads(threads);
        }
        Ok(Self(Mutex::new(State { engine, pending: Vec::new() })))
    }

    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let state = self.state()?;
        let copied = py.detach(|| State { engine: state.engine.clone(), pending: state.pending.clone() });
        Ok(Self(Mutex::new(copied)))
    }

    /// Goes on until a time or a number of events since the start, and says why it ended.
    fn advance(&self, py: Python<'_>, time: f64, events: u64) -> PyResult<&'static str> {
        let until = until(time, events)?;
        let mut state = self.state()?;
        if !state.pending.is_empty() {
            let message =
                "events that were asked for have not been handed out, because a signal came: go on with events() first";
            return Err(PyValueError::new_err(message));
        }
        let engine = &mut state.engine;
        py.detach(|| {
            let mut signals = Signals::new();
            loop {
                let reason = engine.advance_for(signals.steps(), until, None);
                if let Some(reason) = reason.map_err(|error| error::engine(&error))? {
                    return Ok(word(reason));
                }
                signals.look()?;
            }
        })
    }

    /// Advances up to `count` events of the kinds whose bits are set; these as bytes, and why it ended: `None` if there are as many as that.
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
        let State { engine, pending } = &mut *state;
        let reason = py.detach(|| -> PyResult<_> {
            let bytes = count.saturating_mul(EVENT);
            pending.reserve(bytes.saturating_sub(pending.len()).min(1 << 28));
            let mut signals = Signals::new();
            while pending.len() < bytes {
                let mut keep = |event: &Event| {
                    if kinds >> event.code() & 1 == 1 {
                        write(event, pending);
                    }
                    if pending.len() < bytes { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                };
                let reason = engine.advance_for(signals.steps(), until, Some(&mut keep));
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
        let EventCounts { core, capture, release, bounce, wall, thermostat, transition, .. } =
            *state.engine.event_counts();
        let counts = [
            ("core", core),
            ("capture", capture),
            ("release", release),
            ("bounce", bounce),
            ("wall", wall),
            ("thermostat", thermostat),
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
            ("thermal", energy.thermal),
            ("potential", energy.potential),
            ("pair", energy.pair),
            ("dissipated", counts.dissipated.total()),
            ("supplied", counts.supplied.total()),
        ];
        dictionary(py, energies)
    }

    /// Kinetic temperature; `None` where there is none.
    #[getter]
    fn temperature(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let state = self.state()?;
        Ok(py.detach(|| {
            let energy = state.engine.energy();
            ApplicableObservables::of(state.engine.scene()).temperature(energy.thermal, &energy.peculiar_momentum)
        }))
    }

    fn momentum(&self) -> PyResult<[f64; 3]> {
        Ok(self.state()?.engine.energy().momentum.into())
    }

    /// The deepest overlap now, relative to the distance that is needed; 0 if nothing overlaps.
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

    fn images<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| particle.image)
    }

    fn species<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.numbers(py, |particle| [i64::from(particle.species.0)])
    }

    /// Pairs that are captured: lower id, higher id, state.
    fn captured_pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.state()?;
        let pairs = py.detach(|| state.engine.captured_pairs());
        let flat: Vec<i64> =
            pairs.iter().flat_map(|([a, b], state)| [a.0.into(), b.0.into(), i64::from(*state)]).collect();
        array(py, flat, Some(3))
    }

    /// Three numbers of the type `f8` for each particle.
    fn set_velocities(&self, velocities: &[u8]) -> PyResult<()> {
        let set = self.state()?.engine.set_velocities(&vectors_of(velocities));
        set.map_err(|error| PyValueError::new_err(format!("velocities: {error}")))
    }

    /// Three numbers of the type `f8` for each particle.
    fn set_positions(&self, positions: &[u8], keep_states: bool) -> PyResult<()> {
        let states = if keep_states { PairStates::Keep } else { PairStates::FromDistances };
        let set = self.state()?.engine.set_positions(&vectors_of(positions), states);
        set.map_err(|error| PyValueError::new_err(format!("positions: {error}")))
    }
}

/// Vectors of the bytes of an array.
fn vectors_of(bytes: &[u8]) -> Vec<Vector> {
    let number = |bytes: &[u8; 8]| f64::from_ne_bytes(*bytes);
    let numbers = bytes.as_chunks::<8>().0;
    numbers.as_chunks::<3>().0.iter().map(|of| Vector::from(of.each_ref().map(number))).collect()
}

/// An event as `carom.EVENT` has it: packed, in the byte order of the machine.
fn write(event: &Event, bytes: &mut Vec<u8>) {
    bytes.extend_from_slice(&event.time.to_ne_bytes());
    bytes.push(event.code());
    bytes.extend_from_slice(&i64::from(event.particle.0).to_ne_bytes());
    bytes.extend_from_slice(&event.partner().map_or(-1, |partner| i64::from(partner.0)).to_ne_bytes());
    for vector in event.positions.iter().chain(&event.before).chain(&event.after) {
        for component in vector.iter() {
            bytes.extend_from_slice(&component.to_ne_bytes());
        }
    }
    for number in [event.energy_step, event.dissipated, event.normal_impulse(), event.distance] {
        bytes.extend_from_slice(&number.to_ne_bytes());
    }
    for component in event.normal.iter() {
        bytes.extend_from_slice(&component.to_ne_bytes());
    }
}
