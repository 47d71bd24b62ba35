//! Creation of a simulation from a scene.

use super::parts::Engine;
use super::{Chosen, EngineChoice, Simulation};
use crate::model::predecessor::LastState;
use crate::model::{Scene, Thermostat, Until};
use thiserror::Error;

/// Parts of a scene's plan that only a run can execute.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NeedsRun {
    /// A stage that prepares the system.
    #[error(
        "only a run carries out stage `{name}` of the scene: use run::Run, or Simulation::without_plan for the dynamics alone"
    )]
    Stage {
        /// Name of the stage.
        name: String,
    },
    /// An equilibration.
    #[error(
        "only a run carries out the equilibration of the scene: use run::Run, or Simulation::without_plan for the dynamics alone"
    )]
    Equilibration,
    /// A thermostat that rescales all velocities.
    #[error(
        "only a run scales the velocities of the scene: use run::Run, or Simulation::without_plan for the dynamics alone"
    )]
    Rescaling,
    /// A barostat that changes the volume.
    #[error(
        "only a run changes the volume of the scene: use run::Run, or Simulation::without_plan for the dynamics alone"
    )]
    Barostat,
    /// Swap moves of particles.
    #[error("only a run makes swap moves: use run::Run, or Simulation::without_plan for the dynamics alone")]
    Swap,
    /// Replicas at several temperatures.
    #[error(
        "the scene has replicas, which only exchange::Exchange simulates: use exchange::Exchange, or Simulation::without_plan for the dynamics alone"
    )]
    Exchange,
}

impl Simulation {
    /// Starts the dynamics of a scene: chooses the engine and predicts the first events.
    ///
    /// The dynamics include gravity, walls, shear and an Andersen thermostat. The trajectory equals the trajectory of a
    /// [`Run`](crate::run::Run), bit for bit. The duration of the run, measurements and output are ignored.
    ///
    /// # Errors
    /// [`NeedsRun`] if the scene has stages, an equilibration, a thermostat that rescales velocities, a barostat, swap
    /// moves, or replicas.
    pub fn new(scene: Scene) -> Result<Self, NeedsRun> {
        let plan = &scene.run;
        if scene.exchange.is_some() {
            return Err(NeedsRun::Exchange);
        }
        if let Some(stage) = plan.stages.first() {
            return Err(NeedsRun::Stage { name: stage.name.clone() });
        }
        if plan.equilibration != Until::default() || plan.until_stationary {
            return Err(NeedsRun::Equilibration);
        }
        let thermostat = plan.thermostat;
        if matches!(thermostat, Some(Thermostat::Rescaling { .. })) {
            return Err(NeedsRun::Rescaling);
        }
        if plan.barostat.is_some() {
            return Err(NeedsRun::Barostat);
        }
        if plan.swap.is_some() {
            return Err(NeedsRun::Swap);
        }
        // As in a run, the heat bath uses the random stream of the measurement.
        let stage = scene.first_stream() + plan.stages.len() + 1;
        let mut simulation = Self::without_plan(scene);
        if thermostat.is_some() {
            simulation.set_planned_thermostat(thermostat.as_ref(), simulation.stream_seed(), stage);
        }
        Ok(simulation)
    }

    /// Returns the dynamics of a scene without its [`RunPlan`](crate::model::RunPlan). Stages, equilibration and
    /// thermostat are ignored.
    #[must_use]
    pub fn without_plan(scene: Scene) -> Self {
        Self::begin(scene, true)
    }

    /// If `keeps_start` is false, the particles of the scene are freed before other memory is allocated.
    pub(crate) fn begin(mut scene: Scene, keeps_start: bool) -> Self {
        let last = scene.last_state().and_then(Self::last_of);
        if !keeps_start && last.is_some() {
            scene.particles = Vec::new();
        }
        if let Some(last) = last {
            scene.forget_last_state();
            let mut simulation = Self { first_diameters: diameters(&scene), scene, scale: 1.0, ..last };
            simulation.set_threads(simulation.scene.run.threads);
            return simulation;
        }
        let choice = EngineChoice::new(&scene);
        let mut engine = match (choice.is_falling, choice.has_table) {
            (false, false) => Chosen::FreeHard(Engine::placed(&scene)),
            (false, true) => Chosen::FreeTable(Engine::placed(&scene)),
            (true, false) => Chosen::FallingHard(Engine::placed(&scene)),
            (true, true) => Chosen::FallingTable(Engine::placed(&scene)),
        };
        if !keeps_start {
            scene.particles = Vec::new();
        }
        with_engine!(&mut engine, engine => engine.begin(&scene, choice.search));
        scene.forget_last_state();
        let threads = scene.run.threads;
        let first_diameters = diameters(&scene);
        let mut simulation = Self { first_diameters, scene, choice, engine, scale: 1.0, threads, communicator: None };
        simulation.set_threads(threads);
        simulation
    }

    /// Restores the end of an earlier run, for a scene with the same dynamics. Event counts restart at zero.
    fn last_of(state: &LastState) -> Option<Self> {
        // The bytes can be trusted, because this program has written them.
        let mut simulation: Self = postcard::from_bytes(state.simulation.as_ref()?).ok()?;
        simulation.enlarge();
        // The heat bath of the earlier run does not continue.
        simulation.set_planned_thermostat(None, 0, 0);
        with_engine!(&mut simulation.engine, engine => engine.counts.restart(engine.counted_species()));
        Some(simulation)
    }
}

fn diameters(scene: &Scene) -> Vec<f64> {
    scene.species.iter().map(|species| species.diameter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Barostat, Growth, GrowthTarget, RunPlan, StagePlan};
    use crate::run::Run;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    fn planned(run: RunPlan) -> Scene {
        SceneBuilder::new("planned")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2))
            .temperature(1.0)
            .run(run)
            .build()
            .unwrap()
    }

    #[test]
    fn simulation_rejects_scenes_that_need_a_run() {
        let growth = Some(Growth { rate: 0.1, until: GrowthTarget::PackingFraction(0.3) });
        let stage = StagePlan { name: "grow".into(), growth, ..StagePlan::default() };
        let rescaling = Some(Thermostat::Rescaling { temperature: 1.0, interval: 1.0 });
        let bath = Some(Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [true; 3] });
        let barostat = Barostat { pressure: 1.0, interval: 1.0, amplitude: Some(0.1) };
        let plain = RunPlan { limit: Until::time(1.0), ..RunPlan::default() };
        for (plan, refused) in [
            (RunPlan { stages: vec![stage], ..plain.clone() }, NeedsRun::Stage { name: "grow".into() }),
            (RunPlan { equilibration: Until::events(1), ..plain.clone() }, NeedsRun::Equilibration),
            (RunPlan { until_stationary: true, ..plain.clone() }, NeedsRun::Equilibration),
            (RunPlan { thermostat: rescaling, ..plain.clone() }, NeedsRun::Rescaling),
            (RunPlan { thermostat: bath, barostat: Some(barostat), ..plain.clone() }, NeedsRun::Barostat),
        ] {
            let scene = planned(plan);
            assert_eq!(Simulation::new(scene.clone()).err(), Some(refused));
            assert_eq!(Simulation::without_plan(scene).event_counts().physical(), 0);
        }
        assert!(Simulation::new(planned(plain)).is_ok());
    }

    #[test]
    fn simulation_and_run_apply_the_same_heat_bath() {
        let thermostat = Some(Thermostat::Andersen { temperature: 2.0, rate: 1.0, axes: [true; 3] });
        let scene = planned(RunPlan { thermostat, limit: Until::time(2.0), ..RunPlan::default() });
        let mut simulation = Simulation::new(scene.clone()).unwrap();
        simulation.advance(Until::time(2.0)).unwrap();
        assert!(simulation.event_counts().thermostat > 100);
        assert_eq!(simulation.snapshot(), Run::new(scene).finish().unwrap().simulation.snapshot());
    }
}
