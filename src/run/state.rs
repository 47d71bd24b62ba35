//! The state of a run besides the simulation: the stage, its limits, sampling times, instruments and means.

use serde::{Deserialize, Serialize};

use super::driver::{Monitor, Moves, PressureCheck, StormWatch};
use super::forecast;
use super::frames::FrameLimit;
use super::measured_stage::MeasuredStage;
use super::stage::Stage;
use crate::analysis::instruments::{Instruments, SystemDescription};
use crate::analysis::observables::{ApplicableObservables, Observer};
use crate::analysis::sampling_times::SamplingTimes;
use crate::engine::event::{EventCounts, EventCountsBySpecies};
use crate::engine::{Simulation, Until};
use crate::model::{Limit, Scene, Thermostat};
use crate::run::audit::Ledger;

/// The beginning of a stage.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Start {
    pub stage: Stage,
    pub time: f64,
    pub events: u64,
    pub limit: Limit,
}

impl Start {
    pub fn of(simulation: &Simulation, stage: Stage, limit: Limit) -> Self {
        Self { stage, time: simulation.time(), events: simulation.event_counts().physical(), limit }
    }

    /// Simulated time and physical events, since the start of the simulation, at which the stage ends.
    pub fn end(&self) -> (f64, u64) {
        let time = self.limit.time.map_or(f64::INFINITY, |time| self.time + time);
        (time, self.limit.events.map_or(u64::MAX, |events| self.events.saturating_add(events)))
    }
}

/// A sampling time this close to the end, relative to the duration of the stage, coincides with it within
/// round-off.
pub(super) const NEAR: f64 = 1e-9;

/// Fraction of the crossing time after which the initial overlaps are first checked.
const FIRST_CHECK: f64 = 1e-4;

/// The next check of the initial overlaps: whichever comes first.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct OverlapCheck {
    /// Number of events.
    pub events: u64,
    /// Elapsed time.
    pub time: f64,
}

impl OverlapCheck {
    /// Increases the intervals by a tenth, so that persistent overlaps cost little. The time at which
    /// overlaps are resolved is known to about a tenth.
    pub fn grow(&mut self) {
        self.events = self.events.saturating_add(self.events.div_ceil(10));
        self.time *= 1.1;
    }
}

/// The next check of the run's state. It is stored in checkpoints, so that pauses do not shift it.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Aim {
    /// Simulated time.
    pub time: f64,
    /// Physical events.
    pub events: u64,
    /// Number of physical events, cell transitions and Andersen collisions when it was set.
    pub done: u64,
    pub transitions: u64,
    pub collisions: u64,
}

impl Aim {
    /// This aim, or another limit that comes first.
    pub fn until(&self, time: f64, events: u64) -> Until {
        Until { time: time.min(self.time), events: events.min(self.events) }
    }
}

/// A pilot run that is the beginning of its stage.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Pilot {
    /// Number of its physical events.
    pub events: u64,
    /// Number of events, cell transitions and Andersen collisions, since the start of the simulation, at
    /// which it gives up.
    pub patience: u64,
}

/// Rows, frames and instruments of the measurement so far.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Measurement {
    pub rows: SamplingTimes,
    pub frames: SamplingTimes,
    pub instruments: Instruments,
}

/// State of a run: the stage, sampling times, instruments and means. Together with the simulation it is the
/// content of a checkpoint.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunState {
    pub(super) stage: Start,
    pub(super) observer: Observer,
    pub(super) ledger: Ledger,
    /// Simulated time in which a typical particle crosses the box `[time]`.
    pub(super) crossing: f64,
    /// Initial event rate from kinetic theory `[1 / time]`.
    pub(super) rate: Option<f64>,
    /// Longest step in time; it grows if nothing happens.
    pub(super) wait: f64,
    pub(super) overlap_check: OverlapCheck,
    /// The target of an advance that was paused.
    pub(super) aim: Option<Aim>,
    /// The pilot run in progress.
    pub(super) pilot: Option<Pilot>,
    /// Steps of the run since the last event.
    pub(super) quiet_steps: u64,
    /// Rows and frames since the last event.
    pub(super) quiet_rows: u64,
    pub(super) last_row: Option<f64>,
    pub(super) last_frame: Option<f64>,
    /// Largest number of frames.
    pub(super) frames: FrameLimit,
    /// Times of rows in a stage before the measurement.
    pub(super) rows: Option<SamplingTimes>,
    pub(super) measurement: Option<Measurement>,
    /// Event counts before the measurement.
    pub(super) before: EventCounts,
    /// Event counts before the measurement, by kind and species.
    pub(super) counts_before: EventCountsBySpecies,
    /// Wall time of the measurement before the last resumption `[seconds]`.
    pub(super) earlier_seconds: f64,
    /// Whether the present stage has been set up.
    pub(super) has_begun: bool,
    /// Simulated time of the next scaling of velocities; infinite without scaling.
    pub(super) next_scaling: f64,
    /// Simulated time of the next temperature sample before the scaling; infinite without scaling.
    pub(super) next_temperature: f64,
    /// Volume moves of the present stage.
    pub(super) moves: Option<Moves>,
    /// Amplitude of volume moves found so far.
    pub(super) amplitude: Option<f64>,
    /// The observables in an automatic equilibration.
    pub(super) monitor: Option<Monitor>,
    /// The pressure of spheres that grow to a target pressure.
    pub(super) pressure_check: Option<PressureCheck>,
    /// The watch for storms, if they are possible.
    pub(super) storm_watch: Option<StormWatch>,
    /// The end for which rows, frames and instruments were planned, if the run has another end now.
    pub(super) planned: Option<Limit>,
    /// Names of the custom instruments.
    pub(super) registered: Vec<String>,
    /// The completed measured stages.
    pub(super) measured_stages: Vec<MeasuredStage>,
}

/// Initial properties of a scene that its run needs.
pub(crate) struct Beginning {
    observer: Observer,
    crossing: f64,
    rate: Option<f64>,
    frames: FrameLimit,
}

impl Beginning {
    pub fn of(scene: &Scene) -> Self {
        Self {
            observer: Observer::new(scene),
            crossing: crossing_time(scene),
            rate: forecast::rate(scene),
            frames: FrameLimit::of(scene),
        }
    }
}

impl RunState {
    /// At the start of a scene.
    pub(crate) fn new(simulation: &Simulation) -> Self {
        Self::begin(simulation, Beginning::of(simulation.scene()))
    }

    /// The initial state. The simulation may no longer have the initial particles of its scene.
    pub(crate) fn begin(simulation: &Simulation, Beginning { observer, crossing, rate, frames }: Beginning) -> Self {
        let moving = observer.applicable().moving as u64;
        Self {
            ledger: Ledger::open(
                simulation,
                observer.applicable().conserves_momentum && !simulation.scene().run.has_andersen(),
            ),
            stage: Start::of(simulation, Stage::first(&simulation.scene().run), Limit::default()),
            observer,
            crossing,
            rate,
            wait: crossing,
            overlap_check: OverlapCheck { events: moving.div_ceil(16), time: crossing * FIRST_CHECK },
            aim: None,
            pilot: None,
            quiet_steps: 0,
            quiet_rows: 0,
            last_row: None,
            last_frame: None,
            frames,
            rows: None,
            measurement: None,
            before: EventCounts::default(),
            counts_before: EventCountsBySpecies::default(),
            earlier_seconds: 0.0,
            has_begun: false,
            next_scaling: f64::INFINITY,
            next_temperature: f64::INFINITY,
            moves: None,
            amplitude: None,
            monitor: None,
            pressure_check: None,
            storm_watch: StormWatch::of(simulation.scene(), simulation, moving),
            planned: None,
            registered: Vec::new(),
            measured_stages: Vec::new(),
        }
    }

    /// The end of the stage and the remaining time, if the simulation is at the end of its stage within
    /// round-off.
    pub(super) fn rest_of_stage(&self, simulation: &Simulation) -> Option<(f64, f64)> {
        let duration = self.stage.limit.time?;
        let (end, _) = self.stage.end();
        let left = end - simulation.time();
        (left <= NEAR * duration).then_some((end, left))
    }

    /// Whether the measurement has reached its limit, or there will be no further events.
    pub(super) fn has_ended(&self, simulation: &Simulation) -> bool {
        let (_, events) = self.stage.end();
        let is_there = simulation.event_counts().physical() >= events || self.rest_of_stage(simulation).is_some();
        let is_planned = self.stage.limit == Limit::default() || is_there || simulation.is_over();
        self.stage.stage == Stage::Measurement && self.has_begun && is_planned
    }

    /// Sets another end of the measurement, whether it is planned, running or over.
    pub(crate) fn extend(&mut self, limit: Limit) {
        if self.stage.stage == Stage::Measurement {
            if self.measurement.is_some() && limit != self.stage.limit {
                self.planned.get_or_insert(self.stage.limit);
            }
            self.stage.limit = limit;
        }
    }

    /// The end that rows, frames and instruments of the measurement are planned for.
    pub(super) fn planned(&self) -> Limit {
        self.planned.filter(|_| self.stage.stage == Stage::Measurement).unwrap_or(self.stage.limit)
    }

    /// Simulated time and physical events of the measurement so far; `None` before it.
    pub(crate) fn measured_so_far(&self, simulation: &Simulation) -> Option<(f64, u64)> {
        let is_measured = self.stage.stage == Stage::Measurement;
        let events = simulation.event_counts().physical().saturating_sub(self.stage.events);
        is_measured.then(|| (simulation.time() - self.stage.time, events))
    }

    /// The end that the measurement was planned for, if the run has another end now.
    pub(crate) fn planned_before(&self) -> Option<Limit> {
        self.planned
    }

    /// The observables that apply to its scene.
    pub(crate) fn applicable(&self) -> &ApplicableObservables {
        self.observer.applicable()
    }

    /// Names of the custom instruments that it began with.
    pub(crate) fn registered(&self) -> &[String] {
        &self.registered
    }

    /// Results of the instruments so far.
    pub(super) fn measured(&self, system: Option<&SystemDescription>) -> crate::analysis::instruments::Measured {
        let measurement = self.measurement.as_ref().zip(system);
        measurement.map(|(measurement, system)| measurement.instruments.report(system)).unwrap_or_default()
    }
}

/// The simulated time in which the fastest particle crosses the box, at its initial speed, from rest with its
/// acceleration, or at the temperature of an external source. With a heat bath, it is at most the time of
/// [`MANY_COLLISIONS`]. Infinite if nothing moves.
fn crossing_time(scene: &Scene) -> f64 {
    let length = scene.space.size.max().max(scene.longest_range());
    let lightest = scene.species.iter().map(|species| species.mass).fold(f64::INFINITY, f64::min);
    let thermostats = scene.run.stages.iter().map(|stage| stage.thermostat).chain([scene.run.thermostat]).flatten();
    let (mut hottest, mut collisions) =
        (scene.wall_temperatures.iter().flatten().flatten().copied().fold(0.0, f64::max), 0.0_f64);
    for thermostat in thermostats {
        let (Thermostat::Andersen { temperature, .. } | Thermostat::Rescaling { temperature, .. }) = thermostat;
        hottest = hottest.max(temperature);
        if let Thermostat::Andersen { rate, .. } = thermostat {
            collisions = collisions.max(rate * scene.particles.len() as f64);
        }
    }
    let thermal = (hottest / lightest).sqrt();
    let fastest = scene.particles.iter().map(|particle| particle.velocity.norm()).fold(thermal, f64::max);
    let steepest = scene.species.iter().map(|species| species.acceleration.norm()).fold(0.0, f64::max);
    (length / fastest).min((2.0 * length / steepest).sqrt()).min(MANY_COLLISIONS / collisions)
}

/// Number of Andersen collisions between two calls of `watch`, which take a few hundredths of a second.
const MANY_COLLISIONS: f64 = 1e4;
