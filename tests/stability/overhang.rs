//! Static spheres that extend beyond a wall do not hide the wall.

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Scene};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

/// A ball between two walls, above a row of static spheres that extends beyond each wall by `overhang`.
fn over_a_row(overhang: f64) -> Scene {
    let wall = Face::Wall(ContactLaw::smooth(1.0));
    let mut space = Space::periodic_cube(10.0);
    space.boundary[0] = Boundary::Bounded { lower: wall, upper: wall };
    let mut scene = SceneBuilder::new("row")
        .species(SpeciesDraft::new("ball").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("row").diameter(0.5).fixed())
        .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "row"))
        .space(space)
        .particle("ball", Vector::new(5.0, 5.0, 5.0), Vector::new(1.0, 0.0, 0.0));
    // The engine uses cells only for many particles.
    let length = 10.0 + 2.0 * overhang;
    for k in 0..64 {
        scene = scene.particle("row", Vector::new(f64::from(k) / 63.0 * length - overhang, 5.0, 2.0), Vector::zeros());
    }
    scene.build().unwrap()
}

#[test]
fn walls_are_met_in_front_of_static_spheres_beyond_them() {
    for overhang in [0.0, 0.25, 1.0, 15.0, 1000.0] {
        let mut simulation = Simulation::without_plan(over_a_row(overhang));
        for time in [4.5, 13.5, 22.5] {
            let event = simulation.events(Until::time(100.0)).next().expect("a ball between walls meets them for ever");
            let event = event.unwrap();
            assert!((event.time - time).abs() < 1e-14 * time, "{overhang}: {} instead of {time}", event.time);
        }
    }
}
