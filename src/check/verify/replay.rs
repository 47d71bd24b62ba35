//! The replay of a run, with every event of a range shown to the verifier.

use super::certificate::{Certificate, Counts, End};
use super::verifier::Verifier;
use super::violation::{Fault, Violation};
use crate::engine::event::Event;
use crate::engine::{EngineError, Reason, Simulation, States, Until};
use crate::model::{Equilibration, Limit, RunPlan, Scene};
use std::ops::ControlFlow;

/// Events between two calls of `watch` on the way to the range.
const CHUNK: u64 = 100_000;
/// Events between two calls of `watch` within it.
const FEW: u64 = 64;
/// Steps of the engine between two calls of `watch`, however few events they are: some tens of milliseconds.
const STEPS: u64 = 20_000;

/// The range of events of a run to prove.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EventRange {
    /// Events that are only replayed first.
    pub from: u64,
    /// Events that are then proven.
    pub events: u64,
}

/// End of a run, by its own record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunEnd {
    /// Physical events of the whole run; `None` where the record does not have it.
    pub events: Option<u64>,
    /// Simulated time.
    pub time: f64,
}

impl RunEnd {
    /// Round-off bound of a simulated time.
    fn rounding(&self, start: f64) -> f64 {
        4.0 * f64::EPSILON * self.time.abs().max(start.abs())
    }
}

/// Progress of a verification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifyProgress {
    /// Range of events to verify.
    pub range: EventRange,
    /// Events so far, since the start of the simulation.
    pub events: u64,
    /// Whether the range has begun.
    pub is_proving: bool,
    /// Simulated time.
    pub time: f64,
}

impl VerifyProgress {
    /// The part of the way to the range that is done, or of the range: 0 to 1.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let EventRange { from, events } = self.range;
        let (done, all) =
            if self.is_proving { (self.events.saturating_sub(from), events) } else { (self.events, from) };
        (done as f64 / all.max(1) as f64).min(1.0)
    }
}

/// Replays a scene, and proves a range of its events.
///
/// The replay ends where the run does that the scene plans. `watch` is called now and then, and ends it at once where it
/// breaks. Before a range that does not begin at the start, pair states are what the engine remembers; from there on they
/// follow from the events alone.
#[must_use]
pub fn verify(
    scene: Scene,
    range: EventRange,
    watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>,
) -> Certificate {
    certify(scene, range, None, watch)
}

/// Replays a run that has been, and proves a range of its events.
///
/// As [`verify`], but the replay ends where the run did, whatever ended its equilibration. Where the proof comes to that end, number of events and
/// time are held against those of the run: [`End::Departed`] if they differ.
#[must_use]
pub fn verify_run(
    scene: Scene,
    ended: RunEnd,
    range: EventRange,
    watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>,
) -> Certificate {
    certify(scene, range, Some(ended), watch)
}

fn certify(
    scene: Scene,
    range: EventRange,
    recorded: Option<RunEnd>,
    watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>,
) -> Certificate {
    if scene.is_driven() {
        return Certificate { end: End::Driven, ..Certificate::blank(1, scene.start_time) };
    }
    let plan = scene.run.clone();
    let mut replay = Replay {
        simulation: Simulation::without_plan(scene),
        stages: stages(&plan),
        ends: None,
        recorded,
        has_run_out: false,
    };
    let skipped = replay.skip(range, watch);
    let mut states = States::default();
    replay.simulation.states(&mut states);
    let blank = Certificate::blank(replay.simulation.event_counts().physical() + 1, replay.simulation.time());
    let mut verifier = match replay.verifier(range, &states) {
        Ok(verifier) => verifier,
        Err(fault) => return Certificate { end: End::Violated(replay.violation(fault)), ..blank },
    };
    let origin = states.elapsed;
    let end = match skipped {
        Some(End::Idle) => replay.idle(&mut verifier).unwrap_or_else(End::Violated),
        Some(end) => end,
        None => replay.prove(&mut verifier, range, &mut states, watch),
    };
    Certificate {
        duration: states.elapsed.after(&origin),
        counts: Counts { asked: verifier.counts.asked + verifier.window.asked, ..verifier.counts },
        margins: verifier.margins,
        largest_gap: verifier.largest_gap,
        deepest_overlap: verifier.deepest_overlap,
        end,
        ..blank
    }
}

/// The stages of a run that are left, the next one last.
fn stages(plan: &RunPlan) -> Vec<Limit> {
    let until = |limit| Equilibration { limit, until_stationary: false };
    let listed = plan.stages.iter().flat_map(|stage| [stage.measured.unwrap_or_default(), until(stage.limit)]);
    let all: Vec<Equilibration> = listed.chain([plan.last_equilibration(), until(plan.limit)]).collect();
    let ends = all.iter().rev().map(|stage| stage.limit).filter(|limit| *limit != Limit::default());
    let ends: Vec<Limit> = ends.collect();
    // A scene that does not say how long to run, or whose equilibration ends by what it measures, can be replayed for ever.
    if ends.is_empty() || all.iter().any(|stage| stage.until_stationary) { vec![Limit::default()] } else { ends }
}

struct Replay {
    simulation: Simulation,
    stages: Vec<Limit>,
    /// Simulated time and events at which the present stage ends.
    ends: Option<Until>,
    /// Where the run has ended; `None` ends where the scene plans it.
    recorded: Option<RunEnd>,
    /// Whether the time of that run is over.
    has_run_out: bool,
}

impl Replay {
    /// Where the present stage of the run ends; none after the last one.
    fn stage(&mut self) -> Option<Until> {
        if let Some(recorded) = self.recorded {
            return self.left_of(&recorded);
        }
        if self.ends.is_none_or(|ends| self.simulation.event_counts().physical() >= ends.events) {
            let limit = self.stages.pop()?;
            let events = self.simulation.event_counts().physical();
            self.ends = Some(Until {
                time: limit.time.map_or(f64::INFINITY, |time| self.simulation.time() + time),
                events: limit.events.map_or(u64::MAX, |more| events.saturating_add(more)),
            });
        }
        self.ends
    }

    /// Limit of the next step of a run that is over: its events first, and then a time without any. An event there is one too many.
    fn left_of(&self, recorded: &RunEnd) -> Option<Until> {
        let rounding = recorded.rounding(self.simulation.scene().start_time);
        let events = recorded.events.unwrap_or(u64::MAX);
        match self.simulation.event_counts().physical() {
            _ if self.has_run_out => None,
            done if done < events => Some(Until { time: recorded.time + rounding, events }),
            done if done == events && self.simulation.time() < recorded.time - rounding => {
                Some(Until { time: recorded.time, events: u64::MAX })
            }
            _ => None,
        }
    }

    /// How the replay ends where the run does.
    fn ended(&self) -> End {
        let (events, time) = (self.simulation.event_counts().physical(), self.simulation.time());
        if let Some(recorded) = self.recorded {
            let is_there = (time - recorded.time).abs() <= 2.0 * recorded.rounding(self.simulation.scene().start_time);
            if !is_there || recorded.events.is_some_and(|recorded| recorded != events) {
                return End::Departed { recorded, events, time };
            }
            // It has ended before its limit: because nothing will happen any more, or because it was stopped.
            let limit = &self.simulation.scene().run.limit;
            let is_early = limit.time.is_none() && limit.events.is_some_and(|planned| events < planned);
            if is_early && self.simulation.is_over() {
                return End::Idle;
            }
        }
        End::RunEnded
    }

    /// Ends a stage by its time.
    fn end_stage(&mut self) {
        self.ends = None;
        self.has_run_out = true;
    }

    /// Goes to the start of the range without looking.
    fn skip(&mut self, range: EventRange, watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>) -> Option<End> {
        while self.simulation.event_counts().physical() < range.from {
            if watch(&self.progress(range, false)).is_break() {
                return Some(End::Interrupted);
            }
            let Some(stage) = self.stage() else { return Some(self.ended()) };
            let chunk = self.simulation.event_counts().physical().saturating_add(CHUNK);
            let until = Until { events: stage.events.min(range.from).min(chunk), ..stage };
            match self.simulation.advance_for(STEPS, until, None) {
                Ok(None | Some(Reason::Events | Reason::Observer)) => {}
                Ok(Some(Reason::Time)) => self.end_stage(),
                Ok(Some(Reason::Idle)) => return Some(End::Idle),
                Err(error) => return Some(Stop::from(error).into()),
            }
        }
        None
    }

    /// At the start of the range.
    fn verifier(&self, range: EventRange, states: &States) -> Result<Verifier, Fault> {
        let scene = self.simulation.scene();
        match (range.from, scene.predecessor()) {
            (0, None) => Verifier::new(scene, states),
            (_, None) => Verifier::resume(scene, states, &self.simulation.captured_pairs()),
            // Its time is counted from where the engine of the run before it began.
            (_, Some(_)) => {
                let mut verifier = Verifier::resume(scene, states, &self.simulation.captured_pairs())?;
                verifier.start_time = self.simulation.time() - states.elapsed.total();
                Ok(verifier)
            }
        }
    }

    /// Proves event after event.
    fn prove(
        &mut self,
        verifier: &mut Verifier,
        range: EventRange,
        states: &mut States,
        watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>,
    ) -> End {
        let mut end = None;
        while end.is_none() {
            let done = verifier.counts.events();
            if done.is_multiple_of(FEW) && watch(&self.progress(range, true)).is_break() {
                end = Some(End::Interrupted);
            } else if done >= range.events {
                end = Some(End::Asked);
            } else {
                end = self.step(verifier, range, states, watch).unwrap_or_else(|stop| Some(stop.into()));
            }
        }
        let end = end.unwrap_or(End::Asked);
        match verifier.compare_pairs(&self.simulation.captured_pairs()) {
            Err(fault) if !matches!(end, End::Violated(_) | End::Arrested(_) | End::Broken(_) | End::Interrupted) => {
                End::Violated(self.violation(fault))
            }
            _ => end,
        }
    }

    /// The next event of the run, or what there is instead.
    fn step(
        &mut self,
        verifier: &mut Verifier,
        range: EventRange,
        states: &mut States,
        watch: &mut dyn FnMut(&VerifyProgress) -> ControlFlow<()>,
    ) -> Result<Option<End>, Stop> {
        let Some(stage) = self.stage() else {
            return Ok(Some(match self.ended() {
                End::Idle => self.idle(verifier)?,
                end => end,
            }));
        };
        let progress = self.progress(range, true);
        let mut watch = || watch(&progress);
        let until = Until { time: stage.time, events: self.simulation.event_counts().physical().saturating_add(1) };
        let mut event = None;
        let reason = loop {
            let mut show = |executed: &Event| {
                event = Some(*executed);
                ControlFlow::Continue(())
            };
            if let Some(reason) = self.simulation.advance_for(STEPS, until, Some(&mut show))? {
                break reason;
            }
            if watch().is_break() {
                return Ok(Some(End::Interrupted));
            }
        };
        self.simulation.states(states);
        if let Some(event) = event {
            verifier.witness_watched(&event, states, &mut watch).map_err(|fault| self.violation(fault))?;
            return Ok(None);
        }
        verifier.witness_quiet_watched(states, &mut watch).map_err(|fault| self.violation(fault))?;
        self.end_stage();
        if reason == Reason::Idle {
            return Ok(Some(self.idle(verifier)?));
        }
        Ok(None)
    }

    /// The engine says that nothing will happen any more: whether that is so.
    fn idle(&self, verifier: &mut Verifier) -> Result<End, Violation> {
        verifier.witness_end().map(|()| End::Idle).map_err(|fault| self.violation(fault))
    }

    fn violation(&self, fault: Fault) -> Violation {
        Violation { event: self.simulation.event_counts().physical(), time: self.simulation.time(), fault }
    }

    fn progress(&self, range: EventRange, is_proving: bool) -> VerifyProgress {
        let events = self.simulation.event_counts().physical();
        VerifyProgress { range, events, is_proving, time: self.simulation.time() }
    }
}

/// Reason why a proof ends early.
enum Stop {
    Engine(EngineError),
    Violated(Violation),
}

impl From<EngineError> for Stop {
    fn from(error: EngineError) -> Self {
        Self::Engine(error)
    }
}

impl From<Violation> for Stop {
    fn from(violation: Violation) -> Self {
        Self::Violated(violation)
    }
}

impl From<Stop> for End {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Engine(EngineError::Arrest(arrest)) => Self::Arrested(arrest),
            Stop::Engine(EngineError::InvariantBroken(broken)) => Self::Broken(broken),
            Stop::Violated(Violation { fault: Fault::Interrupted, .. }) => Self::Interrupted,
            Stop::Violated(violation) => Self::Violated(violation),
        }
    }
}
