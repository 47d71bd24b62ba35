//! Setup of a run from a scene or a checkpoint.

use std::convert::Infallible;
use std::ops::ControlFlow;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::checkpoint::Checkpoint;
use super::driver::{Halt, drive, drive_in_steps, drive_to};
use super::progress::Progress;
use super::state::{Beginning, RunState};
use super::{Ending, Finished, Recorder, Stage};
use crate::analysis::instruments::{Instrument, InstrumentError, Registry, Setup};
use crate::engine::Simulation;
use crate::model::{Scene, Species, Threads, Until};

/// Why a run failed. `E` is the error of its [`Recorder`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError<E> {
    /// The recorder failed.
    #[error(transparent)]
    Recorder(E),
    /// The custom instruments differ from the instruments at the start of the run.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
}

/// Runs a scene as planned, and passes rows and frames to a recorder. The result is the same as with [`Run::execute`]
/// without custom instruments.
///
/// # Errors
/// The errors of the recorder. If the simulation cannot continue, [`Finished::ending`] contains the reason.
pub fn run<R: Recorder>(
    scene: Scene,
    recorder: &mut R,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Finished, R::Error> {
    let Run { simulation, state, .. } = Run::new(scene);
    drive(simulation, state, Registry::default(), recorder, watch)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Origin {
    Scene,
    Checkpoint,
    /// A paused run, whose instruments were checked before the pause.
    Pause,
}

/// A run of a scene with all its stages and instruments, from the start or from a checkpoint.
///
/// ```
/// use carom::model::{RunPlan, Until};
/// use carom::run::Run;
/// use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
///
/// let scene = SceneBuilder::new("fluid")
///     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
///     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
///     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
///     .temperature(1.0)
///     .run(RunPlan { equilibration: Until::events(2_000), limit: Until::events(5_000), ..RunPlan::default() })
///     .build()?;
/// let finished = Run::new(scene).finish()?;
/// let (name, temperature) = finished.observables[0];
/// assert_eq!(name, "temperature");
/// assert!((temperature.mean - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[must_use = "a run does nothing until `execute` or `finish`"]
pub struct Run {
    pub(super) simulation: Simulation,
    pub(super) state: RunState,
    pub(super) registry: Registry,
    pub(super) origin: Origin,
}

impl Run {
    /// Creates a run from the start of a scene.
    pub fn new(scene: Scene) -> Self {
        let simulation = Simulation::without_plan(scene);
        let state = RunState::new(&simulation);
        Self { simulation, state, registry: Registry::default(), origin: Origin::Scene }
    }

    /// Creates a run from the start of a scene and frees the initial positions and velocities, which saves 56 bytes per
    /// particle. Afterwards, `simulation.scene().particles()` is empty. Scenes with static particles or a growth stage
    /// keep the initial particles.
    pub fn without_start(scene: Scene) -> Self {
        let keeps_start = scene.species.iter().any(Species::is_static) || scene.run.has_growth();
        let beginning = Beginning::of(&scene);
        let simulation = Simulation::begin(scene, keeps_start);
        let state = RunState::begin(&simulation, beginning);
        Self { simulation, state, registry: Registry::default(), origin: Origin::Scene }
    }

    /// Continues a run from a checkpoint. The results are the same, bit for bit, as without the interruption.
    pub fn resume(checkpoint: Checkpoint) -> Self {
        let Checkpoint { mut simulation, state, .. } = checkpoint;
        simulation.set_threads(simulation.scene().run().threads);
        Self { simulation, state, registry: Registry::default(), origin: Origin::Checkpoint }
    }

    /// Sets the number of threads, which does not change the results: see [`Simulation::set_threads`].
    pub fn threads(mut self, threads: impl Into<Threads>) -> Self {
        self.simulation.set_threads(threads);
        self
    }

    /// Plans output for the limit `end`. A repeated run needs this if the limit of the original run was changed.
    pub(crate) fn planned_for(mut self, end: Option<Until>) -> Self {
        self.state.planned = end;
        self
    }

    /// Returns the simulation in its current state.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Returns the current stage.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.state.stage.stage
    }

    /// Returns the simulation of a paused run, to set positions or velocities.
    pub fn simulation_mut(&mut self) -> &mut Simulation {
        &mut self.simulation
    }

    /// Adds a custom [`Instrument`]. `begin` creates the instrument at the start of the measurement. After the run,
    /// [`Finished::instrument`] and [`Finished::take_instrument`] return it.
    ///
    /// Checkpoints contain the state of the instrument. Register the instrument again under the same name before a run
    /// continues from a checkpoint. `begin` is then called only if the measurement has not begun.
    pub fn instrument<I>(mut self, name: &str, begin: impl FnOnce(&Setup<'_>) -> I + Send + 'static) -> Self
    where
        I: Instrument + Clone + Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        self.registry.add(name, begin);
        self
    }

    /// Runs to the end, and passes rows, frames and events to a recorder, for example a [`Folder`](crate::io::Folder).
    ///
    /// `watch` is called every few hundredths of a second. When it returns `Break`, the run is interrupted and can be
    /// resumed. Neither `watch` nor the recorder changes the trajectory. A stage without an end condition is skipped.
    ///
    /// # Errors
    /// [`RunError::Recorder`] if the recorder fails, and [`RunError::Instrument`] if the registered instruments differ
    /// from the instruments at the start of the run. If the simulation cannot continue, [`Finished::ending`] contains
    /// the reason.
    pub fn execute<R: Recorder>(
        self,
        recorder: &mut R,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Finished, RunError<R::Error>> {
        let Self { simulation, state, registry, .. } = self.registered()?;
        drive(simulation, state, registry, recorder, watch).map_err(RunError::Recorder)
    }

    /// Checks the registered instruments and restores their state if the measurement has begun.
    fn registered(mut self) -> Result<Self, InstrumentError> {
        let Self { state, registry, origin, .. } = &mut self;
        match origin {
            Origin::Scene => state.registered = registry.names()?,
            Origin::Checkpoint => registry.compare(&state.registered)?,
            Origin::Pause => return Ok(self),
        }
        if let Some(measurement) = &mut state.measurement {
            measurement.instruments.restore(registry)?;
        }
        Ok(self)
    }

    /// Runs to a simulated time or a number of physical events since the start of the simulation, whichever comes
    /// first. Then pauses and returns the run and `None`. A pause does not change the trajectory. If the run ends
    /// earlier, returns the run and its ending. [`Run::execute`] or [`Run::finish`] then records the last row and
    /// frame.
    ///
    /// ```
    /// # use carom::model::RunPlan;
    /// # use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    /// use carom::engine::Until;
    /// use carom::run::Run;
    ///
    /// # let scene = SceneBuilder::new("fluid")
    /// #     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
    /// #     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
    /// #     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
    /// #     .temperature(1.0)
    /// #     .run(RunPlan { equilibration: Until::events(2_000), limit: Until::events(5_000), ..RunPlan::default() })
    /// #     .build()?;
    /// let (run, ending) = Run::new(scene).advance(Until::events(1_000), &mut ())?;
    /// assert!(ending.is_none() && run.simulation().event_counts().physical() == 1_000);
    /// let finished = run.finish()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::execute`].
    pub fn advance<R: Recorder>(
        self,
        until: Until,
        recorder: &mut R,
    ) -> Result<(Self, Option<Ending>), RunError<R::Error>> {
        let watch = &mut |_: &Progress| ControlFlow::Continue(());
        drive_to(self.registered()?, Halt::At(until), recorder, watch).map_err(RunError::Recorder)
    }

    /// Repeats an interrupted run up to the interruption. Runs to the physical event number `events`, counted from the
    /// start of the simulation, and then to the time `time`.
    ///
    /// `watch` is called as in [`Self::execute`]. If it returns `Break`, the run ends at once.
    pub(crate) fn execute_up_to<R: Recorder>(
        self,
        events: u64,
        time: f64,
        recorder: &mut R,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Finished, RunError<R::Error>> {
        let halt = Halt::At(Until::events(events));
        let (run, ending) = drive_to(self.registered()?, halt, recorder, watch).map_err(RunError::Recorder)?;
        let end = if ending.is_none() { time } else { f64::NEG_INFINITY };
        drive_in_steps(run, end, recorder).map_err(RunError::Recorder)
    }

    /// Runs all stages before the last measurement, and pauses at the start of the measurement. The thermostat and the
    /// gravity of the measurement are set up. Returns the paused run and `None`. A pause does not change the
    /// trajectory. If the run ends earlier, returns the run and its ending.
    ///
    /// `watch` is called as in [`Self::execute`]. Results of measured stages are not recorded.
    ///
    /// # Errors
    /// As [`Self::execute`].
    pub fn prepare(
        self,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(Self, Option<Ending>), InstrumentError> {
        let Ok(prepared) = drive_to(self.registered()?, Halt::Measurement, &mut (), watch);
        Ok(prepared)
    }

    /// Extracts the simulation.
    #[must_use]
    pub fn into_simulation(self) -> Simulation {
        self.simulation
    }

    /// Runs to the end without a recorder.
    ///
    /// # Errors
    /// [`InstrumentError`] under the same conditions as [`Self::execute`].
    pub fn finish(self) -> Result<Finished, InstrumentError> {
        self.execute(&mut (), &mut |_| ControlFlow::Continue(())).map_err(|error: RunError<Infallible>| match error {
            RunError::Instrument(error) => error,
            RunError::Recorder(never) => match never {},
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Growth, GrowthTarget, RunPlan, StagePlan, Thermostat};
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    fn planned(target: f64) -> Scene {
        let bath = Some(Thermostat::Andersen { temperature: 2.0, rate: 1.0, axes: [true; 3] });
        let growth = Some(Growth { rate: 0.1, until: GrowthTarget::PackingFraction(target) });
        let grow = StagePlan { name: "grow".into(), growth, ..StagePlan::default() };
        let plan = RunPlan {
            stages: vec![grow],
            equilibration: Until::events(300),
            limit: Until::events(500),
            thermostat: bath,
            ..RunPlan::default()
        };
        SceneBuilder::new("planned")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
            .temperature(1.0)
            .run(plan)
            .build()
            .unwrap()
    }

    #[test]
    fn prepared_simulation_continues_to_the_result_of_the_run() {
        let finished = Run::new(planned(0.25)).finish().unwrap();
        let go_on = &mut |_: &Progress| ControlFlow::Continue(());
        let (run, ending) = Run::new(planned(0.25)).prepare(go_on).unwrap();
        assert_eq!((ending, run.stage()), (None, Stage::Measurement));
        let mut simulation = run.into_simulation();
        assert!(simulation.has_andersen() && simulation.scale() > 1.0);
        let events = simulation.event_counts().physical() + 500;
        assert_eq!(finished.simulation.event_counts().physical(), events);
        simulation.advance(Until::events(events)).unwrap();
        assert_eq!(simulation.snapshot(), finished.simulation.snapshot());
    }

    #[test]
    fn interrupted_preparation_is_reported() {
        let (_, ending) = Run::new(planned(0.25)).prepare(&mut |_| ControlFlow::Break(())).unwrap();
        assert_eq!(ending, Some(Ending::Interrupted));
    }
}
