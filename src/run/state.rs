//! State of a run besides its simulation.

use serde::{Deserialize, Serialize};

use super::driver::{Monitor, Moves, PressureCheck, StormWatch};
use super::forecast;
use super::frames::FrameLimit;
use super::measured_stage::MeasuredStage;
use super::stage::Stage;
use crate::analysis::instruments::{Instruments, SystemDescription};
use crate::analysis::observables::{ApplicableObservables, Observer};
use crate::analysis::sampling_times::SamplingTimes;
use crate::engine::Simulation;
use crate::engine::event::{EventCounts, EventCountsBySpecies};
use crate::model::{Scene, Thermostat, Until};
use crate::run::audit::Ledger;

/// Simulated time and number of physical events at which a stage began, and its limit.
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

    /// Returns the simulated time and the number of physical events at which the stage ends. Events are counted since
    /// the start of the simulation.
    pub fn end(&self) -> (f64, u64) {
        let time = self.limit.time.map_or(f64::INFINITY, |time| self.time + time);
        (time, self.limit.events.map_or(u64::MAX, |events| self.events.saturating_add(events)))
    }
}

/// Largest difference, relative to the duration of the stage, of a sampling time and an end of stage that coincide
/// within round-off.
pub(super) const NEAR: f64 = 1e-9;

/// Time of the first check for remaining initial overlaps, as a fraction of the crossing time of the box.
const FIRST_CHECK: f64 = 1e-4;

/// Number of physical events and simulated time until the next check for remaining initial overlaps. The check is made
/// when either has passed.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct OverlapCheck {
    pub events: u64,
    pub time: f64,
}

impl OverlapCheck {
    /// Increases the intervals between overlap checks by a tenth, so that persistent overlaps cost little. The time at
    /// which the last overlap is resolved is then known to within about 10 %.
    pub fn grow(&mut self) {
        self.events = self.events.saturating_add(self.events.div_ceil(10));
        self.time *= 1.1;
    }
}

/// The next check of the run: a simulated time or a number of physical events, whichever comes first. Checkpoints
/// contain it, so that pauses do not shift the checks.
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
    /// The pilot run gives up at this number of events, cell transitions and Andersen collisions, counted since the
    /// start of the simulation.
    pub patience: u64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Measurement {
    pub rows: SamplingTimes,
    pub frames: SamplingTimes,
    pub instruments: Instruments,
}

/// State of a run: its stage, sampling times, instruments and averages. A checkpoint consists of this state, the
/// simulation, and the list of output files.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunState {
    pub(super) stage: Start,
    pub(super) observer: Observer,
    pub(super) ledger: Ledger,
    /// Simulated time in which the fastest particle crosses the box `[time]`: see [`crossing_time`].
    pub(super) crossing: f64,
    /// Event rate at the start from kinetic theory `[1 / time]`; `None` if this theory does not apply.
    pub(super) rate: Option<f64>,
    /// Simulated time between two checks of the run. It doubles as long as nothing happens.
    pub(super) wait: f64,
    pub(super) overlap_check: OverlapCheck,
    /// The next check of the run, once it is planned. A continued run keeps the check that was planned before the
    /// interruption.
    pub(super) aim: Option<Aim>,
    pub(super) pilot: Option<Pilot>,
    /// Number of checks of the run since the last event.
    pub(super) quiet_steps: u64,
    /// Number of rows and frames since the last event.
    pub(super) quiet_rows: u64,
    pub(super) last_row: Option<f64>,
    pub(super) last_frame: Option<f64>,
    pub(super) frames: FrameLimit,
    /// Sampling times of the rows in a stage without measurement.
    pub(super) rows: Option<SamplingTimes>,
    pub(super) measurement: Option<Measurement>,
    /// Event counts at the start of the measurement.
    pub(super) before: EventCounts,
    pub(super) counts_before: EventCountsBySpecies,
    /// Wall time that the present measurement took before the run was last continued `[seconds]`.
    pub(super) earlier_seconds: f64,
    /// Whether the present stage has been set up.
    pub(super) has_begun: bool,
    /// Simulated time of the next scaling of velocities; infinite if the thermostat does not scale velocities.
    pub(super) next_scaling: f64,
    /// Simulated time of the next temperature sample between two scalings of the velocities; infinite if no sample is
    /// due before the next scaling.
    pub(super) next_temperature: f64,
    /// Volume moves of the present stage; `None` without a barostat.
    pub(super) moves: Option<Moves>,
    /// Last tuned amplitude of the volume moves; `None` before any tuning.
    pub(super) amplitude: Option<f64>,
    pub(super) monitor: Option<Monitor>,
    /// Pressure of growing spheres; `None` if no spheres grow.
    pub(super) pressure_check: Option<PressureCheck>,
    /// Detection of event storms; `None` if they are impossible.
    pub(super) storm_watch: Option<StormWatch>,
    /// Original limit of the measurement, for which rows, frames and instruments were planned; `None` if the limit was
    /// not changed.
    pub(super) planned: Option<Until>,
    /// Names of the custom instruments with which the run began.
    pub(super) registered: Vec<String>,
    pub(super) measured_stages: Vec<MeasuredStage>,
}

/// Properties of a scene that depend on its initial particles. They are calculated in advance, because these particles
/// may be freed later.
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

    /// The initial particles of the scene may already have been freed.
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
            monitor: None,
            pressure_check: None,
            storm_watch: StormWatch::of(simulation.scene(), simulation, moving),
            planned: None,
            registered: Vec::new(),
            measured_stages: Vec::new(),
        }
    }

    /// If the simulation has reached the end time of the present stage within round-off, returns this time and the time
    /// left until then. Otherwise returns `None`.
    pub(super) fn rest_of_stage(&self, simulation: &Simulation) -> Option<(f64, f64)> {
        let duration = self.stage.limit.time?;
        let (end, _) = self.stage.end();
        let left = end - simulation.time();
        (left <= NEAR * duration).then_some((end, left))
    }

    /// Whether the last measurement has reached its limit, or no event is left.
    pub(super) fn has_ended(&self, simulation: &Simulation) -> bool {
        let (_, events) = self.stage.end();
        let is_there = simulation.event_counts().physical() >= events || self.rest_of_stage(simulation).is_some();
        let is_planned = self.stage.limit == Until::default() || is_there || simulation.is_over();
        self.stage.stage == Stage::Measurement && self.has_begun && is_planned
    }

    /// Changes the limit of the last measurement if the run is in this measurement. Before that, nothing changes: the
    /// measurement takes its limit from the scene when it begins.
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

    /// Returns the simulated time and the number of physical events since the last measurement began; `None` if it has
    /// not begun.
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

/// Shortest simulated time in which a particle crosses the box; infinite if nothing moves. The particle has the highest
/// initial speed, or the thermal speed at the highest temperature of a thermostat or wall, or starts from rest with its
/// acceleration. The result is at most the time of [`MANY_COLLISIONS`] Andersen collisions.
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

/// Largest number of Andersen collisions between two checks of the run. This number of collisions takes a few
/// hundredths of a second.
const MANY_COLLISIONS: f64 = 1e4;
