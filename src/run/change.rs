//! Continuation of a paused run with a changed scene.

use std::path::Path;

use thiserror::Error;

use super::{Run, Stage};
use crate::model::{Scene, Until};
use crate::scene::SceneError;

/// Why a run cannot continue with a changed scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// The text of the scene has an error, or does not fit the current state.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The diameters are growing or have grown, and differ from the diameters in the scene.
    #[error("the scene cannot be changed after diameters have grown: start it again")]
    Grown,
}

impl Run {
    /// Creates a run from `text`, a scene with changed values, such as gravity or interactions. The new run starts at
    /// the beginning of the current stage, with the current particles, bonds and static meshes. `overrides` have the
    /// same form as in [`Scene::from_file_with`].
    ///
    /// # Errors
    /// [`ChangeError::Scene`] if the text has an error or does not fit the state, for example if the box has another
    /// size. [`ChangeError::Grown`] if diameters grow or have grown.
    pub fn changed(&self, text: &str, name: &Path, overrides: &[(&str, &str)]) -> Result<Self, ChangeError> {
        if self.simulation.is_growing() || self.simulation.scale() != 1.0 {
            return Err(ChangeError::Grown);
        }
        let mut scene = Scene::from_toml_after(text, name, overrides, &self.simulation)?;
        self.leave_out_what_is_over(&mut scene);
        Ok(Self::new(scene))
    }

    /// Removes the stages before the current stage.
    fn leave_out_what_is_over(&self, scene: &mut Scene) {
        let plan = &mut scene.run;
        let stage = self.state.stage.stage;
        let over = match stage {
            Stage::Preparation(number) | Stage::EquilibrationOf(number) | Stage::MeasurementOf(number) => {
                number as usize
            }
            Stage::Equilibration | Stage::Measurement => plan.stages.len(),
        };
        plan.stages.drain(..over.min(plan.stages.len()));
        match stage {
            Stage::MeasurementOf(_) => {
                if let Some(first) = plan.stages.first_mut() {
                    first.measured = first.measured.map(|_| Default::default());
                }
            }
            Stage::Measurement => (plan.equilibration, plan.until_stationary) = (Until::default(), false),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
        [space]
        size = [12.0, 10.0, 14.0]
        z = { lower = "wall", upper = "wall", restitution = 0.9 }

        [dynamics]
        gravity = [0.0, 0.0, -0.3]

        [[species]]
        name = "A"
        mass = 1.3
        diameter = 1.0

        [[species]]
        name = "fixed"
        static = true
        diameter = 1.0

        [[interaction]]
        species = ["A", "A"]
        potential = "square-well"
        lambda = 1.5
        well_depth = 0.4
        restitution = 0.95

        [[interaction]]
        species = ["A", "fixed"]
        potential = "hard-sphere"

        [[interaction]]
        name = "link"
        potential = "bond"
        shortest = 1.0
        longest = 1.3

        [[chain]]
        species = "A"
        bond = "link"
        count = 6
        length = 5
        temperature = 0.8

        [[mesh]]
        name = "floor"
        species = "fixed"
        surface = "plane"
        corner = [1.0, 1.0, 1.0]
        edge_1 = [10.0, 0.0, 0.0]
        edge_2 = [0.0, 8.0, 0.0]

        [[stage]]
        name = "warm"
        until_events = 300
        thermostat = { kind = "andersen", temperature = 0.7, rate = 0.5 }

        [run]
        equilibration_events = 400
        until_events = 3000
    "#;

    fn begun(overrides: &[(&str, &str)]) -> Run {
        Run::new(Scene::from_toml_with(SCENE, "scene.toml", overrides).unwrap())
    }

    fn changed(run: &Run, overrides: &[(&str, &str)]) -> Result<Run, ChangeError> {
        run.changed(SCENE, Path::new("scene.toml"), overrides)
    }

    #[test]
    fn unchanged_scene_continues_the_run_identically() {
        let (run, ending) = begun(&[]).advance(Until::events(1_234), &mut ()).unwrap();
        assert_eq!((ending, run.stage()), (None, Stage::Measurement));
        let same = changed(&run, &[]).unwrap();
        assert_eq!(same.stage(), Stage::Equilibration);
        assert_eq!(same.simulation().scene().run().equilibration, Until::default());
        assert_eq!(same.simulation().snapshot(), run.simulation().snapshot());
        let end = run.simulation().time() + 3.0;
        let [a, b] = [run, same].map(|run| run.advance(Until::time(end), &mut ()).unwrap().0.simulation().snapshot());
        assert!(a.time == end && a == b);
    }

    #[test]
    fn changed_values_apply_from_the_current_time() {
        let (run, _) = begun(&[]).advance(Until::events(1_000), &mut ()).unwrap();
        let other = changed(&run, &[("dynamics.gravity.2", "0.5"), ("interaction.0.restitution", "1.0")]).unwrap();
        let (before, after) = (run.simulation().snapshot(), other.simulation().snapshot());
        assert_eq!((&before.positions, &before.velocities), (&after.positions, &after.velocities));
        assert_eq!(before.time, after.time);
        assert_eq!(run.simulation().scene().bonds(), other.simulation().scene().bonds());
        assert_eq!(run.simulation().scene().static_surfaces(), other.simulation().scene().static_surfaces());
        let end = Until::time(before.time + 4.0).or_events(2_000);
        let rises = |run: Run| {
            let (run, _) = run.advance(end, &mut ()).unwrap();
            assert!(run.simulation().real_overlaps().is_empty());
            run.simulation().snapshot().positions.iter().map(|position| position.z).sum::<f64>()
        };
        assert!(rises(other) > rises(run) + 5.0);
    }

    #[test]
    fn stages_that_are_over_do_not_come_again() {
        let (run, _) = begun(&[]).advance(Until::events(100), &mut ()).unwrap();
        assert_eq!(run.stage(), Stage::Preparation(0));
        let other = changed(&run, &[]).unwrap();
        assert_eq!(Stage::simulated(other.simulation().scene().run()).count(), 3);
        let (run, _) = run.advance(Until::events(500), &mut ()).unwrap();
        assert_eq!(run.stage(), Stage::Equilibration);
        let other = changed(&run, &[]).unwrap();
        assert_eq!(Stage::simulated(other.simulation().scene().run()).count(), 2);
    }

    #[test]
    fn a_stage_that_is_measured_is_not_equilibrated_again() {
        let measured = [("stage.0.measure", "true"), ("stage.0.equilibration_events", "200")];
        for (events, stage, equilibration) in
            [(100, Stage::EquilibrationOf(0), Until::events(200)), (400, Stage::MeasurementOf(0), Until::default())]
        {
            let (run, _) = begun(&measured).advance(Until::events(events), &mut ()).unwrap();
            assert_eq!(run.stage(), stage);
            let other = changed(&run, &measured).unwrap();
            let first = other.simulation().scene().run().stages[0].measured.unwrap();
            assert_eq!(first.limit, equilibration, "{stage:?}");
        }
    }

    #[test]
    fn incompatible_changes_are_rejected() {
        let (run, _) = begun(&[]).advance(Until::events(1_000), &mut ()).unwrap();
        for overrides in [
            [("space.size", "[12.0, 10.0, 15.0]")],
            [("species.A.diameter", "1.2")],
            [("space.x", "\"flat\"")],
            [("interaction.0.restitution", "2.0")],
            [("nonsense", "1")],
        ] {
            assert!(matches!(changed(&run, &overrides), Err(ChangeError::Scene(_))), "{overrides:?}");
        }
        let text = include_str!("../../configs/random_packing.toml");
        let few = [("fill.0.count", "200"), ("stage.0.until_events", "500")];
        for (events, is_growing) in [(50, true), (600, false)] {
            let run = Run::new(Scene::from_toml_with(text, "scene.toml", &few).unwrap());
            let (run, _) = run.advance(Until::events(events), &mut ()).unwrap();
            assert_eq!(run.simulation().is_growing(), is_growing);
            assert!(matches!(run.changed(text, Path::new("scene.toml"), &few), Err(ChangeError::Grown)));
        }
    }

    #[test]
    fn pauses_change_nothing() {
        let whole = begun(&[]).finish().unwrap();
        let mut run = begun(&[]);
        let mut pauses = 0;
        for k in 1_u32.. {
            let (time, events) = (0.05 * f64::from(k), u64::from(11 * k));
            let (next, ending) = run.advance(Until::time(time).or_events(events), &mut ()).unwrap();
            run = next;
            if let Some(ending) = ending {
                assert_eq!(ending, whole.ending);
                break;
            }
            pauses += 1;
            let done = run.simulation().event_counts().physical();
            assert!(run.simulation().time() == time || done == events);
        }
        assert!(pauses > 100);
        let paused = run.finish().unwrap();
        assert_eq!(paused.simulation.snapshot(), whole.simulation.snapshot());
        assert_eq!(paused.observables, whole.observables);
        assert_eq!(paused.measurement.event_counts, whole.measurement.event_counts);
        assert_eq!(format!("{:?}", paused.stationarity), format!("{:?}", whole.stationarity));
    }
}
