//! In a box of four cells, particles half a period apart may meet in either of two images.

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::space::Space;
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

/// A ball among static spheres with centres on faces of the cells.
fn lorentz_gas(velocity: [f64; 3]) -> Scene {
    let mut scene = SceneBuilder::new("lorentz")
        .species(SpeciesDraft::new("ball").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("fixed").diameter(1.4).fixed())
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "fixed"))
        .space(Space::periodic_cube(6.0))
        .particle("ball", Vector::repeat(0.1), Vector::from(velocity));
    for at in [[3.0, 3.0, 3.0], [3.0, 0.0, 1.0], [1.0, 3.0, 5.0], [5.0, 2.0, 0.5]] {
        scene = scene.particle("fixed", Vector::from(at), Vector::zeros());
    }
    scene.build().unwrap()
}

#[test]
fn static_spheres_half_a_period_away_are_met() {
    for velocity in [[1.0, 0.3, 0.24], [1.0, 0.3, 0.211], [1.0, 0.3, 0.215], [1.0, 0.3, 0.2]] {
        let mut simulation = Simulation::without_plan(lorentz_gas(velocity));
        simulation.advance(Until::events(5000)).unwrap();
        let event_counts = simulation.event_counts();
        assert!(
            event_counts.deepest_overlap < 1e-12 && event_counts.in_invalid_state == 0,
            "{velocity:?}: {event_counts:?}"
        );
    }
}
