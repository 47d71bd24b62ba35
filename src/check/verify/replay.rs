//! Replays a run and passes every event of a range to the verifier.

use super::certificate::{Certificate, End};
use super::rest::is_sleep;
use super::schedule::{Stretch, schedule};
use super::verifier::Verifier;
use super::violation::{Fault, Violation};
use crate::engine::event::Event;
use crate::engine::{EngineError, Reason, Simulation, States, Until};
use crate::model::Scene;
use std::ops::ControlFlow;

/// Number of events between two calls of `watch` before the range.
const CHUNK: u64 = 100_000;
/// Number of events between two calls of `watch` within the range.
const FEW: u64 = 64;
/// Number of engine steps between two calls of `watch` if few events happen.
const STEPS: u64 = 20_000;

/// The range of events to prove.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EventRange {
    /// Number of events to replay before the proof begins.
    pub from: u64,
    /// Number of events to prove.
    pub events: u64,
}

/// The recorded end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunEnd {
    /// Number of physical events in the whole run; `None` if it is not recorded.
    pub events: Option<u64>,
    /// Simulated time.
    pub time: f64,
}

impl RunEnd {
    /// Returns the round-off error of the recorded time. The run starts at the time `start` `[time]`.
    fn rounding(&self, start: f64) -> f64 {
        4.0 * f64::EPSILON * self.time.abs().max(start.abs())
    }
}

type Watch<'w> = &'w mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>;

/// Progress of a verification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifyProgress {
    /// The range of events to prove.
    pub range: EventRange,
    /// Number of physical events replayed since the start of the simulation.
    pub events: u64,
    /// Whether the replay has reached the range, so that events are being proven.
    pub is_proving: bool,
    /// Simulated time.
    pub time: f64,
}

impl VerifyProgress {
    /// Returns the completed fraction, from 0 to 1. Before the proof begins, this is the fraction of skipped events.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let EventRange { from, events } = self.range;
        let (done, all) =
            if self.is_proving { (self.events.saturating_sub(from), events) } else { (self.events, from) };
        (done as f64 / all.max(1) as f64).min(1.0)
    }
}

/// Replays a scene and proves a range of its events.
///
/// The replay ends at the planned end of the run, or if `watch` breaks. Unless the range begins with the first event,
/// the engine provides the initial pair states. All later pair states follow from the events alone.
#[must_use]
pub fn verify(scene: Scene, range: EventRange, watch: Watch<'_>) -> Certificate {
    certify(scene, range, None, watch)
}

/// Replays a finished run and proves a range of its events.
///
/// The replay ends at the recorded end of the run. Unlike [`verify`], this function supports automatic equilibrations.
/// If the number of events or the end time differs from the record, the certificate has the end [`End::Departed`].
#[must_use]
pub fn verify_run(scene: Scene, ended: RunEnd, range: EventRange, watch: Watch<'_>) -> Certificate {
    certify(scene, range, Some(ended), watch)
}

fn certify(scene: Scene, range: EventRange, recorded: Option<RunEnd>, watch: Watch<'_>) -> Certificate {
    let refused = |end: End| Certificate { end, ..Certificate::blank(1, scene.start_time) };
    let is_driven = scene.run.has_thermostat_or_growth() || scene.run.has_swaps() || scene.shear_rate.is_some();
    if is_driven || scene.has_thermal_walls() || scene.has_flow() {
        return refused(End::Driven);
    }
    let Some(stretches) = schedule(&scene.run, &scene.surfaces) else { return refused(End::OpenStages) };
    let has_changes =
        scene.run.gravities().next().is_some() || scene.surfaces.iter().any(|surface| !surface.stages.is_empty());
    let follows_stages = recorded.is_none() || has_changes;
    let mut replay = Replay {
        simulation: Simulation::without_plan(scene),
        states: States::default(),
        range,
        watch,
        stretches: if follows_stages { stretches } else { Vec::new() },
        begun: None,
        ends: None,
        recorded,
        has_run_out: false,
    };
    let skipped = replay.skip();
    replay.simulation.states(&mut replay.states);
    let blank = Certificate::blank(replay.events() + 1, replay.simulation.time());
    let mut verifier = match replay.verifier() {
        Ok(verifier) => verifier,
        Err(fault) => return Certificate { end: replay.violated(fault), ..blank },
    };
    verifier.proof = blank;
    let origin = replay.states.elapsed;
    let end = match skipped {
        Ok(()) => replay.prove(&mut verifier),
        Err(End::Idle) => replay.idle(&mut verifier),
        Err(end) => end,
    };
    verifier.proof.counts.asked += verifier.window.asked;
    Certificate { duration: replay.states.elapsed.after(&origin), end, ..verifier.proof }
}

struct Replay<'w> {
    simulation: Simulation,
    /// Particle states after the last event. They are not updated while events before the range are skipped.
    states: States,
    range: EventRange,
    watch: Watch<'w>,
    /// Remaining intervals of the run in reverse order.
    stretches: Vec<Stretch>,
    /// Interval that has not been passed to the verifier yet.
    begun: Option<Stretch>,
    /// Simulated time and number of events at which the current interval ends; `None` between intervals.
    ends: Option<Until>,
    recorded: Option<RunEnd>,
    has_run_out: bool,
}

impl Replay<'_> {
    fn events(&self) -> u64 {
        self.simulation.event_counts().physical()
    }

    /// Returns the end of the current interval, and begins an interval if necessary. `None` at the end of the run.
    fn stretch(&mut self) -> Option<Until> {
        let recorded = match self.recorded {
            Some(recorded) => Some(self.left_of(&recorded)?),
            None => None,
        };
        while self.ends.is_none_or(|ends| self.events() >= ends.last_event()) {
            let Some(stretch) = self.stretches.pop() else { return recorded };
            let Stretch { stage, gravity, limit } = &stretch;
            let events = self.events();
            self.ends = Some(Until {
                time: limit.time.map(|time| self.simulation.time() + time),
                events: limit.events.map(|more| events.saturating_add(more)),
            });
            self.simulation.set_stage_of_surfaces(stage);
            if let Some(gravity) = gravity {
                self.simulation.set_gravity(gravity);
            }
            self.begun = Some(stretch);
        }
        self.ends.map(|ends| recorded.map_or(ends, |recorded| ends.or(recorded)))
    }

    /// Returns how far the replay may advance, or `None` at the recorded end of the run. The replay executes the
    /// recorded number of events, and then advances to the recorded time.
    fn left_of(&self, recorded: &RunEnd) -> Option<Until> {
        let rounding = recorded.rounding(self.simulation.scene().start_time);
        let events = recorded.events.unwrap_or(u64::MAX);
        match self.events() {
            _ if self.has_run_out => None,
            done if done < events => Some(Until::time(recorded.time + rounding).or_events(events)),
            done if done == events && self.simulation.time() < recorded.time - rounding => {
                Some(Until::time(recorded.time))
            }
            _ => None,
        }
    }

    fn ended(&self) -> End {
        let (events, time) = (self.events(), self.simulation.time());
        if let Some(recorded) = self.recorded {
            let is_there = (time - recorded.time).abs() <= 2.0 * recorded.rounding(self.simulation.scene().start_time);
            if !is_there || recorded.events.is_some_and(|recorded| recorded != events) {
                return End::Departed { recorded, events, time };
            }
            // A run with fewer events than planned was stopped, or nothing could happen.
            let limit = &self.simulation.scene().run.limit;
            let is_early = limit.time.is_none() && limit.events.is_some_and(|planned| events < planned);
            if is_early && self.simulation.is_over() {
                return End::Idle;
            }
        }
        End::RunEnded
    }

    /// Ends the current interval, or the recorded run. The replay has reached `time` without an event.
    fn end_at(&mut self, time: f64) {
        if self.ends.is_some_and(|ends| ends.last_time() <= time) {
            self.ends = None;
        } else {
            self.has_run_out = true;
        }
    }

    /// Replays the events before the range without a proof. Fails if the replay ends before the range.
    fn skip(&mut self) -> Result<(), End> {
        while self.events() < self.range.from {
            if self.is_stopped(false) {
                return Err(End::Interrupted);
            }
            let Some(stretch) = self.stretch() else { return Err(self.ended()) };
            let chunk = self.events().saturating_add(CHUNK);
            let until = stretch.or(Until::events(self.range.from.min(chunk)));
            match self.simulation.advance_for(STEPS, until)? {
                None | Some(Reason::Events | Reason::Observer) => {}
                Some(Reason::Time) => self.end_at(until.last_time()),
                Some(Reason::Idle) => return Err(End::Idle),
            }
        }
        Ok(())
    }

    fn verifier(&mut self) -> Result<Verifier, Fault> {
        let mut verifier = self.verifier_of_first_stage()?;
        self.tell_stage(&mut verifier)?;
        Ok(verifier)
    }

    fn tell_stage(&mut self, verifier: &mut Verifier) -> Result<(), Fault> {
        let Some(Stretch { stage, gravity, .. }) = self.begun.take() else { return Ok(()) };
        verifier.enter_stage(&stage, &self.states)?;
        gravity.map_or(Ok(()), |gravity| verifier.turn_gravity(&gravity, &self.states))
    }

    fn verifier_of_first_stage(&self) -> Result<Verifier, Fault> {
        let (scene, states) = (self.simulation.scene(), &self.states);
        if self.range.from == 0 && scene.predecessor().is_none() {
            return Verifier::new(scene, states);
        }
        // A run may continue a chain of earlier runs. Elapsed times count from the start of the first run.
        let start_time = match scene.predecessor() {
            Some(_) => self.simulation.time() - states.elapsed.total(),
            None => scene.start_time,
        };
        let asleep = self.simulation.sleeping();
        Verifier::resume_from(scene, states, &self.simulation.captured_pairs(), (start_time, &asleep))
    }

    fn prove(&mut self, verifier: &mut Verifier) -> End {
        let end = loop {
            let done = verifier.proof.counts.events();
            if done.is_multiple_of(FEW) && self.is_stopped(true) {
                break End::Interrupted;
            }
            if done >= self.range.events {
                break End::Asked;
            }
            if let Err(end) = self.step(verifier) {
                break end;
            }
        };
        match verifier.compare_pairs(&self.simulation.captured_pairs()) {
            Err(fault) if !matches!(end, End::Violated(_) | End::Arrested(_) | End::Broken(_) | End::Interrupted) => {
                self.violated(fault)
            }
            _ => end,
        }
    }

    /// Proves the next event of the run. Fails if there is no next event or if the event is wrong.
    fn step(&mut self, verifier: &mut Verifier) -> Result<(), End> {
        let Some(stretch) = self.stretch() else {
            return Err(match self.ended() {
                End::Idle => self.idle(verifier),
                end => end,
            });
        };
        self.tell_stage(verifier).map_err(|fault| self.violated(fault))?;
        let progress = self.progress(true);
        let until = stretch.or_events(self.events().saturating_add(1));
        let Self { simulation, states, watch, .. } = self;
        let mut watch = || watch(&progress);
        let mut events = Vec::new();
        let reason = loop {
            // Grains that fall asleep or wake up are not counted as events, so the observer ends the step.
            let see = |executed: &Event| {
                events.push(*executed);
                if is_sleep(executed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            if let Some(reason) = simulation.advance_for_with(STEPS, until, see)? {
                break reason;
            }
            if watch().is_break() {
                return Err(End::Interrupted);
            }
        };
        simulation.states(states);
        if !events.is_empty() {
            return verifier.witness_all(&events, states, &mut watch).map_err(|fault| self.violated(fault));
        }
        verifier.witness_quiet(states, &mut watch).map_err(|fault| self.violated(fault))?;
        self.end_at(until.last_time());
        if reason == Reason::Idle { Err(self.idle(verifier)) } else { Ok(()) }
    }

    fn idle(&self, verifier: &mut Verifier) -> End {
        verifier.witness_end().map_or_else(|fault| self.violated(fault), |()| End::Idle)
    }

    fn violated(&self, fault: Fault) -> End {
        match fault {
            Fault::Interrupted => End::Interrupted,
            fault => End::Violated(Violation { event: self.events(), time: self.simulation.time(), fault }),
        }
    }

    fn is_stopped(&mut self, is_proving: bool) -> bool {
        let progress = self.progress(is_proving);
        (self.watch)(&progress).is_break()
    }

    fn progress(&self, is_proving: bool) -> VerifyProgress {
        VerifyProgress { range: self.range, events: self.events(), is_proving, time: self.simulation.time() }
    }
}

impl From<EngineError> for End {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::Arrest(arrest) => Self::Arrested(arrest),
            EngineError::InvariantBroken(broken) => Self::Broken(broken),
        }
    }
}
