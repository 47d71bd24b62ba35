//! State of a run, without the simulation.

use serde::{Deserialize, Serialize};

use super::driver::{Monitor, Moves, PressureCheck, StormWatch, Swaps};
use super::forecast;
use super::frames::FrameLimit;
use super::measured_stage::MeasuredStage;
use super::stage::Stage;
use crate::analysis::instruments::{Instruments, SystemDescription};
use crate::analysis::observables::{ApplicableObservables, Observer};
use crate::analysis::sampling_times::SamplingTimes;
use crate::engine::Simulation;
use crate::engine::event::{EventCounts, EventCountsBySpecies};
use crate::model::{Scene, StageSwaps, Thermostat, Until};
use crate::run::audit::Ledger;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Start {
    pub stage: Stage,
    pub time: f64,
    pub events: u64,
    pub limit: Until,
}

impl Start {
    pub fn of(simulation: &Simulation, stage: Stage, limit: Until) -> Self {
        Self { stage, time: simulation.time(), events: simulation.event_counts().physical(), limit }
    }

    /// Returns the simulated time and the number of physical events at the end of the stage.
    pub fn end(&self) -> (f64, u64) {
        let time = self.limit.time.map_or(f64::INFINITY, |time| self.time + time);
        (time, self.limit.events.map_or(u64::MAX, |events| self.events.saturating_add(events)))
    }
}

/// Relative tolerance for times at the end of a stage.
pub(super) const NEAR: f64 = 1e-9;

/// Time of the first check for initial overlaps, relative to the crossing time of the box.
const FIRST_CHECK: f64 = 1e-4;

/// Interval until the next check for initial overlaps, in events or in simulated time, whichever comes first.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct OverlapCheck {
    pub events: u64,
    pub time: f64,
}

impl OverlapCheck {
    /// Increases the interval by a tenth, so that the time of the last overlap is known within about 10 %.
    pub fn grow(&mut self) {
        self.events = self.events.saturating_add(self.events.div_ceil(10));
        self.time *= 1.1;
    }
}

/// The next check of the run, at a simulated time or at a number of physical events. It is stored in checkpoints, so
/// that pauses do not shift the checks.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Aim {
    pub time: f64,
    pub events: u64,
    /// Numbers of physical events, cell transitions and Andersen collisions when this check was planned.
    pub done: u64,
    pub transitions: u64,
    pub collisions: u64,
}

impl Aim {
    pub fn until(&self, time: f64, events: u64) -> Until {
        Until::time(time.min(self.time)).or_events(events.min(self.events))
    }
}

/// An unfinished pilot run that simulates the first part of its stage.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Pilot {
    /// Number of physical events that the pilot run needs for its estimate.
    pub events: u64,
    /// The pilot run is abandoned at this number of events, cell transitions and Andersen collisions.
    pub patience: u64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Measurement {
    pub rows: SamplingTimes,
    pub frames: SamplingTimes,
    pub instruments: Instruments,
}

/// State of a run, without the simulation and the list of output files. A checkpoint contains all three.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunState {
    pub(super) stage: Start,
    pub(super) observer: Observer,
    pub(super) ledger: Ledger,
    /// Result of [`crossing_time`] `[time]`.
    pub(super) crossing: f64,
    /// Initial event rate from kinetic theory `[1 / time]`.
    pub(super) rate: Option<f64>,
    /// Simulated time between two checks of the run. It doubles while nothing happens.
    pub(super) wait: f64,
    pub(super) overlap_check: OverlapCheck,
    pub(super) aim: Option<Aim>,
    pub(super) pilot: Option<Pilot>,
    /// Number of checks of the run since the last event.
    pub(super) quiet_steps: u64,
    /// Number of rows and frames since the last event.
    pub(super) quiet_rows: u64,
    pub(super) last_row: Option<f64>,
    pub(super) last_frame: Option<f64>,
    pub(super) frames: FrameLimit,
    pub(super) rows: Option<SamplingTimes>,
    pub(super) measurement: Option<Measurement>,
    /// Event counts at the start of the measurement.
    pub(super) before: EventCounts,
    pub(super) counts_before: EventCountsBySpecies,
    /// Wall time of the current measurement before the last interruption `[seconds]`.
    pub(super) earlier_seconds: f64,
    pub(super) has_begun: bool,
    /// Time of the next scaling of the velocities; infinite if there is none.
    pub(super) next_scaling: f64,
    /// Time of the next temperature sample; infinite if no sample is due before the next scaling.
    pub(super) next_temperature: f64,
    pub(super) moves: Option<Moves>,
    /// Last tuned amplitude of the volume moves; `None` before any tuning.
    pub(super) amplitude: Option<f64>,
    pub(super) swaps: Option<Swaps>,
    /// The swap moves of the stages that have ended.
    pub(super) stage_swaps: Vec<StageSwaps>,
    pub(super) monitor: Option<Monitor>,
    pub(super) pressure_check: Option<PressureCheck>,
    pub(super) storm_watch: Option<StormWatch>,
    /// Original limit of the measurement; `None` if the limit was not changed.
    pub(super) planned: Option<Until>,
    /// Names of the custom instruments with which the run began.
    pub(super) registered: Vec<String>,
    pub(super) measured_stages: Vec<MeasuredStage>,
}

/// Properties of the initial particles, which may be freed later.
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
    pub(crate) fn new(simulation: &Simulation) -> Self {
        Self::begin(simulation, Beginning::of(simulation.scene()))
    }

    /// The initial particles may have been freed.
    pub(crate) fn begin(simulation: &Simulation, Beginning { observer, crossing, rate, frames }: Beginning) -> Self {
        let moving = observer.applicable().moving as u64;
        Self {
            ledger: Ledger::open(
                simulation,
                observer.applicable().conserves_momentum && !simulation.scene().run.has_andersen(),
            ),
            stage: Start::of(simulation, Stage::first(&simulation.scene().run), Until::default()),
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
            swaps: None,
            stage_swaps: Vec::new(),
            monitor: None,
            pressure_check: None,
            storm_watch: StormWatch::of(simulation.scene(), simulation, moving),
            planned: None,
            registered: Vec::new(),
            measured_stages: Vec::new(),
        }
    }

    /// Returns the end time of the current stage and the time left. `None` unless the end is reached within round-off.
    pub(super) fn rest_of_stage(&self, simulation: &Simulation) -> Option<(f64, f64)> {
        let duration = self.stage.limit.time?;
        let (end, _) = self.stage.end();
        let left = end - simulation.time();
        (left <= NEAR * duration).then_some((end, left))
    }

    pub(super) fn has_ended(&self, simulation: &Simulation) -> bool {
        let (_, events) = self.stage.end();
        let is_there = simulation.event_counts().physical() >= events || self.rest_of_stage(simulation).is_some();
        let is_planned = self.stage.limit == Until::default() || is_there || simulation.is_over();
        self.stage.stage == Stage::Measurement && self.has_begun && is_planned
    }

    /// Changes the limit of the last measurement, if it has begun. Otherwise, the limit will come from the scene.
    pub(crate) fn extend(&mut self, limit: Until) {
        if self.stage.stage == Stage::Measurement {
            if self.measurement.is_some() && limit != self.stage.limit {
                self.planned.get_or_insert(self.stage.limit);
            }
            self.stage.limit = limit;
        }
    }

    pub(super) fn planned(&self) -> Until {
        self.planned.filter(|_| self.stage.stage == Stage::Measurement).unwrap_or(self.stage.limit)
    }

    /// Returns the simulated time and the number of physical events of the last measurement, if it has begun.
    pub(crate) fn measured_so_far(&self, simulation: &Simulation) -> Option<(f64, u64)> {
        let is_measured = self.stage.stage == Stage::Measurement;
        let events = simulation.event_counts().physical().saturating_sub(self.stage.events);
        is_measured.then(|| (simulation.time() - self.stage.time, events))
    }

    pub(crate) fn planned_before(&self) -> Option<Until> {
        self.planned
    }

    pub(crate) fn applicable(&self) -> &ApplicableObservables {
        self.observer.applicable()
    }

    pub(crate) fn registered(&self) -> &[String] {
        &self.registered
    }

    pub(super) fn measured(&self, system: Option<&SystemDescription>) -> crate::analysis::instruments::Measured {
        let measurement = self.measurement.as_ref().zip(system);
        measurement.map(|(measurement, system)| measurement.instruments.report(system)).unwrap_or_default()
    }
}

/// Shortest simulated time in which a particle crosses the box: at its initial speed, at the thermal speed, or in a
/// fall from rest. At most the time of [`MANY_COLLISIONS`] Andersen collisions. Infinite if nothing moves.
fn crossing_time(scene: &Scene) -> f64 {
    let length = scene.space.size.max().max(scene.longest_range());
    let ranges = scene.diameters_of_species();
    let dimensions = scene.space.dimensions();
    let of_smallest = scene.species.iter().zip(&ranges).map(|(it, range)| it.own_mass(range.smallest, dimensions));
    let lightest = of_smallest.fold(f64::INFINITY, f64::min);
    let (mut hottest, mut collisions) =
        (scene.wall_temperatures.iter().flatten().flatten().copied().fold(0.0, f64::max), 0.0_f64);
    for thermostat in scene.run.thermostats() {
        hottest = hottest.max(thermostat.temperature());
        if let Thermostat::Andersen { rate, .. } = thermostat {
            collisions = collisions.max(rate * scene.particles.len() as f64);
        }
    }
    let thermal = (hottest / lightest).sqrt();
    let fastest = scene.particles.iter().map(|particle| particle.velocity.norm()).fold(thermal, f64::max);
    let steepest = scene.species.iter().map(|species| species.acceleration.norm()).fold(0.0, f64::max);
    (length / fastest).min((2.0 * length / steepest).sqrt()).min(MANY_COLLISIONS / collisions)
}

/// Largest number of Andersen collisions between two checks. These collisions take a few hundredths of a second.
const MANY_COLLISIONS: f64 = 1e4;
