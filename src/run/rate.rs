//! Estimate of the event rate before a run, for scenes in which the rate is steady.

use super::forecast;
use crate::engine::surfaces::search_steps;
use crate::engine::{Reason, Simulation, Until};
use crate::model::Scene;

/// Maximum number of moving particles in a trial. Such a trial takes a fraction of a second.
pub(super) const MOST: usize = 3_000;

/// Number of events per moving particle in a trial, and minimum total number of events. The first half of a trial melts
/// the initial lattice.
const EACH: u64 = 10;
const LEAST: u64 = 1_000;

/// Maximum number of engine steps (events, cell transitions and new predictions) in each of the two halves of a trial.
const STEPS: u64 = 500_000;

/// Maximum number of search steps in a trial, which take one or two seconds. An engine step may need very many search
/// steps to find a contact with a surface that oscillates or turns.
const SEARCH_STEPS: u64 = if cfg!(test) { 200_000 } else { 10_000_000 };

/// Number of engine steps between two checks of the number of search steps.
const BETWEEN: u64 = 64;

/// Minimum number of events from which a rate is calculated.
const FEWEST: u64 = 10;

/// Estimates the number of events per simulated time `[1 / time]` in a short trial. If the scene has too many particles
/// or the trial has too few events, the rate follows from kinetic theory. Returns `None` if kinetic theory fails.
///
/// The result does not depend on the speed of the machine.
#[must_use]
pub fn expected_rate(scene: &Scene) -> Option<f64> {
    let is_moving = |id: crate::model::SpeciesId| !scene.species[id.0 as usize].is_static();
    let moving = scene.particles.iter().filter(|particle| is_moving(particle.species)).count();
    let tried = if moving <= MOST && scene.particles.len() <= 100 * MOST { tried(scene, moving as u64) } else { None };
    tried.or_else(|| forecast::rate(scene))
}

/// A trial: a short simulation of a scene with limited work.
pub(super) struct Try {
    pub simulation: Simulation,
    /// Number of search steps of this thread at which the trial is abandoned; `None` if no surface moves.
    most: Option<u64>,
}

impl Try {
    pub fn of(scene: &Scene) -> Self {
        let most = scene.has_moving_surfaces().then(|| search_steps().wrapping_add(SEARCH_STEPS));
        Self { simulation: Simulation::without_plan(scene.clone()), most }
    }

    /// Returns an error if the simulation cannot continue, or if there were too many search steps.
    pub fn advance(&mut self, mut steps: u64, until: Until) -> Result<Option<Reason>, ()> {
        let Some(most) = self.most else {
            return self.simulation.advance_for(steps, until).map_err(drop);
        };
        while steps > 0 {
            if search_steps() >= most {
                return Err(());
            }
            let some = steps.min(BETWEEN);
            if let Some(reason) = self.simulation.advance_for(some, until).map_err(drop)? {
                return Ok(Some(reason));
            }
            steps -= some;
        }
        Ok(None)
    }
}

/// Returns the event rate in the second half of a trial, or in the whole trial if it ended early.
fn tried(scene: &Scene, moving: u64) -> Option<f64> {
    let mut attempt = Try::of(scene);
    let target = LEAST.max(EACH * moving);
    let mut begin = (attempt.simulation.time(), 0);
    if attempt.advance(STEPS, Until::events(target / 2)) == Ok(Some(Reason::Events)) {
        let half = (attempt.simulation.time(), target / 2);
        // If the simulation ends or fails in the second half, the events so far are used.
        let _ = attempt.advance(STEPS, Until::events(target));
        if attempt.simulation.event_counts().physical() >= half.1 + FEWEST {
            begin = half;
        }
    }
    let simulation = attempt.simulation;
    let events = simulation.event_counts().physical() - begin.1;
    let rate = events as f64 / (simulation.time() - begin.0);
    (events >= FEWEST && rate.is_finite() && rate > 0.0).then_some(rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::potential::Potential;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    fn fluid(potential: Potential, count: u64, packing_fraction: f64) -> Scene {
        SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(2.0).diameter(1.0))
            .interaction(InteractionDraft::new(potential).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(packing_fraction))
            .temperature(1.5)
            .build()
            .unwrap()
    }

    fn measured(scene: Scene) -> f64 {
        let mut simulation = Simulation::without_plan(scene);
        simulation.advance(Until::events(20_000)).unwrap();
        let start = simulation.time();
        simulation.advance(Until::events(40_000)).unwrap();
        20_000.0 / (simulation.time() - start)
    }

    #[test]
    fn kinetic_theory_and_trial_rates_match_measurement() {
        let sphere = Potential::hard_sphere(1.0).unwrap();
        let well = Potential::square_well(1.0, 1.5, 0.5).unwrap();
        for (potential, packing_fraction, most) in [(&sphere, 0.05, 0.2), (&sphere, 0.45, 0.2), (&well, 0.2, 1.0)] {
            let small = fluid(potential.clone(), 500, packing_fraction);
            let (tried, theory) = (expected_rate(&small).unwrap(), forecast::rate(&small).unwrap());
            let truth = measured(small);
            let what = format!("{packing_fraction}: {tried} {theory} {truth}");
            assert!((tried / truth - 1.0).abs() < 0.35 && (theory / truth - 1.0).abs() < most, "{what}");
            // This system is too large for a trial, so the rate follows from kinetic theory.
            let large = fluid(potential.clone(), 4_000, packing_fraction);
            assert!((expected_rate(&large).unwrap() / (8.0 * truth) - 1.0).abs() < most, "{what}");
        }
    }

    /// The plate oscillates so fast that an engine step needs very many search steps.
    #[test]
    fn trial_beside_a_fast_surface_stops_at_its_work_limit() {
        let scene = Scene::from_toml(
            "
            space = { size = [8.0, 8.0, 60.0], x = 'walls', y = 'walls', z = { lower = 'wall', upper = 'open', restitution = 0.7 } }
            dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 1e-3 }
            species = [{ name = 'grain', mass = 1.0, diameter = 1.0 }]
            interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.7 }]
            fill = [{ species = 'grain', arrangement = 'random', count = 200, region = { lower = [0.0, 0.0, 4.9], upper = [8.0, 8.0, 20.0] }, temperature = 0.01 }]
            run = { until_time = 20 }
            [[surface]]
            name = 'plate'
            shape = 'parallelogram'
            corner = [0.0, 0.0, 4.0]
            edge_1 = [8.0, 0.0, 0.0]
            edge_2 = [0.0, 8.0, 0.0]
            motion = [{ kind = 'oscillation', amplitude = [0.0, 0.0, 0.3], frequency = 1e6 }]",
            "scene.toml",
        );
        let scene = scene.unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
        let before = search_steps();
        assert!(crate::run::foreseen_rate(&scene).is_err());
        let done = search_steps() - before;
        // The number of search steps is checked only every 64 engine steps, so it may exceed the maximum.
        assert!((SEARCH_STEPS..2 * SEARCH_STEPS).contains(&done), "{done}");
        assert_eq!(crate::run::burdens(&scene).len(), 1);
    }

    #[test]
    fn particles_at_rest_or_never_meeting_have_no_rate() {
        let pair = |velocity: f64| {
            SceneBuilder::new("pair")
                .space(crate::model::space::Space {
                    boundary: [crate::model::space::Boundary::OPEN; 3],
                    ..crate::model::space::Space::periodic_cube(9.0)
                })
                .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .particle("A", crate::Vector::repeat(2.0), crate::Vector::new(velocity, 0.0, 0.0))
                .particle("A", crate::Vector::repeat(6.0), crate::Vector::zeros())
                .build()
                .unwrap()
        };
        assert_eq!([expected_rate(&pair(0.0)), expected_rate(&pair(1.0))], [None, None]);
    }
}
