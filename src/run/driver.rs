//! Runs the stages of a run in order, and advances the simulation within each stage.

mod advance;
mod equilibrate;
mod finish;
mod growth;
mod measure;
mod pace;
mod recorder;
mod stages;
mod storm;
mod swaps;
mod volume;

pub use equilibrate::MOST_EVENTS_PER_PARTICLE;
pub(super) use equilibrate::Monitor;
pub(super) use growth::PressureCheck;
use recorder::{Failed, KeepsError};
pub(super) use storm::StormWatch;
pub(super) use swaps::Swaps;
pub(super) use volume::{FEWEST_MOVES, Moves};

use std::ops::ControlFlow;

use super::begin::Origin;
use super::progress::Progress;
use super::state::RunState;
use super::{Blocked, Ending, Finished, Recorder, Run, Stage};
use crate::analysis::instruments::{Registry, SystemDescription};
use crate::base::clock::Instant;
use crate::engine::{Scaling, Simulation};
use crate::model::Until;

/// Initial and largest number of engine steps between two calls of `watch`. The number is adapted to the wall time and
/// does not affect the trajectory.
const STEPS: [u64; 2] = [64, 1 << 16];

const NEVER: Until = Until { time: None, events: None };

pub(super) fn drive<R: Recorder>(
    simulation: Simulation,
    state: RunState,
    registry: Registry,
    recorder: &mut R,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Finished, R::Error> {
    let mut recorder = KeepsError { recorder, error: None };
    let finished = Driver::new(simulation, state, registry, &mut recorder, watch).drive();
    finished.map_err(|Failed| recorder.into_error())
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Halt {
    Never,
    /// Pause at a simulated time or at a total number of physical events, whichever comes first.
    At(Until),
    Measurement,
}

/// Advances a run until it ends or reaches `halt`. Returns the run and its ending; the ending is `None` after a pause.
pub(super) fn drive_to<R: Recorder>(
    run: Run,
    halt: Halt,
    recorder: &mut R,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(Run, Option<Ending>), R::Error> {
    let Run { simulation, state, registry, .. } = run;
    let mut recorder = KeepsError { recorder, error: None };
    let mut driver = Driver::new(simulation, state, registry, &mut recorder, watch);
    driver.halt = halt;
    let ending = match driver.stages() {
        Ok(ending) => ending,
        Err(Failed) => return Err(recorder.into_error()),
    };
    let ending = if driver.is_halted { None } else { Some(ending) };
    driver.state.earlier_seconds += driver.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
    let Driver { simulation, state, registry, .. } = driver;
    Ok((Run { simulation, state, registry, origin: Origin::Pause }, ending))
}

/// Continues a run one engine step at a time, and interrupts the run at a simulated time.
pub(super) fn drive_in_steps<R: Recorder>(run: Run, time: f64, recorder: &mut R) -> Result<Finished, R::Error> {
    let Run { simulation, state, registry, .. } = run;
    let mut recorder = KeepsError { recorder, error: None };
    let mut watch = |progress: &Progress| {
        if progress.time < time { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let mut driver = Driver::new(simulation, state, registry, &mut recorder, &mut watch);
    (driver.steps, driver.most_steps) = (1, 1);
    let finished = driver.drive();
    finished.map_err(|Failed| recorder.into_error())
}

struct Driver<'a> {
    simulation: Simulation,
    state: RunState,
    system: Option<SystemDescription>,
    /// Custom instruments whose measurement has not begun.
    registry: Registry,
    recorder: &'a mut dyn Recorder<Error = Failed>,
    watch: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    /// Wall time at which the current measurement began or was continued.
    started: Option<Instant>,
    /// Whether growth or an automatic equilibration has reached its goal, which ends the stage.
    is_over: bool,
    is_pilot: bool,
    /// Point at which a pilot run pauses. The caller does not see this pause.
    pause: Until,
    halt: Halt,
    is_halted: bool,
    /// A pilot run gives up after this number of events, cell transitions and Andersen collisions.
    patience: u64,
    steps: u64,
    most_steps: u64,
    blocked: Option<Blocked>,
    scaling: Option<Scaling>,
}

impl<'a> Driver<'a> {
    fn new(
        simulation: Simulation,
        state: RunState,
        registry: Registry,
        recorder: &'a mut dyn Recorder<Error = Failed>,
        watch: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Self {
        let mut driver = Self {
            simulation,
            state,
            system: None,
            registry,
            recorder,
            watch,
            started: None,
            is_pilot: false,
            pause: NEVER,
            halt: Halt::Never,
            is_halted: false,
            patience: u64::MAX,
            is_over: false,
            steps: STEPS[0],
            most_steps: STEPS[1],
            blocked: None,
            scaling: None,
        };
        driver.describe();
        driver
    }
}

impl Driver<'_> {
    fn drive(mut self) -> Result<Finished, Failed> {
        let ending = self.stages()?;
        self.finish(ending)
    }

    fn stages(&mut self) -> Result<Ending, Failed> {
        loop {
            if !self.state.has_begun {
                self.enter();
            }
            if let Some(blocked) = self.blocked.take() {
                return Ok(Ending::Blocked(blocked));
            }
            let stage = self.state.stage.stage;
            if self.halt == Halt::Measurement && stage == Stage::Measurement {
                self.is_halted = true;
                return Ok(Ending::Interrupted);
            }
            let next = stage.next(&self.simulation.scene().run);
            if stage.is_measured() {
                let ending = self.measure()?;
                match next.filter(|_| !ending.is_early()) {
                    Some(next) => {
                        self.end_measured_stage()?;
                        self.leave(next);
                        continue;
                    }
                    None => return Ok(ending),
                }
            }
            let Some(next) = next else { return Ok(Ending::Events) };
            let has_end = self.growth().is_some() || self.state.monitor.is_some();
            if (self.state.stage.limit != Until::default() || has_end)
                && let Some(over) = self.prepare()?
            {
                return Ok(over);
            }
            self.leave(next);
        }
    }

    /// Advances to a simulated time or to the end of the stage. Returns an ending if the run reaches `events` or ends.
    fn advance(&mut self, time: f64, events: u64) -> Result<Option<Ending>, Failed> {
        while self.simulation.time() < time {
            let done = self.simulation.event_counts().physical();
            if done >= events {
                return Ok(Some(Ending::Events));
            }
            if self.is_checkpoint_due() {
                self.keep()?;
            }
            if self.is_stopped() {
                return Ok(Some(Ending::Interrupted));
            }
            let scaling = self.state.next_scaling;
            let temperature = self.state.next_temperature;
            let next_move = self.next_move();
            let next_swap = self.next_swap();
            let until = time.min(scaling).min(temperature).min(next_move).min(next_swap);
            let most = events.min(self.next_check());
            let ending = self.go(until, most)?;
            match ending {
                // Due to rounding, the simulation may stop before `until`. Times are therefore compared with `until`.
                Some(Ending::Time) => {
                    if scaling <= until {
                        self.rescale(scaling);
                    } else if temperature <= until {
                        self.sample_temperature();
                    }
                    if next_move <= until {
                        self.move_volume(next_move);
                    }
                    if next_swap <= until {
                        self.swap(next_swap);
                    }
                    if time <= until {
                        break;
                    }
                }
                Some(_) => return Ok(ending),
                None => {}
            }
            for check in [Self::check_growth, Self::check_equilibrium, Self::check_storm] {
                if let ControlFlow::Break(ending) = check(self) {
                    self.is_over = ending.is_none();
                    return Ok(ending);
                }
            }
        }
        Ok((self.simulation.event_counts().physical() >= events).then_some(Ending::Events))
    }

    fn describe(&mut self) {
        let measurement = self.state.measurement.as_ref();
        let is_measured = !(self.simulation.scene().measure.is_empty() && self.registry.is_empty())
            || measurement.is_some_and(|measurement| !measurement.instruments.is_empty());
        let applicable = self.state.observer.applicable();
        self.system = is_measured.then(|| SystemDescription::of_simulation(&self.simulation, applicable));
    }

    /// Passes a checkpoint of the current state to the recorder.
    fn keep(&mut self) -> Result<(), Failed> {
        self.simulation.complete();
        let seconds = self.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        let mut state = self.state.clone();
        state.earlier_seconds += seconds;
        self.recorder.checkpoint(&self.simulation, &state)
    }

    fn is_stopped(&mut self) -> bool {
        let progress = self.progress();
        let is_stopped = (self.watch)(&progress).is_break() || self.recorder.is_full();
        self.agreed(is_stopped)
    }

    fn is_checkpoint_due(&self) -> bool {
        !self.is_pilot && self.agreed(self.recorder.is_checkpoint_due())
    }

    /// Returns the value of the first process, because all processes must make the same decisions.
    fn agreed(&self, found: bool) -> bool {
        self.simulation.agreed(u64::from(found)) != 0
    }

    fn progress(&self) -> Progress {
        let (time, events) = (self.simulation.time(), self.simulation.event_counts().physical());
        let stage = &self.state.stage;
        Progress {
            stage: stage.stage,
            time,
            elapsed: time - stage.time,
            events: events - stage.events,
            limit: stage.limit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::model::space::{Boundary, Space};
    use crate::model::{OutputPlan, RunPlan, Until};
    use crate::run::{Ending, Stage, run};
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn run_can_be_interrupted_while_no_events_happen() {
        let mut space = Space::periodic_cube(3.0);
        space.size.x = 1e15;
        let scene = SceneBuilder::new("pipe")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(0.5, 0.5, 0.5), Vector::new(1.0, 0.3, 0.2))
            .particle("A", Vector::new(1e10, 1.5, 1.5), Vector::new(-1.0, 0.1, 0.3))
            .run(RunPlan { limit: Until::events(100), ..RunPlan::default() })
            // Without these intervals, a pilot run would be needed.
            .output(OutputPlan { thermo_interval: Some(1e15), frame_interval: Some(1e15), ..OutputPlan::default() })
            .build()
            .unwrap();
        let mut asked = 0;
        // There are at most `STEPS[1]` engine steps between two calls of `watch`.
        let finished = run(scene, &mut (), &mut |_| {
            asked += 1;
            if asked < 8 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let finished = finished.unwrap();
        assert_eq!(finished.ending, Ending::Interrupted);
        assert!(finished.simulation.event_counts().transition <= 7 * STEPS[1]);
    }

    fn overlapping(boundary: Boundary, velocity: [f64; 3]) -> SceneBuilder {
        let space = Space { boundary: [boundary, boundary, Boundary::Flat], ..Space::periodic_cube(10.0) };
        SceneBuilder::new("overlapping")
            .allow_invalid_start(true)
            .space(Space { size: Vector::new(10.0, 10.0, 0.0), ..space })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(2.0, 5.0, 0.0), Vector::zeros())
            .particle("A", Vector::new(2.5, 5.0, 0.0), Vector::zeros())
            .particle("A", Vector::new(8.0, 8.5, 0.0), Vector::from(velocity))
    }

    fn finished(scene: SceneBuilder, run_plan: RunPlan, thermo_interval: Option<f64>) -> crate::run::Finished {
        let output = OutputPlan { thermo_interval, frame_interval: Some(1e5), ..OutputPlan::default() };
        let scene = scene.run(run_plan).output(output).build().unwrap();
        run(scene, &mut (), &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn run_starting_with_overlaps_ends_normally() {
        let limit = |events| RunPlan { limit: Until::events(events), ..RunPlan::default() };
        // The run has far more rows than `MOST_QUIET_ROWS`, but only about 40 rows between two events.
        let bounces = finished(overlapping(Boundary::walls(1.0), [1.0, 0.0, 0.0]), limit(100), Some(0.2));
        assert_eq!((bounces.ending, bounces.measurement.event_counts.wall), (Ending::Events, 100));
        let leaves = finished(overlapping(Boundary::OPEN, [1.0, 0.0, 0.0]), limit(10), None);
        assert_eq!(leaves.ending, Ending::Idle);
        // The third disk passes the other two disks repeatedly, without a collision.
        let passes = finished(overlapping(Boundary::Periodic, [1.0, 0.0, 0.0]), limit(10), Some(0.01));
        assert_eq!(passes.ending, Ending::GaveUp);
    }

    #[test]
    fn run_gives_up_if_any_stage_has_no_events() {
        let pass = |position: [f64; 3], velocity: f64, scene: SceneBuilder| {
            scene.particle("A", Vector::from(position), Vector::new(velocity, 0.0, 0.0))
        };
        let scene = SceneBuilder::new("passing")
            .space(Space::periodic_cube(10.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
        let scene = pass([2.0, 7.0, 5.0], -1.0, pass([2.0, 2.0, 5.0], 1.0, scene));
        let plan = RunPlan { equilibration: Until::events(10), limit: Until::time(10.0), ..RunPlan::default() };
        let finished = finished(scene, plan, Some(1e-3));
        assert_eq!((finished.ending, finished.stage), (Ending::GaveUp, Stage::Equilibration));
    }
}
