//! Event rates of a scene, estimated before it is run.

use super::forecast;
use crate::engine::{Reason, Simulation, Until};
use crate::model::Scene;

/// Particles whose first events are tried: few enough for a part of a second.
pub(super) const MOST: usize = 3_000;

/// Events of each that are tried, and of all of them at least. The first half melts the lattice of the start.
const EACH: u64 = 10;
const LEAST: u64 = 1_000;

/// Steps of the engine that are tried at most: events, cell transitions, predictions anew.
const STEPS: u64 = 500_000;

/// Fewer events give no rate.
const FEWEST: u64 = 10;

/// Events by simulated time `[1 / time]`: those of a try, of which each particle has some; of more particles than can be tried so, what kinetic theory
/// says of a fluid at the speeds of the start. `None` where neither gives one.
///
/// It is a function of the scene: nothing depends on the clock.
#[must_use]
pub fn expected_rate(scene: &Scene) -> Option<f64> {
    let is_moving = |id: crate::model::SpeciesId| !scene.species[id.0 as usize].is_static();
    let moving = scene.particles.iter().filter(|particle| is_moving(particle.species)).count();
    let tried = if moving <= MOST && scene.particles.len() <= 100 * MOST { tried(scene, moving as u64) } else { None };
    tried.or_else(|| forecast::rate(scene))
}

/// The rate of the second half of a try, or of all of it where it has come to an end before.
fn tried(scene: &Scene, moving: u64) -> Option<f64> {
    let mut simulation = Simulation::without_plan(scene.clone());
    let target = LEAST.max(EACH * moving);
    let mut begin = (simulation.time(), 0);
    if let Ok(Some(Reason::Events)) = simulation.advance_for(STEPS, Until::events(target / 2), None) {
        let half = (simulation.time(), target / 2);
        // Where it ends, there is what there is.
        let _ = simulation.advance_for(STEPS, Until::events(target), None);
        if simulation.event_counts().physical() >= half.1 + FEWEST {
            begin = half;
        }
    }
    let events = simulation.event_counts().physical() - begin.1;
    let rate = events as f64 / (simulation.time() - begin.0);
    (events >= FEWEST && rate.is_finite() && rate > 0.0).then_some(rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::potential::Potential;
    use crate::scene::{Amount, Lattice, SceneBuilder};

    fn fluid(potential: Potential, count: u64, packing_fraction: f64) -> Scene {
        SceneBuilder::new("fluid")
            .species("A", 2.0, 1.0)
            .interaction("A", "A", potential, 1.0)
            .fill(Lattice::FaceCentredCubic, "A", count, Amount::PackingFraction(packing_fraction))
            .temperature(1.5)
            .build()
            .unwrap()
    }

    /// Events by time, once the lattice has melted.
    fn measured(scene: Scene) -> f64 {
        let mut simulation = Simulation::without_plan(scene);
        simulation.advance(Until::events(20_000)).unwrap();
        let start = simulation.time();
        simulation.advance(Until::events(40_000)).unwrap();
        20_000.0 / (simulation.time() - start)
    }

    #[test]
    fn kinetic_theory_and_a_try_are_near_the_truth() {
        let sphere = Potential::hard_sphere(1.0).unwrap();
        let well = Potential::square_well(1.0, 1.5, 0.5).unwrap();
        for (potential, packing_fraction, most) in [(&sphere, 0.05, 0.2), (&sphere, 0.45, 0.2), (&well, 0.2, 1.0)] {
            let small = fluid(potential.clone(), 500, packing_fraction);
            let (tried, theory) = (expected_rate(&small).unwrap(), forecast::rate(&small).unwrap());
            let truth = measured(small);
            let what = format!("{packing_fraction}: {tried} {theory} {truth}");
            assert!((tried / truth - 1.0).abs() < 0.35 && (theory / truth - 1.0).abs() < most, "{what}");
            // Of many particles nothing is tried.
            let large = fluid(potential.clone(), 4_000, packing_fraction);
            assert!((expected_rate(&large).unwrap() / (8.0 * truth) - 1.0).abs() < most, "{what}");
        }
    }

    #[test]
    fn what_rests_or_never_meets_has_no_rate() {
        let pair = |velocity: f64| {
            SceneBuilder::new("pair")
                .space(crate::model::space::Space {
                    boundary: [crate::model::space::Boundary::OPEN; 3],
                    ..crate::model::space::Space::periodic_cube(9.0)
                })
                .species("A", 1.0, 1.0)
                .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
                .particle("A", crate::Vector::repeat(2.0), crate::Vector::new(velocity, 0.0, 0.0))
                .particle("A", crate::Vector::repeat(6.0), crate::Vector::zeros())
                .build()
                .unwrap()
        };
        assert_eq!([expected_rate(&pair(0.0)), expected_rate(&pair(1.0))], [None, None]);
    }
}
